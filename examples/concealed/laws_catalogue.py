"""Laws of the catalogue's effects, in other forms than those fitted, and the twins that leave-one-out conceals with them.

Knees stand where data sheets put them: plateaus of nitinol wire at 360 to 650 MPa, of tubes at 0.6 to 1.3 % strain.
"""

from __future__ import annotations

import numpy as np

from examples.concealed.bending import closing_curvature, strain_per_curvature
from examples.concealed.design import Joint
from examples.concealed.protocol import RELEASING
from examples.concealed.recipes import (
    BEND,
    LENGTH,
    Context,
    Nature,
    Parameters,
    Recipe,
    reverses_at_two_heights,
    sign,
    two_rates,
)

FRICTION = (("tension", *BEND),)


def _tendon_stress(g: np.random.Generator, joint: Joint) -> float:
    """Curvature (1/m) that brings the tendon to 0.6 to 1.1 GPa, at a middling length."""
    area = np.pi * joint.tendon_radius**2
    return float(g.uniform(0.6e9, 1.1e9) * area * joint.arm / (joint.gain(0.025) * joint.rigidity))


def _tube_strain(g: np.random.Generator, joint: Joint) -> float:
    """Curvature (1/m) at which the tubes' outermost fibre is strained by 1.3 to 2.4 %."""
    return float(g.uniform(0.013, 0.024) / strain_per_curvature(joint))


def _closing(g: np.random.Generator, joint: Joint) -> float:
    return float(g.uniform(1.2, 1.8) * closing_curvature(joint.middle))


def _plateau_tension(g: np.random.Generator, c: Context) -> float:
    return float(g.uniform(360e6, 650e6) * np.pi * c.joint.tendon_radius**2)


def _snap(g: np.random.Generator, c: Context) -> Parameters:
    at = g.uniform(0.4, 0.7) / float(c.joint.gain(0.025))
    return {
        "release_tension_n": c.tension * at,
        "return_tension_n": c.tension * at * g.uniform(0.5, 0.75),
        "jump_per_m": c.curvature * g.uniform(0.05, 0.2),
        "groups": int(g.integers(2, 6)),
    }


def _warming(g: np.random.Generator, c: Context) -> Parameters:
    stiffness = g.random() < 0.6
    return {
        "change": sign(g) * (g.uniform(0.03, 0.2) if stiffness else c.curvature * g.uniform(0.03, 0.15)),
        # Two thermal masses in a row: the housing follows the room, the tube follows the housing.
        "housing_s": c.duration * g.uniform(0.2, 1.5),
        "tube_s": c.duration * g.uniform(0.03, 0.3),
        "acts_on": "stiffness" if stiffness else "zero",
    }


