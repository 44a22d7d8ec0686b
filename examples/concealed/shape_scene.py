"""One photograph of a tube or an assembled pair under its weight, with what is left out.

A pair is the composite beam.
"""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass, replace

import numpy as np
from numpy.typing import NDArray

from examples.concealed.design import Robot, Tube, ring, sector
from examples.concealed.shape_beam import ELEMENTS, Strand, solve

Array = NDArray[np.float64]
Parameters = dict[str, float]
GRAVITY = 9.81


@dataclass(frozen=True)
class ShapeRun:
    """One photograph: tube names' indices (both for a pair), natural side up, arc fractions of its points."""

    outer: int | None
    middle: int | None
    up: bool
    points: Array


@dataclass(frozen=True)
class Scene:
    """Everything that makes the shapes of a case."""

    robot: Robot
    runs: tuple[ShapeRun, ...]
    modulus: float
    natural: Mapping[str, float]
    effects: Mapping[str, Parameters]


def tubes_of(robot: Robot, run: ShapeRun) -> list[Tube]:
    """Return the tubes of a photograph, the outer first."""
    return ([robot.outers[run.outer]] if run.outer is not None else []) + (
        [robot.middles[run.middle]] if run.middle is not None else []
    )


def chord_moments(tube: Tube) -> tuple[float, float]:
    """Area (m^2) and second moment (m^4) of the strip left by a straight laser cut."""
    ro, ri = tube.outer_diameter / 2, tube.inner_diameter / 2
    rise = tube.depth - ro
    parts = []
    for radius in (ro, ri):
        if abs(rise) >= radius:
            parts.append((0.0, 0.0, 0.0))
            continue
        a = float(np.arccos(rise / radius))
        lune = a - np.sin(a) * np.cos(a)
        parts.append(
            (
                radius**2 * lune,
                2 * radius / 3 * np.sin(a) ** 3 / lune,
                radius**4 / 4 * (lune + 2 * np.sin(a) ** 3 * np.cos(a)),
            )
        )
    (ao, yo, jo), (ai, yi, ji) = parts
    area = ao - ai
    axis = (yo * ao - yi * ai) / area
    return float(area), float(jo - ji - area * axis**2)


def end_length(tube: Tube, scale: float) -> float:
    """Extra cut length (m) of the notch end effect, shaped after the solid-element figures.

    Falls with depth, grows with the ring.
    """
    ro = tube.outer_diameter / 2
    return float(
        scale
        * ro
        * np.interp(tube.depth / ro, [1.45, 1.57, 1.75, 1.88], [0.80, 0.73, 0.58, 0.47])
        * np.interp(tube.uncut / ro, [0.5, 1.5, 3.0], [0.53, 1.0, 1.2])
    )


def _cells(
    tube: Tube, modulus: float, effects: Mapping[str, Parameters], *, chosen: bool
) -> tuple[Array, Array, Array, Array]:
    """Length, rigidity, weight and strip-axis offset of a tube, element by element."""
    if chosen and (error := effects.get("notch_depth_error")):
        tube = replace(tube, depth=min(tube.depth + error["error_um"] * 1e-6, 0.97 * tube.outer_diameter))
    area, axis, moment = sector(tube)
    if "chord_section" in effects:
        area, moment = chord_moments(tube)
    if end := effects.get("notch_end_effect"):
        # The extra compliance sits where the strip meets the ring; the pitch keeps its length.
        moment = tube.cut / (tube.cut / moment + end_length(tube, end["scale"]) * (1 / moment - 1 / ring(tube)[1]))
    full, stiff = ring(tube)
    length = np.tile(np.repeat([tube.uncut, tube.cut], ELEMENTS) / ELEMENTS, tube.count)
    rigidity = modulus * np.tile(np.repeat([stiff, moment], ELEMENTS), tube.count)
    if defect := effects.get("local_stiffness_defect"):
        cell = int(defect["at_share"] * tube.count)
        for pitch in range(cell, cell + int(defect["pitches"])):
            rigidity[2 * ELEMENTS * pitch + ELEMENTS : 2 * ELEMENTS * (pitch + 1)] *= defect["stiffness_ratio"]
    weight = 6450.0 * GRAVITY * np.tile(np.repeat([full, area], ELEMENTS), tube.count)
    return length, rigidity, weight, np.tile(np.repeat([0.0, axis], ELEMENTS), tube.count)


