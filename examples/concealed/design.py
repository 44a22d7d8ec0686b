"""Robots to record: random tubes and joints, the nominal configuration a user would write.

And the published base model.

Everything is SI. The base model is equations (9)-(12) of "Model-based Design of the COAST Guidewire Robot for Large
Deflection" (RA-L 2023) with the sector section of (1)-(2).
"""

from __future__ import annotations

from dataclasses import dataclass, field, replace

import numpy as np
from numpy.typing import NDArray

Array = NDArray[np.float64]


@dataclass(frozen=True)
class Tube:
    """One notched tube; lengths in m, natural curvature in 1/m."""

    name: str
    outer_diameter: float
    inner_diameter: float
    depth: float
    cut: float
    uncut: float
    count: int
    natural_curvature: float

    @property
    def pitch(self) -> float:
        """Length of one ring and one cut (m)."""
        return self.cut + self.uncut


def sector(tube: Tube, depth: float | None = None) -> tuple[float, float, float]:
    """Area (m^2), neutral axis (m) and second moment (m^4) of the strip left by a notch, equations (1)-(2)."""
    ro, ri = tube.outer_diameter / 2, tube.inner_diameter / 2
    phi = 2 * np.arccos(((tube.depth if depth is None else depth) - ro) / ro)
    area = phi / 2 * (ro**2 - ri**2)
    axis = 4 * np.sin(phi / 2) * (ro**3 - ri**3) / (3 * phi * (ro**2 - ri**2))
    moment = (ro**4 - ri**4) * (phi + np.sin(phi)) / 8 - area * axis**2
    return float(area), float(axis), float(moment)


def ring(tube: Tube) -> tuple[float, float]:
    """Area (m^2) and second moment (m^4) of the uncut tube."""
    ro, ri = tube.outer_diameter / 2, tube.inner_diameter / 2
    return float(np.pi * (ro**2 - ri**2)), float(np.pi / 4 * (ro**4 - ri**4))


def series_moment(tube: Tube, depth: float | None = None, extra_cut: float = 0.0) -> float:
    """Second moment of the series compliance over one pitch (m^4).

    `extra_cut` lengthens the cut without lengthening the pitch.
    """
    return tube.pitch / (tube.uncut / ring(tube)[1] + (tube.cut + extra_cut) / sector(tube, depth)[2])


@dataclass(frozen=True)
class Joint:
    """The stroke model's numbers for one pair (outer may be None); SI."""

    outer: Tube | None
    middle: Tube
    youngs_modulus: float
    pulley_friction: float
    wrap_angle: float
    notch_friction: float
    deadband: float
    tendon_radius: float
    tendon_modulus: float
    tendon_length: float

    @property
    def arm(self) -> float:
        """Moment arm dy (m)."""
        return sector(self.middle)[1] + self.middle.inner_diameter / 2 - self.tendon_radius

    @property
    def rigidity(self) -> float:
        """EI of the joint (N m^2)."""
        moment = series_moment(self.middle) + (series_moment(self.outer) if self.outer else 0.0)
        return self.youngs_modulus * moment

    @property
    def tendon_compliance(self) -> float:
        """Stretch per tension (m/N); a joint without a tendon does not stretch."""
        if self.tendon_radius == 0:
            return 0.0
        return self.tendon_length / (self.tendon_modulus * np.pi * self.tendon_radius**2)

    def gain(self, length: float | Array) -> Array:
        """Actuator tension over tension at the segment, e^(mu alpha) eta^Nf."""
        return np.exp(self.pulley_friction * self.wrap_angle) * self.notch_friction ** (
            np.asarray(length) / self.middle.pitch
        )

    def chord(self, curvature: Array, length: float | Array) -> Array:
        """Tendon shortening dL_kin (m) of a segment of uniform curvature."""
        return (
            chord_shortening(np.asarray(curvature) * self.middle.pitch, self.middle.cut, self.arm)
            * length
            / self.middle.pitch
        )

    def stroke(self, curvature: Array, length: float | Array) -> tuple[Array, Array]:
        """Stroke (m) and actuator tension (N) of the base model."""
        tension = self.gain(length) * self.rigidity * np.asarray(curvature) / self.arm
        return self.deadband + self.chord(curvature, length) + tension * self.tendon_compliance, tension

    def curvature(self, stroke: Array, length: float | Array) -> Array:
        """Curvature (1/m) at a stroke: Newton on the nearly straight base curve, slack below the deadband."""
        pull = np.maximum(np.asarray(stroke, float) - self.deadband, 0.0)
        stretch = self.gain(length) * self.rigidity / self.arm * self.tendon_compliance
        slope = stretch + self.arm * np.asarray(length)
        kappa = pull / slope
        for _ in range(4):
            kappa = kappa - (self.chord(kappa, length) + stretch * kappa - pull) / slope
        return kappa


