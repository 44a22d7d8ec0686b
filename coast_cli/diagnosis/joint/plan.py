"""What a recording could tell, before it is made: which effects it would show, which it would confuse, what to do next.

Each effect is simulated on the planned drive at a stated size. What the base model's own parameters could take up is
projected out, then what any other effect could, to first order and inside its ranges; the rest tells the two apart.
"""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass, replace
from typing import TYPE_CHECKING

import numpy as np

from coast_cli.diagnosis.joint.candidates import applicable, starts_of
from coast_cli.diagnosis.joint.problem import JointProblem
from coast_cli.diagnosis.joint.protocols import Bench, Protocol, candidates, expected
from coast_cli.diagnosis.thresholds import EFFECT_NATS, SMALLEST
from coast_cli.effects.catalogue import effects_of
from coast_cli.effects.effect import Effect, Need

if TYPE_CHECKING:
    from coast_cli.diagnosis.fit import Fit
    from coast_cli.mechanics.section import FloatArray

_STEP = 1e-3
_RESCALINGS = 12
_SHAPE_REACH = 0.5  # share of its value by which a shape parameter may move in a first-order refit
_TENSION_NOISE = 0.02  # of the largest tension, where nothing is known of the load cell
_MISSING = {
    "stroke": "needs a stroke as the drive",
    "time": "needs time",
    "release": "needs a release",
    "pairs": "needs several notch depths",
    "outer": "needs an outer tube",
}


@dataclass(frozen=True, slots=True)
class Outlook:
    """What a planned recording could tell of one effect; errors are RMS over the response, in noise levels.

    Attributes:
        effect: as simulated, or None where the recording cannot show it at all; ``reason`` then says why.
        change: of the response. visible: what is left of it once the base parameters are refitted.
        closest: id of the effect that explains the most of the rest. apart: what it leaves.
    """

    id: str
    component: str
    effect: Effect | None
    reason: str
    change: float = 0.0
    visible: float = 0.0
    closest: str = ""
    apart: float = 0.0
    count: int = 0

    @property
    def is_visible(self) -> bool:
        """Whether a diagnosis would see that something is left out."""
        return _counts(self.visible, self.count)

    @property
    def is_told_apart(self) -> bool:
        """Whether a diagnosis would name the right effect."""
        return self.is_visible and _counts(self.apart, self.count)


@dataclass(frozen=True, slots=True)
class Proposal:
    """A recording worth making: in bench words, and the evidence (nats) it is expected to add between the rivals."""

    words: str
    gain: float


