"""Laws outside the catalogue: near its span (`NEAR_SPAN`, alone and in pairs) and far from it (`FAR`).

A law near the span resembles one or two effects of the catalogue and differs from each in stage, variable, memory or
rate; `FAR` also holds one whose form alone differs. A name given to any of them is a wrong name.
"""

from __future__ import annotations

import numpy as np

from examples.concealed.recipes import (
    BEND,
    LENGTH,
    Nature,
    Recipe,
    returns,
    reverses_at_two_heights,
    sign,
    timed,
    two_rates,
)

# Without a load cell what a drive loses and what a tendon gives are one.
DRIVE = ("drive", "tendon")

NEAR_SPAN: dict[str, Recipe] = {
    # The drive belt creeps back with speed: like a lag, but of the stroke and bounded.
    "drive_speed_slip": Recipe(
        "drive",
        "outside",
        two_rates,
        lambda g, c: {"slip_um": c.span_mm * g.uniform(15, 60), "knee_mm_per_s": c.speed * g.uniform(0.5, 3.0)},
        "slip_um",
        (1.0, 600.0),
        Nature(DRIVE, (("rate",),), memory=False, rate=True, dissipative=None),
    ),
    # Every millimetre of travel loses a little, either way: like a set, but of the path.
    "drive_path_loss": Recipe(
        "drive",
        "outside",
        lambda p: p.has("cycles", "partial", "rates"),
        lambda g, _c: {"loss_um_per_mm": sign(g) * g.uniform(3, 25), "exponent": g.uniform(0.7, 1.0)},
        "loss_um_per_mm",
        (0.2, 150.0),
        Nature(DRIVE, (("path",),), memory=True, rate=False, dissipative=None),
    ),
    # The stage walks as its housing warms: like thermal drift, but of the stroke.
    "drive_zero_walk": Recipe(
        "drive",
        "outside",
        timed,
        lambda g, c: {"walk_um": sign(g) * c.span_mm * g.uniform(15, 80), "exponent": g.uniform(0.45, 0.7)},
        "walk_um",
        (1.0, 800.0),
        Nature(DRIVE, (("time",),), memory=False, rate=False, dissipative=None),
    ),
    # Strands rub on each other: a loop in stretch, not in tension.
    "braid_friction": Recipe(
        "tendon",
        "outside",
        lambda p: reverses_at_two_heights(p) and p.has_tension,
        lambda g, c: {"share": g.uniform(0.1, 0.6), "limits_n": c.tension * g.uniform(0.1, 0.4)},
        "share",
        (0.005, 3.0),
        Nature(("tendon",), (("tension",),), memory=True, rate=False, dissipative=True),
    ),
    # A coated cable is stiffer when pulled fast.
    "cable_speed_stiffening": Recipe(
        "tendon",
        "outside",
        two_rates,
        lambda g, c: {"rise": g.uniform(0.15, 0.6), "knee_mm_per_s": c.speed * g.uniform(0.5, 3.0)},
        "rise",
        (0.01, 0.95),
        Nature(
            ("tendon", "transmission"), (("tension", "stroke"), ("rate",)), memory=False, rate=True, dissipative=None
        ),
    ),
    # The sheath pinches where the segment is bent: tension is lost with the square of the bend, either way.
    "kinked_sheath": Recipe(
        "transmission",
        "outside",
        lambda p: p.lengths >= 2 or p.has_tension,
        lambda g, c: {"log_ratio": g.uniform(0.1, 0.5), "full_rad": c.curvature * 0.03},
        "log_ratio",
        (0.01, 1.5),
        Nature(("transmission", "structure"), (BEND,), memory=False, rate=False, dissipative=False),
    ),
    # Friction that turns round with the motion and falls with speed.
    "stribeck_sheath": Recipe(
        "transmission",
        "outside",
        lambda p: two_rates(p) and p.has("partial", "cycles", "rates"),
        lambda g, c: {
            "log_ratio": g.uniform(0.06, 0.3),
            "law": "stribeck",
            "presliding_um": g.uniform(0.5, 2.0),
            "kinetic_share": g.uniform(0.1, 0.45),
            "knee_mm_per_s": c.speed * g.uniform(0.4, 1.5),
        },
        "log_ratio",
        (0.005, 0.9),
        Nature(("transmission", "structure"), (("rate",),), memory=True, rate=True, dissipative=True),
    ),
    # The lubricant runs off: friction that turns round with the motion and grows with time.
    "drying_sheath": Recipe(
        "transmission",
        "outside",
        lambda p: p.has_time and p.has("cycles", "rates", "partial"),
        lambda g, c: {
            "log_ratio": g.uniform(0.06, 0.3),
            "law": "drying",
            "presliding_um": g.uniform(0.5, 2.0),
            "time_s": c.duration,
            "exponent": g.uniform(0.7, 1.6),
        },
        "log_ratio",
        (0.005, 0.9),
        Nature(("transmission", "structure"), (("time",),), memory=True, rate=False, dissipative=True),
    ),
    # A pulley out of centre: like the screw's error, but of the tension.
    "eccentric_pulley": Recipe(
        "transmission",
        "outside",
        lambda p: p.steps() < 0.03,
        lambda g, c: {
            "amplitude": g.uniform(0.02, 0.12),
            "period_mm": c.span_mm * g.uniform(0.22, 0.6),
            "phase_rad": g.uniform(0, 2 * np.pi),
        },
        "amplitude",
        (0.002, 0.5),
        Nature(("transmission", "tendon"), (("stroke", "turns"),), memory=False, rate=False, dissipative=False),
    ),
    # A polymer jacket round the tubes: bending relaxes with two time constants.
    "jacket_relaxation": Recipe(
        "structure",
        "outside",
        lambda p: p.has_time and p.has("ladder", "ladder_down", "rates", "partial"),
        lambda g, c: {"compliance": g.uniform(0.05, 0.3), "time_constant_s": c.duration * g.uniform(0.01, 0.08)},
        "compliance",
        (0.003, 1.5),
        Nature(("structure",), ((*BEND, "time"),), memory=True, rate=True, dissipative=True),
    ),
    # The jacket softens with the largest bend so far: like a tendon's set, but of the stiffness.
    "jacket_softening": Recipe(
        "structure",
        "outside",
        lambda p: p.has("cycles", "partial"),
        lambda g, c: {"loss": g.uniform(0.1, 0.5), "scale_per_m": c.curvature * g.uniform(0.3, 1.0)},
        "loss",
        (0.01, 3.0),
        Nature(("structure",), (BEND,), memory=True, rate=False, dissipative=True),
    ),
    # Tubes press on each other when bent: friction between them grows with the square of the bend.
    "pressed_tubes": Recipe(
        "structure",
        "outside",
        reverses_at_two_heights,
        lambda g, c: {"share": g.uniform(0.05, 0.25), "full_n_mm": c.joint.rigidity * c.curvature * 1e3},
        "share",
        (0.005, 0.6),
        Nature(("structure", "transmission"), (BEND,), memory=True, rate=False, dissipative=True),
    ),
    # A band along the tube, counted from the tip, is softer or stiffer than the rest.
    "stiffness_along": Recipe(
        "structure",
        "outside",
        lambda p: p.lengths >= 3 and p.response != "notch",
        lambda g, _c: {"change": g.uniform(0.3, 1.5), "at_mm": g.uniform(10, 25), "width_mm": g.uniform(3, 8)},
        "change",
        (0.02, 6.0),
        Nature(("structure",), (LENGTH,), memory=False, rate=False, dissipative=False),
    ),
    # A lens that compresses what is far off its axis: like a stiffening, but of the picture.
    "lens_compression": Recipe(
        "sensor",
        "outside",
        lambda p: p.response != "notch" and (p.has_tension or p.lengths >= 3),
        lambda g, _c: {"loss": sign(g) * g.uniform(0.05, 0.3), "power": g.uniform(1.6, 2.6), "full": 0.0},
        "loss",
        (0.005, 0.45),
        Nature(("sensor", "structure"), (BEND,), memory=False, rate=False, dissipative=None),
    ),
    # Each movement shakes the camera a little further.
    "camera_walk": Recipe(
        "sensor",
        "outside",
        lambda p: p.response != "notch" and p.has("cycles", "partial", "rates"),
        lambda g, c: {"walk": sign(g) * c.curvature * g.uniform(0.01, 0.06), "full": c.curvature},
        "walk",
        (0.01, 20.0),
        Nature(("sensor",), (("path",),), memory=True, rate=False, dissipative=None),
    ),
}