PHYSICS: dict[str, Recipe] = {
    "capstan_hysteresis": Recipe(
        "pulleys, notches",
        "physics",
        reverses_at_two_heights,
        lambda g, _c: {
            "log_ratio": g.uniform(0.03, 0.25),
            "law": str(g.choice(["front", "dahl", "maxwell", "lugre"])),
            "pulleys": int(g.integers(3, 8)),
            "far_share": g.uniform(0.0, 0.25),
            "presliding_um": g.uniform(0.4, 3.0),
            "stribeck": g.uniform(0.05, 0.2),
        },
        "log_ratio",
        (0.004, 0.9),
        Nature(("transmission", "structure"), FRICTION, memory=True, rate=False, dissipative=True),
        ("direction",),
        wrist=0.15,
    ),
    "distributed_notch_friction": Recipe(
        "notches",
        "physics",
        lambda p: p.response == "notch",
        lambda g, _c: {"friction": g.uniform(0.08, 0.5), "spread": g.uniform(0.1, 0.4)},
        "friction",
        (0.01, 0.8),
        Nature(("transmission",), ((*BEND, "position"),), memory=True, rate=False, dissipative=True),
        ("notch",),
        wrist=1.0,
    ),
    "coulomb_friction": Recipe(
        "tubes",
        "physics",
        reverses_at_two_heights,
        lambda g, c: {
            "moment_n_mm": c.joint.rigidity * c.curvature * 1e3 * g.uniform(0.02, 0.12),
            "spread": g.uniform(0.15, 0.6),
        },
        "moment_n_mm",
        (0.0, 50.0),
        Nature(("structure",), (BEND,), memory=True, rate=False, dissipative=True),
        ("direction",),
        wrist=0.15,
    ),
    "backlash": Recipe(
        "actuator",
        "physics",
        reverses_at_two_heights,
        lambda g, c: {"width_mm": c.span_mm * g.uniform(0.02, 0.12), "rolling": g.uniform(2.0, 8.0)},
        "width_mm",
        (0.002, 0.8),
        Nature(("drive",), (("stroke",),), memory=True, rate=False, dissipative=None),
        ("direction",),
    ),
    "leadscrew_pitch_error": Recipe(
        "actuator",
        "physics",
        lambda p: p.steps() < 0.035,
        lambda g, c: {
            "amplitude_um": c.span_mm * g.uniform(5, 30),
            "period_mm": 0.635,
            "phase_rad": g.uniform(0, 2 * np.pi),
            "lean": g.uniform(0.15, 0.4),
            "wear": g.uniform(-0.3, 0.3),
        },
        "amplitude_um",
        (1.0, 80.0),
        Nature(("drive",), (("stroke", "turns"),), memory=False, rate=False, dissipative=False),
        ("stroke",),
    ),
    "tendon_superelasticity": Recipe(
        "tendon",
        "physics",
        lambda p: p.has_tension or p.lengths >= 3,
        lambda g, c: {
            "knee_tension_n": _plateau_tension(g, c),
            "extra_compliance": g.uniform(0.5, 6.0),
            "spread": g.uniform(0.03, 0.15),
        },
        "extra_compliance",
        (0.05, 25.0),
        Nature(("tendon",), (("tension",),), memory=False, rate=False, dissipative=False),
        ("tension", "stroke", "curvature"),
        reach=_tendon_stress,
    ),
    "tendon_creep": Recipe(
        "tendon",
        "physics",
        lambda p: p.has_time and p.has("ladder", "ladder_down"),
        lambda g, c: {"stretch_ratio": g.uniform(0.03, 0.2), "time_constant_s": c.duration * g.uniform(0.03, 0.12)},
        "stretch_ratio",
        (0.003, 0.6),
        Nature(("tendon",), (("tension", "time"),), memory=True, rate=True, dissipative=True),
        ("time",),
    ),
    "tendon_permanent_set": Recipe(
        "tendon",
        "physics",
        lambda p: p.has("cycles", "partial"),
        lambda g, c: {
            "threshold_n": c.tension * g.uniform(0.05, 0.4),
            "power": g.uniform(1.2, 1.7),
            "scale_n": c.tension,
            "slack_um_per_n": c.span_mm * 1e3 / c.tension * g.uniform(0.03, 0.2),
        },
        "slack_um_per_n",
        (1.0, 3000.0),
        Nature(("tendon", "drive"), (("tension", "stroke"),), memory=True, rate=False, dissipative=True),
        ("direction", "cycle"),
    ),
    "tube_superelasticity": Recipe(
        "tubes",
        "physics",
        lambda p: p.response == "notch" or p.has_tension or p.lengths >= 3,
        lambda g, _c: {
            "knee_strain": g.uniform(0.006, 0.013),
            "plateau_slope": g.uniform(0.03, 0.1),
            "share": g.uniform(0.3, 1.0),
        },
        "share",
        (0.04, 1.0),
        Nature(("structure",), (BEND,), memory=False, rate=False, dissipative=False),
        ("curvature", "stroke"),
        wrist=0.3,
        reach=_tube_strain,
    ),
    "tube_hysteresis": Recipe(
        "tubes",
        "physics",
        lambda p: reverses_at_two_heights(p) and (p.response == "notch" or p.has_tension or p.lengths >= 2),
        lambda g, _c: {
            "knee_strain": g.uniform(0.006, 0.012),
            "lower_plateau": g.uniform(0.35, 0.75),
            "compliance": g.uniform(0.3, 2.0),
        },
        "compliance",
        (0.02, 8.0),
        Nature(("structure",), (BEND,), memory=True, rate=False, dissipative=True),
        ("direction", "curvature"),
        wrist=0.3,
        reach=_tube_strain,
    ),
    "notch_closure": Recipe(
        "notches",
        "physics",
        lambda p: p.response == "notch",
        lambda g, c: {
            "contact_curvature_per_m": float(closing_curvature(c.joint.middle)) * g.uniform(0.85, 1.05),
            "spread": g.uniform(0.01, 0.06),
            "stiffness_rise": g.uniform(0.4, 8.0),
        },
        "stiffness_rise",
        (0.05, 60.0),
        Nature(("structure",), (BEND,), memory=False, rate=False, dissipative=False),
        ("curvature", "stroke"),
        wrist=1.0,
        reach=_closing,
    ),
    "snap_through": Recipe(
        "tube pair",
        "physics",
        lambda p: p.response != "notch" and p.steps() < 0.05,
        _snap,
        "jump_per_m",
        (0.05, 15.0),
        Nature(("structure",), ((*BEND, "tension"),), memory=True, rate=False, dissipative=True),
        ("curvature", "stroke"),
    ),
    "precurvature": Recipe(
        "tube pair",
        "physics",
        lambda p: p.response == "bend" and p.lengths >= 3 and p.slack_start,
        lambda g, _c: {"curvature_per_m": sign(g) * g.uniform(0.3, 4.0), "lean": g.uniform(-0.3, 0.3)},
        "curvature_per_m",
        (0.02, 12.0),
        Nature(("structure",), (), memory=False, rate=False, dissipative=False),
        ("curvature", "stroke"),
    ),
    "tip_load": Recipe(
        "environment",
        "physics",
        lambda p: p.response == "notch" or (p.lengths >= 3 and p.slack_start),
        lambda g, c: {
            "force_mn": sign(g) * c.joint.rigidity * c.curvature / 0.03 * 1e3 * g.uniform(0.03, 0.2),
            "tilt_rad": g.uniform(-0.4, 0.4),
        },
        "force_mn",
        (0.01, 500.0),
        Nature(("structure",), (LENGTH,), memory=False, rate=False, dissipative=False),
        ("bending_length", "notch"),
        wrist=0.4,
    ),
    "gravity": Recipe(
        "environment",
        "physics",
        lambda p: p.response != "notch" and p.lengths >= 3 and p.slack_start,
        lambda g, _c: {"in_plane": sign(g) * g.uniform(0.5, 1.0)},
        "in_plane",
        (0.1, 1.0),
        Nature(("structure",), (LENGTH,), memory=False, rate=False, dissipative=False),
        ("bending_length", "notch"),
        floor=1.4,
    ),
    "bending_length_offset": Recipe(
        "inner tube",
        "physics",
        lambda p: p.lengths >= 3,
        lambda g, _c: {"offset_mm": sign(g) * g.uniform(0.3, 3.0)},
        "offset_mm",
        (0.05, 5.0),
        Nature(("structure",), (LENGTH,), memory=False, rate=False, dissipative=False),
        ("bending_length",),
    ),
    "thermal_drift": Recipe(
        "material",
        "physics",
        lambda p: p.has_time and p.has("cycles", "rates", "ladder", "ladder_down"),
        _warming,
        "change",
        (0.002, 0.0),
        Nature(("structure", "sensor"), (("time",),), memory=False, rate=False, dissipative=False),
        ("time",),
    ),
    "viscous_friction": Recipe(
        "sheath, tubes",
        "physics",
        two_rates,
        lambda g, c: {
            "drag_n_s_per_mm": c.tension / c.speed * g.uniform(0.01, 0.06),
            "thinning": g.uniform(0.55, 0.9),
            "knee_mm_per_s": c.speed * g.uniform(0.3, 1.5),
        },
        "drag_n_s_per_mm",
        (1e-5, 1e3),
        Nature(("transmission", "structure"), (("rate",),), memory=False, rate=True, dissipative=True),
        ("rate", "direction"),
    ),
    "transmission_compliance": Recipe(
        "cable",
        "physics",
        lambda p: p.has_tension,
        lambda g, c: {
            "compliance_ratio": g.uniform(0.15, 0.8),
            "hardening": g.uniform(0.1, 0.35),
            "scale_n": c.tension,
        },
        "compliance_ratio",
        (0.02, 3.0),
        Nature(("tendon",), (("tension",),), memory=False, rate=False, dissipative=False),
        ("tension", "stroke"),
    ),
}

