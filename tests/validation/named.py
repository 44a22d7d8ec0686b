"""Recordings by the separate forward model of ``tests/independent_joint.py``, diagnosed: which effect is named?

``python -m tests.validation.named --seeds 0:50`` prints the table. Levels as in the contract's proof: L0 nothing left
out, L1 one effect in a recording that can show it, L2 an effect that the base parameters absorb, L5 a sensor's artefact
beside the physics it looks like, L6 something that is in no catalogue. The seed draws everything.
"""

from __future__ import annotations

import argparse
from collections import Counter
from collections.abc import Callable, Iterator
from dataclasses import dataclass, replace

import numpy as np

from coast_cli.diagnosis.answer import Diagnosis
from coast_cli.diagnosis.joint import diagnose_joint
from coast_cli.recordings.model import JointRun
from coast_cli.spec.config import Config
from coast_cli.spec.load import REFERENCE, load_config, load_config_text
from tests.independent_joint import Left, Truth, noise, simulate, stroke_for, sweep, wrist

COLOURS = ("white", "ar", "drift")
WRIST = """
version = 1
[materials.nitinol]
youngs_modulus_gpa = 40.0
density_kg_per_m3 = 6450.0
[middle]
material = "nitinol"
outer_diameter_mm = 1.62
inner_diameter_mm = 1.40
[[middle.samples]]
name = "A"
depth_mm = 1.40
notch = { cut_mm = 0.8, uncut_mm = 1.2, count = 5 }
[joint]
youngs_modulus_gpa = 40.0
pulley_friction = 0.0
notch_friction = 1.0
deadband_mm = 0.0
"""
Draw = Callable[[np.random.Generator, float, float], Left]


def _sign(g: np.random.Generator) -> float:
    return float(g.choice((-1.0, 1.0)))


# For each effect what it leaves out, given the largest curvature k (1/m) and tension f (N) of the recording.
DRAWS: dict[str, Draw] = {
    "capstan_hysteresis": lambda g, _k, _f: Left(release_ratio=g.uniform(0.6, 0.93)),
    "coulomb_friction": lambda g, k, _f: Left(friction_moment=3.2e-6 * k * g.uniform(0.03, 0.12)),
    "backlash": lambda g, _k, _f: Left(gap=g.uniform(0.05e-3, 0.4e-3)),
    "leadscrew_pitch_error": lambda g, _k, _f: Left(screw=(g.uniform(0.02e-3, 0.07e-3), g.uniform(0.0, 6.28))),
    "tendon_superelasticity": lambda g, _k, f: Left(wire_knee=(f * g.uniform(0.35, 0.7), g.uniform(0.5, 4.0))),
    "tendon_creep": lambda g, _k, _f: Left(creep=(g.uniform(0.08, 0.3), g.uniform(4.0, 20.0))),
    "tendon_permanent_set": lambda g, _k, f: Left(set_per_newton=(g.uniform(0.05e-3, 0.3e-3), f * g.uniform(0.0, 0.4))),
    "tube_superelasticity": lambda g, k, _f: Left(tube_knee=(k * g.uniform(0.35, 0.65), g.uniform(0.3, 0.7))),
    "snap_through": lambda g, k, _f: _snap(k, g.uniform(0.4, 0.7), g.uniform(0.5, 0.8), g.uniform(0.08, 0.2)),
    "precurvature": lambda g, _k, _f: Left(rest=_sign(g) * g.uniform(1.0, 6.0)),
    "tip_load": lambda g, _k, _f: Left(tip_force=_sign(g) * g.uniform(0.4e-3, 2e-3)),
    "bending_length_offset": lambda g, _k, _f: Left(length_error=_sign(g) * g.uniform(1e-3, 4e-3)),
    "thermal_drift": lambda g, _k, _f: Left(drift=(0.0, _sign(g) * g.uniform(2.0, 6.0), g.uniform(60.0, 600.0))),
    "sensor_lag": lambda g, _k, _f: Left(lag=g.uniform(1.0, 4.0)),
    "camera_scale": lambda g, _k, _f: Left(scale=1.0 + _sign(g) * g.uniform(0.05, 0.15)),
    "camera_offset": lambda g, _k, _f: Left(offset=_sign(g) * g.uniform(0.8, 4.0)),
    "gravity": lambda g, _k, _f: Left(tilt=_sign(g) * g.uniform(0.5, 1.0)),
    "chord_section": lambda _g, _k, _f: Left(flat=True),
    "notch_end_effect": lambda g, _k, _f: Left(end_share=g.uniform(0.7, 1.3)),
    "distributed_notch_friction": lambda _g, _k, _f: Left(),
}
# A camera's scale is a stiffness to every recording of curvature alone: level L2 holds it.
SHOWN = tuple(effect for effect in DRAWS if effect != "camera_scale")
PAIRED = ("chord_section", "notch_end_effect")
UNKNOWN: dict[str, Draw] = {
    "ripple along the stroke": lambda g, _k, _f: Left(ripple=(g.uniform(1.0, 3.0), g.uniform(0.9e-3, 1.4e-3))),
    "bump at a stroke": lambda g, _k, _f: Left(
        bump=(_sign(g) * g.uniform(2.0, 5.0), g.uniform(2.0e-3, 2.8e-3), g.uniform(0.08e-3, 0.2e-3))
    ),
}


