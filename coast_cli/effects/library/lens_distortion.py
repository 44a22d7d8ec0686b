"""Lens distortion: places move outward or inward with their distance from the middle of the picture."""

from __future__ import annotations

from dataclasses import dataclass

from coast_cli.effects.effect import Parameter
from coast_cli.effects.shape_stages import OnImage
from coast_cli.mechanics.section import FloatArray


@dataclass(frozen=True)
class LensDistortion(OnImage):
    """The first radial term; the picture is taken as centred on the shape."""

    radial_per_m2: float = 0.0

    id = "lens_distortion"
    title = "the lens distorts"
    component = "camera"
    kind = "sensor"
    scope = "camera"
    equation = "r -> r (1 + radial r^2), r from the middle of the shape"
    source = "Brown, Photogrammetric Engineering 32 (1966) 444: first radial term"
    parameters = (Parameter("radial_per_m2", 0.0, -200.0, 200.0, (10.0,), "a few per cent at 50 mm"),)
    unlikely = 3.0
    decided_by = "a grid in the plane of the tube, in the same picture"

    def see(self, x: FloatArray, y: FloatArray, centre: tuple[float, float]) -> tuple[FloatArray, FloatArray]:
        """Distort."""
        across, up = x - centre[0], y - centre[1]
        factor = 1.0 + self.radial_per_m2 * (across**2 + up**2)
        return centre[0] + across * factor, centre[1] + up * factor
