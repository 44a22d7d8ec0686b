"""What moment bends a superelastic notched tube how far: its strip and its ring in series, as one table a tube.

One pitch is a ring and a strip under one moment, and their bends add. Where notches differ, the tube's table is that of
all its notches in series. Below the plateau every table is the straight line of ``rigidity_series``.
"""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass
from functools import cached_property
from typing import TYPE_CHECKING

import numpy as np
from numpy.typing import ArrayLike, NDArray

from coast_cli.mechanics.fibres import LAYERS, Fibres, moment_curvature, ring_fibres, strip_fibres
from coast_cli.mechanics.section import FloatArray
from coast_cli.mechanics.superelastic import Superelastic

if TYPE_CHECKING:
    from coast_cli.mechanics.tubes import Tubes

# Nodes past the first, and layers: straight lines between them are within 2e-4 of the law; of many sections within 2e-3.
_FINE, _COARSE, _MANY = (96, LAYERS), (40, 24), 64
_BEYOND = 0.02  # strain past the end of the plateau to which a table reaches; further on it is straight


@dataclass(frozen=True)
class BendingLaw:
    """Tables of m tubes, shape (m, q), rising from zero: mean curvature (1/m), moment (N m), largest strain in a strip."""

    curvature: FloatArray
    moment: FloatArray
    strain: FloatArray

    @cached_property
    def rigidity(self) -> FloatArray:
        """Rigidity below the plateau, N m^2, shape (m, 1)."""
        return np.asarray(self.moment[:, 1:2] / self.curvature[:, 1:2])

    def carried(self, curvature: FloatArray) -> FloatArray:
        """Return the moment over the rigidity below the plateau, 1/m, so that it equals the curvature there.

        Args:
            curvature: 1/m, shape (m, k); the other way round the law is taken as its mirror image.
        """
        size = np.abs(curvature)
        bent = interpolated(size, self.curvature, self.moment) / self.rigidity
        return np.copysign(np.where(size <= self.curvature[:, 1:2], size, bent), curvature)

    def slope(self, curvature: FloatArray) -> FloatArray:
        """Return the slope of ``carried``: tangent over initial rigidity, 1 below the plateau."""
        size = np.abs(curvature)
        run, rise = (np.diff(table, axis=1) for table in (self.curvature, self.moment))
        slope = np.take_along_axis(rise / run, _places(size, self.curvature), axis=1) / self.rigidity
        return np.where(size <= self.curvature[:, 1:2], 1.0, slope)

    def strain_at(self, curvature: FloatArray) -> FloatArray:
        """Return the largest strain that any strip reaches at a mean curvature (1/m), shape (m, k)."""
        return interpolated(np.abs(curvature), self.curvature, self.strain)

    def strain_rise(self, curvature: FloatArray) -> FloatArray:
        """Return that strain over what it would be if the tube were linear, shape (m, k)."""
        linear = self.strain[:, 1:2] / self.curvature[:, 1:2] * np.abs(curvature)
        past = np.abs(curvature) > self.curvature[:, 1:2]
        return np.where(past, self.strain_at(curvature) / np.where(past, linear, 1.0), 1.0)


@dataclass(frozen=True)
class Softening:
    """How tubes that bend together soften: each one's fraction of the rigidity below the plateau, (m, 1), and its law."""

    parts: tuple[tuple[FloatArray, BendingLaw], ...] = ()

    def carried(self, curvature: FloatArray) -> FloatArray:
        """Return the curvature (1/m) that linear tubes would have under the same moment: itself below the plateau."""
        return self._sum(curvature, curvature, lambda law, rows: law.carried(rows) - rows)

    def slope(self, curvature: FloatArray) -> FloatArray:
        """Return the slope of ``carried``: 1 below the plateau."""
        return self._sum(curvature, np.ones_like(curvature), lambda law, rows: law.slope(rows) - 1.0)

    def strain_rise(self, curvature: FloatArray) -> FloatArray:
        """Return the largest strain in a strip over that of a linear one at the same curvature (1/m): 1 below the plateau.

        Past it the neutral axis moves, and the strips take a larger part of the bend from the rings.
        """
        if not self.parts:
            return np.ones_like(curvature)
        rows = np.abs(_rows(curvature, len(self.parts[0][0])))
        rises = [law.strain_rise(rows) for _, law in self.parts]
        return np.asarray(np.max(rises, axis=0).reshape(_shape(curvature, rows)))

    def _sum(
        self, curvature: FloatArray, linear: FloatArray, change: Callable[[BendingLaw, FloatArray], FloatArray]
    ) -> FloatArray:
        if not self.parts:
            return linear
        rows = _rows(curvature, len(self.parts[0][0]))
        changes = np.sum([part * change(law, rows) for part, law in self.parts], axis=0)
        return np.asarray(linear + changes.reshape(_shape(curvature, rows)))


