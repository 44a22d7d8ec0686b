"""The tendon-driven joint: tendon stroke from curvature, curvature from stroke, and where the tip is.

Equations (9)-(12) of P, "Model-based Design of the COAST Guidewire Robot for Large Deflection" (RA-L 2023), with what P
omits decided as in each docstring. Valid for increasing stroke only; on release the real joint lags.
"""

from __future__ import annotations

from dataclasses import dataclass, replace
from functools import cached_property
from typing import Any, Protocol

import numpy as np
from numpy.typing import ArrayLike

from coast_cli.errors import BadInput
from coast_cli.mechanics.bending_law import Softening, softening_of
from coast_cli.mechanics.plausible import MODULUS, RADIUS, SEGMENT, WIRE, require, require_of_tubes
from coast_cli.mechanics.section import FloatArray
from coast_cli.mechanics.tube import NotchedTube
from coast_cli.mechanics.tubes import Tubes
from coast_cli.mechanics.uneven import Free, Part, parts
from coast_cli.mechanics.verdict import Verdict
from coast_cli.rows import short_repr

# Newton steps of the inverse; five are enough from the linear start, the rest is for hard corners.
_MOST_STEPS = 60


@dataclass(frozen=True, slots=True)
class Tendon:
    """The pull wire: radius (m), Young's modulus (Pa), undeformed length from actuator to tip (m)."""

    radius: float
    youngs_modulus: float
    length: float

    def __post_init__(self) -> None:
        """Refuse what is far outside physics.

        Raises:
            BadInput: naming the number.
        """
        require(RADIUS, radius=self.radius)
        require(MODULUS, youngs_modulus=self.youngs_modulus)
        require(WIRE, length=self.length)

    @property
    def stiffness(self) -> float:
        """Axial stiffness E pi r^2 / L, N/m."""
        return self.youngs_modulus * np.pi * self.radius**2 / self.length


@dataclass(frozen=True)
class Joint:
    """A bending segment: an outer and a middle tube, or one notched tube, pulled by one tendon.

    Attributes:
        outer: the outer tube, or None for a joint of one tube.
        middle: the tube whose inner wall holds the tendon.
        tendon: None where the drive is a tension (its radius then counts as zero, P's dy).
        youngs_modulus: of the joint model, Pa; P calibrates it apart from the gravity model's.
        pulley_friction: mu. wrap_angle: alpha, rad. notch_friction: eta, per notch.
        deadband: slack stroke before the tendon pulls, m.
        outer_cover: how far beyond the inner tube's tip the outer tube covers the middle one, m; None for everywhere.
    """

    __repr__ = short_repr

    outer: NotchedTube | None
    middle: NotchedTube
    tendon: Tendon | None
    youngs_modulus: float
    pulley_friction: float = 0.0
    wrap_angle: float = 0.0
    notch_friction: float = 1.0
    deadband: float = 0.0
    outer_cover: float | None = None

    def __post_init__(self) -> None:
        """Refuse what is far outside physics.

        Raises:
            BadInput: naming the number.
        """
        require(MODULUS, youngs_modulus=self.youngs_modulus)

    @cached_property
    def second_moment(self) -> float:
        """Series second moment of area of both tubes together, m^4 (decision: I_out,series + I_mid,series)."""
        tubes = (self.middle,) if self.outer is None else (self.outer, self.middle)
        return sum(tube.rigidity_series / tube.youngs_modulus for tube in tubes)

    @property
    def rigidity(self) -> float:
        """Flexural rigidity of the joint, N m^2."""
        return self.youngs_modulus * self.second_moment

    @cached_property
    def softening(self) -> Softening:
        """How superelastic tubes soften past their plateaus; nothing where all are linear."""
        if self.middle.superelastic is None and (self.outer is None or self.outer.superelastic is None):
            return Softening()
        return softening_of(None if self.outer is None else self.outer.row, self.middle.row, self.youngs_modulus)

    @cached_property
    def free(self) -> Free | None:
        """The middle tube beyond the outer tube's end; None where the outer tube covers the whole segment."""
        if self.outer is None or self.outer_cover is None:
            return None
        alone = replace(self, outer=None, outer_cover=None)
        return Free(self.outer_cover, alone.rigidity, alone.softening)

    @property
    def elastic(self) -> Joint:
        """The same joint of linear tubes: itself below every plateau."""
        outer = None if self.outer is None else replace(self.outer, superelastic=None)
        return replace(self, outer=outer, middle=replace(self.middle, superelastic=None))

    @cached_property
    def lever_arm(self) -> float:
        """Distance dy of the tendon from the middle tube's neutral axis, m: ybar + ri - r_t, averaged over notches."""
        radius = 0.0 if self.tendon is None else self.tendon.radius
        return np.mean(self.middle.notch.neutral_axis).item() + self.middle.inner_radius - radius

    @cached_property
    def cut(self) -> float:
        """Mean cut length of the middle tube, m."""
        return np.mean(self.middle.cut).item()

    @cached_property
    def pitch(self) -> float:
        """Mean pitch of the middle tube, m."""
        return np.mean(self.middle.pitch).item()

    @cached_property
    def closing_curvature(self) -> FloatArray:
        """Curvature at which each notch of the middle tube closes, or the first of the outer tube, 1/m, shape (n,)."""
        closing = self.middle.closing_curvature
        return closing if self.outer is None else np.minimum(closing, self.outer.closing_curvature.min())

    @property
    def closure_curvature(self) -> float:
        """Curvature at which the first notch's faces touch, 1/m."""
        return float(self.closing_curvature.min())


