"""What can be left out of a shape: its component, the photographs that can show it, and random parameters."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass

import numpy as np

from examples.concealed.shape_scene import Parameters, ShapeRun


@dataclass(frozen=True)
class ShapeRecipe:
    """One left-out effect of shapes: its parameters, what recordings show it, and its amplitude for scaling."""

    component: str
    kind: str
    needs: Callable[[tuple[ShapeRun, ...]], bool]
    draw: Callable[[np.random.Generator], Parameters]
    amplitude: str
    limits: tuple[float, float]
    near: tuple[str, ...] = ()


def single_tubes(runs: tuple[ShapeRun, ...]) -> bool:
    """Return whether no photograph shows a pair."""
    return all(run.outer is None or run.middle is None for run in runs)


def has_pairs(runs: tuple[ShapeRun, ...]) -> bool:
    """Return whether a photograph shows a pair."""
    return any(run.outer is not None and run.middle is not None for run in runs)


def tube_count(runs: tuple[ShapeRun, ...]) -> int:
    """Return how many tubes or pairs are shown."""
    return len({(run.outer, run.middle) for run in runs})


def both_ways(runs: tuple[ShapeRun, ...]) -> bool:
    """Return whether every tube is shown both ways up."""
    return len({run.up for run in runs}) == 2 and len(
        {(run.outer, run.middle, run.up) for run in runs}
    ) == 2 * tube_count(runs)


def _sign(g: np.random.Generator) -> float:
    return float(g.choice([-1.0, 1.0]))


def _defect(g: np.random.Generator) -> Parameters:
    """Return a cracked notch or two, or a place where solder has stiffened a few."""
    if g.random() < 0.75:
        return {"pitches": float(g.integers(1, 3)), "stiffness_ratio": g.uniform(0.05, 0.5)}
    return {"pitches": float(g.integers(3, 9)), "stiffness_ratio": g.uniform(4.0, 15.0)}


SHAPE_EFFECTS: dict[str, ShapeRecipe] = {
    "base_tilt": ShapeRecipe(
        "clamp", "physics", single_tubes, lambda g: {"angle_deg": _sign(g) * g.uniform(0.3, 5)}, "angle_deg", (0.02, 10)
    ),
    "tip_load": ShapeRecipe(
        "environment",
        "physics",
        lambda r: single_tubes(r) and both_ways(r),
        lambda g: {"force_mn": g.uniform(0.02, 0.4)},
        "force_mn",
        (0.001, 3),
    ),
    "precurvature_gradient": ShapeRecipe(
        "tube",
        "physics",
        lambda r: single_tubes(r) and both_ways(r),
        lambda g: {"share": _sign(g) * g.uniform(0.2, 1.0), "tube": 0.0},
        "share",
        (0.01, 3),
    ),
    "local_stiffness_defect": ShapeRecipe(
        "notch",
        "physics",
        lambda r: single_tubes(r) and tube_count(r) == 1,
        lambda g: {"at_share": g.uniform(0.08, 0.55), **_defect(g)},
        "stiffness_ratio",
        (0.02, 0.9),
    ),
    "notch_depth_error": ShapeRecipe(
        "tube",
        "parameter",
        lambda r: single_tubes(r) and both_ways(r) and tube_count(r) >= 3,
        lambda g: {"error_um": _sign(g) * g.uniform(4, 25), "tube": 0.0},
        "error_um",
        (0.5, 30),
    ),
    "chord_section": ShapeRecipe(
        "tube",
        "physics",
        lambda r: single_tubes(r) and both_ways(r) and tube_count(r) >= 3,
        lambda _g: {"share": 1.0},
        "share",
        (1, 1),
    ),
    "notch_end_effect": ShapeRecipe(
        "tube",
        "physics",
        lambda r: single_tubes(r) and both_ways(r) and tube_count(r) >= 3,
        lambda g: {"scale": g.uniform(0.7, 1.3)},
        "scale",
        (0.6, 1.4),
    ),
    "neutral_axis_offset": ShapeRecipe(
        "tube",
        "physics",
        lambda r: single_tubes(r) and both_ways(r),
        lambda g: {"share": g.uniform(0.85, 1.15)},
        "share",
        (0.8, 1.2),
    ),
    "roll_misalignment": ShapeRecipe(
        "pair", "physics", has_pairs, lambda g: {"roll_deg": g.uniform(5, 30)}, "roll_deg", (3, 40)
    ),
    "camera_scale": ShapeRecipe(
        "camera",
        "sensor",
        lambda _r: True,
        lambda g: {"scale": 1 + _sign(g) * g.uniform(0.01, 0.06)},
        "scale",
        (0.85, 1.15),
    ),
}
# Artefacts of the camera that look like a natural curvature or a gradient of it.
SHAPE_SENSOR: dict[str, ShapeRecipe] = {
    "camera_tilt": ShapeRecipe(
        "camera",
        "sensor",
        lambda _r: True,
        lambda g: {"foreshortening": g.uniform(0.01, 0.06)},
        "foreshortening",
        (0.002, 0.2),
        ("camera_scale",),
    ),
    "lens_distortion": ShapeRecipe(
        "camera",
        "sensor",
        lambda _r: True,
        lambda g: {"radial": _sign(g) * g.uniform(0.01, 0.06)},
        "radial",
        (0.002, 0.2),
        ("camera_scale",),
    ),
}
SHAPE_OUTSIDE: dict[str, ShapeRecipe] = {
    "late_heat_set": ShapeRecipe(
        "outside",
        "outside",
        lambda r: single_tubes(r) and tube_count(r) == 1,
        lambda g: {"growth_per_m": _sign(g) * g.uniform(2, 12), "from_share": g.uniform(0.15, 0.6)},
        "growth_per_m",
        (0.2, 40),
        ("precurvature_gradient",),
    ),
    "wavy_heat_set": ShapeRecipe(
        "outside",
        "outside",
        single_tubes,
        lambda g: {"amplitude_per_m": g.uniform(1, 6), "waves": g.uniform(2.5, 6), "phase_rad": g.uniform(0, 6.28)},
        "amplitude_per_m",
        (0.1, 12),
    ),
    "half_coated": ShapeRecipe(
        "outside",
        "outside",
        single_tubes,
        lambda g: {"extra_weight": g.uniform(0.3, 1.5), "from_share": g.uniform(0.3, 0.6)},
        "extra_weight",
        (0.02, 4),
        ("tip_load", "gravity"),
    ),
    "table_contact": ShapeRecipe(
        "outside",
        "outside",
        lambda r: single_tubes(r) and any(not run.up for run in r),
        lambda g: {"depth_share": g.uniform(0.4, 0.8)},
        "depth_share",
        (0.2, 0.95),
        ("tip_load",),
    ),
    "assembly_friction": ShapeRecipe(
        "outside",
        "outside",
        has_pairs,
        lambda g: {"moment_n_mm": _sign(g) * g.uniform(0.002, 0.03)},
        "moment_n_mm",
        (1e-4, 0.2),
        ("coulomb_friction",),
    ),
    "draught": ShapeRecipe(
        "outside",
        "outside",
        single_tubes,
        lambda g: {"share_of_weight": _sign(g) * g.uniform(0.05, 0.4)},
        "share_of_weight",
        (0.005, 1.0),
        ("tip_load",),
    ),
}
SHAPE_RECIPES = SHAPE_EFFECTS | SHAPE_SENSOR | SHAPE_OUTSIDE
SHAPE_NEUTRAL = {"stiffness_ratio": 1.0, "scale": 1.0}
# Recordings in which calibration takes the effect for a modulus or a natural curvature.
SHAPE_HIDING: dict[str, tuple[str, ...]] = {
    "notch_end_effect": ("youngs_modulus", "chord_section", "notch_depth_error"),
    "chord_section": ("youngs_modulus", "notch_end_effect", "notch_depth_error"),
    "notch_depth_error": ("youngs_modulus", "notch_end_effect", "chord_section"),
    "gravity": ("youngs_modulus",),
}