def softening_of(outer: Tubes | None, middle: Tubes, modulus: float) -> Softening:
    """Return how a joint's tubes soften, row by row, with one austenite modulus (Pa); nothing where all are linear.

    The bend is towards the middle tube's notches, where the tendon pulls, and away from the outer tube's.
    """
    tubes = ((outer, False), (middle, True))
    moments = [(0.0 if one is None else one.rigidity_series / one.youngs_modulus) for one, _ in tubes]
    parts = []
    for (one, towards_notch), moment in zip(tubes, moments, strict=True):
        if one is not None and one.superelastic is not None:
            law = bending_law(one, one.superelastic, modulus, towards_notch=towards_notch)
            parts.append((np.reshape(moment / sum(moments), (-1, 1)), law))
    return Softening(tuple(parts))


def bending_law(
    tubes: Tubes, law: Superelastic, modulus: ArrayLike, *, towards_notch: bool, unloading: bool = False
) -> BendingLaw:
    """Return the bending law of tubes.

    Args:
        modulus: of the austenite of each tube, Pa, shape (m,) or one number; martensite follows in proportion.
        towards_notch: the way of the bend: the strip's skin is stretched, else pressed.
        unloading: the law on the way back from full transformation.
    """
    own = np.broadcast_to(np.asarray(modulus, dtype=float), tubes.outer_radius.shape)
    depth, cut, uncut, spread, count = _distinct(tubes)
    nodes, layers = _COARSE if depth.size > _MANY else _FINE
    strips = strip_fibres(tubes.outer_radius[:, None], tubes.inner_radius[:, None], depth, tubes.section, layers)
    stiff = np.broadcast_to(own[:, None], depth.shape)
    bend, moment, strain = _curve(strips, law, stiff, nodes, towards_notch=towards_notch, unloading=unloading)
    rings = ring_fibres(tubes.outer_radius, tubes.inner_radius)
    ring_bend = _ring_bend(rings, law, own, moment, unloading=unloading)
    pitch = cut + uncut
    curvature = (bend * (cut + spread)[..., None] + ring_bend * uncut[..., None]) / pitch[..., None]
    if depth.shape[1] == 1:
        return BendingLaw(curvature[:, 0], moment[:, 0], strain[:, 0])
    return _in_series(curvature, moment, strain, pitch * count)


@dataclass(frozen=True, slots=True)
class StripLaws:
    """Bending of the cut pieces of one tube alone, without its rings: a row of tables a distinct notch.

    Attributes:
        towards, away: laws of a bend towards the notches and away from them. row: of each notch, shape (n,).
    """

    towards: BendingLaw
    away: BendingLaw
    row: NDArray[np.intp]

    @classmethod
    def of(cls, tube: Tubes, law: Superelastic) -> StripLaws:
        """Return those of a table of one tube."""
        spread = np.broadcast_to(tube.end_length, tube.depth.shape)
        kinds, row = np.unique(np.stack((tube.depth[0], tube.cut[0], spread[0])), axis=1, return_inverse=True)
        depth, cut, end = kinds
        strips = strip_fibres(tube.outer_radius, tube.inner_radius, depth, tube.section)
        stiff = np.broadcast_to(tube.youngs_modulus, depth.shape)

        def way(*, towards_notch: bool) -> BendingLaw:
            bend, moment, strain = _curve(strips, law, stiff, _FINE[0], towards_notch=towards_notch, unloading=False)
            return BendingLaw(bend * ((cut + end) / cut)[:, None], moment, strain)

        return cls(way(towards_notch=True), way(towards_notch=False), row.reshape(-1))

    def softness(self, moment: FloatArray, notch: NDArray[np.intp]) -> FloatArray:
        """Return secant over initial rigidity of cut pieces under moments (N m, positive towards the notch)."""
        size = np.abs(moment)
        kinds = self.row[notch]
        found = np.ones_like(size)
        for kind in np.unique(kinds):
            here = kinds == kind
            for law, way in ((self.towards, moment >= 0.0), (self.away, moment < 0.0)):
                some = here & way & (size > law.moment[kind, 1])
                bend = interpolated(size[some][None], law.moment[kind : kind + 1], law.curvature[kind : kind + 1])[0]
                found[some] = size[some] / bend / law.rigidity[kind, 0]
        return found