def photograph(scene: Scene, run: ShapeRun) -> Array:
    """Noiseless points [n, 2] (mm) of one run."""
    effects, robot = scene.effects, scene.robot
    outer = None if run.outer is None else robot.outers[run.outer]
    middle = None if run.middle is None else robot.middles[run.middle]
    flip = 1.0 if run.up else -1.0
    tubes = [tube for tube in (outer, middle) if tube is not None]
    first = tubes[0]
    chosen = (run.outer if run.outer is not None else -1 - (run.middle or 0)) == (
        scene.runs[0].outer if scene.runs[0].outer is not None else -1 - (scene.runs[0].middle or 0)
    )
    cells = [_cells(tube, scene.modulus, effects, chosen=chosen) for tube in tubes]
    length, rigidity, weight = cells[0][0], sum(cell[1] for cell in cells), sum(cell[2] for cell in cells)
    s = np.cumsum(length) - length / 2
    total = float(length.sum())
    roll = np.radians(effects.get("roll_misalignment", {}).get("roll_deg", 0.0))
    if len(tubes) == 2:
        # Default: the outer curves against gravity, the middle along it.
        pull = cells[0][1] * scene.natural[first.name] - cells[1][1] * scene.natural[tubes[1].name] * np.cos(roll)
        natural = flip * pull / rigidity
        sideways = cells[1][1] * scene.natural[tubes[1].name] * np.sin(roll) / rigidity
        if friction := effects.get("assembly_friction"):
            natural = natural + friction["moment_n_mm"] * 1e-3 / rigidity * np.sign(s - total / 3)
    else:
        natural, sideways = np.full(length.size, flip * scene.natural[first.name]), np.zeros(length.size)
    if (gradient := effects.get("precurvature_gradient")) and chosen:
        natural = natural * (1 + gradient["share"] * (s / total - 0.5))
    if wavy := effects.get("wavy_heat_set"):
        natural = natural + flip * wavy["amplitude_per_m"] * np.sin(
            2 * np.pi * wavy["waves"] * s / total + wavy["phase_rad"]
        )
    if late := effects.get("late_heat_set"):
        beyond = np.maximum(s / total - late["from_share"], 0.0) / (1.0 - late["from_share"])
        natural = natural + flip * late["growth_per_m"] * beyond**1.5
    if coat := effects.get("half_coated"):
        weight = weight * (1 + coat["extra_weight"] * (s > coat["from_share"] * total))
    weight = weight * effects.get("gravity", {}).get("in_plane", 1.0)
    axis = np.zeros(length.size)
    if offset := effects.get("neutral_axis_offset"):
        axis = flip * cells[0][3] * offset["share"]
    wind = effects.get("draught", {}).get("share_of_weight", 0.0) * float((weight * length).sum())
    strand = Strand(length, rigidity, weight, natural, axis)
    floor = None
    tilt = np.radians(effects.get("base_tilt", {}).get("angle_deg", 0.0))
    if contact := effects.get("table_contact"):
        free = solve(strand, tilt=tilt)
        floor = float(min(free.y.min() * contact["depth_share"], -2e-3))
    shape = solve(
        strand, tilt=tilt, down=effects.get("tip_load", {}).get("force_mn", 0.0) * 1e-3, outward=wind, floor=floor
    )
    turned = np.cumsum(sideways * length)
    x, y = shape.x, shape.y
    if roll:
        # Out of plane the camera sees the projection.
        x = np.concatenate([[0.0], np.cumsum(np.diff(x) * np.cos(turned))])
        y = np.concatenate([[0.0], np.cumsum(np.diff(y) * np.cos(turned))])
    at = run.points * total
    points = 1e3 * np.column_stack([np.interp(at, shape.s, x), np.interp(at, shape.s, y)])
    return _lens(points, effects)


def _lens(points: Array, effects: Mapping[str, Parameters]) -> Array:
    if scale := effects.get("camera_scale"):
        points = points * scale["scale"]
    if tilt := effects.get("camera_tilt"):
        points = (
            points * np.array([1.0, 1 - tilt["foreshortening"]]) / (1 + tilt["foreshortening"] * points[:, :1] / 100)
        )
    if lens := effects.get("lens_distortion"):
        centre = points.mean(axis=0)
        radius = ((points - centre) ** 2).sum(axis=1, keepdims=True) / 50.0**2
        points = centre + (points - centre) * (1 + lens["radial"] * radius)
    return points
