"""Notched tubes as arrays with one row a tube: the one place where geometry and material become a beam.

One pitch is ``uncut`` (the full ring) and then ``cut`` (what the notch leaves), starting with uncut at the clamp. Rows may
differ in their notch count: shorter tubes are filled up with pieces of no length.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass, fields
from functools import cached_property
from typing import TYPE_CHECKING, Any

import numpy as np
from numpy.typing import NDArray

from coast_cli.mechanics.section import FloatArray, SectionKind, SectionProperties, full_section, notched_section
from coast_cli.mechanics.superelastic import Superelastic

if TYPE_CHECKING:
    from coast_cli.mechanics.tube import NotchedTube


_KEPT = ("possible", "pitch", "ring", "notch", "rigidity_mean", "rigidity_series")  # of picked tubes
_BLOCK_BYTES, _TABLES = 256e6, 20  # of one block of tubes, and how many tables of their pieces are held while solving
Rows = NDArray[np.int64]


@dataclass(frozen=True)
class Tubes:
    """m tubes; lengths in m, moduli in Pa. Numbers may be complex: sensitivities are complex steps.

    Attributes:
        outer_radius, inner_radius, youngs_modulus, density, natural_curvature: shape (m,); the last signed, 1/m.
        depth, cut, uncut: of the notches, shape (m, 1) where all notches of a tube are alike, else (m, n).
        count: notches of each tube, shape (m,).
        section: what a notch leaves.
        end_length: extra cut length by which stress spreads from strip to ring, m, shape (m, 1) or (m, n), or 0.
        superelastic: stress-strain law past the elastic range; None for a linear material.
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
    superelastic: Superelastic | None = None

    @property
    def size(self) -> int:
        """Number of tubes."""
        return int(self.outer_radius.size)

    def picked(self, rows: Any) -> Tubes:  # noqa: ANN401  # whatever indexes an array
        """Return some of the tubes, in the order of ``rows``; what is known of them already is not found anew."""

        def some(value: Any) -> Any:  # noqa: ANN401
            if isinstance(value, SectionProperties):
                return SectionProperties(*(some(getattr(value, item.name)) for item in fields(value)))
            return value[rows] if isinstance(value, np.ndarray) else value

        made = Tubes(**{item.name: some(getattr(self, item.name)) for item in fields(self)})
        known = {name: some(self.__dict__[name]) for name in _KEPT if name in self.__dict__}
        made.__dict__.update(known)  # where cached properties keep their values
        return made

    @cached_property
    def possible(self) -> NDArray[np.bool_]:
        """Whether each row is a tube: a wall, a notch from the axis to below the far side, and lengths above 0."""
        ro = self.outer_radius[:, None]
        notches = (self.depth >= ro) & (self.depth < 2.0 * ro) & (self.cut > 0.0) & (self.uncut > 0.0)
        wall = (self.inner_radius > 0.0) & (self.inner_radius < self.outer_radius) & (self.youngs_modulus > 0.0)
        return np.asarray(np.all(notches, axis=1) & wall & (self.count > 0))

    @cached_property
    def pitch(self) -> FloatArray:
        """Uncut plus cut length of each notch, m, shape of ``depth``."""
        return self.uncut + self.cut

    @cached_property
    def ring(self) -> SectionProperties:
        """Properties of the uncut rings, shape (m, 1)."""
        return full_section(self.outer_radius[:, None], self.inner_radius[:, None])

    @cached_property
    def notch(self) -> SectionProperties:
        """Properties of what each notch leaves, shape of ``depth``."""
        return notched_section(self.outer_radius[:, None], self.inner_radius[:, None], self.depth, self.section)

    @cached_property
    def per_notch(self) -> tuple[FloatArray, FloatArray, FloatArray]:
        """Length (m), rigidity (N m^2) and mass per length (kg/m) of the given notches, uncut and cut in turn.

        Shape (m, 2) where all notches of a tube are alike, else (m, 2n). The end effect acts as extra cut length:
        pitch/EI = uncut/EI_1 + (cut + end_length)/EI_2, so the cut piece is softer by cut/(cut + end_length).
        """
        softened = self.notch.second_moment * self.cut / (self.cut + self.end_length)
        modulus, density = self.youngs_modulus[:, None], self.density[:, None]
        return (
            _in_turn(self.uncut, self.cut),
            modulus * _in_turn(self.ring.second_moment, softened),
            density * _in_turn(self.ring.area, self.notch.area),
        )

    @cached_property
    def pieces(self) -> tuple[FloatArray, FloatArray, FloatArray]:
        """Length (m), rigidity (N m^2) and mass per length (kg/m) of the 2n pieces from the clamp, shape (m, 2n)."""
        most = int(self.count.max())
        length, rigidity, weight = (
            column if column.shape[1] == 2 * most else np.tile(column, (1, most)) for column in self.per_notch
        )
        if np.all(self.count == most):
            return length, rigidity, weight
        there = np.arange(2 * most) < 2 * self.count[:, None]
        return np.where(there, length, 0.0), rigidity, weight

    @cached_property
    def rigidity_mean(self) -> FloatArray:
        """Flexural rigidity averaged along each tube, N m^2: P's integral of I, which the rings dominate."""
        length, rigidity, _ = self.per_notch
        return np.asarray((rigidity * length).sum(axis=1) / self.pitch.sum(axis=1))

    @cached_property
    def rigidity_series(self) -> FloatArray:
        """Length over summed compliance, N m^2: the uniform tube that bends as far under one moment."""
        length, rigidity, _ = self.per_notch
        return np.asarray(self.pitch.sum(axis=1) / (length / rigidity).sum(axis=1))

    @cached_property
    def series_second_moment(self) -> FloatArray:
        """Second moment of area that each pitch has in series, cut and uncut, m^4, shape of ``depth``."""
        rigidity = self.per_notch[1][:, 1::2]
        compliance = self.cut * self.youngs_modulus[:, None] / rigidity + self.uncut / self.ring.second_moment
        return np.asarray(self.pitch / compliance)

    @cached_property
    def strain_per_curvature(self) -> FloatArray:
        """Largest strain of what each notch leaves for a unit mean curvature, m, shape of ``depth``.

        The cuts take the whole bend, so each bends by curvature * pitch / cut; the strain is that times the distance
        from the neutral axis to the outer skin or to the near edge of the section, whichever is further.
        """
        ro, axis = self.outer_radius[:, None], self.notch.neutral_axis
        near = self.depth - ro
        if self.section == "sector":
            near = self.inner_radius[:, None] * near / ro  # its inner corner
        return np.asarray(np.maximum(ro - axis, axis - near) * self.pitch / self.cut)

    @cached_property
    def closing_curvature(self) -> FloatArray:
        """Mean curvature at which the faces of each notch touch, cut/(ro + ybar)/pitch, 1/m, shape of ``depth``."""
        return np.asarray(self.cut / (self.outer_radius[:, None] + self.notch.neutral_axis) / self.pitch)

    def end_length_of_solids(self) -> tuple[FloatArray, tuple[str, ...]]:
        """Return the extra cut length that 3-D solids give, m, shape of ``depth``, 0 for rows that are no tubes; notes."""
        from coast_cli.mechanics.end_effect import end_length

        found, rows = np.zeros_like(self.depth), self.possible
        some = self.picked(rows)
        radii = some.outer_radius[:, None], some.inner_radius[:, None]
        found[rows], notes = end_length(*radii, some.depth, some.cut, some.uncut, some.section)
        return found, notes


