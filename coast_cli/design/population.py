"""Many tubes that differ in their numbers, as arrays with one row a tube: drawn from tolerances, or sampled for a design.

A ``NotchedTube`` is one tube; a thousand of them as objects would be a thousand loops. Rows may differ in their notch
count: shorter tubes are filled up with pieces of no length.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass, fields
from functools import cached_property
from typing import Any

import numpy as np
from numpy.typing import NDArray

from coast_cli.mechanics.section import FloatArray, SectionKind, SectionProperties, full_section, notched_section
from coast_cli.mechanics.tube import NotchedTube


@dataclass(frozen=True)
class TubePopulation:
    """m tubes; lengths in m, moduli in Pa.

    Attributes:
        outer_radius, inner_radius, youngs_modulus, density, natural_curvature: shape (m,); the last signed, 1/m.
        depth, cut, uncut: of the notches, shape (m, 1) where all notches of a tube are alike, else (m, n).
        count: notches of each tube, shape (m,).
        section: what a notch leaves. end_length: extra cut length, m, shape (m, 1) or (m, n), or 0.
    """

    outer_radius: FloatArray
    inner_radius: FloatArray
    depth: FloatArray
    cut: FloatArray
    uncut: FloatArray
    count: NDArray[np.int64]
    youngs_modulus: FloatArray
    density: FloatArray
    natural_curvature: FloatArray
    section: SectionKind = "sector"
    end_length: FloatArray | float = 0.0

    @property
    def size(self) -> int:
        """Number of tubes."""
        return int(self.outer_radius.size)

    def picked(self, rows: Any) -> TubePopulation:  # noqa: ANN401  # whatever indexes an array
        """Return some of the tubes, in the order of ``rows``."""
        values = {item.name: getattr(self, item.name) for item in fields(self)}
        return TubePopulation(**{k: v[rows] if isinstance(v, np.ndarray) else v for k, v in values.items()})

    @cached_property
    def notch(self) -> SectionProperties:
        """Properties of what each notch leaves, shape of ``depth``."""
        return notched_section(self.outer_radius[:, None], self.inner_radius[:, None], self.depth, self.section)

    @cached_property
    def possible(self) -> NDArray[np.bool_]:
        """Whether each row is a tube: a wall, a notch from the axis to below the far side, and lengths above 0."""
        ro = self.outer_radius[:, None]
        notches = (self.depth >= ro) & (self.depth < 2.0 * ro) & (self.cut > 0.0) & (self.uncut > 0.0)
        wall = (self.inner_radius > 0.0) & (self.inner_radius < self.outer_radius) & (self.youngs_modulus > 0.0)
        return np.asarray(np.all(notches, axis=1) & wall & (self.count > 0))

    @cached_property
    def rigidities(self) -> tuple[FloatArray, FloatArray]:
        """Flexural rigidity of the ring, shape (m, 1), and of each cut with its end effect, shape of ``depth``; N m^2."""
        modulus = self.youngs_modulus[:, None]
        ring = full_section(self.outer_radius, self.inner_radius).second_moment[:, None]
        return modulus * ring, modulus * self.notch.second_moment * self.cut / (self.cut + self.end_length)

    @cached_property
    def pieces(self) -> tuple[FloatArray, FloatArray, FloatArray]:
        """Length (m), rigidity (N m^2) and mass per length (kg/m) of the 2n pieces from the clamp, shape (m, 2n)."""
        most = int(self.count.max())
        there = np.arange(most) < self.count[:, None]
        length, rigidity, weight = (np.empty((self.size, most, 2)) for _ in range(3))
        length[..., 0], length[..., 1] = np.where(there, self.uncut, 0.0), np.where(there, self.cut, 0.0)
        rigidity[..., 0], rigidity[..., 1] = self.rigidities
        ring = full_section(self.outer_radius, self.inner_radius)
        weight[..., 0], weight[..., 1] = ring.area[:, None], self.notch.area
        weight *= self.density[:, None, None]
        shape = (self.size, 2 * most)
        return length.reshape(shape), rigidity.reshape(shape), weight.reshape(shape)

    @cached_property
    def rigidity_mean(self) -> FloatArray:
        """Flexural rigidity averaged along each tube, N m^2."""
        ring, cut = self.rigidities
        return np.asarray((self.uncut * ring + self.cut * cut).sum(axis=1) / (self.uncut + self.cut).sum(axis=1))

    @cached_property
    def rigidity_series(self) -> FloatArray:
        """Length over summed compliance of each tube, N m^2."""
        ring, cut = self.rigidities
        return np.asarray((self.uncut + self.cut).sum(axis=1) / (self.uncut / ring + self.cut / cut).sum(axis=1))


def population(tubes: Sequence[NotchedTube]) -> TubePopulation:
    """Return tubes of one section and one notch count as a population.

    Raises:
        ValueError: they differ in either.
    """
    first = tubes[0]
    if any(tube.section != first.section or tube.count != first.count for tube in tubes):
        raise ValueError("the tubes of a population share their section and, one depth a notch, their count")

    def column(name: str) -> FloatArray:
        return np.array([getattr(tube, name) for tube in tubes], dtype=float)

    end = np.stack([np.broadcast_to(np.asarray(tube.end_length, dtype=float), tube.depth.shape) for tube in tubes])
    return TubePopulation(
        outer_radius=column("outer_radius"),
        inner_radius=column("inner_radius"),
        depth=np.stack([tube.depth for tube in tubes]),
        cut=np.stack([tube.cut for tube in tubes]),
        uncut=np.stack([tube.uncut for tube in tubes]),
        count=np.array([tube.count for tube in tubes]),
        youngs_modulus=column("youngs_modulus"),
        density=column("density"),
        natural_curvature=column("natural_curvature"),
        section=first.section,
        end_length=end,
    )