def _snap(k: float, at: float, back: float, jump: float) -> Left:
    held = 3.2e-6 * k * at
    return Left(snap=(held, held * back, k * jump))


@dataclass(frozen=True)
class Case:
    """A recording and what its maker left out: an effect's id, or an empty text."""

    config: Config
    runs: tuple[JointRun, ...]
    truth: str
    colour: str


def recorded(name, pair, length, clock, stroke, response, tension, kind="curvature") -> JointRun:
    """Return a run as the reader would."""
    outer, middle = pair
    rows = np.arange(len(stroke) if stroke is not None else len(tension))
    response = response if response.ndim == 2 else response[:, np.newaxis]
    return JointRun(
        name, f"{name}.csv", rows + 2, clock, outer, middle, np.full(rows.size, length), stroke, tension, response, kind
    )


def make(effect: str, seed: int, *, level: str = "L1", left: Left | None = None) -> Case:
    """Return the recording of one effect; ``left`` overrides what is drawn."""
    rng = np.random.default_rng([*map(ord, effect + level), seed])
    colour = COLOURS[seed % 3]
    if effect == "distributed_notch_friction":
        return _wrist(rng, colour)
    config = load_config(REFERENCE)
    truth = Truth(modulus=42.6e9 * rng.uniform(0.88, 1.14), deadband=1.2e-3 + rng.uniform(-0.15e-3, 0.15e-3))
    top_curvature = rng.uniform(24.0, 38.0)
    force = 1.7 * top_curvature / 35.0
    if left is None:
        left = (DRAWS | UNKNOWN)[effect](rng, top_curvature, force)
    truth = replace(truth, left=left)
    sigma = rng.uniform(0.06, 0.2) * (0.4 if effect == "gravity" else 1.0)  # the weight is faint
    pairs = [("OT1", "MT1"), ("OT4", "MT1"), ("OT4", "MT3"), ("OT1", "MT3")] if effect in PAIRED else [("OT4", "MT1")]
    lengths, rates = [0.035, 0.02, 0.035], [0.2e-3, 0.2e-3, 0.04e-3]
    if effect in PAIRED:
        lengths, rates = [0.035, 0.02, 0.028, 0.035], [0.2e-3] * 4
    if effect == "bending_length_offset":
        lengths, rates = [0.035, 0.02, 0.012, 0.035], [0.2e-3] * 4
    if level == "L2":
        lengths, rates = [0.03], [0.2e-3]
    with_tension = level == "L1"
    runs, earlier, started = [], 0.0, 0.0
    for number, length in enumerate(lengths):
        pair = pairs[number % len(pairs)]
        top = stroke_for(top_curvature, length, replace(truth, left=Left()), *pair)
        clock, stroke = sweep(top, rates[number], top / (90 if effect == "leadscrew_pitch_error" else 34), 6.0)
        clock = clock + started
        started = clock[-1] + 20.0
        if level == "L2":
            keep = int(np.argmax(stroke)) + 1
            clock, stroke = clock[:keep], stroke[:keep]
        seen, tension, earlier = simulate(truth, *pair, length, clock, stroke, earlier)
        kind, width = ("bend", length + left.length_error) if effect == "bending_length_offset" else ("curvature", 1.0)
        seen = seen * width + noise(rng, seen.size, sigma * (0.025 if kind == "bend" else 1.0), colour)
        witness = tension + 0.004 * force * rng.standard_normal(tension.size) if with_tension else None
        runs.append(recorded(f"run_{number}", pair, length, clock, stroke, seen, witness, kind))
    return Case(config, tuple(runs), effect if left != Left() else "", colour)


def _wrist(rng: np.random.Generator, colour: str) -> Case:
    config = load_config_text(WRIST, "wrist.toml")
    friction, modulus = rng.uniform(0.15, 0.6), 40e9 * rng.uniform(0.8, 1.2)
    runs = []
    for number in range(3):
        top = rng.uniform(1.5, 2.2)
        tension = np.concatenate([np.linspace(0.0, top, 30), np.linspace(top, 0.0, 30)])
        bent = wrist(friction, tension, modulus=modulus)
        level = 0.01 * bent.max()
        spread = np.stack([noise(rng, tension.size, level, colour) for _ in range(bent.shape[1])], axis=1)
        runs.append(recorded(f"run_{number}", (None, "A"), 0.01, None, None, bent + spread, tension, "notch"))
    return Case(config, tuple(runs), "distributed_notch_friction", colour)