def block_size(notches: int, most: int) -> int:
    """Return how many tubes (or pairs, of so many notches together) fit into one block of bounded memory, 1 to most."""
    return max(1, min(most, int(_BLOCK_BYTES / (8 * _TABLES * 2 * notches))))


def tubes_of(tubes: Sequence[NotchedTube]) -> Tubes:
    """Return tubes of one section, one stress-strain law and one notch count as rows.

    Raises:
        ValueError: they differ in either.
    """
    first = tubes[0]
    alike = [(tube.section, tube.superelastic, tube.count) for tube in tubes]
    if any(one != alike[0] for one in alike):
        raise ValueError("tubes in one table share their section, their law and, one depth a notch, their count")

    def column(name: str) -> Any:  # noqa: ANN401  # numbers, of which some may be complex
        return np.array([getattr(tube, name) for tube in tubes]) * 1.0

    return Tubes(
        outer_radius=column("outer_radius"),
        inner_radius=column("inner_radius"),
        depth=column("depth"),
        cut=column("cut"),
        uncut=column("uncut"),
        count=np.array([tube.count for tube in tubes]),
        youngs_modulus=column("youngs_modulus"),
        density=column("density"),
        natural_curvature=column("natural_curvature"),
        section=first.section,
        end_length=np.stack([np.broadcast_to(tube.end_length, tube.depth.shape) for tube in tubes]),
        superelastic=first.superelastic,
    )


def _in_turn(first: FloatArray, second: FloatArray) -> FloatArray:
    return np.stack(np.broadcast_arrays(first, second), axis=-1).reshape(len(first), -1)
