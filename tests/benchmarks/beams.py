"""Accuracy and speed of the beam and pair solvers, all in one run: ``python -m tests.benchmarks``.

Times are processor times, best of a few rounds, so that other work on the machine counts little; what runs on threads
is counted by processor time over the number of threads. No time is asserted anywhere.
"""

import resource
import sys
import time
from dataclasses import replace
from importlib.util import find_spec
from pathlib import Path

import numpy as np

from coast_cli.mechanics.beam import solve_beam, solve_segments, solve_tips
from coast_cli.mechanics.beam.step import segment_displacement, segment_tangent, segment_turn
from coast_cli.mechanics.section import full_section, notched_section
from coast_cli.mechanics.tube import NotchedTube

ROOT = Path(__file__).parents[2]
GRAVITY = 9.81
LENGTH = 0.1128
REFERENCE = {
    5.0: (0.087982123270705, -0.066789038374872),
    -5.0: (0.060216743875269, -0.086052930077382),
    -15.0: (0.030065655053199, -0.090728647097830),
}


def best(function, rounds: int) -> float:
    """Least processor time of a call, s."""
    times = []
    for _ in range(rounds):
        start = time.process_time()
        function()
        times.append(time.process_time() - start)
    return min(times)


def reference_tube(natural_curvature: float, count: int = 188) -> NotchedTube:
    one = np.ones(count)
    return NotchedTube(
        "reference", 0.2e-3, 0.165e-3, 0.35e-3 * one, 0.3e-3 * one, 0.3e-3 * one, 45e9, 6450.0, natural_curvature
    )


def tubes(count: int, *, deepest: float = 0.36e-3, curvature: float = 15.0, notches: int = 188):
    """Different tubes as arrays: outer radius, depth, modulus and natural curvature of each drawn at random."""
    rng = np.random.default_rng(7)
    ro = 0.2e-3 * rng.uniform(0.98, 1.02, count)
    ring, depth = full_section(ro, 0.825 * ro), rng.uniform(0.25e-3, deepest, count)
    notch = notched_section(ro, 0.825 * ro, depth * ro / 0.2e-3)
    modulus = rng.uniform(40e9, 50e9, count)
    rigidity = np.tile(modulus[:, None] * np.stack((ring.second_moment, notch.second_moment), axis=1), (1, notches))
    weight = np.tile(6450.0 * np.stack((ring.area, notch.area), axis=1), (1, notches))
    return np.full(2 * notches, 0.3e-3), rigidity, weight, rng.uniform(-curvature, curvature, count)[:, None]


def runge_kutta(tube: NotchedTube, moment: float) -> float:
    """One plain-Python RK4 march from the clamp, one step a piece: the moment it leaves at the tip."""
    from math import cos, sin

    pieces = tube.segments
    angle, x, y, shear = 0.0, 0.0, 0.0, float(pieces.weight @ pieces.length) * GRAVITY
    columns = (pieces.length.tolist(), pieces.rigidity.tolist(), (pieces.weight * GRAVITY).tolist())
    for h, rigidity, weight in zip(*columns, strict=True):

        def slope(angle, moment, shear, rigidity=rigidity):
            return tube.natural_curvature - moment / rigidity, -shear * cos(angle), cos(angle), sin(angle)

        a = slope(angle, moment, shear)
        b = slope(angle + h / 2 * a[0], moment + h / 2 * a[1], shear - weight * h / 2)
        c = slope(angle + h / 2 * b[0], moment + h / 2 * b[1], shear - weight * h / 2)
        d = slope(angle + h * c[0], moment + h * c[1], shear - weight * h)
        angle, moment, x, y = (
            value + h / 6 * (p + 2 * q + 2 * r + s)
            for value, p, q, r, s in zip((angle, moment, x, y), a, b, c, d, strict=True)
        )
        shear -= weight * h
    return moment


def shoot(tube: NotchedTube) -> int:
    """Secant shooting with RK4 from a guess; the number of marches."""
    guess, other = 8e-6, 9e-6
    at_guess, at_other = runge_kutta(tube, guess), runge_kutta(tube, other)
    marches = 2
    while abs(other - guess) > 1e-16 and marches < 40:
        guess, other = other, other - at_other * (other - guess) / (at_other - at_guess)
        at_guess, at_other = at_other, runge_kutta(tube, other)
        marches += 1
    return marches


