"""The controls along a planar path: X1 to X4 and psi of P at each feed, how far the body is off, and what is out of reach.

Following the leader, the stage (X4) and the bend (X2) grow together, so that the bend begins where it began, and the
tendon (X1) holds its curvature; beyond the bend the outer tube alone is fed (X3). What is left out: walls that could
guide the body, gravity, and bends of the assembled tubes at rest that no correction names.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass
from math import inf
from typing import Any

import numpy as np

from coast_cli.design.drive_history import drive_along
from coast_cli.design.follow_leader import Body, deviation, follow_path
from coast_cli.design.loading import acting_on_load, corrected_stroke
from coast_cli.design.reach import PLATEAU_STRAIN, Mask, Pulled, Webs, softens, tendon_limits, web_limits
from coast_cli.effects.effect import Effect
from coast_cli.effects.seen import outside_at
from coast_cli.mechanics.joint import Joint, curvature_from_stroke, stroke, tension
from coast_cli.mechanics.section import FloatArray
from coast_cli.recordings.planar_path import PlanarPath
from coast_cli.rows import Drawn, Rows, rows_of
from coast_cli.spec.config import Checks
from coast_cli.units import DEGREE, MILLIMETRE

LARGEST_BEND = 145.0 * DEGREE  # a branch that turns back by more is out of the robot's purpose
_ENDS = 1e-6
_AGREES, _NEAR = 0.01, 0.05  # relative, and 1/m: of the prediction with the curvature asked for


@dataclass(frozen=True, eq=False, repr=False)
class PathPlan(Rows, Drawn):
    """What a path asks of the robot.

    Attributes:
        columns: of the answer, a row a feed; units are in the names. body: which the robot takes. path: that it follows.
        reached: whether every row is within reach. notes: for the user.
    """

    columns: dict[str, Any]
    body: Body
    path: PlanarPath
    reached: bool
    notes: tuple[str, ...]

    def _table(self) -> list[dict[str, Any]]:
        return rows_of(self.columns)


@dataclass(frozen=True, eq=False)
class _Pulled:
    """The tendon at each row: X1 and X2 as commanded (m), tension (N), strain, and the curvature they give (1/m)."""

    stroke: FloatArray
    bending_length: FloatArray
    tension: FloatArray
    strain: FloatArray
    curvature: FloatArray


def plan_path(
    joint: Joint,
    effects: Sequence[Effect],
    path: PlanarPath,
    feed: FloatArray,
    *,
    within: float,
    checks: Checks | None = None,
    back: bool = False,
) -> PathPlan:
    """Return the controls at each feed and what is out of reach.

    Args:
        joint: a pair, or one tube, which cannot be fed on beyond its bend.
        effects: corrections; strokes then follow the history, so the way back has its own.
        feed: arc lengths of the tip along the path, rising, m. back: whether the robot is drawn back through them again.
        within: the most that the body may be off the path, m.
        checks: whose stroke and tendon strain are limits at every row.

    Example:
        >>> joint = coast.build(coast.load_config(coast.REFERENCE)).joint()
        >>> path = coast.path_of_curvature(np.array([0.0, 0.03]), np.array([20.0, 20.0]))
        >>> found = coast.plan_path(joint, (), path, np.array([0.01, 0.02, 0.03]), within=2e-3)
        >>> found.reached
        True
    """
    tubes = [tube for tube in (joint.outer, joint.middle) if tube is not None]
    longest = min(*(tube.length for tube in tubes), inf if joint.outer_cover is None else joint.outer_cover)
    body, far = follow_path(path, longest, within, extends=joint.outer is not None)
    way = ["in"] * feed.size + (["out"] * (feed.size - 1) if back else [])
    feed = np.concatenate((feed, feed[-2::-1])) if back else feed
    bent, beyond = body.bent(feed), body.beyond(feed)
    wanted = np.where(bent > 0.0, abs(body.curvature), 0.0)
    acting, left_out = acting_on_load(effects)
    pulled = _pull(joint, acting, wanted, bent)
    largest, mean = deviation(path, body, feed)
    sign = -1.0 if body.curvature < 0.0 else 1.0
    reasons = [
        (wanted * bent > LARGEST_BEND * (1.0 + 1e-6), f"bent by more than {LARGEST_BEND / DEGREE:g} degrees"),
        *web_limits(wanted, Webs.of(joint), checks, closes=any(effect.id == "notch_closure" for effect in acting)),
        *_pull_reasons(pulled, checks, wanted, tendon=joint.tendon is not None),
        *_feed_reasons(joint, bent, beyond),
        (largest > within, f"the body is more than {within / MILLIMETRE:g} mm off the path"),
    ]
    words = _joined(reasons, feed.size)
    columns: dict[str, Any] = {
        "feed_mm": feed / MILLIMETRE,
        "way": way,
        "stroke_mm": _known(pulled.stroke / MILLIMETRE),
        "bending_length_mm": pulled.bending_length / MILLIMETRE,
        "outer_advance_mm": beyond / MILLIMETRE,
        "stage_advance_mm": (feed - beyond) / MILLIMETRE,
        "roll_deg": np.full(feed.size, path.roll / DEGREE + (180.0 if sign < 0.0 else 0.0)),
        "curvature_per_m": _known(sign * pulled.curvature + 0.0),
        "path_curvature_per_m": path.curvature_at(feed),
        "tension_n": _known(pulled.tension),
        "tendon_strain": _known(pulled.strain),
        "deviation_max_mm": largest / MILLIMETRE,
        "deviation_rms_mm": mean / MILLIMETRE,
        "reachable": [word is None for word in words],
        "reason": words,
    }
    reached = all(word is None for word in words)
    outside = outside_at(
        acting,
        curvature=pulled.curvature,
        stroke=None if joint.tendon is None else pulled.stroke,
        tension=pulled.tension,
        bending_length=pulled.bending_length,
    )
    notes = (*path.notes, *left_out, *outside, *_notes(joint, acting, body, path, far, within, back=back))
    return PathPlan(columns, body, path, reached, notes)


def _pull(joint: Joint, acting: Sequence[Effect], curvature: FloatArray, bent: FloatArray) -> _Pulled:
    """Return the tendon at each row; where nothing bends yet it is just taut."""
    rows, nothing = curvature > 0.0, np.zeros_like(curvature)
    if joint.tendon is None:
        unknown, force = np.full_like(curvature, np.nan), tension(joint, curvature, bent)
        if acting:
            force[rows] = corrected_stroke(joint, acting, bent[rows], curvature[rows], inverse=False).tension
        return _Pulled(unknown, bent, force, unknown, curvature)
    if not acting:
        direct = stroke(joint, curvature, bent)
        back = curvature_from_stroke(joint, direct.stroke, bent)
        return _Pulled(direct.stroke, bent, direct.tension, direct.tendon_strain, back.curvature)
    found = _Pulled(nothing + joint.deadband, bent.copy(), nothing.copy(), nothing.copy(), nothing.copy())
    if rows.any():
        driven = drive_along(joint, joint.tendon, acting, curvature[rows], bent[rows])
        found.stroke[rows], found.bending_length[rows] = driven.stroke, driven.bending_length
        found.tension[rows], found.curvature[rows] = driven.tension, driven.curvature
        found.strain[rows] = driven.stretch / joint.tendon.length
    return found


def _pull_reasons(
    pulled: _Pulled, checks: Checks | None, curvature: FloatArray, *, tendon: bool
) -> list[tuple[Mask, str]]:
    unheld = np.isnan(pulled.stroke if tendon else pulled.tension)
    off = ~unheld & (np.abs(pulled.curvature - curvature) > _AGREES * curvature + _NEAR)
    found = [
        (unheld, "no pull holds this curvature"),
        (off, "pulled so, the model settles at another curvature"),
        (pulled.stroke < 0.0, "the stroke would be below zero"),
    ]
    return [*found, *tendon_limits(Pulled(pulled.stroke, pulled.strain, pulled.tension), checks)]


def _feed_reasons(joint: Joint, bent: FloatArray, beyond: FloatArray) -> list[tuple[Mask, str]]:
    if joint.outer is None:
        return [(beyond > 0.0, "one tube cannot be fed on beyond its bend")]
    length = joint.outer.length
    words = f"X2 + X3 above {length / MILLIMETRE:g} mm: the outer tube's notches no longer cover the bend"
    return [((beyond > 0.0) & (bent + beyond > length * (1.0 + 1e-12)), words)]


def _joined(reasons: Sequence[tuple[Mask, str]], count: int) -> list[str | None]:
    words: list[str | None] = [None] * count
    for mask, text in reasons:
        for row in np.flatnonzero(mask):
            before = words[row]
            words[row] = text if before is None else f"{before}; {text}"
    return words


def _known(values: FloatArray) -> Sequence[float | None]:
    """Return the values, None where there is none."""
    return [None if np.isnan(value) else float(value) for value in values]


def _notes(
    joint: Joint, acting: Sequence[Effect], body: Body, path: PlanarPath, far: float, within: float, *, back: bool
) -> list[str]:
    places = [value / MILLIMETRE for value in (body.start, body.start + body.bend)]
    notes = [
        f"the bend is at {abs(body.curvature):.4g} 1/m from {places[0]:.4g} to {places[1]:.4g} mm."
        if body.bend * abs(body.curvature) > 0.0
        else "the body stays straight."
    ]
    if far < path.length:
        notes.append(
            f"the body stays within {within / MILLIMETRE:g} mm of {far / MILLIMETRE:.4g} of {path.length / MILLIMETRE:.4g} mm: "
            "it has one bend, of one curvature."
        )
    strain = float(Webs.of(joint).strain(np.array([abs(body.curvature)]))[0])
    if body.bend > 0.0 and strain > PLATEAU_STRAIN and not softens(joint, [effect.id for effect in acting]):
        notes.append(
            f"web strain reaches {100.0 * strain:.3g} %: above {100.0 * PLATEAU_STRAIN:g} % nitinol softens, "
            "which the model leaves out."
        )
    if joint.outer_cover is not None and joint.outer_cover <= body.bend * (1.0 + _ENDS):
        cover = joint.outer_cover / MILLIMETRE
        notes.append(f"the bend ends at {cover:g} mm (joint.outer_cover_mm): a longer one would be uneven.")
    beyond = float(body.beyond(np.array([path.length]))[0])
    if joint.outer is not None and beyond > 0.0 and joint.outer.natural_curvature:
        natural = abs(joint.outer.natural_curvature)
        notes.append(
            f"beyond the bend the outer tube counts as straight; its own {natural:g} 1/m would move the tip by up to "
            f"{natural * beyond**2 / 2.0 / MILLIMETRE:.2g} mm."
        )
    if joint.tendon is None:
        notes.append("there is no [tendon], so stroke and tendon strain have no value.")
    elif back and not acting:
        notes.append("without corrections the way out has the strokes of the way in; the real joint lags on release.")
    return notes
