"""How a superelastic notched tube comes back: the curves of release from every curvature that it was bent to.

A released section leaves its loading curve with the slope of its elastic parts, and reaches the lower plateau layer by
layer, its skin first. The curves are tabulated over the peak, each from the peak down to straight.
"""

from __future__ import annotations

from dataclasses import dataclass
from functools import lru_cache

import numpy as np

from coast_cli.mechanics.bending_law import BendingLaw, bending_law, interpolated
from coast_cli.mechanics.fibres import moment_after, ring_fibres, strip_fibres
from coast_cli.mechanics.section import FloatArray
from coast_cli.mechanics.superelastic import Superelastic
from coast_cli.mechanics.tubes import Tubes

_PEAKS, _SHARES, _LAYERS = 16, 25, 16


@dataclass(frozen=True)
class LoadAndRelease:
    """Load and release of one tube, in curvatures that a linear tube would have under the same moment.

    Attributes:
        load: its bending law. peak: mean curvatures that it was bent to, 1/m, shape (p,), from its plateau on.
        release: curvature and moment over rigidity over the peak, on the way back from it, shapes (p, q), rising.
    """

    load: BendingLaw
    peak: FloatArray
    release: tuple[FloatArray, FloatArray]

    def released(self, peak: FloatArray, share: FloatArray) -> FloatArray:
        """Return the moment over rigidity over the peak, (n, q), on release from peaks (1/m, (n,)) at shares (q,) of them."""
        wanted = np.broadcast_to(share, (len(self.peak), share.size))
        table = interpolated(wanted, *self.release)
        row = np.clip(np.searchsorted(self.peak, peak, side="right") - 1, 0, len(self.peak) - 2)
        part = np.clip((peak - self.peak[row]) / (self.peak[row + 1] - self.peak[row]), 0.0, 1.0)[:, None]
        return np.asarray(
            np.where(peak[:, None] <= self.peak[0], share, (1.0 - part) * table[row] + part * table[row + 1])
        )


def load_and_release(tubes: Tubes, law: Superelastic, modulus: float, *, towards_notch: bool) -> LoadAndRelease:
    """Return load and release of one tube with an austenite modulus (Pa); notches that differ count as their mean."""
    lengths = (np.mean(np.broadcast_to(x, tubes.depth.shape)) for x in (tubes.depth, tubes.cut, tubes.uncut))
    mean = (*lengths, np.mean(tubes.end_length), tubes.outer_radius[0], tubes.inner_radius[0])
    return _tabulated(tuple(float(value) for value in mean), tubes.section, law, modulus, towards_notch)


@lru_cache(maxsize=64)
def _tabulated(
    geometry: tuple[float, ...],
    section: str,
    law: Superelastic,
    modulus: float,
    towards_notch: bool,  # noqa: FBT001 -- private
) -> LoadAndRelease:
    depth, cut, uncut, spread, ro, ri = geometry
    one = np.ones(1)
    tube = Tubes(
        *(one * ro, one * ri, one[None] * depth, one[None] * cut, one[None] * uncut),
        *(np.ones(1, dtype=np.int64), one * modulus, one, one),
        section=section,  # type: ignore[arg-type]
        end_length=one[None] * spread,
    )
    load = bending_law(tube, law, modulus, towards_notch=towards_notch)
    strip = strip_fibres(one * ro, one * ri, one * depth, tube.section, _LAYERS)
    ring = modulus * float(ring_fibres(one * ro, one * ri).inertia[0])
    first = law.yield_strain * law.austenite_modulus / modulus / float(strip.reach[0])
    peaks = np.geomspace(first, first * (1.0 + law.transformation_strain / law.yield_strain), _PEAKS)
    sign, shares = (1.0 if towards_notch else -1.0), np.linspace(0.0, 1.0, _SHARES)
    top, moment = moment_after(strip, law, sign * peaks, sign * peaks[:, None] * shares, modulus)
    top, moment = sign * top, sign * moment
    pitch = cut + uncut
    peak = (peaks * (cut + spread) + top / ring * uncut) / pitch
    bend = (peaks[:, None] * shares * (cut + spread) + moment / ring * uncut) / pitch
    rigidity = float(load.rigidity[0, 0])
    return LoadAndRelease(load, peak, (bend / peak[:, None], moment / rigidity / peak[:, None]))