def clean(seed: int, colour: str) -> Case:
    """Return a recording in which nothing is left out, its base parameters off by what a calibration leaves."""
    return make("clean", 3 * seed + COLOURS.index(colour), left=Left())


def diagnosed(case: Case) -> Diagnosis:
    """Return the tool's answer, as by default but for sets of at most two effects."""
    return diagnose_joint(case.config, case.runs, most_effects=2)


def outcome(case: Case, answer: Diagnosis) -> str:
    """Say how the answer stands to the truth: first, second, group, closest, insufficient, unexplained, none or wrong.

    ``closest``: the name is told as what came nearest, and its form left more than the noise allows for it to be given.
    """
    names = [effect.id for effect in answer.effects]
    if answer.verdict in ("agrees", "parameters"):
        return "none"
    if answer.verdict in ("insufficient", "unexplained", "unnamed"):
        kind = "insufficient" if answer.verdict == "insufficient" else "unexplained"
        return "closest" if answer.attempts[:1] == (case.truth,) else kind
    if names[0] == case.truth:
        return "first"
    if case.truth in names:
        return "second"
    if any(case.truth in other for other in answer.alternatives):
        return "group"
    return "wrong"


def wilson(hits: int, count: int) -> tuple[float, float]:
    """Return the 95 % interval of a share (Wilson, J. Am. Stat. Assoc. 22 (1927) 209)."""
    if count == 0:
        return 0.0, 1.0
    z, share = 1.959964, hits / count
    middle, spread = share + z * z / (2 * count), z * np.sqrt(share * (1 - share) / count + z * z / (4 * count**2))
    return (middle - spread) / (1 + z * z / count), (middle + spread) / (1 + z * z / count)


FAMILIES = {
    "friction and play": ("capstan_hysteresis", "coulomb_friction", "backlash", "distributed_notch_friction"),
    "actuator and tendon": (
        "leadscrew_pitch_error",
        "tendon_superelasticity",
        "tendon_creep",
        "tendon_permanent_set",
        "bending_length_offset",
    ),
    "structure": ("tube_superelasticity", "snap_through", "chord_section", "notch_end_effect"),
    "at rest": ("precurvature", "tip_load", "gravity"),
    "camera and clock": ("sensor_lag", "camera_offset", "thermal_drift"),
}
L2 = ("capstan_hysteresis", "coulomb_friction", "tendon_superelasticity", "bending_length_offset", "camera_scale")
L5 = ("sensor_lag", "capstan_hysteresis", "camera_offset", "tendon_permanent_set", "thermal_drift", "tendon_creep")


def rows(seeds: range, levels: str = "L0 L1 L2 L5 L6") -> Iterator[tuple[str, str, Counter[str]]]:
    """Yield level, subject and how often each outcome was met."""
    if "L0" in levels:
        for colour in COLOURS:
            yield (
                "L0",
                colour,
                Counter(
                    "right" if (v := diagnosed(clean(seed, colour)).verdict) in ("agrees", "parameters") else v
                    for seed in seeds
                ),
            )
    for level, subjects in (("L1", SHOWN), ("L2", L2), ("L5", L5), ("L6", tuple(UNKNOWN))):
        if level not in levels:
            continue
        for effect in subjects:
            cases = (make(effect, seed, level=level) for seed in seeds)
            yield level, effect, Counter(outcome(case, diagnosed(case)) for case in cases)


def main() -> None:
    """Print the table."""
    parser = argparse.ArgumentParser(description=__doc__)
    parser.add_argument("--seeds", default="0:50", help="first:last, the last not included")
    parser.add_argument("--levels", default="L0 L1 L2 L5 L6")
    options = parser.parse_args()
    first, last = map(int, options.seeds.split(":"))
    total: dict[str, Counter[str]] = {}
    for level, subject, counts in rows(range(first, last), options.levels):
        total[level] = total.get(level, Counter()) + counts
        print(_line(level, subject, counts), flush=True)
    for level, counts in total.items():
        print(_line(level, "all", counts))


def _line(level: str, subject: str, counts: Counter[str]) -> str:
    count = sum(counts.values())
    wanted = {
        "L0": ("right",),
        "L1": ("first",),
        "L2": ("first", "none", "group"),
        "L5": ("first",),
        "L6": ("unexplained",),
    }
    hits = sum(counts[name] for name in wanted[level])
    low, high = wilson(hits, count)
    told = ", ".join(f"{name} {number}" for name, number in counts.most_common())
    return f"{level}  {subject:<36} {hits:>4}/{count:<4} {100 * low:5.1f} to {100 * high:5.1f} %   {told}"


if __name__ == "__main__":
    main()