SENSORS: dict[str, Recipe] = {
    "sensor_lag": Recipe(
        "camera",
        "sensor",
        lambda p: p.has_time and p.rates() > 2.5 and p.has(*RELEASING),
        lambda g, c: {
            "time_constant_s": c.duration * g.uniform(0.004, 0.03),
            "law": str(g.choice(["exposure", "two_stage", "queue"])),
        },
        "time_constant_s",
        (0.001, 60.0),
        Nature(("sensor",), (("rate", "time", *BEND),), memory=True, rate=True, dissipative=None),
        ("rate", "direction"),
    ),
    "camera_scale": Recipe(
        "camera",
        "sensor",
        lambda p: p.response == "curvature" and p.lengths >= 3,
        lambda g, c: {
            "scale": 1 + sign(g) * g.uniform(0.1, 0.35),
            "perspective": g.uniform(-0.004, 0.004),
            "full": c.curvature,
        },
        "scale",
        (0.6, 1.5),
        Nature(("sensor",), (BEND,), memory=False, rate=False, dissipative=None),
        ("curvature",),
        floor=1.0,
    ),
    "camera_offset": Recipe(
        "camera",
        "sensor",
        lambda p: p.response == "bend" and p.lengths >= 3 and p.slack_start,
        lambda g, _c: {"offset": sign(g) * g.uniform(1.0, 6.0), "tilt": g.uniform(-0.1, 0.1)},
        "offset",
        (0.05, 20.0),
        Nature(("sensor",), (), memory=False, rate=False, dissipative=None),
        ("curvature", "stroke"),
    ),
}

