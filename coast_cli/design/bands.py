"""What is not known of a joint, as pairs of joints: each fitted or made number one standard deviation either way.

Fitted numbers come with their correlations from ``[fitted]`` and move along the principal axes of their covariance, so that
the pairs are independent; tolerances are, one a drawn number. Half the difference of a pair's answers is one standard
deviation of the answer, and independent ones add by their squares (to second order for what is odd in the numbers).
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass, replace
from math import erf, sqrt
from typing import Any

import numpy as np

from coast_cli.design.variation import ROLL, variation
from coast_cli.effects.catalogue import CATALOGUE, build_effects
from coast_cli.effects.effect import Effect
from coast_cli.mechanics.joint import Joint
from coast_cli.mechanics.section import FloatArray
from coast_cli.mechanics.tube import NotchedTube
from coast_cli.mechanics.tubes import Tubes
from coast_cli.spec.build import Design, build_joint
from coast_cli.spec.config import Config
from coast_cli.spec.values import Calibrated, nominal

WIDTH_90 = 1.6448536269514722  # standard deviations on either side of 90 % of a normal distribution
_ABOVE = 0.5 * (1.0 + erf(1.0 / sqrt(2.0)))  # probability of what lies below one standard deviation
_AXIS = 1e-6  # of the largest; smaller axes are rounding


@dataclass(frozen=True, eq=False)
class Alternative:
    """A joint with its corrections, one independent standard deviation below and above what is told."""

    below: tuple[Joint, tuple[Effect, ...]]
    above: tuple[Joint, tuple[Effect, ...]]


def alternatives(design: Design, pair: str | None = None, *, tolerances: bool = False) -> tuple[Alternative, ...]:
    """Return what may be otherwise of a joint: the fit of ``[fitted]`` and, where asked for, how its tubes are made.

    Raises:
        BadInput: as ``Design.joint``.
    """
    found = [*_of_the_fit(design, pair)]
    return (*found, *_of_the_tubes(design, pair)) if tolerances else tuple(found)


def told_of(config: Config, *, tolerances: bool) -> tuple[str, ...]:
    """Return the note that says what the bands are of; none without any."""
    fitted = () if config.fitted is None else (f"the fit of {', '.join(config.fitted.keys)}",)
    tubes = () if not tolerances else ("[tolerances]" if config.tolerances is not None else "the default tolerances",)
    parts = (*fitted, *tubes)
    return (f"bands are 90 %, of {' and of '.join(parts)}.",) if parts else ()


def _of_the_fit(design: Design, pair: str | None) -> list[Alternative]:
    config, fitted = design.config, design.config.fitted
    if fitted is None:
        return []
    std = np.array(fitted.std)
    covariance = np.array(fitted.correlation) * np.outer(std, std)
    scale = np.where(std > 0.0, std, 1.0)
    variance, axes = np.linalg.eigh(0.5 * (covariance + covariance.T) / np.outer(scale, scale))
    kept = variance > _AXIS * max(float(variance.max()), 0.0)
    steps = (axes * np.sqrt(np.maximum(variance, 0.0)) * scale[:, None]).T[kept]

    def moved(step: FloatArray) -> tuple[Joint, tuple[Effect, ...]]:
        changed = config
        for key, change in zip(fitted.keys, step.tolist(), strict=True):
            changed = _moved(changed, key, change)
        return build_joint(changed, *design.pair(pair)), build_effects(changed.corrections)

    return [Alternative(moved(-step), moved(step)) for step in steps]


def _moved(config: Config, key: str, change: float) -> Config:
    """Return a configuration with one number moved, no further than its range."""
    number = _at(config, key)
    if key.startswith("corrections."):
        _, effect, name = key.split(".", 2)
        parameters = CATALOGUE[effect].parameters if effect in CATALOGUE else ()
        low, high = next(((p.low, p.high) for p in parameters if p.name == name), (-np.inf, np.inf))
    else:
        _, low, high = config.bounds(key)
    value = float(np.clip(nominal(number) + change, low, high))
    moved: Any = number.model_copy(update={"value": value}) if isinstance(number, Calibrated) else value
    changed: Config = _put(config, key.split("."), moved)
    return changed


def _at(config: Config, key: str) -> Any:  # noqa: ANN401  # a number, plain or calibratable
    place: Any = config
    for part in key.split("."):
        place = place[part] if isinstance(place, dict) else getattr(place, part)
    return place


def _put(document: Any, parts: Sequence[str], value: Any) -> Any:  # noqa: ANN401
    """Return a document, or a table in it, with one entry replaced."""
    if not parts:
        return value
    first, *rest = parts
    if isinstance(document, dict):
        return {**document, first: _put(document[first], rest, value)}
    return document.model_copy(update={first: _put(getattr(document, first), rest, value)})


def _of_the_tubes(design: Design, pair: str | None) -> list[Alternative]:
    joint = design.joint(pair)
    tubes = [tube for tube in (joint.outer, joint.middle) if tube is not None]
    varied = variation(design.config, tubes)
    columns = [place for place, item in enumerate(varied.inputs) if item.key != ROLL]  # roll moves no stroke
    shares = np.full((2 * len(columns), len(varied.inputs)), 0.5)
    for row, column in enumerate(columns):
        shares[2 * row, column], shares[2 * row + 1, column] = 1.0 - _ABOVE, _ABOVE
    made = {tube.name: varied.tube(tube, shares) for tube in tubes}

    def with_row(row: int) -> tuple[Joint, tuple[Effect, ...]]:
        middle = _made(joint.middle, made[joint.middle.name], row)
        outer = None if joint.outer is None else _made(joint.outer, made[joint.outer.name], row)
        return replace(joint, outer=outer, middle=middle), design.effects

    return [Alternative(with_row(2 * place), with_row(2 * place + 1)) for place in range(len(columns))]


def _made(tube: NotchedTube, rows: Tubes, row: int) -> NotchedTube:
    """Return one row of tubes as made as the tube that it stands for."""

    def each(values: FloatArray) -> FloatArray:
        return np.broadcast_to(values[row], tube.depth.shape).copy()

    return replace(
        tube,
        outer_radius=float(rows.outer_radius[row]),
        inner_radius=float(rows.inner_radius[row]),
        depth=each(rows.depth),
        cut=each(rows.cut),
        uncut=each(rows.uncut),
        youngs_modulus=float(rows.youngs_modulus[row]),
        natural_curvature=float(rows.natural_curvature[row]),
        end_length=each(np.asarray(rows.end_length)),
    )
