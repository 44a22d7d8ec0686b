"""The stages at which effects of a joint act, each a base class with methods that are the identity unless overridden.

An effect is made of the stages that it acts at; the first of them says where it stands in the order of action.
"""

from __future__ import annotations

from dataclasses import replace
from typing import ClassVar

import numpy as np

from coast_cli.effects.effect import Effect, History, Motion, RecordingKind, Segment, Stage
from coast_cli.effects.shape_stages import OnShapes
from coast_cli.mechanics.joint import Joint
from coast_cli.mechanics.section import FloatArray
from coast_cli.mechanics.tube import NotchedTube


class OnTubes(OnShapes):
    """Geometry of the tubes, before anything else; of joints and of photographed tubes alike."""

    stage: ClassVar[Stage] = "structure"
    recordings: ClassVar[tuple[RecordingKind, ...]] = ("joint", "shapes")
    changes_tubes = True

    def geometry(self, tube: NotchedTube) -> NotchedTube:
        """Change a tube itself."""
        return tube

    def joint(self, joint: Joint) -> Joint:
        """Change the joint's tubes, all alike."""
        outer = None if joint.outer is None else self.geometry(joint.outer)
        return replace(joint, outer=outer, middle=self.geometry(joint.middle))


class OnJoint(Effect):
    """Anything that acts on a joint."""

    recordings: ClassVar[tuple[RecordingKind, ...]] = ("joint",)


class OnDrive(OnJoint):
    """What the drive does, before it reaches the tendon."""

    stage: ClassVar[Stage] = "drive"

    def drive(self, history: History) -> History:
        """Change what the drive does before it reaches the tendon."""
        return history


class OnStretch(OnJoint):
    """The tendon's elongation by its tension."""

    stage: ClassVar[Stage] = "tendon"

    def stretch(self, stretch: FloatArray, tension: FloatArray, joint: Joint) -> FloatArray:
        """Change the tendon's elongation (m) at each tension (N); memoryless and increasing."""
        return stretch


class OnSlack(OnJoint):
    """Length that the tendon has gained by what its tension was."""

    stage: ClassVar[Stage] = "tendon"

    def slack(self, tension: FloatArray, history: History, joint: Joint) -> FloatArray:
        """Return tendon length (m) that the history of tension (N) has added by each row."""
        return np.zeros_like(tension)


class OnBranches(OnJoint):
    """Part of the tabulated branches of load and release; ``OnTransmission`` and ``OnStructure`` say which part."""

    @property
    def lumps(self) -> int:
        """Into how many parts that move by themselves the effect divides a segment of equal notches."""
        return 1

    @property
    def rounding(self) -> float:
        """Standard deviation of ln of the play's width along the path: ends of the wait are rounded by it."""
        return 0.0


class OnTransmission(OnBranches):
    """Friction between the actuator and the notches."""

    stage: ClassVar[Stage] = "transmission"

    def friction(self, direction: int, joint: Joint, bending_length: float) -> float:
        """Return the exponent added to ln(actuator tension / tension at the segment), load (+1) or release (-1)."""
        return 0.0

    def notch_friction(self) -> tuple[float, float]:
        """Return the coefficient by which tension decays with each notch's bend, and the share of its own bend in it."""
        return 0.0, 0.0


class OnStructure(OnBranches):
    """The moment by which the segment resists its bend."""

    stage: ClassVar[Stage] = "structure"

    def moment(self, moment: FloatArray, curvature: FloatArray, direction: int, segment: Segment) -> FloatArray:
        """Change the moment (N m) that holds each curvature (1/m), on load (+1) or release (-1)."""
        return moment

    def homing(self) -> float:
        """Return the share (0 to 1) of the rest shape's tendon path that the zero of the stroke already counts."""
        return 0.0


class OnDrift(OnJoint):
    """A slow change of the structure."""

    stage: ClassVar[Stage] = "structure"

    def drift(self, time: FloatArray) -> FloatArray | None:
        """Return how far (0 to 1) the change has come at each time (s), or None for none."""
        return None

    def drifted(self, share: float) -> tuple[float, float]:
        """Return the factor on stiffness and the curvature at rest (1/m) when the change has come so far."""
        return 1.0, 0.0


class OnDrag(OnJoint):
    """Tension that the motion of the segment takes."""

    stage: ClassVar[Stage] = "structure"

    def drag(self, motion: Motion) -> FloatArray:
        """Return the tension (N, at the actuator) that the motion of the segment takes, row by row."""
        return np.zeros_like(motion.tension)


class OnSettling(OnJoint):
    """A segment that comes late."""

    stage: ClassVar[Stage] = "structure"

    def settle(self, curvature: FloatArray, history: History, joint: Joint, rigidity: float, arm: float) -> FloatArray:
        """Let the segment's curvature (n, m) come late; ``rigidity`` in N m^2, ``arm`` the tendon's lever arm, m."""
        return curvature


class OnDevice(OnJoint):
    """What a device without tubes answers, between its drive and its sensor."""

    def carry(self, response: FloatArray, history: History) -> FloatArray:
        """Change the response (n,), SI, before the sensor reads it; ``history`` is the drive as it acts."""
        return response


class OnSensor(OnJoint):
    """The camera."""

    stage: ClassVar[Stage] = "sensor"

    def sense(self, response: FloatArray, history: History) -> FloatArray:
        """Change the response, shape (n, k), on its way through the camera; in the recording's SI unit."""
        return response


class OnLoadCell(OnJoint):
    """The load cell."""

    stage: ClassVar[Stage] = "sensor"

    def weigh(self, tension: FloatArray, history: History) -> FloatArray:
        """Change the tension (N) on its way through the load cell."""
        return tension