def chord_shortening(theta: Array, cut: float, arm: float) -> Array:
    """Tendon shortening (m) across one cut bent by theta (rad)."""
    half = np.asarray(theta) / 2
    # np.sinc keeps the limit theta -> 0 exact: cut - 2 (cut/theta - arm) sin(theta/2).
    return cut * (1 - np.sinc(half / np.pi)) + 2 * arm * np.sin(half)


@dataclass(frozen=True)
class Robot:
    """A nominal design as its user knows it: tubes in stock, and one set of joint numbers."""

    outers: tuple[Tube, ...]
    middles: tuple[Tube, ...]
    joint: Joint
    inner_diameters: tuple[float, float]
    density: float = 6450.0
    calibration: dict[str, tuple[float, float]] = field(default_factory=dict)

    def pair(self, outer: int | None, middle: int) -> Joint:
        """Return the joint of one pair of tubes."""
        return replace(self.joint, outer=None if outer is None else self.outers[outer], middle=self.middles[middle])


def draw_robot(rng: np.random.Generator, *, wrist: bool = False) -> Robot:
    """Return a random robot: a COAST pair, or (wrist) one larger notched tube that is driven by tension."""
    if wrist:
        return _draw_wrist(rng)
    mm = 1e-3
    od = round(rng.uniform(0.32, 0.44), 2)
    wall = round(rng.uniform(0.03, 0.05), 3)
    out_id = round(od + rng.uniform(0.03, 0.06), 3)
    out_od = round(out_id + rng.uniform(0.08, 0.12), 3)
    cut, uncut = (round(float(rng.choice([0.2, 0.25, 0.3, 0.35, 0.4])), 3) for _ in range(2))
    count = int(np.ceil(48 / (cut + uncut))) + int(rng.integers(0, 30))

    def stock(prefix: str, diameter: float, inner: float, number: int, low: float, high: float) -> tuple[Tube, ...]:
        return tuple(
            Tube(
                f"{prefix}{i + 1}",
                diameter * mm,
                inner * mm,
                round(diameter * rng.uniform(low, high), 3) * mm,
                cut * mm,
                uncut * mm,
                count + (40 if prefix == "OT" else 0),
                round(rng.uniform(0.5, 8.0), 1),
            )
            for i in range(number)
        )

    outers = stock("OT", out_od, out_id, int(rng.integers(1, 5)), 0.62, 0.80)
    middles = stock("MT", od, round(od - 2 * wall, 3), int(rng.integers(1, 4)), 0.66, 0.80)
    joint = Joint(
        outers[0],
        middles[0],
        round(rng.uniform(36, 70), 1) * 1e9,
        round(rng.uniform(0.1, 0.38), 4),
        round(float(rng.choice([np.pi / 2, np.pi, np.pi, 1.25 * np.pi])), 6),
        round(rng.uniform(1.001, 1.009), 4),
        round(rng.uniform(0.0, 1.6), 2) * mm,
        round(rng.uniform(0.03, 0.05), 3) * mm,
        round(rng.uniform(45, 70), 2) * 1e9,
        round(rng.uniform(250, 450), 1) * mm,
    )
    inner_od = round(0.72 * (od - 2 * wall), 3)
    # The tendon runs through the inner tube.
    bore = round(max(0.6 * inner_od, joint.tendon_radius * 2e3 + 0.012), 3)
    return Robot(outers, middles, joint, (inner_od * mm, bore * mm), calibration=_calibration(rng, joint))