class DrivenSegment(Protocol):
    """What the joint model asks of a joint, or of many at once: numbers, or arrays of one shape."""

    @property
    def tendon(self) -> Tendon | None:
        """The pull wire, or None."""

    @property
    def pulley_friction(self) -> float:
        """Friction coefficient mu of the pulleys."""

    @property
    def wrap_angle(self) -> float:
        """Angle alpha around them, rad."""

    @property
    def notch_friction(self) -> float:
        """Factor eta on the tension, per notch."""

    @property
    def deadband(self) -> float:
        """Slack stroke, m."""

    @property
    def rigidity(self) -> Any:  # noqa: ANN401  # a number or an array, real or complex
        """Flexural rigidity, N m^2."""

    @property
    def softening(self) -> Softening:
        """How superelastic tubes soften past their plateaus."""

    @property
    def free(self) -> Free | None:
        """The middle tube where it bends alone, or None."""

    @property
    def lever_arm(self) -> Any:  # noqa: ANN401
        """Distance dy of the tendon from the neutral axis, m."""

    @property
    def cut(self) -> Any:  # noqa: ANN401
        """Mean cut length, m."""

    @property
    def pitch(self) -> Any:  # noqa: ANN401
        """Mean pitch, m."""


@dataclass(frozen=True, slots=True)
class Joints:
    """One joint with many pairs of tubes in turn; the last five have one entry a pair, as in ``Joint``."""

    tendon: Tendon | None
    pulley_friction: float
    wrap_angle: float
    notch_friction: float
    deadband: float
    rigidity: FloatArray
    lever_arm: FloatArray
    cut: FloatArray
    pitch: FloatArray
    softening: Softening

    @property
    def free(self) -> Free | None:
        """None: many pairs at once are covered by their outer tubes."""
        return None


def joints_of(joint: Joint, outer: Tubes, middle: Tubes) -> Joints:
    """Return a joint with its tubes replaced by those of many pairs, row by row."""
    second_moment = outer.rigidity_series / outer.youngs_modulus + middle.rigidity_series / middle.youngs_modulus
    radius = 0.0 if joint.tendon is None else joint.tendon.radius
    return Joints(
        tendon=joint.tendon,
        pulley_friction=joint.pulley_friction,
        wrap_angle=joint.wrap_angle,
        notch_friction=joint.notch_friction,
        deadband=joint.deadband,
        rigidity=joint.youngs_modulus * second_moment,
        lever_arm=np.mean(middle.notch.neutral_axis, axis=1) + middle.inner_radius - radius,
        cut=np.mean(middle.cut, axis=1),
        pitch=np.mean(middle.pitch, axis=1),
        softening=softening_of(outer, middle, joint.youngs_modulus),
    )


