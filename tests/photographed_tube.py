"""Shapes of tubes notch by notch, independent of the forward model that is fitted: nothing of coast_cli takes part."""

from __future__ import annotations

import math
from collections.abc import Callable
from dataclasses import dataclass
from functools import cache

import numpy as np
from scipy.integrate import trapezoid
from scipy.interpolate import CubicSpline
from scipy.optimize import brentq

RO, RI, CUT, UNCUT, DENSITY, GRAVITY = 0.2e-3, 0.165e-3, 0.3e-3, 0.3e-3, 6450.0, 9.81
COUNT = 120
LENGTH = COUNT * (CUT + UNCUT)
STEPS = 2  # of a ring or a cut
SOFT_WIDTH = 0.3e-3
WAVES = 3.3
CONFIG = """
version = 1
[materials.nitinol]
youngs_modulus_gpa = 45.0
density_kg_per_m3 = 6450.0
[outer]
material = "nitinol"
outer_diameter_mm = 0.4
inner_diameter_mm = 0.33
notch = {{ cut_mm = 0.3, uncut_mm = 0.3, count = {count} }}
{samples}
"""
SAMPLE = '[[outer.samples]]\nname = "{name}"\ndepth_mm = {depth}\nnatural_curvature_per_m = {natural}\n'


def config_text(tubes: dict[str, tuple[float, float]]) -> str:
    """A configuration of tubes: name -> (depth in mm, natural curvature in 1/m)."""
    samples = "".join(SAMPLE.format(name=n, depth=d, natural=k) for n, (d, k) in tubes.items())
    return CONFIG.format(count=COUNT, samples=samples)


def sector(depth: float) -> tuple[float, float]:
    """Area and second moment of what a notch leaves, by quadrature over the ring's angle."""
    half = np.arccos((depth - RO) / RO)
    angle = np.linspace(-half, half, 20001)
    area = trapezoid(np.full_like(angle, (RO**2 - RI**2) / 2.0), angle)
    first = trapezoid((RO**3 - RI**3) / 3.0 * np.cos(angle), angle)
    second = trapezoid((RO**4 - RI**4) / 4.0 * np.cos(angle) ** 2, angle)
    return float(area), float(second - first**2 / area)


@dataclass(frozen=True)
class Bench:
    """What the bench does besides what the model knows; SI."""

    depth: float = 0.314e-3
    natural: float = 4.0
    modulus: float = 45e9
    tilt: float = 0.0
    tip_force: float = 0.0
    gradient: float = 0.0
    soft_at: float | None = None
    soft_angle_per_moment: float = 0.0
    extra_cut: float = 0.0
    growth: float = 0.0  # of the natural curvature along the tube, as a share of it
    wave: float = 0.0  # 1/m, over 3.3 waves
    kink_at: float | None = None
    kink_angle: float = 0.0
    clip_at: float | None = None
    clip_mass: float = 0.0


def _spot(off: float) -> float:
    """A narrow bell, 1/m, whose integral is one."""
    return math.exp(-0.5 * (off / SOFT_WIDTH) ** 2) / SOFT_WIDTH / math.sqrt(2.0 * math.pi)


@cache
def shape(bench: Bench, up: bool, points: int = 120) -> tuple[np.ndarray, np.ndarray]:
    """Places (m) of points from clamp to tip: Runge and Kutta's fourth order, shooting with the clamp's moment."""
    area, second = sector(bench.depth)
    ring_area, ring_second = np.pi * (RO**2 - RI**2), np.pi / 4.0 * (RO**4 - RI**4)
    soft = (CUT + bench.extra_cut) / CUT / second / bench.modulus
    stiff = 1.0 / (ring_second * bench.modulus)
    light, heavy = DENSITY * GRAVITY * area, DENSITY * GRAVITY * ring_area
    steps = [
        (length / STEPS, compliance, weight)
        for _ in range(COUNT)
        for length, compliance, weight in ((UNCUT, stiff, heavy), (CUT, soft, light))
        for _ in range(STEPS)
    ]
    side = 1.0 if up else -1.0
    total = COUNT * (UNCUT * heavy + CUT * light)
    clip = bench.clip_mass * GRAVITY
    clip_at = LENGTH if bench.clip_at is None else bench.clip_at

    def beyond_clip(s: float) -> float:
        return 0.5 * clip * math.erfc((s - clip_at) / SOFT_WIDTH / math.sqrt(2.0))

    def added(s: float) -> float:
        if bench.soft_at is None:
            return 0.0
        return bench.soft_angle_per_moment * _spot(s - bench.soft_at)

    def slope(
        s: float, compliance: float, beyond: float, angle: float, moment: float
    ) -> tuple[float, float, float, float]:
        own = bench.natural * (1.0 + bench.growth * (s / LENGTH - 0.5)) + bench.gradient * (s - LENGTH / 2.0)
        own += bench.wave * math.sin(WAVES * 2.0 * math.pi * s / LENGTH)
        if bench.kink_at is not None:
            own += bench.kink_angle * _spot(s - bench.kink_at)
        natural = side * own
        curvature = natural - (compliance + added(s)) * moment
        return curvature, -(beyond + beyond_clip(s)) * math.cos(angle), math.cos(angle), math.sin(angle)

    def march(moment: float) -> list[tuple[float, float, float, float, float]]:
        s, angle, x, y, beyond = 0.0, bench.tilt, 0.0, 0.0, total + bench.tip_force
        line = [(s, angle, moment, x, y)]
        for h, compliance, weight in steps:
            half = beyond - weight * h / 2
            one = slope(s, compliance, beyond, angle, moment)
            two = slope(s + h / 2, compliance, half, angle + h / 2 * one[0], moment + h / 2 * one[1])
            three = slope(s + h / 2, compliance, half, angle + h / 2 * two[0], moment + h / 2 * two[1])
            four = slope(s + h, compliance, beyond - weight * h, angle + h * three[0], moment + h * three[1])
            angle, moment, x, y = (
                value + h / 6 * (a + 2 * b + 2 * c + d)
                for value, a, b, c, d in zip((angle, moment, x, y), one, two, three, four, strict=True)
            )
            s, beyond = s + h, beyond - weight * h
            line.append((s, angle, moment, x, y))
        return line

    most = total * LENGTH / 2.0 + (bench.tip_force + clip) * LENGTH
    clamped = brentq(lambda moment: march(moment)[-1][2], -most, 2.0 * most, xtol=1e-15, rtol=1e-13)
    s, _, _, x, y = np.array(march(clamped)).T
    at = np.linspace(0.0, LENGTH, points)
    return CubicSpline(s, x)(at), CubicSpline(s, y)(at)


def csv_text(
    photographs: list[tuple[str, Bench, bool]],
    noise: float,
    seed: int = 1,
    seen: Callable[[np.ndarray, np.ndarray], tuple[np.ndarray, np.ndarray]] = lambda x, y: (x, y),
) -> str:
    """A shapes file: (tube, bench, natural side up), points with white noise (m)."""
    random = np.random.default_rng(seed)
    lines = ["run,tube,natural,x_mm,y_mm"]
    for number, (tube, bench, up) in enumerate(photographs):
        x, y = seen(*shape(bench, up))
        for px, py in zip(x, y, strict=True):
            a, b = 1e3 * (px + noise * random.standard_normal()), 1e3 * (py + noise * random.standard_normal())
            first = px == 0.0 and py == 0.0
            lines.append(
                f"s{number},{tube},{'up' if up else 'down'},{0.0 if first else a:.5f},{0.0 if first else b:.5f}"
            )
    return "\n".join(lines) + "\n"
