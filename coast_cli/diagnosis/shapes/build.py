"""From a configuration and photographs to a problem: which base parameters are free, within which bounds."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from typing import TYPE_CHECKING

import numpy as np

from coast_cli.diagnosis.shapes.ends import with_ends_settled
from coast_cli.diagnosis.shapes.forward import Forward
from coast_cli.diagnosis.shapes.photograph import photographs, usual_sign
from coast_cli.diagnosis.shapes.problem import ShapeProblem, TubeParameter
from coast_cli.diagnosis.thresholds import CURVATURE_PRIOR, CURVATURE_TURN_PRIOR, END_EFFECT_SPREAD, MODULUS_PRIOR
from coast_cli.effects.catalogue import build_effects
from coast_cli.effects.effect import acting
from coast_cli.effects.shape_stages import OnShapes

if TYPE_CHECKING:
    from coast_cli.recordings.model import ShapeRun
    from coast_cli.spec.config import Config

_MODULUS_RANGE = 8.0


def build_shape_problem(config: Config, runs: Sequence[ShapeRun], *, without: Sequence[str] = ()) -> ShapeProblem:
    """Return the problem that runs pose to a configuration, all points fitted.

    Args:
        without: ids of effects that are neither named nor rivals.

    Raises:
        BadInput: a tube is unknown, or the points cannot be its shape.
    """
    from coast_cli.spec.build import build

    design = build(config)
    taken = photographs(design, runs)
    tubes = {place + 1: tube for place, tube in enumerate((*design.outer, *design.middle))}
    natural = {number: usual_sign(design, tube) * tube.natural_curvature for number, tube in tubes.items()}
    seen = {number for photograph in taken for number, _ in photograph.tubes}
    alone = {photograph.tubes[0][0] for photograph in taken if not photograph.is_pair}
    problem = ShapeProblem(
        forward=Forward(taken, design.gravity),
        calibratable=(
            *_moduli(config, seen),
            *_curvatures(config, alone, natural, {n: t.length for n, t in tubes.items()}),
            *_spreads({number: tubes[number].name for number in sorted(alone)}),
        ),
        train=tuple(np.ones(len(run), dtype=bool) for run in runs),
        modulus={number: tube.youngs_modulus for number, tube in tubes.items()},
        natural=natural,
        stock={
            number: (f"{'outer' if number <= len(design.outer) else 'middle'}.samples.{tube.name}", tube)
            for number, tube in tubes.items()
        },
        fixed_effects=tuple(acting(build_effects(config.corrections, "shapes"), OnShapes)),
        concealed=frozenset(without),
    )
    return with_ends_settled(problem)


def _moduli(config: Config, seen: set[int]) -> list[TubeParameter]:
    from coast_cli.spec.tubes import bench_tubes
    from coast_cli.spec.values import Calibrated

    materials: dict[str, list[int]] = {}
    for place, tube in enumerate((*bench_tubes(config, "outer"), *bench_tubes(config, "middle"))):
        if place + 1 in seen:
            materials.setdefault(tube.material, []).append(place + 1)
    found = []
    for name, numbers in materials.items():
        given = config.materials[name].youngs_modulus_gpa
        key = f"materials.{name}.youngs_modulus_gpa"
        if isinstance(given, Calibrated):
            prior = max(float(np.log(given.max / given.min)) / 4.0, 1e-9)
            found.append(
                TubeParameter(key, given.value, given.min, given.max, prior, logarithmic=True, tubes=tuple(numbers))
            )
        else:
            low, high = max(given / _MODULUS_RANGE, 0.001), min(given * _MODULUS_RANGE, 1e4)
            found.append(TubeParameter(key, given, low, high, MODULUS_PRIOR, logarithmic=True, tubes=tuple(numbers)))
    return found


def _curvatures(
    config: Config, alone: set[int], natural: Mapping[int, float], lengths: Mapping[int, float]
) -> list[TubeParameter]:
    outer = 0 if config.outer is None else len(config.outer.samples)
    found = []
    for number in sorted(alone):
        role, stock, place = (
            ("outer", config.outer, number - 1) if number <= outer else ("middle", config.middle, number - 1 - outer)
        )
        name = "" if stock is None else stock.samples[place].name
        value = natural[number]
        prior = max(CURVATURE_PRIOR * abs(value), CURVATURE_TURN_PRIOR / lengths[number])
        reach = 8.0 * prior + abs(value)
        low, high = max(value - reach, -1000.0), min(value + reach, 1000.0)
        key = f"{role}.samples.{name}.natural_curvature_per_m"
        found.append(TubeParameter(key, value, low, high, prior, tubes=(number,), quantity="curvature"))
    return found


def _spreads(alone: Mapping[int, str]) -> list[TubeParameter]:
    """Return the spread of each tube's end effect; by one tube alone it is a part of the effect itself."""
    most = 2.0 * END_EFFECT_SPREAD
    return [
        TubeParameter(
            f"{name}.end_effect_spread", 0.0, -most, most, END_EFFECT_SPREAD, tubes=(number,), quantity="spread"
        )
        for number, name in alone.items()
        if len(alone) > 1
    ]