def one_tube() -> tuple[float, float]:
    tube = reference_tube(5.0)
    tube.segments  # noqa: B018
    mine, theirs = best(lambda: solve_beam(tube, GRAVITY), 30), best(lambda: shoot(tube), 10)
    march = best(lambda: runge_kutta(tube, 8e-6), 10)
    print(f"one tube, automatic start                     {1e3 * mine:8.2f} ms")
    print(
        f"  plain-Python RK4 shooting, {shoot(tube)} marches of 376  {1e3 * theirs:8.2f} ms ({1e3 * march:.2f} ms a march)"
    )
    print(f"  one tube over RK4 shooting                  {mine / theirs:8.2f}")
    for curvature, (x, y) in REFERENCE.items():
        solution = solve_beam(reference_tube(curvature), GRAVITY)
        error = np.hypot(solution.x[-1] - x, solution.y[-1] - y) / LENGTH
        print(f"  tip error / length at k0 = {curvature:+5.0f} 1/m          {error:8.0e}")
    return mine, march


def against_opensees(mine: float) -> None:
    import csv

    with (ROOT / "tests" / "validation" / "data" / "opensees_beams.csv").open() as file:
        frozen = [row for row in csv.DictReader(file) if row["elements_per_piece"] == "1"]
    theirs, source = min(float(row["seconds"]) for row in frozen), "frozen with its data, not this run"
    if find_spec("openseespy"):
        sys.path.insert(0, str(ROOT / "examples" / "frames"))
        from opensees_beams import solve
        from reference_tubes import frame_model

        model = frame_model(-15.0, 1)
        theirs, source = best(lambda: solve(model, 10), 5), "this run"
    errors = [
        np.hypot(float(row["tip_x_m"]) - x, float(row["tip_y_m"]) - y) / LENGTH
        for row, (x, y) in zip(frozen, REFERENCE.values(), strict=True)
    ]
    print(f"OpenSees, one element a piece ({source}) {1e3 * theirs:8.1f} ms, {theirs / mine:.0f} times one tube")
    print(f"  its tip errors / length                     {min(errors):8.0e} to {max(errors):.0e}")


def batches(march: float) -> None:
    count = 10_000
    columns = tubes(count)
    gravity = (0.0, -GRAVITY)
    numpy_time = best(lambda: solve_segments(*columns, gravity=gravity), 4)
    shapes = solve_segments(*columns, gravity=gravity)
    sample = range(0, count, 250)
    alone = [solve_segments(columns[0], *(c[i] for c in columns[1:]), gravity=gravity) for i in sample]
    apart = max(
        np.hypot(shapes.x[i, -1] - a.x[0, -1], shapes.y[i, -1] - a.y[0, -1]) for i, a in zip(sample, alone, strict=True)
    )
    print(f"10,000 different tubes, numpy, one core       {count / numpy_time:8.0f} tubes/s")
    print(f"  tubes in the time of one RK4 march          {count * march / numpy_time:8.1f}")
    print(
        f"  unconverged {np.count_nonzero(~shapes.converged)}, against the scalar path / length {apart / LENGTH:8.0e}"
    )
    if find_spec("numba") is None:
        print("the same compiled: not here, the extra [fast] is not installed")
        return
    many = tubes(100_000)
    solve_tips(*many, gravity=gravity)
    one = best(lambda: solve_tips(*many, gravity=gravity), 4)
    two = best(lambda: solve_tips(*many, gravity=gravity, threads=2), 4) / 2.0
    tips = solve_tips(*columns, gravity=gravity)
    apart = np.max(np.hypot(tips.x - shapes.x[:, -1], tips.y - shapes.y[:, -1]))
    share = flops_of_a_tube() / one / peak() * many[1].shape[0]
    print(f"100,000 different tubes, [fast]               {1e5 / one:8.0f} tubes/s on one core, {1e5 / two:.0f} on two")
    print(f"  unconverged {np.count_nonzero(~tips.converged)}, against numpy / length           {apart / LENGTH:8.0e}")
    print(f"  tubes in the time of one RK4 march          {1e5 * march / one:8.0f}")
    print(f"  share of the measured floating-point peak   {share:8.0%}")


class _Counted:
    """A number that counts the operations done with it."""

    operations = 0

    def _count(self, *_):
        _Counted.operations += 1
        return self

    __add__ = __radd__ = __sub__ = __rsub__ = __mul__ = __rmul__ = __neg__ = _count


def flops_of_a_tube() -> int:
    """Additions and products of the two full marches over 376 pieces; the coarse start is not counted."""
    number = _Counted()
    _Counted.operations = 0
    *_, forces, series = segment_turn(*[number] * 9)
    turn = _Counted.operations
    segment_tangent(number, number, forces, series, number, number)
    segment_displacement(number, number, number, series)
    return 376 * (turn + _Counted.operations)


