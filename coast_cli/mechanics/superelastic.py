"""Superelastic nitinol in one dimension: a flag-shaped stress-strain law whose inner loops have a closed form.

The state is the transformed fraction xi, from -1 (all martensite of compression) through 0 (austenite) to 1 (of
tension). Austenite and martensite carry the same stress, so the compliance is linear in xi (Reuss). Forward
transformation holds the upper plateau, reverse the lower one, in between xi waits: a generalised play in strain
(Krasnosel'skii and Pokrovskii 1989), which is one clip a step. Both envelopes are piecewise linear in strain.
Sources: flag shape and compression, Auricchio and Taylor, Comput. Methods Appl. Mech. Eng. 143 (1997) 175; temperature,
Clausius-Clapeyron.
"""

from __future__ import annotations

from dataclasses import dataclass, replace
from typing import Any

import numpy as np

from coast_cli.mechanics.section import FloatArray

CLAUSIUS_CLAPEYRON = 6.5e6  # Pa/K, nitinol (physics.md, sizes worth knowing: +6.5 MPa/K)


@dataclass(frozen=True, slots=True)
class Superelastic:
    """Material law at one temperature; SI.

    Attributes:
        austenite_modulus, martensite_modulus: Pa, martensite at most austenite.
        upper_plateau, lower_plateau: tensile stress at which each transformation begins from austenite, Pa.
        transformation_strain: length of the upper plateau in strain.
        plateau_modulus: slope of both plateaus against strain of the upper one, Pa.
        compression_ratio: plateau stresses in compression over those in tension; the plateau is as much shorter.
    """

    austenite_modulus: float
    martensite_modulus: float
    upper_plateau: float
    lower_plateau: float
    transformation_strain: float
    plateau_modulus: float = 0.0
    compression_ratio: float = 1.0

    @property
    def yield_strain(self) -> float:
        """Smallest strain, in tension or compression, at which a transformation begins."""
        return self.upper_plateau * min(1.0, self.compression_ratio) / self.austenite_modulus

    @property
    def lower_length(self) -> float:
        """Length of the lower plateau in strain; the law needs it above zero."""
        return self.transformation_strain - (self.upper_plateau - self.lower_plateau) * self.softening

    @property
    def softening(self) -> float:
        """Compliance of martensite beyond that of austenite, 1/Pa."""
        return 1.0 / self.martensite_modulus - 1.0 / self.austenite_modulus

    def with_modulus(self, austenite_modulus: Any) -> Superelastic:  # noqa: ANN401  # a number, or one for each section
        """Return the law with both moduli in proportion to another austenite modulus (Pa), plateaus as they are."""
        factor = austenite_modulus / self.austenite_modulus
        return replace(self, austenite_modulus=austenite_modulus, martensite_modulus=factor * self.martensite_modulus)

    def warmer(self, kelvin: float, slope: float = CLAUSIUS_CLAPEYRON) -> Superelastic:
        """Return the law at a temperature higher by ``kelvin``: both plateaus rise by ``slope`` (Pa/K)."""
        shift = slope * kelvin
        return replace(self, upper_plateau=self.upper_plateau + shift, lower_plateau=self.lower_plateau + shift)

    def fraction_loading(self, strain: FloatArray) -> FloatArray:
        """Return xi on the loading envelope, away from zero strain along the upper plateaus."""
        if self.compression_ratio == 1.0:
            return np.copysign(_forward(self, np.abs(strain)), strain)
        return _forward(self, strain) - _forward(_compressed(self), -strain)

    def fraction_unloading(self, strain: FloatArray) -> FloatArray:
        """Return xi on the unloading envelope, back to zero strain along the lower plateaus."""
        if self.compression_ratio == 1.0:
            return np.copysign(_reverse(self, np.abs(strain)), strain)
        return _reverse(self, strain) - _reverse(_compressed(self), -strain)

    def fraction(self, strain: FloatArray, before: FloatArray) -> FloatArray:
        """Return xi after a monotone step to ``strain`` from the fraction ``before``: the play's one clip."""
        compressed = _compressed(self)
        low = _forward(self, strain) - _reverse(compressed, -strain)
        high = _reverse(self, strain) - _forward(compressed, -strain)
        return np.minimum(np.maximum(before, low), high)

    def stress(self, strain: FloatArray, fraction: FloatArray) -> FloatArray:
        """Return the stress (Pa) at a strain with the fraction xi frozen, or on the envelope that gave it."""
        return (strain - self.rest_strain(fraction)) * self.modulus(fraction)

    def modulus(self, fraction: FloatArray) -> FloatArray:
        """Return the elastic modulus (Pa) of the mixture."""
        return self.austenite_modulus / (1.0 + self.austenite_modulus * self.softening * np.abs(fraction))

    def rest_strain(self, fraction: FloatArray) -> FloatArray:
        """Return the strain at which a mixture is free of stress."""
        tension = _rest(self, np.abs(fraction))
        if self.compression_ratio == 1.0:
            return np.copysign(tension, fraction)
        return np.where(fraction >= 0.0, tension, -_rest(_compressed(self), np.abs(fraction)))

    def loading_stress(self, strain: FloatArray) -> FloatArray:
        """Return the stress (Pa) on the loading envelope, from an unloaded austenite."""
        return self.stress(strain, self.fraction_loading(strain))

    def unloading_stress(self, strain: FloatArray) -> FloatArray:
        """Return the stress (Pa) on the unloading envelope, from beyond the end of the plateau."""
        return self.stress(strain, self.fraction_unloading(strain))


def _compressed(law: Superelastic) -> Superelastic:
    """Return the law of compression, written as if for tension."""
    ratio = law.compression_ratio
    return replace(
        law,
        upper_plateau=ratio * law.upper_plateau,
        lower_plateau=ratio * law.lower_plateau,
        transformation_strain=law.transformation_strain / ratio,
        plateau_modulus=ratio**2 * law.plateau_modulus,
        compression_ratio=1.0,
    )


def _forward(law: Superelastic, strain: FloatArray) -> FloatArray:
    """Return the fraction on the upper plateau at each tensile strain."""
    return np.clip((strain - law.upper_plateau / law.austenite_modulus) / law.transformation_strain, 0.0, 1.0)


def _reverse(law: Superelastic, strain: FloatArray) -> FloatArray:
    """Return the fraction on the lower plateau at each tensile strain."""
    return np.clip((strain - law.lower_plateau / law.austenite_modulus) / law.lower_length, 0.0, 1.0)


def _rest(law: Superelastic, fraction: FloatArray) -> FloatArray:
    """Return the strain at which a mixture of a tensile fraction carries nothing."""
    rise = law.plateau_modulus * law.transformation_strain
    linear = law.transformation_strain - law.upper_plateau * law.softening - rise / law.austenite_modulus
    return fraction * (linear - fraction * (rise * law.softening))
