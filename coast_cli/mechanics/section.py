"""Cross-sections of a tube: the full ring, and what a one-sided notch leaves of it.

Equations (1)-(2) of P, "Model-based Design of the COAST Guidewire Robot for Large Deflection" (RA-L 2023). P keeps a
*sector* of the ring (radial cut walls); a straight laser cut leaves the *chord* section instead (a circular segment of
the outer circle less that of the bore), which is 1.1 to 1.6 times softer on the reference tubes.
"""

from __future__ import annotations

from dataclasses import dataclass
from typing import Literal

import numpy as np
from numpy.typing import ArrayLike, NDArray

SectionKind = Literal["sector", "chord"]
FloatArray = NDArray[np.float64]


@dataclass(frozen=True, slots=True)
class SectionProperties:
    """Area (m^2), distance of the neutral axis from the tube's axis (m), second moment of area about it (m^4)."""

    area: FloatArray
    neutral_axis: FloatArray
    second_moment: FloatArray


def full_section(outer_radius: ArrayLike, inner_radius: ArrayLike) -> SectionProperties:
    """Return the properties of the uncut ring; radii in m, any shapes that broadcast (P, text above (1))."""
    ro, ri = _numbers(outer_radius), _numbers(inner_radius)
    area = np.pi * (ro**2 - ri**2)
    return SectionProperties(area, np.zeros_like(area), np.pi / 4.0 * (_fourth_power(ro) - _fourth_power(ri)))


def notched_section(
    outer_radius: ArrayLike, inner_radius: ArrayLike, depth: ArrayLike, kind: SectionKind = "sector"
) -> SectionProperties:
    """Return the properties of the section that a notch of ``depth`` leaves.

    Args:
        outer_radius, inner_radius: of the tube, m.
        depth: of the notch from the outer surface, m; ro <= depth < 2 ro. Arrays broadcast.
        kind: "sector" (P (1)-(2), radial cut walls) or "chord" (a straight cut, exact circular segments).

    Example:
        >>> left = coast.notched_section(225e-6, 175e-6, 400e-6)
        >>> round(left.area.item() * 1e12, 1), round(left.neutral_axis.item() * 1e6, 1)
        (13593.5, 185.9)
    """
    ro, ri, d = np.broadcast_arrays(_numbers(outer_radius), _numbers(inner_radius), _numbers(depth))
    return _sector(ro, ri, d) if kind == "sector" else _chord(ro, ri, d)


def _numbers(values: ArrayLike) -> FloatArray:
    """Return an array of floats, or of complex numbers as they are: sensitivities are complex steps."""
    return np.asarray(values) * 1.0


def _fourth_power(values: FloatArray) -> FloatArray:
    """Return x^4 as the C library has it: numpy's vector instructions round it otherwise for one tube than for many."""
    return np.array([value**4 for value in values.ravel().tolist()]).reshape(values.shape)


def _sector(ro: FloatArray, ri: FloatArray, depth: FloatArray) -> SectionProperties:
    half = np.arccos((depth - ro) / ro)
    phi = 2.0 * half
    area = phi / 2.0 * (ro**2 - ri**2)
    cubes = ro**3 - ri**3
    neutral_axis = 4.0 * np.sin(half) * cubes / (3.0 * phi * (ro**2 - ri**2))
    second_moment = (ro**4 - ri**4) * (phi + np.sin(phi)) / 8.0 - 8.0 * np.sin(half) ** 2 * cubes**2 / (
        9.0 * phi * (ro**2 - ri**2)
    )
    return SectionProperties(area, neutral_axis, second_moment)


def _chord(ro: FloatArray, ri: FloatArray, depth: FloatArray) -> SectionProperties:
    outer_area, outer_first, outer_second = _segment(ro, depth - ro)
    bore_area, bore_first, bore_second = _segment(ri, depth - ro)
    area = outer_area - bore_area
    neutral_axis = (outer_first - bore_first) / area
    return SectionProperties(area, neutral_axis, outer_second - bore_second - area * neutral_axis**2)


def _segment(radius: FloatArray, distance: FloatArray) -> tuple[FloatArray, FloatArray, FloatArray]:
    """Return area, first and second moment, about the circle's centre, of its part beyond a chord at ``distance``."""
    half = np.arccos(np.clip(distance / radius, -1.0, 1.0))
    sine, cosine = np.sin(half), np.cos(half)
    area = radius**2 * (half - sine * cosine)
    first = 2.0 / 3.0 * radius**3 * sine**3
    second = radius**4 / 4.0 * (half - sine * cosine + 2.0 * sine**3 * cosine)
    return area, first, second


def strip_across(
    outer_radius: ArrayLike, inner_radius: ArrayLike, depth: ArrayLike, kind: SectionKind = "sector"
) -> tuple[FloatArray, FloatArray]:
    """Return second moment about the axis of symmetry and torsion constant (m^4) of what a notch leaves.

    The torsion constant is that of a thin open strip of its mean arc (Timoshenko and Goodier, Theory of Elasticity, sec.
    109, with the 0.63 t of its ends), free to warp, so that short cuts are stiffer than it says.
    """
    ro, ri, d = np.broadcast_arrays(_numbers(outer_radius), _numbers(inner_radius), _numbers(depth))
    halves = [np.arccos(np.clip((d - ro) / radius, -1.0, 1.0)) for radius in (ro, ro if kind == "sector" else ri)]
    parts = [_segment_across(radius, half, kind) for radius, half in zip((ro, ri), halves, strict=True)]
    wall, arc = ro - ri, 0.5 * (ro + ri) * (halves[0] + halves[1])
    return parts[0] - parts[1], (arc - 0.63 * wall) * wall**3 / 3.0


def _segment_across(radius: FloatArray, half: FloatArray, kind: SectionKind) -> FloatArray:
    """Return the second moment about the axis of symmetry of a circle's sector, or of its segment, of a half angle."""
    sine, cosine = np.sin(half), np.cos(half)
    ends = 1.0 if kind == "sector" else 1.0 + 2.0 / 3.0 * sine**2
    return np.asarray(radius**4 / 4.0 * (half - ends * sine * cosine))
