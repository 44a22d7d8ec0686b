"""One notched tube: geometry and material in, the piecewise-constant beam that it is out.

One pitch is ``uncut`` (the full ring) and then ``cut`` (what the notch leaves), starting with uncut at the clamp.
"""

from __future__ import annotations

from dataclasses import dataclass
from functools import cached_property

import numpy as np

from coast_cli.mechanics.section import FloatArray, SectionKind, SectionProperties, full_section, notched_section


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
    """

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

    @property
    def count(self) -> int:
        """Number of notches."""
        return int(self.depth.size)

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
    def ring(self) -> SectionProperties:
        """Properties of the uncut ring."""
        return full_section(self.outer_radius, self.inner_radius)

    @cached_property
    def notch(self) -> SectionProperties:
        """Properties of what each notch leaves, shape (n,)."""
        return notched_section(self.outer_radius, self.inner_radius, self.depth, self.section)

    @cached_property
    def segments(self) -> Segments:
        """The 2n constant pieces, uncut first.

        The end effect acts as extra cut length: pitch/EI = uncut/EI_1 + (cut + end_length)/EI_2, so the cut piece
        is softer by cut/(cut + end_length).
        """
        softened = self.notch.second_moment * self.cut / (self.cut + self.end_length)
        ring = np.broadcast_to(self.ring.second_moment, softened.shape)
        ring_area = np.broadcast_to(self.ring.area, softened.shape)
        return Segments(
            length=_interleave(self.uncut, self.cut),
            rigidity=self.youngs_modulus * _interleave(ring, softened),
            weight=self.density * _interleave(ring_area, self.notch.area),
        )

    @cached_property
    def rigidity_mean(self) -> float:
        """Flexural rigidity averaged along the tube, N m^2: P's integral of I, which the rings dominate."""
        return np.sum(self.segments.rigidity * self.segments.length).item() / self.length

    @cached_property
    def rigidity_series(self) -> float:
        """Length over summed compliance, N m^2: the uniform tube that bends as far under one moment."""
        return self.length / np.sum(self.segments.length / self.segments.rigidity).item()

    @cached_property
    def series_second_moment(self) -> FloatArray:
        """Second moment of area that each pitch has in series, cut and uncut, m^4, shape (n,)."""
        cut, uncut = self.segments.length[1::2], self.segments.length[0::2]
        compliance = cut * self.youngs_modulus / self.segments.rigidity[1::2] + uncut / self.ring.second_moment
        return np.asarray((cut + uncut) / compliance)

    @cached_property
    def strain_per_curvature(self) -> FloatArray:
        """Strain of the strip's outer fibre for a unit curvature of the segment, m, shape (n,)."""
        axis = self.notch.neutral_axis
        inner_edge = self.inner_radius * (self.depth - self.outer_radius) / self.outer_radius
        return np.asarray(np.maximum(self.outer_radius - axis, axis - inner_edge) * self.pitch / self.cut)

    @cached_property
    def closing_curvature(self) -> FloatArray:
        """Curvature of the segment at which the faces of each notch touch, cut/(ro + ybar)/pitch, 1/m, shape (n,)."""
        return np.asarray(self.cut / (self.outer_radius + self.notch.neutral_axis) / self.pitch)

    @cached_property
    def is_graded(self) -> bool:
        """Whether notches differ from each other."""
        return bool(np.ptp(self.depth) > 0.0 or np.ptp(self.pitch) > 0.0 or np.ptp(self.cut) > 0.0)


def _interleave(first: FloatArray, second: FloatArray) -> FloatArray:
    return np.stack((first, second), axis=-1).reshape(-1)