FAR: dict[str, Recipe] = {
    # Strands of a braid lie down at low load and are straight after: like slack, or a knee the other way round.
    "braid_bedding": Recipe(
        "tendon",
        "outside",
        lambda p: p.has_tension or p.lengths >= 3,
        lambda g, c: {"slack_um": c.span_mm * g.uniform(25, 110), "scale_n": c.tension * g.uniform(0.1, 0.35)},
        "slack_um",
        (2.0, 1200.0),
        Nature(("tendon",), (("tension",),), memory=False, rate=False, dissipative=False),
    ),
    "wire_pull_coupling": Recipe(
        "structure",
        "outside",
        lambda p: p.lengths >= 2,
        lambda g, c: {"pull_mm_per_n": sign(g) * 2.0 / c.tension * g.uniform(0.3, 1.5)},
        "pull_mm_per_n",
        (0.01, 30.0),
        Nature(("structure",), (("tension", *BEND, *LENGTH),), memory=False, rate=False, dissipative=False),
    ),
    "notch_crack": Recipe(
        "structure",
        "outside",
        lambda p: p.has("triangle", "cycles", "partial", "rates"),
        lambda g, _c: {
            "at_share": g.uniform(0.3, 0.6),
            "notch_share": g.uniform(0.02, 0.08),
            "compliance_ratio": g.uniform(2.0, 5.0),
        },
        "compliance_ratio",
        (1.1, 12.0),
        Nature(("structure",), (("time", *BEND),), memory=True, rate=False, dissipative=True),
    ),
    "wrinkled_sheath": Recipe(
        "drive",
        "outside",
        lambda p: p.steps() < 0.03,
        lambda g, c: {
            "amplitude_um": c.span_mm * g.uniform(6, 30),
            "span_mm": c.span_mm + c.joint.deadband * 1e3,
            "exponent": g.uniform(1.7, 2.6),
            "turns": g.uniform(3.5, 7.0),
        },
        "amplitude_um",
        (1.0, 120.0),
        Nature(DRIVE, (("stroke",),), memory=False, rate=False, dissipative=None),
    ),
    "lens_rolling": Recipe(
        "sensor",
        "outside",
        lambda p: p.response != "notch",
        lambda g, _c: {
            "amplitude": g.uniform(0.3, 2.0),
            "turns": g.uniform(1.2, 2.6),
            "phase_rad": g.uniform(0, 2 * np.pi),
        },
        "amplitude",
        (0.05, 6.0),
        Nature(("sensor",), (BEND,), memory=False, rate=False, dissipative=None),
    ),
    "work_hardening": Recipe(
        "structure",
        "outside",
        lambda p: p.has("cycles", "partial", "rates"),
        lambda g, c: {"rise": g.uniform(0.05, 0.3), "path_rad": c.curvature * 0.025 * g.uniform(1.5, 5.0)},
        "rise",
        (0.005, 1.0),
        Nature(("structure",), (("path",),), memory=True, rate=False, dissipative=None),
    ),
    "camera_bump": Recipe(
        "sensor",
        "outside",
        lambda p: p.response != "notch" and p.has("cycles", "partial", "triangle"),
        lambda g, _c: {"at_share": g.uniform(0.25, 0.7), "step": sign(g) * g.uniform(0.5, 3.0)},
        "step",
        (0.05, 10.0),
        Nature(("sensor",), (("time",),), memory=True, rate=False, dissipative=None),
    ),
    "ringing": Recipe(
        "sensor",
        "outside",
        lambda p: p.has_time and p.rates() > 2.0 and p.has("ladder", "ladder_down", "rates") and returns(p),
        lambda g, c: {"period_s": c.dt * g.uniform(8, 20), "damping": g.uniform(0.02, 0.08)},
        "period_s",
        (1e-3, 60.0),
        Nature(("sensor", "structure"), (("rate", "time"),), memory=True, rate=True, dissipative=None),
    ),
}

OUTSIDE: dict[str, Recipe] = NEAR_SPAN | FAR
