"""Moment and curvature of a section of superelastic layers: strip, ring or bar, for any number of tubes at once.

Plane sections stay plane. A section is cut into layers across the bending axis whose area, centroid and second moment
are exact, so that below the plateau the answer is that of ``section.py`` to rounding; beyond it the error falls with
the square of the layer's height. Each layer follows the material's own law, with its own memory.
"""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass, fields

import numpy as np
from numpy.typing import ArrayLike

from coast_cli.errors import NotConverged
from coast_cli.mechanics.section import FloatArray, SectionKind
from coast_cli.mechanics.superelastic import Superelastic

LAYERS = 32
_MOST_STEPS = 80
_BALANCED = 1e-13  # of the force that the section would carry at its largest strain
_BLOCK = 1 << 17  # strains at once, so that they stay in the processor's cache


@dataclass(frozen=True, slots=True)
class Fibres:
    """Layers of sections, shape (..., layers): area (m^2), centroid from the section's own (m), own second moment (m^4).

    Attributes:
        low, high: edges of the section from its centroid, m, shape (...,).
        centroid: from the tube's axis, m, shape (...,); positive towards the strip.
    """

    area: FloatArray
    position: FloatArray
    second_moment: FloatArray
    low: FloatArray
    high: FloatArray
    centroid: FloatArray

    @property
    def reach(self) -> FloatArray:
        """Distance of the further edge from the centroid, m."""
        return np.asarray(np.maximum(self.high, -self.low))

    @property
    def inertia(self) -> FloatArray:
        """Second moment of area about the centroid, m^4."""
        return np.asarray((self.area * self.position**2 + self.second_moment).sum(axis=-1))


def ring_fibres(outer_radius: ArrayLike, inner_radius: ArrayLike, layers: int = LAYERS) -> Fibres:
    """Return the layers of uncut rings; radii in m."""
    ro, ri = np.broadcast_arrays(np.asarray(outer_radius, dtype=float), np.asarray(inner_radius, dtype=float))
    edges = _edges(-ro, ro, layers)
    return _layers(edges, [a - b for a, b in zip(_disc(ro, edges), _disc(ri, edges), strict=True)])


def strip_fibres(
    outer_radius: ArrayLike,
    inner_radius: ArrayLike,
    depth: ArrayLike,
    kind: SectionKind = "sector",
    layers: int = LAYERS,
) -> Fibres:
    """Return the layers of what notches of ``depth`` leave; m, arrays broadcast. See ``section.notched_section``."""
    ro, ri, d = np.broadcast_arrays(*(np.asarray(value, dtype=float) for value in (outer_radius, inner_radius, depth)))
    if kind == "chord":
        edges = _edges(d - ro, ro, layers)
        return _layers(edges, [a - b for a, b in zip(_disc(ro, edges), _disc(ri, edges), strict=True)])
    half = np.arccos((d - ro) / ro)
    edges = _edges(ri * np.cos(half), ro, layers)
    return _layers(edges, [a - b for a, b in zip(_wedge(ro, half, edges), _wedge(ri, half, edges), strict=True)])


def bar_fibres(width: float, height: float, layers: int = LAYERS) -> Fibres:
    """Return the layers of a rectangular bar of ``width`` and ``height`` (m)."""
    edges = _edges(np.asarray(-height / 2.0), np.asarray(height / 2.0), layers)
    return _layers(edges, [width * edges ** (power + 1) / (power + 1) for power in range(3)])


