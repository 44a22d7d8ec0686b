"""Frozen frames: the camera repeats a frame, in bursts, while the drive goes on.

What repeats is found in the rows themselves (``recordings.faults``) and is left out of every fit; the effect only says so.
"""

from __future__ import annotations

from dataclasses import dataclass

from coast_cli.effects.effect import Parameter
from coast_cli.effects.stages import OnSensor


@dataclass(frozen=True)
class FrozenFrames(OnSensor):
    """The fraction of rows that repeat the frame before them."""

    fraction: float = 0.0

    id = "frozen_frames"
    title = "frames repeat in bursts"
    component = "camera"
    kind = "sensor"
    scope = "camera"
    equation = "response(t) = response at the last frame that was new"
    source = "repeated values in telemetry: NIST/SEMATECH e-Handbook of Statistical Methods, sec. 4.4.4"
    parameters = (Parameter("fraction", 0.0, 0.0, 1.0, (0.1,), "counted in the recording, not fitted", role="found"),)
    needs = ("frozen",)
    decided_by = "the same sweep with another camera or a slower frame rate"