@dataclass(frozen=True, slots=True)
class StrokeSolution:
    """Answer of the joint model; arrays of the broadcast shape of curvature and bending length.

    Attributes:
        curvature: 1/m. stroke: tendon stroke X1, m. tension: at the actuator, N. tendon_strain: relative.
        verdict: whether the inverse converged everywhere; the direct problem always does.
    """

    __repr__ = short_repr

    curvature: FloatArray
    stroke: FloatArray
    tension: FloatArray
    tendon_strain: FloatArray
    verdict: Verdict


def tendon_shortening(joint: DrivenSegment, curvature: ArrayLike, bending_length: ArrayLike) -> FloatArray:
    """Return how far the bend alone pulls the tendon, m: its chord across each cut (P (9), decision on dL_kin).

    Nf [cut - 2 (1/kn - dy) sin(kn cut / 2)] with kn = kappa pitch / cut; kappa X2 dy for small bends.
    """
    count = np.asarray(bending_length, dtype=float) / joint.pitch
    total = np.zeros(())
    for share, bend, _ in segment_parts(joint, curvature, bending_length):
        half = bend * joint.pitch / 2.0
        each = joint.cut * (1.0 - np.sinc(half / np.pi)) + 2.0 * joint.lever_arm * np.sin(half)
        total = total + share * (count * each)
    return np.asarray(total)


def tension(joint: DrivenSegment, curvature: ArrayLike, bending_length: ArrayLike) -> FloatArray:
    """Return the tension at the actuator, N: e^(mu alpha) eta^(X2/pitch) EI kappa / dy (P (10)-(12)).

    EI kappa is the moment of linear tubes; past the plateau of a superelastic one it is less.
    """
    per_curvature = friction_gain(joint, bending_length) * joint.rigidity / joint.lever_arm
    return np.asarray(
        per_curvature * joint.softening.carried(segment_parts(joint, curvature, bending_length)[0].curvature)
    )


def stroke(joint: DrivenSegment, curvature: ArrayLike, bending_length: ArrayLike) -> StrokeSolution:
    """Return the tendon stroke that bends the segment to ``curvature`` (1/m, >= 0) at ``bending_length`` X2 (m).

    Raises:
        BadInput: the joint has no tendon, so a stroke has no meaning.

    Example:
        >>> joint = coast.build(coast.load_config(coast.REFERENCE)).joint()
        >>> coast.stroke(joint, [20.0, 40.0], 20e-3).stroke.round(7)
        array([0.0026001, 0.0040002])
    """
    tendon = _tendon(joint)
    require_of_tubes(joint, bending_length=bending_length)
    kappa, length = np.broadcast_arrays(np.asarray(curvature, dtype=float), np.asarray(bending_length, dtype=float))
    force = tension(joint, kappa, length)
    total = joint.deadband + tendon_shortening(joint, kappa, length) + force / tendon.stiffness
    strain = force / (tendon.stiffness * tendon.length)
    return StrokeSolution(kappa, total, force, strain, Verdict(converged=True))


def curvature_from_stroke(joint: DrivenSegment, stroke_length: ArrayLike, bending_length: ArrayLike) -> StrokeSolution:
    """Return the curvature that ``stroke_length`` X1 (m) reaches at ``bending_length`` X2 (m); zero within the deadband.

    Newton's method from the small-bend line, which lies below the root because the shortening is concave.

    Raises:
        BadInput: the joint has no tendon, so a stroke has no meaning.

    Example:
        >>> joint = coast.build(coast.load_config(coast.REFERENCE)).joint()
        >>> round(coast.curvature_from_stroke(joint, 2.6e-3, 20e-3).curvature.item(), 3)
        19.999
    """
    tendon = _tendon(joint)
    require_of_tubes(joint, stroke_length=stroke_length, bending_length=bending_length)
    drive, length = np.broadcast_arrays(np.asarray(stroke_length, dtype=float), np.asarray(bending_length, dtype=float))
    wanted = np.maximum(drive - joint.deadband, 0.0)
    stretch = friction_gain(joint, length) * joint.rigidity / joint.lever_arm / tendon.stiffness
    straight = segment_parts(joint, np.zeros_like(length), length)[0].rate
    kappa = wanted / (stretch * straight + length * joint.lever_arm)
    count = length / joint.pitch
    steps, error = 0, np.inf
    while steps < _MOST_STEPS:
        steps += 1
        each = segment_parts(joint, kappa, length)
        slope = stretch * joint.softening.slope(each[0].curvature) * each[0].rate
        for share, bend, rate in each:
            half = bend * joint.pitch / 2.0
            path = joint.lever_arm * np.cos(half) - joint.cut / 2.0 * _sinc_slope(half)
            slope = slope + share * rate * (count * joint.pitch * path)
        carried = joint.softening.carried(each[0].curvature)
        excess = tendon_shortening(joint, kappa, length) + stretch * carried - wanted
        change = excess / slope
        kappa = np.maximum(kappa - change, 0.0)
        error = float(np.max(np.abs(change) / (1.0 + kappa), initial=0.0))
        if error <= 1e-15 or not np.isfinite(error):
            break
    converged = bool(error <= 1e-12)
    message = "converged" if converged else "the stroke is past what this joint can bend to: give a smaller stroke"
    force = tension(joint, kappa, length)
    strain = force / (tendon.stiffness * tendon.length)
    return StrokeSolution(kappa, drive, force, strain, Verdict(converged, message, steps, error))