JOINT_EFFECTS: dict[str, Recipe] = PHYSICS | SENSORS

# A camera's scale is a stiffness to every recording of curvature alone; other twins are found by fitting (lumped.py).
TWINS: dict[str, tuple[str, ...]] = {"camera_scale": ("youngs_modulus",)}

# Concealed together in leave-one-out: names that are the same law to most recordings, or contain it.
NEAR_TWINS: dict[str, tuple[str, ...]] = {
    "capstan_hysteresis": ("distributed_notch_friction",),
    "distributed_notch_friction": ("capstan_hysteresis",),
    "coulomb_friction": ("backlash",),
    "backlash": ("coulomb_friction",),
    "tube_superelasticity": ("tube_hysteresis",),
    "tube_hysteresis": ("tube_superelasticity",),
    "tendon_superelasticity": ("transmission_compliance",),
    # With the tubes' modulus free, a scale of the load cell is the same line from stroke to curvature and to tension.
    "transmission_compliance": ("tendon_superelasticity", "load_cell_scale"),
    "precurvature": ("camera_offset",),
    "camera_offset": ("precurvature",),
    "tip_load": ("gravity",),
    "gravity": ("tip_load",),
    "bending_length_offset": ("bending_length_label",),
    "sensor_lag": ("viscous_friction",),
    "viscous_friction": ("sensor_lag",),
}
