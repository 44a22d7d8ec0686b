"""Tubes as they are made: each drawn number with an error from its tolerance, as rows of tubes.

All notches of one tube err alike. Samples cut from one stock share the errors of its diameters and modulus; the rest
errs from sample to sample. The cut errs at a fixed pitch, since the stage sets the pitch and the laser's kerf the cut.
"""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass, replace

import numpy as np

from coast_cli.mechanics.section import FloatArray
from coast_cli.mechanics.tube import NotchedTube
from coast_cli.mechanics.tubes import Tubes
from coast_cli.spec.config import Config
from coast_cli.spec.tolerances import Tolerance, Tolerances
from coast_cli.spec.tubes import Role, bench_tubes
from coast_cli.units import DEGREE, MILLIMETRE

ROLL = "roll_deg"
ROLES: tuple[Role, ...] = ("outer", "middle")
_OF_THE_STOCK = ("outer_diameter_mm", "inner_diameter_mm", "youngs_modulus_percent")


@dataclass(frozen=True, slots=True)
class VariedInput:
    """One number that varies: of which tube or stock ("" for the roll of a pair), which key, and its tolerance."""

    of: str
    key: str
    tolerance: Tolerance

    @property
    def name(self) -> str:
        """The input as people write it, e.g. ``OT4.depth_mm`` or ``outer.inner_diameter_mm``."""
        return f"{self.of}.{self.key}" if self.of else self.key

    def error(self, share: FloatArray) -> FloatArray:
        """Return the errors at the given probabilities (0..1), in the unit of the key."""
        from scipy.special import ndtri

        if self.tolerance.distribution == "uniform":
            return np.asarray(self.tolerance.plus_minus * (2.0 * share - 1.0))
        return np.asarray(self.tolerance.plus_minus / 2.0 * ndtri(share))


@dataclass(frozen=True)
class Variation:
    """What varies of some tubes.

    Attributes:
        inputs: in the order of the columns of every table of probabilities.
        stock: role of each tube.
        tables: names of tubes whose end effect comes from the table of 3-D solids, and is looked up anew.
    """

    inputs: tuple[VariedInput, ...]
    stock: Mapping[str, str]
    tables: frozenset[str]

    def tube(self, tube: NotchedTube, shares: FloatArray) -> Tubes:
        """Return a tube as made, once for each row of probabilities, shape (m, inputs)."""
        count = len(shares)
        errors = {
            item.key: item.error(shares[:, column])
            for column, item in enumerate(self.inputs)
            if item.of in {tube.name, self.stock[tube.name]}
        }
        nothing = np.zeros(count)

        def error(key: str) -> FloatArray:
            return errors.get(key, nothing)

        depth = tube.depth if np.ptp(tube.depth) > 0.0 else tube.depth[:1]
        cut, uncut = tube.cut[: depth.size], tube.uncut[: depth.size]
        cut_error = error("cut_mm")[:, None] * MILLIMETRE
        made = Tubes(
            outer_radius=tube.outer_radius + error("outer_diameter_mm") / 2.0 * MILLIMETRE,
            inner_radius=tube.inner_radius + error("inner_diameter_mm") / 2.0 * MILLIMETRE,
            depth=depth + error("depth_mm")[:, None] * MILLIMETRE,
            cut=cut + cut_error,
            uncut=uncut - cut_error,
            count=np.full(count, tube.count),
            youngs_modulus=tube.youngs_modulus * (1.0 + error("youngs_modulus_percent") / 100.0),
            density=np.full(count, tube.density),
            natural_curvature=tube.natural_curvature + error("natural_curvature_per_m"),
            section=tube.section,
            end_length=np.broadcast_to(tube.end_length, tube.depth.shape)[: depth.size] + np.zeros((count, 1)),
            superelastic=tube.superelastic,
        )
        return replace(made, end_length=made.end_length_of_solids()[0]) if tube.name in self.tables else made

    def roll(self, shares: FloatArray) -> FloatArray:
        """Return the roll of the outer tube, rad, shape (m,)."""
        found = np.zeros(len(shares))
        for column, item in enumerate(self.inputs):
            if item.key == ROLL:
                found += item.error(shares[:, column]) * DEGREE
        return found


def variation(config: Config, tubes: Sequence[NotchedTube]) -> Variation:
    """Return what varies of the tubes by the [tolerances] of a configuration, or by their defaults."""
    table = config.tolerances or Tolerances()
    keys = {name: getattr(table, name) for name in type(table).model_fields}
    given = {name: item for name, item in keys.items() if item is not None and item.plus_minus > 0.0}
    bench = {tube.name: tube for role in ROLES for tube in bench_tubes(config, role)}
    stock = {tube.name: bench[tube.name].role for tube in tubes}
    # In the order of tubes and keys; a dict keeps the first of those that a stock shares.
    inputs = {
        VariedInput(stock[tube.name] if key in _OF_THE_STOCK else tube.name, key, item): None
        for tube in tubes
        for key, item in given.items()
        if key != ROLL
    }
    if ROLL in given:
        inputs[VariedInput("", ROLL, given[ROLL])] = None
    tables = frozenset(tube.name for tube in bench.values() if tube.end_effect == "table")
    return Variation(tuple(inputs), stock, tables)
