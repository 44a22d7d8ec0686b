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


def _interleave(first: FloatArray, second: FloatArray) -> FloatArray:
    return np.stack((first, second), axis=-1).reshape(-1)