def moment_curvature(
    fibres: Fibres,
    law: Superelastic,
    curvature: ArrayLike,
    *,
    axial_force: float = 0.0,
    unloading: bool = False,
    modulus: ArrayLike | None = None,
) -> tuple[FloatArray, FloatArray]:
    """Return moment about the centroid (N m) and strain there, on an envelope; both of the shape of ``curvature``.

    Every layer is taken on its own envelope. Where the neutral axis moves, a few layers turn back while the bend grows;
    ``moment_history`` follows those too, and differs by some 2e-4.

    Args:
        fibres: sections of shape (...,). curvature: 1/m, shape (..., q); positive stretches the high edge (the strip's
            skin: a bend towards the notch).
        axial_force: that the section carries, N; pull is positive.
        unloading: the envelope back from full transformation instead of the one up from austenite.
        modulus: of the austenite of each section, Pa, shape (...,), where it is not the law's.

    Raises:
        NotConverged: no strain of the centroid balances the force.
    """
    kappa = np.asarray(curvature, dtype=float)
    kappa = np.broadcast_to(kappa, np.broadcast_shapes(kappa.shape, (*fibres.low.shape, 1)))
    moment, centre = np.empty(kappa.shape), np.empty(kappa.shape)
    rows = kappa.reshape(-1, kappa.shape[-1])
    flat = _flat(fibres, kappa.shape[:-1])
    stiff = None if modulus is None else np.broadcast_to(modulus, kappa.shape[:-1]).reshape(-1, 1, 1)
    step = max(1, _BLOCK // (kappa.shape[-1] * fibres.area.shape[-1]))
    for first in range(0, len(rows), step):
        part = slice(first, first + step)
        own = law if stiff is None else law.with_modulus(stiff[part])
        found = _balanced(_rows(flat, part), own, rows[part], axial_force, _envelope(own, unloading=unloading))
        moment.reshape(rows.shape)[part], centre.reshape(rows.shape)[part] = found[:2]
    return moment, centre


def moment_after(
    fibres: Fibres, law: Superelastic, peak: ArrayLike, curvature: ArrayLike, modulus: ArrayLike | None = None
) -> tuple[FloatArray, FloatArray]:
    """Return the moment (N m) at peaks, and after one monotone change from each of them to other curvatures.

    Args:
        peak: curvature reached from austenite, 1/m, shape (p,). curvature: shape (p, q); one section for all.
        modulus: of the austenite, Pa, where it is not the law's.
    """
    own = law if modulus is None else law.with_modulus(float(np.asarray(modulus)))
    peaks, kappa = np.asarray(peak, dtype=float)[:, None], np.asarray(curvature, dtype=float)
    flat = _flat(fibres, (len(peaks),))
    top, _, fraction = _balanced(flat, own, peaks, 0.0, _envelope(own, unloading=False))
    return top[:, 0], _balanced(flat, own, kappa, 0.0, _after(own, fraction))[0]


def moment_history(
    fibres: Fibres, law: Superelastic, curvature: ArrayLike, *, axial_force: float = 0.0
) -> tuple[FloatArray, FloatArray]:
    """Return moment (N m) and strain of the centroid along a history of curvature, from austenite.

    Args:
        curvature: 1/m, shape (..., t), followed in order; each step may go either way.
    """
    kappa = np.asarray(curvature, dtype=float)
    kappa = np.broadcast_to(kappa, np.broadcast_shapes(kappa.shape, (*fibres.low.shape, 1)))
    rows = kappa.reshape(-1, kappa.shape[-1])
    flat = _flat(fibres, kappa.shape[:-1])
    fraction = np.zeros((len(rows), 1, fibres.area.shape[-1]))
    moment, centre = np.empty(rows.shape), np.empty(rows.shape)
    for step in range(rows.shape[1]):
        found = _balanced(flat, law, rows[:, step : step + 1], axial_force, _after(law, fraction))
        moment[:, step], centre[:, step], fraction = found[0][:, 0], found[1][:, 0], found[2]
    return moment.reshape(kappa.shape), centre.reshape(kappa.shape)


_State = Callable[[FloatArray], tuple[FloatArray, FloatArray]]  # strain -> fraction, and where it moves: 1 up, -1 down


def _envelope(law: Superelastic, *, unloading: bool) -> _State:
    def state(strain: FloatArray) -> tuple[FloatArray, FloatArray]:
        fraction = law.fraction_unloading(strain) if unloading else law.fraction_loading(strain)
        size = np.abs(fraction)
        return fraction, np.where((size > 0.0) & (size < 1.0), -1.0 if unloading else 1.0, 0.0)

    return state


def _after(law: Superelastic, before: FloatArray) -> _State:
    def state(strain: FloatArray) -> tuple[FloatArray, FloatArray]:
        fraction = law.fraction(strain, before)
        size = np.abs(fraction)
        return fraction, ((size > 0.0) & (size < 1.0)) * np.sign(size - np.abs(before))

    return state


def _balanced(
    fibres: Fibres, law: Superelastic, curvature: FloatArray, axial_force: float, state: _State
) -> tuple[FloatArray, FloatArray, FloatArray]:
    """Return moment, strain of the centroid and fractions that balance the force: Newton's method inside a bracket.

    The force rises with the strain of the centroid and is piecewise linear in it, so that a few steps end on it exactly.
    """
    area, arm = fibres.area[:, None, :], fibres.position[:, None, :]
    bent = curvature[:, :, None] * arm
    austenite, martensite = (np.reshape(m, (-1, 1)) for m in (law.austenite_modulus, law.martensite_modulus))
    whole = fibres.area.sum(axis=-1)[:, None]
    widest = np.abs(curvature) * fibres.reach[:, None]
    pull = abs(axial_force) / (martensite * whole) + law.transformation_strain * (axial_force != 0.0)
    low, high = -widest - pull, widest + pull
    centre = np.clip(np.broadcast_to(axial_force / (austenite * whole), curvature.shape), low, high)
    tolerance = _BALANCED * (austenite * whole * (widest + 1e-12) + abs(axial_force))
    for _ in range(_MOST_STEPS):
        strain = bent + centre[:, :, None]
        fraction, moving = state(strain)
        tangent = _tangent(law, fraction, moving)
        stress = law.stress(strain, fraction)
        excess = (stress * area).sum(axis=-1) - axial_force
        if np.all((np.abs(excess) <= tolerance) | (high - low <= 1e-16 * (1.0 + widest))):
            break
        low, high = np.where(excess < 0.0, centre, low), np.where(excess > 0.0, centre, high)
        slope = (tangent * area).sum(axis=-1)
        trial = centre - excess / np.maximum(slope, 1e-9 * austenite * whole)
        inside = (trial > low) & (trial < high)
        centre = np.where(np.abs(excess) <= tolerance, centre, np.where(inside, trial, 0.5 * (low + high)))
    else:
        raise NotConverged("no neutral axis balances the axial force of a section: give a smaller curvature or force.")
    own = (tangent * fibres.second_moment[:, None, :]).sum(axis=-1) * curvature
    return np.asarray((stress * area * arm).sum(axis=-1) + own), centre, fraction


def _tangent(law: Superelastic, fraction: FloatArray, moving: FloatArray) -> FloatArray:
    """Return the slope of stress against strain (Pa) where each fraction waits (0) or moves up (1) or down (-1)."""
    slope = law.modulus(fraction)
    if not moving.any():
        return slope
    squeezed = np.where(fraction < 0.0, law.compression_ratio**2, 1.0)
    up = law.plateau_modulus * squeezed
    rise = law.transformation_strain / law.lower_length
    return np.where(moving > 0.0, up, np.where(moving < 0.0, up * rise, slope))


def _edges(low: FloatArray, high: FloatArray, layers: int) -> FloatArray:
    share = np.linspace(0.0, 1.0, layers + 1)
    edges = low[..., None] + share * (high - low)[..., None]
    edges[..., -1] = high
    return np.asarray(edges)


def _layers(edges: FloatArray, below: list[FloatArray]) -> Fibres:
    """Return layers between edges from the area and its first and second moment below each edge."""
    area, first, second = (np.diff(values, axis=-1) for values in below)
    total = area.sum(axis=-1)
    centroid = first.sum(axis=-1) / total
    centre = first / area
    return Fibres(
        area=area,
        position=centre - centroid[..., None],
        second_moment=np.maximum(second - area * centre**2, 0.0),
        low=edges[..., 0] - centroid,
        high=edges[..., -1] - centroid,
        centroid=centroid,
    )


def _disc(radius: FloatArray, level: FloatArray) -> list[FloatArray]:
    """Return area, first and second moment of a disc below a level, about its centre."""
    r = radius[..., None]
    angle = np.arccos(np.clip(-level / r, -1.0, 1.0))  # from the bottom
    sine, cosine = np.sin(angle), np.cos(angle)
    area = r**2 * (angle - sine * cosine)
    return [area, -2.0 / 3.0 * r**3 * sine**3, r**4 / 4.0 * (angle - sine * cosine + 2.0 * sine**3 * cosine)]


def _wedge(radius: FloatArray, half: FloatArray, level: FloatArray) -> list[FloatArray]:
    """Return area, first and second moment below a level of a disc's sector of half angle ``half`` about +y."""
    corner = (radius * np.cos(half))[..., None]
    slope = np.tan(half)[..., None]
    straight = np.clip(level, 0.0, corner)
    triangle = [2.0 * slope * straight ** (power + 2) / (power + 2) for power in range(3)]
    above = [a - b for a, b in zip(_disc(radius, np.maximum(level, corner)), _disc(radius, corner), strict=True)]
    return [a + b for a, b in zip(triangle, above, strict=True)]


def _flat(fibres: Fibres, shape: tuple[int, ...]) -> Fibres:
    """Return sections broadcast to a shape and then in one row after another."""
    layers = fibres.area.shape[-1]
    values = {}
    for item in fields(Fibres):
        value: FloatArray = getattr(fibres, item.name)
        row = (layers,) if value.ndim == fibres.area.ndim else ()
        values[item.name] = np.broadcast_to(value, (*shape, *row)).reshape(-1, *row)
    return Fibres(**values)


def _rows(fibres: Fibres, part: slice) -> Fibres:
    return Fibres(**{item.name: getattr(fibres, item.name)[part] for item in fields(Fibres)})
