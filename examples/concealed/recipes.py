"""What can be left out: for each effect its component, the protocols that can show it, and random parameters.

`amplitude` names the parameter that is scaled until the effect stands the wanted number of noise widths above the
refitted base model; `limits` keep it physical; `floor` is the least size (noise widths) at which a case counts as
L1. `near` lists names that would not be wrong for something outside the catalogue.
"""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass

import numpy as np

from examples.concealed.design import Joint
from examples.concealed.protocol import RELEASING, Needs, Protocol

Parameters = dict[str, object]


@dataclass(frozen=True)
class Context:
    """Sizes an effect's parameters scale with: largest curvature (1/m), actuator tension (N).

    Stroke span (mm), duration (s).
    """

    joint: Joint
    curvature: float
    tension: float
    span_mm: float
    duration: float
    dt: float
    bend: bool


@dataclass(frozen=True)
class Recipe:
    """One effect: how it is drawn and when a recording can show it."""

    component: str
    kind: str
    needs: Needs
    draw: Callable[[np.random.Generator, Context], Parameters]
    amplitude: str
    limits: tuple[float, float]
    axes: tuple[str, ...]
    near: tuple[str, ...] = ()
    wrist: float = 0.0
    floor: float = 2.4


def _sign(rng: np.random.Generator) -> float:
    return float(rng.choice([-1.0, 1.0]))


def _reverses_at_two_heights(p: Protocol) -> bool:
    return p.has("partial", "cycles") or (
        sum(run.kind in RELEASING for run in p.runs) >= 2 and p.has("partial", "cycles", "ladder_down")
    )


def _lengths(number: int) -> Needs:
    return lambda p: p.response == "notch" or p.lengths >= number


def _snap(g: np.random.Generator, c: Context) -> Parameters:
    at = g.uniform(0.4, 0.7) / float(c.joint.gain(0.025))
    return {
        "release_tension_n": c.tension * at,
        "return_tension_n": c.tension * at * g.uniform(0.5, 0.75),
        "jump_per_m": c.curvature * g.uniform(0.05, 0.2),
        "groups": int(g.integers(1, 4)),
    }


