"""Notch depth error: the cuts are deeper or shallower than the configuration has them."""

from __future__ import annotations

from dataclasses import dataclass, replace

import numpy as np

from coast_cli.effects.effect import Parameter
from coast_cli.effects.shape_stages import TUBE
from coast_cli.effects.stages import OnTubes
from coast_cli.mechanics.tube import NotchedTube
from coast_cli.units import MICROMETRE


@dataclass(frozen=True)
class NotchDepthError(OnTubes):
    """The same error of depth at every notch of one tube, or of all; positive is deeper."""

    depth_um: float = 0.0
    tube: float = 0.0

    id = "notch_depth_error"
    title = "the cut is deeper or shallower than specified"
    component = "tube"
    kind = "parameter"
    equation = "d -> d + depth"
    source = "P blames machining tolerances; notch depth +-0.01 to 0.02 mm"
    parameters = (
        Parameter("depth_um", 0.0, -80.0, 80.0, (5.0, -5.0), "tolerance 10 to 20 micrometres", expected=(0.0, 15.0)),
        TUBE,
    )
    recordings = ("shapes",)  # on a joint it hides in the modulus
    of_stock = True
    decided_by = "the same load on tubes of other depths, both ways up; or the depth measured under a microscope"

    def geometry(self, tube: NotchedTube) -> NotchedTube:
        """Deepen the cuts, within the tube."""
        diameter = 2.0 * tube.outer_radius
        depth = np.clip(tube.depth + self.depth_um * MICROMETRE, 0.5 * diameter, 0.985 * diameter)
        return replace(tube, depth=depth)
