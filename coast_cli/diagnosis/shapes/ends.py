"""Whether a trace that is shorter than its tube ends before the tip, or shows the whole tube smaller than it is.

A trace that ends early says nothing about the tip, and its points lie where they were seen. A camera's scale, its lens or
a turn out of the plane shorten the whole picture. Both are fitted; the points across the line decide, and what shortens all
photographs alike needs less to be believed.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import replace
from typing import TYPE_CHECKING, Any

import numpy as np

from coast_cli.diagnosis.fit import Fit, fit
from coast_cli.diagnosis.noise_model import NoiseBank
from coast_cli.diagnosis.shapes.forward import Forward
from coast_cli.diagnosis.shapes.photograph import Photograph
from coast_cli.diagnosis.thresholds import BEGINS_LATE, EFFECT_NATS, ENDS_EARLY, ENDS_EARLY_NATS
from coast_cli.units import MILLIMETRE

if TYPE_CHECKING:
    from coast_cli.diagnosis.shapes.problem import ShapeProblem

_STEPS = 8
_MOST_NATS_A_TIP = 30.0
_TIP_NOISE = 3.0  # noise levels by which a blurred tip may be off
_LONG_NOISE = 5.0  # noise levels beyond which a tip is missed for another reason
_DEGREE = 5  # of the polynomial by which points are moved along the line that fits
# What shortens a picture, or lengthens it.
_SHORTENING = ("camera_scale", "camera_tilt", "lens_distortion", "roll_misalignment", "neutral_axis_offset")


def with_ends_settled(problem: ShapeProblem) -> ShapeProblem:
    """Return the problem with those last points that are not the tip no longer taken for it."""
    short = [_is_short(photograph) for photograph in problem.photographs]
    if not any(short):
        return problem
    early = _ending_early(problem, short)
    fitted = fit(early, steps=_STEPS, until="fine")
    missed = [short or miss for short, miss in zip(short, _missed_tips(early, fitted), strict=True)]
    if missed != short:
        early = _ending_early(problem, missed)
        fitted = fit(early, steps=_STEPS, until="fine")
    price = min(ENDS_EARLY_NATS * sum(missed), float(EFFECT_NATS))
    if not _ends_early(problem, _across(early, fitted) - price):
        return problem
    return _on_the_line(early, fitted)


def early_ends(photographs: Sequence[Photograph]) -> list[str]:
    """Return a sentence on what the photographs do not show of their tubes."""
    ends, begins = [], []
    for photograph in photographs:
        missing = photograph.length - float(photograph.at[-1])
        if not photograph.shows_tip and missing > 0.0:
            ends.append(f"{photograph.run.name} {missing / MILLIMETRE:.3g} mm before the tip")
        if photograph.begins_at > BEGINS_LATE * photograph.length:
            begins.append(f"{photograph.run.name} {photograph.begins_at / MILLIMETRE:.3g} mm after the clamp")
    said = [f"ends: {', '.join(ends)}"] if ends else []
    said += [f"begins: {', '.join(begins)}"] if begins else []
    return [f"not the whole tube is seen ({'; '.join(said)}); what is not seen is not counted"] if said else []


def _is_short(photograph: Photograph) -> bool:
    open_ended = photograph.shows_tip and not photograph.placed.all()
    return open_ended and photograph.recorded_length < (1.0 - ENDS_EARLY) * photograph.length


def _ending_early(problem: ShapeProblem, early: Sequence[bool]) -> ShapeProblem:
    pairs = zip(problem.photographs, early, strict=True)
    taken = [photograph.ending_early() if one else photograph for photograph, one in pairs]
    return replace(problem, forward=Forward(taken, problem.forward.gravity))


def _missed_tips(problem: ShapeProblem, fitted: Fit) -> list[bool]:
    """Return which last points, taken for the tip, lie before it by more than noise."""
    noise = max(_LONG_NOISE * fitted.evidence.level, 1e-9)
    found = []
    for photograph, rows, (_, along) in zip(problem.photographs, problem.slices, problem.rows, strict=True):
        is_open = photograph.shows_tip and not photograph.placed.all() and bool(along.any())
        found.append(is_open and float(fitted.residual[rows.stop - 1]) < -noise)
    return found


def _ends_early(problem: ShapeProblem, without: float) -> bool:
    """Return whether no tube seen whole, in a shortened picture or not, is likelier than traces that end early."""
    if _across(problem, fit(problem, steps=_STEPS, until="fine")) >= without:
        return False
    starts: dict[str, Any] = {}
    for contender in problem.candidates(()):
        for start in contender.starts:
            if start.id in _SHORTENING:
                starts.setdefault(start.id, start)
    fits = (fit(problem, (start,), steps=_STEPS, until="fine") for start in starts.values())
    return all(_across(problem, one) - EFFECT_NATS < without for one in fits)


def _across(problem: ShapeProblem, fitted: Fit) -> float:
    """Return the log likelihood of what lies across the line, less what the tips miss."""
    sequences = [np.flatnonzero(across) for across, _ in problem.rows]
    found = NoiseBank(sequences).evidence(fitted.residual[~problem.along])
    along = fitted.residual[problem.along] / (_TIP_NOISE * max(found.level, 1e-9))
    return found.log_likelihood - float(np.sum(np.minimum(0.5 * along**2, _MOST_NATS_A_TIP)))


def _on_the_line(problem: ShapeProblem, fitted: Fit) -> ShapeProblem:
    """Return the problem with points of traces that end early moved along the line to where they were seen."""
    state = problem.state(fitted.coordinates, fitted.effects)
    lines = problem.forward.lines([(index, state) for index in range(len(problem.photographs))])
    moved = []
    for photograph, line in zip(problem.photographs, lines, strict=True):
        if photograph.shows_tip:
            moved.append(photograph)
            continue
        dx, dy = photograph.run.x - line.x[0], photograph.run.y - line.y[0]
        degree = min(_DEGREE, max(len(photograph.run) // 6, 1))
        along = dx * line.along_x[0] + dy * line.along_y[0]
        off = np.polynomial.Chebyshev.fit(photograph.at, along, degree)(photograph.at)
        moved.append(replace(photograph, at=np.clip(photograph.at + off, 0.0, photograph.length)))
    return replace(problem, forward=Forward(moved, problem.forward.gravity))
