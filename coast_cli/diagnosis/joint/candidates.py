"""Which effects could show in a recording of a joint, where their fits start, and what a fit of them moves."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from itertools import product
from typing import TYPE_CHECKING

import numpy as np

from coast_cli.diagnosis.joint.moments import lost_steps
from coast_cli.diagnosis.problem import Contender
from coast_cli.diagnosis.space import BaseParameter, Coordinate, ParameterSpace
from coast_cli.effects.catalogue import effects_of
from coast_cli.effects.devices import device_effects
from coast_cli.effects.effect import Effect, Need, Parameter, Scale
from coast_cli.effects.library.lost_steps import LostSteps

if TYPE_CHECKING:
    from coast_cli.diagnosis.joint.problem import JointProblem


def joint_candidates(problem: JointProblem, taken: set[str]) -> list[Contender]:
    """Return the effects that may be added to those taken."""

    def starts(kind: type[Effect]) -> tuple[Effect, ...]:
        if kind is LostSteps:
            return lost_steps(problem)
        return tuple(starts_of(kind, problem.reached, problem.holds))

    found = ((kind, starts(kind)) for kind in applicable(problem) if kind.id not in taken)
    return [Contender(begun) for _, begun in found if begun]


def applicable(problem: JointProblem) -> list[type[Effect]]:
    """Return the effects that could show in this recording at all, and that a fit can find."""
    left_out = problem.concealed | {effect.id for effect in problem.fixed_effects}
    return [
        effect
        for effect in (effects_of("joint") if problem.device is None else device_effects()).values()
        if effect.id not in left_out
        and all(problem.holds.get(need, True) for need in effect.needs)
        and not any(parameter.role == "found" for parameter in effect.parameters)
    ]


def starts_of(
    effect: type[Effect], scales: Mapping[Scale, float], holds: Mapping[Need, bool] | None = None
) -> list[Effect]:
    """Return the starts of an effect on a recording with these scales, which ``holds`` what parameters need or not."""
    choices = [
        [p.null]
        if p.needs is not None and holds is not None and not holds.get(p.needs, True)
        else list(map(float, range(int(scales["runs"]))))
        if p.role == "run"
        else [float(np.clip(start * scales[p.relative_to], p.low, p.high)) for start in p.starts]
        for p in effect.parameters
    ]
    names = [parameter.name for parameter in effect.parameters]
    return [effect(**dict(zip(names, chosen, strict=True))) for chosen in product(*choices)]


def joint_space(problem: JointProblem, effects: tuple[Effect, ...]) -> ParameterSpace:
    """Return what a fit of these effects moves; what the recording cannot hold stays at its null."""
    owned = tuple(
        tuple(
            _effect_coordinate(p, value, problem, effect)
            for p, value in zip(effect.parameters, effect.values(), strict=True)
        )
        for effect in effects
    )
    return ParameterSpace(base_coordinates(problem.base), effects, owned)


def base_coordinates(base: Sequence[BaseParameter]) -> tuple[Coordinate, ...]:
    """Return the coordinates of base parameters, drawn towards their configured values."""
    return tuple(
        Coordinate(
            name=p.name,
            value=p.value if p.start is None else p.start,
            low=p.low,
            high=p.high,
            width=p.prior,
            scale=0.1 if p.logarithmic else max(0.3 * p.prior, 1e-6),
            mean=p.inner,
            reach=0.7 if p.logarithmic else max(p.prior, 1e-6),
            logarithmic=p.logarithmic,
            pays=False,
        )
        for p in base
    )


def _effect_coordinate(p: Parameter, value: float, problem: JointProblem, effect: Effect) -> Coordinate:
    if p.expected is not None and p.logarithmic:
        return Coordinate(
            name=p.name,
            value=value,
            low=p.low,
            high=p.high,
            width=p.expected[1],
            scale=0.3,
            mean=float(np.log(p.expected[0])),
            reach=0.4,
            logarithmic=True,
            late=p.role == "shape",
        )
    missing = p.needs is not None and not problem.holds.get(p.needs, True)
    pinned = missing or p.role not in ("size", "shape") or p.name in effect.idle
    value = p.null if missing else value
    span, shapes = p.high - p.low, p.role == "shape"
    return Coordinate(
        name=p.name,
        value=value,
        low=value if pinned else p.low,
        high=value if pinned else p.high,
        width=_prior_width(p, problem.reached),
        scale=max(abs(value), 1e-3 * span),
        null=value if shapes or pinned else p.null,
        reach=max(0.4 * abs(value), 0.05 * span) if shapes else np.inf,
        late=shapes,
    )


def _prior_width(parameter: Parameter, scales: Mapping[Scale, float]) -> float:
    """Return twice the farthest start from the null; where it starts at its null alone, a tenth of its range."""
    null = 0.0 if parameter.relative_to else parameter.null
    farthest = max(abs(start * scales[parameter.relative_to] - null) for start in parameter.starts)
    return 2.0 * farthest if farthest > 0.0 else 0.1 * (parameter.high - parameter.low)