JOINT_EFFECTS: dict[str, Recipe] = {
    "capstan_hysteresis": Recipe(
        "pulleys, notches",
        "physics",
        _reverses_at_two_heights,
        lambda g, _c: {
            "log_ratio": g.uniform(0.03, 0.25),
            "law": str(g.choice(["front", "dahl", "maxwell"])),
            "pulleys": int(g.integers(3, 8)),
            "far_share": g.uniform(0.0, 0.25),
            "presliding_um": g.uniform(0.4, 2.0),
        },
        "log_ratio",
        (0.004, 0.9),
        ("direction",),
        wrist=0.15,
    ),
    "distributed_notch_friction": Recipe(
        "notches",
        "physics",
        lambda p: p.response == "notch",
        lambda g, _c: {"friction": g.uniform(0.08, 0.5)},
        "friction",
        (0.01, 0.8),
        ("notch",),
        wrist=1.0,
    ),
    "coulomb_friction": Recipe(
        "tubes",
        "physics",
        _reverses_at_two_heights,
        lambda g, c: {
            "moment_n_mm": c.joint.rigidity * c.curvature * 1e3 * g.uniform(0.02, 0.12),
            "spread": g.uniform(0.05, 0.4),
        },
        "moment_n_mm",
        (0.0, 50.0),
        ("direction",),
        wrist=0.15,
    ),
    "backlash": Recipe(
        "actuator",
        "physics",
        _reverses_at_two_heights,
        lambda g, c: {"width_mm": c.span_mm * g.uniform(0.02, 0.12)},
        "width_mm",
        (0.002, 0.8),
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
        },
        "amplitude_um",
        (1.0, 80.0),
        ("stroke",),
    ),
    "tendon_superelasticity": Recipe(
        "tendon",
        "physics",
        lambda p: p.has_tension or p.lengths >= 3,
        lambda g, c: {
            "knee_tension_n": c.tension * g.uniform(0.4, 0.75),
            "extra_compliance": g.uniform(0.3, 3.0),
            "width_n": c.tension * g.uniform(0.01, 0.05),
        },
        "extra_compliance",
        (0.05, 12.0),
        ("tension", "stroke", "curvature"),
    ),
    "tendon_creep": Recipe(
        "tendon",
        "physics",
        lambda p: p.has_time and p.has("ladder", "ladder_down"),
        lambda g, c: {"stretch_ratio": g.uniform(0.03, 0.2), "time_constant_s": c.duration * g.uniform(0.03, 0.12)},
        "stretch_ratio",
        (0.003, 0.6),
        ("time",),
    ),
    "tendon_permanent_set": Recipe(
        "tendon",
        "physics",
        lambda p: p.has("cycles", "partial"),
        lambda g, c: {
            "threshold_n": c.tension * g.uniform(0.05, 0.4),
            "width_n": c.tension * 0.03,
            "slack_um_per_n": c.span_mm * 1e3 / c.tension * g.uniform(0.03, 0.2),
        },
        "slack_um_per_n",
        (1.0, 3000.0),
        ("direction", "cycle"),
    ),
    "tube_superelasticity": Recipe(
        "tubes",
        "physics",
        lambda p: p.response == "notch" or p.has_tension or p.lengths >= 3,
        lambda g, c: {
            "knee_curvature_per_m": c.curvature * g.uniform(0.4, 0.75),
            "width_per_m": c.curvature * g.uniform(0.01, 0.06),
            "stiffness_ratio": g.uniform(0.2, 0.8),
        },
        "stiffness_ratio",
        (0.06, 0.97),
        ("curvature", "stroke"),
        wrist=0.3,
    ),
    "notch_closure": Recipe(
        "notches",
        "physics",
        lambda _p: True,
        lambda g, c: {
            "contact_curvature_per_m": c.curvature * g.uniform(0.5, 0.8),
            "width_per_m": c.curvature * g.uniform(0.005, 0.03),
            "stiffness_rise": g.uniform(0.4, 8.0),
        },
        "stiffness_rise",
        (0.05, 60.0),
        ("curvature", "stroke"),
        wrist=0.3,
    ),
    "snap_through": Recipe(
        "tube pair",
        "physics",
        lambda p: p.response != "notch" and p.steps() < 0.05,
        _snap,
        "jump_per_m",
        (0.05, 15.0),
        ("curvature", "stroke"),
    ),
    "precurvature": Recipe(
        "tube pair",
        "physics",
        lambda p: p.response == "bend" and p.lengths >= 3 and p.slack_start,
        lambda g, _c: {"curvature_per_m": _sign(g) * g.uniform(0.3, 4.0)},
        "curvature_per_m",
        (0.02, 12.0),
        ("curvature", "stroke"),
    ),
    "tip_load": Recipe(
        "environment",
        "physics",
        lambda p: p.response == "notch" or (p.lengths >= 3 and p.slack_start),
        lambda g, c: {
            "force_mn": _sign(g) * c.joint.rigidity * c.curvature / 0.03 * 1e3 * g.uniform(0.03, 0.2),
            "tilt_rad": g.uniform(-0.4, 0.4),
        },
        "force_mn",
        (0.01, 500.0),
        ("bending_length", "notch"),
        wrist=0.4,
    ),
    "gravity": Recipe(
        "environment",
        "physics",
        lambda p: p.response != "notch" and p.lengths >= 3 and p.slack_start,
        lambda g, _c: {"in_plane": _sign(g) * g.uniform(0.5, 1.0)},
        "in_plane",
        (0.1, 1.0),
        ("bending_length", "notch"),
        floor=1.4,
    ),
    "bending_length_offset": Recipe(
        "inner tube",
        "physics",
        lambda p: p.lengths >= 3,
        lambda g, _c: {"offset_mm": _sign(g) * g.uniform(0.3, 3.0)},
        "offset_mm",
        (0.05, 5.0),
        ("bending_length",),
    ),
    "thermal_drift": Recipe(
        "material",
        "physics",
        lambda p: p.has_time and p.has("cycles", "rates", "ladder", "ladder_down"),
        lambda g, c: (
            {
                "change": _sign(g) * g.uniform(0.03, 0.2),
                "time_constant_s": c.duration * g.uniform(0.3, 2.0),
                "acts_on": "stiffness",
            }
            if g.random() < 0.6
            else {
                "change": _sign(g) * c.curvature * g.uniform(0.03, 0.15),
                "time_constant_s": c.duration * g.uniform(0.3, 2.0),
                "acts_on": "zero",
            }
        ),
        "change",
        (0.002, 0.0),
        ("time",),
    ),
    "sensor_lag": Recipe(
        "camera",
        "sensor",
        lambda p: p.has_time and p.rates() > 2.5 and p.has(*RELEASING),
        lambda g, c: {
            "time_constant_s": c.duration * g.uniform(0.004, 0.03),
            "law": str(g.choice(["delay", "one_stage", "two_stage"])),
        },
        "time_constant_s",
        (0.001, 60.0),
        ("rate", "direction"),
    ),
    "camera_scale": Recipe(
        "camera",
        "sensor",
        lambda p: p.response == "curvature" and p.lengths >= 3,
        lambda g, _c: {"scale": 1 + _sign(g) * g.uniform(0.1, 0.35)},
        "scale",
        (0.6, 1.5),
        ("curvature",),
        floor=1.0,
    ),
    "camera_offset": Recipe(
        "camera",
        "sensor",
        lambda p: p.response == "bend" and p.lengths >= 3 and p.slack_start,
        lambda g, _c: {"offset": _sign(g) * g.uniform(1.0, 6.0)},
        "offset",
        (0.05, 20.0),
        ("curvature", "stroke"),
    ),
}