def tip(curvature: ArrayLike, bending_length: ArrayLike) -> tuple[FloatArray, FloatArray]:
    """Return the tip (x, y) of a segment of constant curvature, m: sin(k L)/k and (1 - cos(k L))/k, straight included.

    Args:
        curvature: k, 1/m. bending_length: L, m.

    Raises:
        BadInput: a bending length beyond 2 m.

    Example:
        >>> x, y = coast.tip(20.0, 30e-3)
        >>> round(x.item() * 1e3, 3), round(y.item() * 1e3, 3)
        (28.232, 8.733)
    """
    require(SEGMENT, bending_length=bending_length)
    kappa, length = np.broadcast_arrays(np.asarray(curvature, dtype=float), np.asarray(bending_length, dtype=float))
    bend = kappa * length
    along = length * np.sinc(bend / np.pi)
    across = length * np.sinc(bend / (2.0 * np.pi)) * np.sin(bend / 2.0)
    return np.asarray(along), np.asarray(across)


def segment_tip(joint: DrivenSegment, curvature: ArrayLike, bending_length: ArrayLike) -> tuple[FloatArray, FloatArray]:
    """Return the tip (x, y) of a joint at a mean curvature, m: one arc, or two where the outer tube ends on the way."""
    length = np.asarray(bending_length, dtype=float)
    x, y, angle = np.zeros(()), np.zeros(()), np.zeros(())
    for share, bend, _ in segment_parts(joint, curvature, length):
        along, across = tip(bend, share * length)
        x = x + np.cos(angle) * along - np.sin(angle) * across
        y = y + np.sin(angle) * along + np.cos(angle) * across
        angle = angle + bend * share * length
    return np.asarray(x), np.asarray(y)


def segment_parts(joint: DrivenSegment, curvature: ArrayLike, bending_length: ArrayLike) -> tuple[Part, ...]:
    """Return the parts of a segment of a mean curvature (1/m) from clamp to tip; one where it bends evenly."""
    kappa = np.asarray(curvature, dtype=float)
    if joint.free is None:
        return (Part(1.0, kappa, 1.0),)
    mean, length = np.broadcast_arrays(kappa, np.asarray(bending_length, dtype=float))
    return parts(joint.rigidity, joint.softening, joint.free, mean, length)


def friction_gain(joint: DrivenSegment, bending_length: ArrayLike) -> FloatArray:
    """Return the tension at the actuator over that at the segment, e^(mu alpha) eta^(X2/pitch) (P (10)-(11))."""
    notches = np.asarray(bending_length, dtype=float) / joint.pitch
    return np.asarray(np.exp(joint.pulley_friction * joint.wrap_angle) * joint.notch_friction**notches)


def _sinc_slope(half: FloatArray) -> FloatArray:
    """Return d/dz of sin(z)/z, by its series near zero where the closed form cancels."""
    small = np.abs(half) < 1e-3
    safe = np.where(small, 1.0, half)
    return np.where(small, -half / 3.0 + half**3 / 30.0, (safe * np.cos(safe) - np.sin(safe)) / safe**2)


def _tendon(joint: DrivenSegment) -> Tendon:
    if joint.tendon is None:
        raise BadInput(
            "a stroke needs a tendon", key="tendon", allowed="a [tendon] table with radius, modulus and length"
        )
    return joint.tendon