def outlook(problem: JointProblem, size: float = 5.0) -> list[Outlook]:
    """Return what a planned recording could tell of every effect of the catalogue.

    Args:
        problem: from ``protocols.planned``.
        size: RMS change of the response that each effect is simulated at, in noise levels; less where its range ends.
    """
    view = _View(problem)
    usable = {effect.id for effect in applicable(problem)}
    scales = problem.scales()
    shapes = {
        identifier: [
            view.shape(view.sized(start, size)) for start in starts_of(kind, scales) if np.any(view.raw(start))
        ]
        for identifier, kind in effects_of("joint").items()
        if identifier in usable
    }
    found = []
    for identifier, kind in effects_of("joint").items():
        if not shapes.get(identifier):
            found.append(Outlook(identifier, kind.component, None, _reason(kind, problem)))
            continue
        mine = shapes[identifier][len(shapes[identifier]) // 2]
        rivals = {
            other: min(shape.leaves(mine.change) for shape in theirs)
            for other, theirs in shapes.items()
            if other != identifier and theirs
        }
        closest = min(rivals, key=lambda other: rivals[other], default="")
        found.append(
            Outlook(
                identifier,
                kind.component,
                mine.effect,
                "",
                view.level(view.raw(mine.effect)),
                view.level(mine.change),
                closest,
                view.scale * rivals.get(closest, float(np.linalg.norm(mine.change))),
                problem.observed.size,
            )
        )
    return found


def next_recording(
    problem: JointProblem, rivals: Sequence[Fit], offered: Sequence[Protocol] | None = None
) -> tuple[Proposal, ...]:
    """Return recordings that would tell rivals apart, the best first; none for fewer than two rivals.

    Each protocol is predicted under every rival; every other is refitted to that, old and new recording together, to
    first order. The gain is the misfit that stays, halved and corrected for the noise's colour, of the closest two.

    Args:
        problem: as recorded. rivals: fits that explain it alike, with their base coordinates and effects.
        offered: protocols to choose from; by default a handful around what was recorded.
    """
    if len(rivals) < 2:
        return ()
    whole = problem.only([np.ones(len(run), bool) for run in problem.runs])
    noise = min(fit.evidence.level for fit in rivals)
    memory = float(np.clip(np.median([fit.evidence.memory for fit in rivals]), 0.0, 0.95))
    efficiency = (1.0 - memory) / (1.0 + memory)
    past = _Pairwise(replace(whole, noise=noise), rivals)
    proposals = []
    for protocol in around(problem) if offered is None else offered:
        future = _Pairwise(_posed(problem, protocol, noise), rivals)
        gain = min(
            0.5 * efficiency * (_misfit([past, future], true, other) - _misfit([past], true, other))
            for true in range(len(rivals))
            for other in range(len(rivals))
            if true != other
        )
        proposals.append(Proposal(protocol.words, float(max(gain, 0.0))))
    return tuple(sorted(proposals, key=lambda proposal: -proposal.gain))


def around(problem: JointProblem) -> list[Protocol]:
    """Return the protocols that could follow a recording: its tubes, its response, its range and rate."""
    first, bench = problem.runs[0], bench_of(problem)
    drives = np.concatenate([run.drive for run in problem.runs])
    lengths = np.unique(np.round(np.concatenate([run.bending_length for run in problem.runs]), 6))
    low, top = float(drives.min()), float(drives.max())
    found = candidates(
        bench, low, top, lengths.tolist(), problem.joints[first.pair].middle.length, usual_rate(problem, top - low)
    )
    if first.kind != "notch":
        return found
    return [protocol for protocol in found if len({float(run.bending_length[0]) for run in protocol.runs}) == 1]


def bench_of(problem: JointProblem) -> Bench:
    """Return the bench that a recording was made on."""
    first = problem.runs[0]
    return Bench(
        first.middle,
        first.outer,
        first.kind,
        first.response.shape[1],
        first.stroke is not None,
        problem.tension_noise is not None,
    )


def usual_rate(problem: JointProblem, span: float) -> float:
    """Return the usual speed of the drive (SI per s), or a minute for the whole range where time is not known."""
    speeds = [
        np.abs(np.diff(run.drive))[steps > 0.0] / steps[steps > 0.0]
        for run in problem.runs
        if run.time is not None
        for steps in (np.diff(run.time),)
    ]
    moving = np.concatenate(speeds) if speeds else np.zeros(0)
    moving = moving[moving > 1e-3 * float(moving.max(initial=0.0))]
    return float(np.median(moving)) if moving.size else span / 60.0


def _posed(problem: JointProblem, protocol: Protocol, noise: float) -> JointProblem:
    """Return the same joints and free parameters on the runs of a protocol."""
    posed = replace(problem, runs=protocol.runs, train=(), usable=(), tension_usable=())
    predicted = posed.predict(problem.configured(), ())
    largest = max(float(prediction.tension.max(initial=0.0)) for prediction in predicted)
    return expected(posed, noise, problem.tension_noise or _TENSION_NOISE * max(largest, 1e-6))


def _misfit(parts: Sequence[_Pairwise], true: int, other: int) -> float:
    """Return the squared misfit, in noise levels, of one rival refitted to what another predicts."""
    target = np.concatenate([part.predicted[true] - part.predicted[other] for part in parts])
    basis = np.concatenate([part.tangents[other] for part in parts])
    basis = np.linalg.qr(basis / np.maximum(np.linalg.norm(basis, axis=0), 1e-300))[0]
    left = target - basis @ (basis.T @ target)
    return float(left @ left)


class _Pairwise:
    """Predictions and tangents of every rival on one recording, in noise levels."""

    def __init__(self, problem: JointProblem, rivals: Sequence[Fit]) -> None:
        self.predicted = [_stacked(problem, fit.coordinates, fit.effects) for fit in rivals]
        # A parameter on its bound stays there, or the refit would leave what can be believed.
        self.tangents = [
            _tangent(problem, fit.coordinates, fit.effects)[:, ~np.array(fit.at_bound, dtype=bool)] for fit in rivals
        ]


@dataclass(frozen=True)
class _Shape:
    """One effect at one shape, base parameters projected out: its change, and how its own parameters can move it."""

    effect: Effect
    change: FloatArray
    basis: FloatArray
    triangle: FloatArray
    low: FloatArray
    high: FloatArray

    def leaves(self, target: FloatArray) -> float:
        """Return the norm of what this effect leaves of another's change, its parameters refitted in their ranges."""
        from scipy.optimize import lsq_linear

        rest = target - self.change
        along = self.basis.T @ rest
        outside = max(float(rest @ rest - along @ along), 0.0)
        found = lsq_linear(self.triangle, along, bounds=(self.low, self.high), method="bvls")
        return float(np.sqrt(outside + 2.0 * found.cost))


class _View:
    """A planned recording seen from the base model: predictions in noise levels, base parameters projected out."""

    def __init__(self, problem: JointProblem) -> None:
        self._problem = problem
        self._start = problem.configured()
        self._origin = _stacked(problem, self._start, ())
        base = _tangent(problem, self._start, ())
        self._base = np.linalg.qr(base)[0]
        self._responses = problem.observed.size
        self.scale = 1.0 / float(np.sqrt(self._responses))

    def raw(self, effect: Effect) -> FloatArray:
        """Return the change an effect makes."""
        return _stacked(self._problem, self._start, (effect,)) - self._origin

    def left(self, change: FloatArray) -> FloatArray:
        """Project the base parameters out, once and again for rounding."""
        for _ in range(2):
            change = change - self._base @ (self._base.T @ change)
        return change

    def level(self, change: FloatArray) -> float:
        """Return an RMS over the response."""
        return float(np.linalg.norm(change)) * self.scale

    def sized(self, effect: Effect, size: float) -> Effect:
        """Return the effect with its sizes scaled until the response changes by ``size``, or its range ends."""
        for _ in range(_RESCALINGS):
            now = float(np.linalg.norm(self.raw(effect)[: self._responses])) * self.scale
            if now <= 0.0 or abs(now / size - 1.0) < 0.01:
                break
            effect = _times(effect, float(np.clip(size / now, 0.2, 5.0)))
        return effect

    def shape(self, effect: Effect) -> _Shape:
        """Return an effect ready to be compared."""
        change = self.left(self.raw(effect))
        columns, low, high = [], [], []
        for parameter in effect.parameters:
            value = getattr(effect, parameter.name)
            step = _STEP * max(abs(value), 1e-2 * (parameter.high - parameter.low))
            step = -step if value + step > parameter.high else step
            moved = self.left(self.raw(replace(effect, **{parameter.name: value + step})))
            columns.append((moved - change) / step)
            reach = np.inf if parameter.role == "size" else _SHAPE_REACH * max(abs(value), 0.1 * parameter.high)
            low.append(max(parameter.low - value, -reach))
            high.append(min(parameter.high - value, reach))
        matrix = np.stack(columns, axis=1) if columns else np.zeros((change.size, 1))
        basis, triangle = np.linalg.qr(matrix)
        bounds = np.array(low or [-1.0]), np.array(high or [1.0])
        return _Shape(effect, change, basis, triangle, bounds[0], np.maximum(bounds[1], bounds[0] + 1e-12))


def _stacked(problem: JointProblem, coordinates: FloatArray, effects: Sequence[Effect]) -> FloatArray:
    """Return predicted responses and then tensions, in noise levels."""
    response, tension = problem.fitted(problem.predict(coordinates, effects))
    return np.concatenate([response / problem.noise, tension / (problem.tension_noise or 1.0)])


def _tangent(problem: JointProblem, coordinates: FloatArray, effects: Sequence[Effect]) -> FloatArray:
    """Return how the prediction moves with every base and effect parameter, (n, q)."""
    space = problem.space(effects)

    def seen(vectors: Sequence[FloatArray]) -> list[FloatArray]:
        return [_stacked(problem, *space.split(vector)) for vector in vectors]

    start = space.joined(coordinates)
    return space.jacobian(seen, start, seen([start])[0], space.moving, central=False)


def _times(effect: Effect, factor: float) -> Effect:
    """Scale the sizes of an effect inside their ranges."""
    changes: Mapping[str, float] = {
        p.name: float(np.clip(p.null + factor * (getattr(effect, p.name) - p.null), p.low, p.high))
        for p in effect.parameters
        if p.role == "size"
    }
    return replace(effect, **changes)


def _counts(level: float, count: int) -> bool:
    """Return whether an RMS in noise levels is large enough, and has evidence enough, to be named."""
    return level >= SMALLEST and 0.5 * count * level**2 >= EFFECT_NATS


def _reason(kind: type[Effect], problem: JointProblem) -> str:
    if kind.id in {effect.id for effect in problem.fixed_effects}:
        return "already in the model"
    lacking = [_MISSING[need] for need in kind.needs if need in _MISSING and not _has(need, problem)]
    return lacking[0] if lacking else "changes nothing here"


def _has(need: Need, problem: JointProblem) -> bool:
    return need != "pairs" and problem.holds.get(need, True)