OUTSIDE: dict[str, Recipe] = {
    "wire_pull_coupling": Recipe(
        "outside",
        "outside",
        lambda p: p.lengths >= 2,
        lambda g, c: {"pull_mm_per_n": _sign(g) * 2.0 / c.tension * g.uniform(0.3, 1.5)},
        "pull_mm_per_n",
        (0.01, 30.0),
        (),
        near=("bending_length_offset",),
    ),
    "room_temperature_cycle": Recipe(
        "outside",
        "outside",
        lambda p: p.has_time and p.has("cycles", "rates", "ladder_down"),
        lambda g, c: {"change": g.uniform(0.03, 0.15), "period_s": c.duration * g.uniform(0.2, 0.6)},
        "change",
        (0.003, 0.4),
        (),
        near=("thermal_drift",),
    ),
    "notch_crack": Recipe(
        "outside",
        "outside",
        lambda p: p.has("triangle", "cycles", "partial", "rates"),
        lambda g, _c: {
            "at_share": g.uniform(0.3, 0.6),
            "notch_share": g.uniform(0.02, 0.08),
            "compliance_ratio": g.uniform(2.0, 5.0),
        },
        "compliance_ratio",
        (1.1, 12.0),
        (),
        near=("snap_through",),
    ),
    "clock_drop": Recipe(
        "outside",
        "outside",
        lambda p: p.has("triangle", "cycles", "partial"),
        lambda g, _c: {"at_share": g.uniform(0.15, 0.4), "frames": float(g.integers(2, 9))},
        "frames",
        (1.0, 14.0),
        (),
        near=("sensor_lag",),
    ),
    "wrinkled_sheath": Recipe(
        "outside",
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
        (),
        near=("leadscrew_pitch_error",),
    ),
    "termination_slip": Recipe(
        "outside",
        "outside",
        lambda p: p.has("cycles", "partial", "triangle"),
        lambda g, c: {
            "at_tension_n": tuple(sorted(c.tension * g.uniform(0.25, 0.9, int(g.integers(2, 5))))),
            "step_um": c.span_mm * g.uniform(10, 50),
        },
        "step_um",
        (2.0, 400.0),
        (),
        near=("tendon_permanent_set",),
    ),
    "viscous_friction": Recipe(
        "outside",
        "outside",
        lambda p: p.has_time and p.rates() > 2.5 and p.has(*RELEASING),
        lambda g, c: {"drag_n_s_per_mm": c.tension / (c.span_mm / c.duration) * g.uniform(0.01, 0.06)},
        "drag_n_s_per_mm",
        (1e-5, 1e3),
        (),
        near=("sensor_lag",),
    ),
    "lens_rolling": Recipe(
        "outside",
        "outside",
        lambda p: p.response != "notch",
        lambda g, _c: {
            "amplitude": g.uniform(0.3, 2.0),
            "turns": g.uniform(1.2, 2.6),
            "phase_rad": g.uniform(0, 2 * np.pi),
        },
        "amplitude",
        (0.05, 6.0),
        (),
    ),
    "work_hardening": Recipe(
        "outside",
        "outside",
        lambda p: p.has("cycles", "partial", "rates"),
        lambda g, c: {"rise": g.uniform(0.05, 0.3), "path_rad": c.curvature * 0.025 * g.uniform(1.5, 5.0)},
        "rise",
        (0.005, 1.0),
        (),
        near=("thermal_drift",),
    ),
    "camera_bump": Recipe(
        "outside",
        "outside",
        lambda p: p.response != "notch" and p.has("cycles", "partial", "triangle"),
        lambda g, _c: {"at_share": g.uniform(0.25, 0.7), "step": _sign(g) * g.uniform(0.5, 3.0)},
        "step",
        (0.05, 10.0),
        (),
        near=("camera_offset",),
    ),
    "ringing": Recipe(
        "outside",
        "outside",
        lambda p: p.has_time and p.rates() > 2.0 and p.has("ladder", "ladder_down", "rates"),
        lambda g, c: {"period_s": c.dt * g.uniform(8, 20), "damping": g.uniform(0.02, 0.08)},
        "period_s",
        (1e-3, 60.0),
        (),
        near=("sensor_lag",),
    ),
}

RECIPES: dict[str, Recipe] = JOINT_EFFECTS | OUTSIDE

# A camera's scale is a stiffness to every recording of curvature alone; other twins are found by fitting (see lumped.py).
TWINS: dict[str, tuple[str, ...]] = {"camera_scale": ("youngs_modulus",)}
