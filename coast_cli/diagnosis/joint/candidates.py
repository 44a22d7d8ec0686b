"""Which effects could show in a recording of a joint, where their fits start, and what a fit of them moves."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from itertools import product
from typing import TYPE_CHECKING

import numpy as np

from coast_cli.diagnosis.problem import Contender
from coast_cli.diagnosis.space import BaseParameter, Coordinate, ParameterSpace
from coast_cli.effects.catalogue import CATALOGUE
from coast_cli.effects.effect import Effect, Need, Parameter, Scale

if TYPE_CHECKING:
    from coast_cli.diagnosis.joint.problem import JointProblem


def joint_candidates(problem: JointProblem, taken: set[str], *, alone: bool) -> list[Contender]:
    """Return the effects that may be added to those taken; ``alone`` asks also for what competes by itself."""

    def starts(kind: type[Effect]) -> tuple[Effect, ...]:
        return tuple(starts_of(kind, problem.reached, problem.holds))

    found = [Contender(starts(kind)) for kind in applicable(problem) if kind.id not in taken]
    if alone:
        found += [Contender(starts(kind), alone=True) for kind in applicable_by_rows(problem) if kind.id not in taken]
    return found


def applicable(problem: JointProblem) -> list[type[Effect]]:
    """Return the effects that could show in this recording at all."""
    return _showing(problem, problem.holds)


def applicable_by_rows(problem: JointProblem) -> list[type[Effect]]:
    """Return the effects that could show if samples counted time, where there is no clock.

    They compete alone: with a guessed clock, which in one sweep runs with the drive, a set of them draws anything.
    """
    if problem.holds["time"]:
        return []
    return [effect for effect in _showing(problem, {**problem.holds, "time": True}) if "time" in effect.needs]


def _showing(problem: JointProblem, holds: Mapping[Need, bool]) -> list[type[Effect]]:
    left_out = problem.concealed | {effect.id for effect in problem.fixed_effects}
    return [e for e in CATALOGUE.values() if e.id not in left_out and all(holds.get(need, True) for need in e.needs)]


def starts_of(
    effect: type[Effect], scales: Mapping[Scale, float], holds: Mapping[Need, bool] | None = None
) -> list[Effect]:
    """Return the starts of an effect on a recording with these scales, which ``holds`` what parameters need or not."""
    choices = [
        [p.null]
        if p.needs is not None and holds is not None and not holds.get(p.needs, True)
        else [float(np.clip(start * scales[p.relative_to], p.low, p.high)) for start in p.starts]
        for p in effect.parameters
    ]
    names = [parameter.name for parameter in effect.parameters]
    return [effect(**dict(zip(names, chosen, strict=True))) for chosen in product(*choices)]


def joint_space(problem: JointProblem, effects: tuple[Effect, ...]) -> ParameterSpace:
    """Return what a fit of these effects moves; what the recording cannot hold stays at its null."""
    owned = tuple(
        tuple(
            _effect_coordinate(p, value, problem) for p, value in zip(effect.parameters, effect.values(), strict=True)
        )
        for effect in effects
    )
    return ParameterSpace(base_coordinates(problem.base), effects, owned)


def base_coordinates(base: Sequence[BaseParameter]) -> tuple[Coordinate, ...]:
    """Return the coordinates of base parameters, drawn towards their configured values."""
    return tuple(
        Coordinate(
            name=p.name,
            value=p.value,
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


def _effect_coordinate(p: Parameter, value: float, problem: JointProblem) -> Coordinate:
    pinned = p.needs is not None and not problem.holds.get(p.needs, True)
    span, shapes = p.high - p.low, p.role == "shape"
    return Coordinate(
        name=p.name,
        value=p.null if pinned else value,
        low=p.null if pinned else p.low,
        high=p.null if pinned else p.high,
        width=_prior_width(p, problem.reached),
        scale=max(abs(value), 1e-3 * span),
        null=value if shapes else p.null,
        reach=max(0.4 * abs(value), 0.05 * span) if shapes else np.inf,
        late=shapes,
    )


def _prior_width(parameter: Parameter, scales: Mapping[Scale, float]) -> float:
    null = 0.0 if parameter.relative_to else parameter.null
    return 2.0 * max(*(abs(start * scales[parameter.relative_to] - null) for start in parameter.starts), 1e-9)
