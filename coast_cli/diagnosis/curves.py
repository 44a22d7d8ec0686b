"""What the refitted base model and the corrected model predict, run by run: a diagnosis arrives with them."""

from __future__ import annotations

from dataclasses import dataclass
from typing import TYPE_CHECKING

if TYPE_CHECKING:
    from coast_cli.mechanics.section import FloatArray
    from coast_cli.recordings.model import JointRun, ShapeRun


@dataclass(frozen=True, eq=False)
class JointCurve:
    """A run with what both models expect of it, [n, k] in the run's SI unit."""

    run: JointRun
    base: FloatArray
    corrected: FloatArray


@dataclass(frozen=True, eq=False)
class ShapeCurve:
    """A photographed shape with both models' lines at its points: x and y in m, [2, n]; ``at``: arc length, m, [n].

    Attributes:
        curvature: of the recording, the refitted base and the corrected model, 1/m, [3, n]; NaN at the ends.
        natural: curvature of the corrected model without any load, 1/m, in the frame of the picture; None of a pair.
    """

    run: ShapeRun
    at: FloatArray
    base: FloatArray
    corrected: FloatArray
    curvature: FloatArray
    natural: float | None