def peak() -> float:
    """Fused additions and products of one core, 1/s, counted as two."""
    import numba

    @numba.njit(error_model="numpy", fastmath={"contract", "nsz"})
    def chains(rounds, factor):
        values = np.ones(64)
        for _ in range(rounds):
            for j in range(64):
                values[j] = values[j] * factor + 0.1
        return values.sum()

    chains(1, 0.5)
    return 128.0 * 2_000_000 / best(lambda: chains(2_000_000, 0.5), 4)


def hard_set() -> None:
    count = 10_000
    columns = tubes(count, deepest=0.39e-3, curvature=20.0)
    start = time.process_time()
    found = solve_segments(*columns, gravity=(0.0, -GRAVITY))
    seconds = time.process_time() - start
    largest = np.degrees(np.max(np.abs(found.angle[:, -1])))
    print(f"hard set of 10,000: unconverged {np.count_nonzero(~found.converged)}, {count / seconds:.0f} tubes/s")
    print(f"  tips to {largest:.0f} degrees, {np.count_nonzero(found.equilibria > 1)} with other equilibria found")


def pairs(outer: int, middle: int) -> float:
    from coast_cli.mechanics.pairs import pair_table

    rng = np.random.default_rng(0)
    base = NotchedTube("t", 0.25e-3, 0.2e-3, np.ones(1), np.full(188, 3e-4), np.full(188, 3e-4), 45e9, 6450.0)
    outers = [
        replace(base, depth=np.full(188, depth), natural_curvature=curvature)
        for depth, curvature in zip(rng.uniform(0.3e-3, 0.4e-3, outer), rng.uniform(0.0, 6.0, outer), strict=True)
    ]
    inner = replace(base, outer_radius=0.18e-3, inner_radius=0.14e-3, cut=np.full(125, 3e-4), uncut=np.full(125, 3e-4))
    middles = [
        replace(inner, depth=np.full(125, depth), natural_curvature=curvature)
        for depth, curvature in zip(rng.uniform(0.22e-3, 0.29e-3, middle), rng.uniform(-10.0, 0.0, middle), strict=True)
    ]
    start = time.process_time()
    pair_table(outers, middles, GRAVITY)
    return time.process_time() - start


def scaling() -> None:
    def exponent(sizes, seconds):
        return np.polyfit(np.log(sizes), np.log(seconds), 1)[0]

    sides = (500, 1000, 2000)
    by_pairs = [pairs(n, n) for n in sides[:2]]
    memory = resource.getrusage(resource.RUSAGE_SELF).ru_maxrss / 1e6
    print(f"1,000 x 1,000 pairs, numpy                    {by_pairs[1]:8.2f} s")
    print(f"  most memory so far                          {memory:8.2f} GB")
    by_pairs.append(pairs(sides[2], sides[2]))
    gravity = (0.0, -GRAVITY)
    counts = (2000, 4000, 8000, 16000)
    drawn = [tubes(n) for n in counts]
    by_tubes = [best(lambda c=c: solve_segments(*c, gravity=gravity), 2) for c in drawn]
    notches = (100, 200, 400, 800)
    fixed = [(t[0] * 188 / n, *t[1:]) for n in notches for t in [tubes(2000, notches=n)]]
    by_notches = [best(lambda c=c: solve_segments(*c, gravity=gravity), 2) for c in fixed]
    print("cost grows with the power")
    for name, sizes, seconds in (
        ("tubes", counts, by_tubes),
        ("notches", notches, by_notches),
        ("pairs", np.square(sides), by_pairs),
    ):
        points = ", ".join(f"{n}: {s:.2f} s" for n, s in zip(sizes, seconds, strict=True))
        print(f"  {exponent(sizes, seconds):5.2f} of {name:8} ({points})")
    if find_spec("matplotlib") and len(sys.argv) > 1:
        plot(
            sys.argv[1],
            {"tubes": (counts, by_tubes), "notches": (notches, by_notches), "pairs": (np.square(sides), by_pairs)},
        )


def plot(path: str, curves) -> None:
    import matplotlib as mpl

    mpl.use("Agg")
    import matplotlib.pyplot as plt

    figure, axes = plt.subplots(figsize=(5, 4), layout="constrained")
    for name, (sizes, seconds) in curves.items():
        axes.loglog(sizes, seconds, "o-", label=name)
    axes.set(xlabel="number", ylabel="processor time (s)")
    axes.legend()
    figure.savefig(path)


def main() -> None:
    mine, march = one_tube()
    against_opensees(mine)
    scaling()
    batches(march)
    hard_set()
