"""How far joints bend within their limits, and which limits a bend passes: open notches, tendon, webs, tension."""

from __future__ import annotations

from collections.abc import Callable, Iterable
from dataclasses import replace
from typing import NamedTuple

import numpy as np
from numpy.typing import NDArray

from coast_cli.errors import BadInput
from coast_cli.mechanics.bending_law import Softening
from coast_cli.mechanics.joint import DrivenSegment, Joint, segment_parts, stroke, tension
from coast_cli.mechanics.section import FloatArray
from coast_cli.spec.config import Checks
from coast_cli.units import MILLIMETRE

Mask = NDArray[np.bool_]
PLATEAU_STRAIN, SET_STRAIN = 0.008, 0.054  # 360 MPa over 45 GPa, and 4.6 % further, where nitinol keeps a set
_HALVINGS = 60
_ROUNDED = 1.0 + 1e-12
_SOFTENING = frozenset({"tube_superelasticity", "tube_hysteresis"})


class Pulled(NamedTuple):
    """The tendon where joints are bent: stroke (m) and strain, NaN where there is none, and tension (N)."""

    stroke: FloatArray
    strain: FloatArray
    tension: FloatArray


class Webs(NamedTuple):
    """What of the notches limits a bend: largest strain for one 1/m (m), curvature at which the first closes (1/m)."""

    strain_per_curvature: FloatArray | float
    closure_curvature: FloatArray | float
    softening: Softening = Softening()

    def strain(self, curvature: FloatArray) -> FloatArray:
        """Return the largest strain in a web at a curvature (1/m), past the plateau of superelastic tubes too."""
        return np.asarray(curvature * self.strain_per_curvature * self.softening.strain_rise(curvature))

    @classmethod
    def of(cls, joint: Joint) -> Webs:
        """Return those of both tubes of a joint."""
        tubes = [tube for tube in (joint.outer, joint.middle) if tube is not None]
        largest = max(float(tube.strain_per_curvature.max()) for tube in tubes)
        return cls(largest, joint.closure_curvature, joint.softening)


def bent_webs(joint: Joint, curvature: FloatArray, bending_length: FloatArray) -> list[tuple[Webs, FloatArray]]:
    """Return the webs of each part of a segment with its curvature (1/m) at mean curvatures and lengths (m)."""
    tubes = (joint, replace(joint, outer=None, outer_cover=None))
    found = zip(tubes, segment_parts(joint, curvature, bending_length), strict=False)
    return [(Webs.of(one), np.where(part.share > 0.0, part.curvature, 0.0)) for one, part in found]


def require_covered(joint: Joint, bending_length: float) -> None:
    """Refuse a bending length (m) over which the segment bends unevenly, where limits are held at one curvature.

    Raises:
        BadInput: the outer tube ends on the way.
    """
    if joint.outer_cover is not None and bending_length > joint.outer_cover:
        raise BadInput(
            "limits and forecasts are of segments that bend evenly",
            key="joint.outer_cover_mm",
            found=f"{joint.outer_cover / MILLIMETRE:g}, and a bending length of {bending_length / MILLIMETRE:g} mm",
            allowed="a bending length up to it, or no outer_cover_mm",
            hint="`coast stroke` answers for uneven segments.",
        )


def softens(joint: Joint, acting: Iterable[str]) -> bool:
    """Return whether the model has the stress plateau: by the joint's material, or by an effect of these ids."""
    return bool(joint.softening.parts) or not _SOFTENING.isdisjoint(acting)


def pulled_at(joint: DrivenSegment, curvature: FloatArray, bending_length: float) -> Pulled:
    """Return the tendon at curvatures (1/m) and a bending length (m), without corrections."""
    if joint.tendon is None:
        unknown = np.full_like(curvature, np.nan)
        return Pulled(unknown, unknown, tension(joint, curvature, bending_length))
    found = stroke(joint, curvature, bending_length)
    return Pulled(found.stroke, found.tendon_strain, found.tension)


def largest_curvature(pull: Callable[[FloatArray], Pulled], webs: Webs, checks: Checks) -> FloatArray:
    """Return the largest curvature (1/m) at which every given limit on stroke, strain, tension and webs holds.

    Found by halving: all of them grow with the bend. A curvature that no pull holds passes no limit.
    """
    high = np.atleast_1d(np.asarray(webs.closure_curvature, dtype=float)).copy()
    if checks.max_web_strain is not None:
        high = np.minimum(high, checks.max_web_strain / webs.strain_per_curvature)

    def holding(curvature: FloatArray) -> Mask:
        within = checks.max_web_strain is None or webs.strain(curvature) <= checks.max_web_strain * _ROUNDED
        return tendon_holds(pull(curvature), checks) & within

    low = np.where(holding(high), high, 0.0)
    for _ in range(_HALVINGS):
        middle = 0.5 * (low + high)
        holds = holding(middle)
        low, high = np.where(holds, middle, low), np.where(holds, high, middle)
    return low


def tendon_holds(pulled: Pulled, checks: Checks) -> Mask:
    """Return where no limit on the tendon is passed."""
    passed = np.zeros(pulled.tension.shape, dtype=bool)
    for mask, _ in tendon_limits(pulled, checks):
        passed |= mask
    return ~passed


def tendon_limits(pulled: Pulled, checks: Checks | None) -> list[tuple[Mask, str]]:
    """Return where each given limit on the tendon is passed, with what to say of it."""
    found: list[tuple[Mask, str]] = []
    if checks is None:
        return found
    if checks.max_stroke_mm is not None:
        limit = checks.max_stroke_mm.value
        found.append((pulled.stroke > limit * MILLIMETRE, f"stroke above {limit:g} mm (checks.max_stroke_mm)"))
    if checks.max_tendon_strain is not None:
        limit = checks.max_tendon_strain
        found.append((pulled.strain > limit, f"tendon strain above {limit:g} (checks.max_tendon_strain)"))
    if checks.max_tension_n is not None:
        limit = checks.max_tension_n
        found.append((pulled.tension > limit, f"tension above {limit:g} N (checks.max_tension_n)"))
    return found


def web_limits(curvature: FloatArray, webs: Webs, checks: Checks | None, *, closes: bool) -> list[tuple[Mask, str]]:
    """Return where each limit on what the notches leave is passed, with what to say of it.

    Args:
        closes: whether the model itself stops at closed notches, so that closing is no limit.
    """
    strain = webs.strain(curvature)
    largest = float(np.max(strain, initial=0.0))
    closing = float(np.min(webs.closure_curvature))
    found = [
        (
            curvature > closing if not closes else np.zeros(curvature.shape, bool),
            f"notch faces touch above {closing:.4g} 1/m",
        ),
        (strain > SET_STRAIN, f"web strain {largest:.3g} above {SET_STRAIN:g}, where nitinol keeps a set"),
    ]
    if checks is not None and checks.max_web_strain is not None:
        limit = checks.max_web_strain
        found.append((strain > limit, f"web strain {largest:.3g} above {limit:g} (checks.max_web_strain)"))
    if checks is not None and checks.fatigue is not None:
        limit = checks.fatigue.amplitude
        words = f"strain amplitude {0.5 * largest:.3g} from straight above {limit:g} (checks.fatigue)"
        found.append((0.5 * strain > limit, words))
    if checks is not None and checks.min_closure_margin is not None:
        limit = checks.min_closure_margin
        words = f"notch faces touch at less than {limit:g} times the curvature (checks.min_closure_margin)"
        found.append((curvature * limit > closing, words))
    return found