def _draw_wrist(rng: np.random.Generator) -> Robot:
    mm = 1e-3
    od = round(rng.uniform(0.9, 1.9), 2)
    ident = round(od * rng.uniform(0.82, 0.88), 2)
    cut, uncut = round(rng.uniform(0.6, 1.2), 1), round(rng.uniform(0.6, 1.4), 1)
    tube = Tube(
        "A",
        od * mm,
        ident * mm,
        round(od * rng.uniform(0.82, 0.9), 2) * mm,
        cut * mm,
        uncut * mm,
        int(rng.integers(4, 9)),
        0.0,
    )
    joint = Joint(None, tube, round(rng.uniform(35, 60), 1) * 1e9, 0.0, round(np.pi, 6), 1.0, 0.0, 0.0, 0.0, 0.0)
    return Robot((), (tube,), joint, (0.0, 0.0), calibration=_calibration(rng, joint))


def _calibration(rng: np.random.Generator, joint: Joint) -> dict[str, tuple[float, float]]:
    """Bounds that some users write beside a number, and others do not."""
    if rng.random() < 0.5:
        return {}
    bounds = {"youngs_modulus_gpa": (10.0, 160.0)}
    if joint.tendon_radius:
        bounds |= {"pulley_friction": (0.0, 1.0), "notch_friction": (1.0, 1.03), "deadband_mm": (0.0, 3.0)}
    return bounds


def _notch(tube: Tube) -> str:
    return f"notch = {{ cut_mm = {tube.cut * 1e3:.6g}, uncut_mm = {tube.uncut * 1e3:.6g}, count = {tube.count} }}"


def config_text(robot: Robot) -> str:
    """Return the nominal configuration as TOML, in the format of the reference `tubes.toml`."""
    joint = robot.joint

    def number(key: str, value: float) -> str:
        if key in robot.calibration:
            low, high = robot.calibration[key]
            return f"{key} = {{ value = {value:.10g}, min = {low:g}, max = {high:g} }}"
        return f"{key} = {value:.10g}"

    lines = [
        "version = 1",
        "",
        "[materials.nitinol]",
        f"youngs_modulus_gpa = {joint.youngs_modulus / 1e9:.10g}",
        f"density_kg_per_m3 = {robot.density}",
        "",
        "[environment]",
        "gravity_m_per_s2 = 9.81",
    ]
    for kind, tubes in (("outer", robot.outers), ("middle", robot.middles)):
        if not tubes:
            continue
        first = tubes[0]
        lines += [
            "",
            f"[{kind}]",
            'material = "nitinol"',
            f"outer_diameter_mm = {first.outer_diameter * 1e3:.6g}",
            f"inner_diameter_mm = {first.inner_diameter * 1e3:.6g}",
            _notch(first),
        ]
        for tube in tubes:
            lines += [
                "",
                f"[[{kind}.samples]]",
                f'name = "{tube.name}"',
                f"depth_mm = {tube.depth * 1e3:.6g}",
                f"natural_curvature_per_m = {tube.natural_curvature:.6g}",
            ]
            if (tube.cut, tube.uncut, tube.count) != (first.cut, first.uncut, first.count):
                lines.append(_notch(tube))
    if robot.inner_diameters[0]:
        lines += [
            "",
            "[inner]",
            "youngs_modulus_gpa = 200.0",
            f"outer_diameter_mm = {robot.inner_diameters[0] * 1e3:.6g}",
            f"inner_diameter_mm = {robot.inner_diameters[1] * 1e3:.6g}",
        ]
    if joint.tendon_radius:
        lines += [
            "",
            "[tendon]",
            f"radius_mm = {joint.tendon_radius * 1e3:.6g}",
            f"youngs_modulus_gpa = {joint.tendon_modulus / 1e9:.6g}",
            f"length_mm = {joint.tendon_length * 1e3:.6g}",
        ]
    lines += [
        "",
        "[joint]",
        number("youngs_modulus_gpa", joint.youngs_modulus / 1e9),
        number("pulley_friction", joint.pulley_friction),
        f"wrap_angle_rad = {joint.wrap_angle:.10g}",
        number("notch_friction", joint.notch_friction),
        number("deadband_mm", joint.deadband * 1e3),
    ]
    if robot.outers:
        lines.append(f'pair = "{robot.outers[0].name}/{robot.middles[0].name}"')
    return "\n".join(lines) + "\n"
