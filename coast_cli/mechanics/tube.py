"""One notched tube: the row of ``Tubes`` that a configuration names, with plain numbers for what it has one of."""

from __future__ import annotations

from dataclasses import dataclass
from functools import cached_property

import numpy as np

from coast_cli.mechanics.plausible import CURVATURE, DENSITY, LENGTH, RADIUS, require
from coast_cli.mechanics.section import FloatArray, SectionKind, SectionProperties
from coast_cli.mechanics.superelastic import Superelastic
from coast_cli.mechanics.tubes import Tubes, tubes_of
from coast_cli.rows import short_repr


@dataclass(frozen=True, slots=True)
class Segments:
    """The constant pieces of a tube from clamp to tip.

    Attributes:
        length: of each piece, m, shape (2n,).
        rigidity: flexural rigidity E I, N m^2, shape (2n,).
        weight: mass per length, kg/m, shape (2n,); times gravity it is the distributed weight w of P (2).
    """

    length: FloatArray
    rigidity: FloatArray
    weight: FloatArray


@dataclass(frozen=True)
class NotchedTube:
    """A tube with n one-sided notches.

    Attributes:
        name: as in the configuration.
        outer_radius, inner_radius: m.
        depth, cut, uncut: of each notch, m, shape (n,), clamp to tip.
        youngs_modulus: Pa.
        density: kg/m^3.
        natural_curvature: 1/m, signed: positive bends against gravity (an outer tube), negative along it (a middle tube).
        section: what a notch leaves, "sector" (P) or "chord" (a straight cut).
        end_length: extra cut length by which stress spreads from strip to ring, m, shape (n,); zeros leave it out (P).
        superelastic: stress-strain law past the elastic range; None for a linear material.
    """

    __repr__ = short_repr

    name: str
    outer_radius: float
    inner_radius: float
    depth: FloatArray
    cut: FloatArray
    uncut: FloatArray
    youngs_modulus: float
    density: float
    natural_curvature: float = 0.0
    section: SectionKind = "sector"
    end_length: FloatArray | float = 0.0
    superelastic: Superelastic | None = None

    def __post_init__(self) -> None:
        """Refuse what is far outside physics.

        Raises:
            BadInput: naming the number.
        """
        require(RADIUS, outer_radius=self.outer_radius, inner_radius=self.inner_radius)
        require(LENGTH, cut=self.cut, uncut=self.uncut)
        require(DENSITY, density=self.density)
        require(CURVATURE, natural_curvature=self.natural_curvature)

    @property
    def count(self) -> int:
        """Number of notches."""
        return int(self.depth.size)

    @cached_property
    def row(self) -> Tubes:
        """The tube as a table of one row, which knows its geometry."""
        return tubes_of((self,))

    @cached_property
    def pitch(self) -> FloatArray:
        """Uncut plus cut length of each notch, m, shape (n,)."""
        return self.uncut + self.cut

    @cached_property
    def length(self) -> float:
        """Notched length, m."""
        length: float = self.pitch.sum().item()  # not float(): sensitivities are complex
        return length

    @cached_property
    def notch(self) -> SectionProperties:
        """Properties of what each notch leaves, shape (n,)."""
        notch = self.row.notch
        return SectionProperties(notch.area[0], notch.neutral_axis[0], notch.second_moment[0])

    @cached_property
    def segments(self) -> Segments:
        """The 2n constant pieces, uncut first."""
        return Segments(*(column[0] for column in self.row.per_notch))

    @cached_property
    def rigidity_mean(self) -> float:
        """Flexural rigidity averaged along the tube, N m^2: P's integral of I, which the rings dominate."""
        return self.row.rigidity_mean.item()

    @cached_property
    def rigidity_series(self) -> float:
        """Length over summed compliance, N m^2: the uniform tube that bends as far under one moment."""
        return self.row.rigidity_series.item()

    @property
    def series_second_moment(self) -> FloatArray:
        """Second moment of area that each pitch has in series, cut and uncut, m^4, shape (n,)."""
        return np.asarray(self.row.series_second_moment[0])

    @property
    def strain_per_curvature(self) -> FloatArray:
        """Largest strain of what each notch leaves for a unit mean curvature, m, shape (n,)."""
        return np.asarray(self.row.strain_per_curvature[0])

    @property
    def closing_curvature(self) -> FloatArray:
        """Mean curvature at which the faces of each notch touch, 1/m, shape (n,)."""
        return np.asarray(self.row.closing_curvature[0])

    @cached_property
    def is_graded(self) -> bool:
        """Whether notches differ from each other."""
        return bool(np.ptp(self.depth) > 0.0 or np.ptp(self.pitch) > 0.0 or np.ptp(self.cut) > 0.0)