def _distinct(tubes: Tubes) -> tuple[FloatArray, ...]:
    """Return depth, cut, uncut and extra cut length of the different notches of tubes (m, n), and how many there are."""
    table = np.stack(np.broadcast_arrays(tubes.depth, tubes.cut, tubes.uncut, tubes.end_length))
    found, count = np.unique(table, axis=2, return_counts=True)
    return (*found, count)


def interpolated(at: FloatArray, known: FloatArray, values: FloatArray) -> FloatArray:
    """Return values of rising tables row by row, straight beyond their ends; ``at`` (m, k), tables (m, q)."""
    place = _places(at, known)
    left, right = (np.take_along_axis(known, place + step, axis=1) for step in (0, 1))
    low, high = (np.take_along_axis(values, place + step, axis=1) for step in (0, 1))
    return np.asarray(low + (at - left) * ((high - low) / (right - left)))


def _rows(curvature: FloatArray, count: int) -> FloatArray:
    """Return curvatures as one row a tube: any shape for one tube, else a number or one for each tube."""
    kappa = np.asarray(curvature, dtype=float)
    return kappa.reshape(1, -1) if count == 1 else np.broadcast_to(kappa.reshape(-1, 1), (count, 1))


def _shape(curvature: FloatArray, rows: FloatArray) -> tuple[int, ...]:
    return np.shape(curvature) if len(rows) == 1 else (len(rows),)


def _places(at: FloatArray, known: FloatArray) -> np.ndarray:
    """Return the interval of each value in its row's table: one search, with the rows set one behind the other."""
    top = known[:, -1:]
    row = 2.0 * np.arange(len(known))[:, None]
    behind = (known / top + row).ravel()
    found = np.searchsorted(behind, (np.clip(at / top, 0.0, 1.0) + row).ravel(), side="right").reshape(at.shape)
    first = known.shape[1] * np.arange(len(known))[:, None]
    return np.asarray(np.clip(found - first - 1, 0, known.shape[1] - 2))


def _curve(
    fibres: Fibres, law: Superelastic, modulus: FloatArray, count: int, *, towards_notch: bool, unloading: bool
) -> tuple[FloatArray, FloatArray, FloatArray]:
    """Return curvature, moment and largest strain of sections, shape (..., q), from zero to past the plateau."""
    begins = (law.lower_plateau / law.upper_plateau if unloading else 1.0) * law.yield_strain
    first = begins * (law.austenite_modulus / modulus) / fibres.reach
    end = law.yield_strain + law.transformation_strain * max(1.0, 1.0 / law.compression_ratio) + _BEYOND
    ratio = np.geomspace(1.0, 2.0 * end / law.yield_strain, count)
    nodes = first[..., None] * np.concatenate(([0.0], ratio))
    sign = 1.0 if towards_notch else -1.0
    moment, centre = moment_curvature(fibres, law, sign * nodes, unloading=unloading, modulus=modulus)
    skins = [np.abs(sign * nodes * edge[..., None] + centre) for edge in (fibres.low, fibres.high)]
    return nodes, sign * moment, np.maximum(*skins)


def _ring_bend(
    rings: Fibres, law: Superelastic, modulus: FloatArray, moment: FloatArray, *, unloading: bool
) -> FloatArray:
    """Return the curvature of each tube's ring under the moments of its strips (m, n, q)."""
    most = float((moment.max(axis=(1, 2)) / (rings.inertia / rings.reach)).max())
    linear = moment / (modulus * rings.inertia)[:, None, None]
    if most <= law.yield_strain * law.austenite_modulus * (law.lower_plateau / law.upper_plateau if unloading else 1.0):
        return np.asarray(linear)
    bend, held, _ = _curve(rings, law, modulus, _FINE[0], towards_notch=True, unloading=unloading)
    return interpolated(moment.reshape(len(moment), -1), held, bend).reshape(moment.shape)


def _in_series(curvature: FloatArray, moment: FloatArray, strain: FloatArray, pitch: FloatArray) -> BendingLaw:
    """Return one law a tube from those of its notches (m, n, q): at each moment their bends add by pitch."""
    softest = np.argmin(moment[:, :, 1], axis=1)
    held = np.take_along_axis(moment, softest[:, None, None], axis=1)[:, 0]
    bend, largest = np.zeros_like(held), np.zeros_like(held)
    for notch, share in enumerate((pitch / pitch.sum(axis=1, keepdims=True)).T):
        bend += share[:, None] * interpolated(held, moment[:, notch], curvature[:, notch])
        largest = np.maximum(largest, interpolated(held, moment[:, notch], strain[:, notch]))
    return BendingLaw(bend, held, largest)
