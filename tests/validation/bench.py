"""Recordings with faults of the bench, drawn wide, and what is answered to them.

``python -m tests.validation.bench --seeds 0:300`` prints each answer that is not right, and what must not be: agreement said
of a recording of which a run, or what was kept back, lies above 1.5 noise widths. Faults are put into the rows by this module's
own arithmetic; the noise that was added is known row by row.
"""

from __future__ import annotations

import argparse
from collections import Counter
from dataclasses import dataclass, replace

import numpy as np

from coast_cli.diagnosis.answer import Diagnosis
from coast_cli.diagnosis.joint import diagnose_joint
from coast_cli.diagnosis.joint.problem import with_base
from coast_cli.effects.effect import History
from coast_cli.effects.forward import Layout, predict
from coast_cli.recordings.model import JointRun
from coast_cli.spec.build import build_joint
from tests.modelled_joint import CONFIG, TOP, coloured, make_run

MOST_WIDTHS = 1.5
LENGTHS = (0.022, 0.028, 0.035)
CAMERA = ("camera_saturation", "frozen_frames", "periodic_disturbance")
OF_A_RUN = ("gain", "offset", "zero", "bending_length_label", "lost_steps")
CELL = ("load_cell_scale", "load_cell_offset")
FAULTS = ("none", *OF_A_RUN, *CAMERA, *CELL)
NAMES = {"gain": "run_differs", "offset": "run_differs", "zero": "run_differs"}


@dataclass(frozen=True)
class Bench:
    """A recording: its runs, the fault and the run that has it, and the noise of each run, RMS in 1/m."""

    runs: tuple[JointRun, ...]
    fault: str
    run: str | None
    noise: tuple[float, ...]

    @property
    def name(self) -> str:
        """Id of the effect that is right; empty for none."""
        return "" if self.fault == "none" else NAMES.get(self.fault, self.fault)


def draw(seed: int, fault: str | None = None) -> Bench:
    """Return the recording of a seed; the seed also draws the fault where none is asked for."""
    rng = np.random.default_rng([77, seed])
    fault = fault or FAULTS[int(rng.integers(len(FAULTS)))]
    level, memory = float(np.exp(rng.uniform(np.log(0.05), np.log(0.4)))), float(rng.choice([0.0, 0.0, 0.5, 0.9]))
    lengths = [LENGTHS[place % 3] for place in range(int(rng.integers(5, 8)))]
    odd = int(rng.integers(len(lengths)))
    modulus = 42.6 * rng.uniform(0.9, 1.1) if fault not in CELL else 42.6
    joint = with_base(build_joint(CONFIG, "OT4", "MT1"), {"youngs_modulus_gpa": modulus})
    factor, period, phase = (
        1.0 + rng.choice((-1.0, 1.0)) * rng.uniform(0.12, 0.25),
        rng.uniform(2.0, 6.0),
        rng.uniform(0, 6),
    )
    swing, floor = level * rng.uniform(2.0, 8.0), rng.uniform(0.75, 0.92)
    soft = rng.uniform(0.0, 0.02)
    runs, noises = [], []
    for number, length in enumerate(lengths):
        count = int(rng.integers(70, 110))
        top = TOP * length / 0.035 * rng.uniform(0.9, 1.0) + 0.4e-3
        turn = rng.uniform(0.45, 0.6)
        stroke = np.interp(np.linspace(0, 1, count), [0.0, turn, 1.0], [0.0, top, rng.uniform(0.0, 0.3) * top])
        is_odd = number == odd
        true = _driven(rng, stroke, fault if is_odd else "none")
        mislabelled = is_odd and fault == "bending_length_label"
        real = length + (rng.choice((-1.0, 1.0)) * rng.uniform(3e-3, 6e-3) if mislabelled else 0.0)
        time = np.cumsum(rng.uniform(0.16, 0.24, count))
        time -= time[0]
        history = History(time, true, None, np.full(count, real))
        found = predict(joint, (), [history], Layout("curvature", 1, 160.0))[0]
        seen = found.response[:, 0]
        if fault == "periodic_disturbance":
            seen = seen + swing * np.sin(2 * np.pi * time / period + phase)
        if is_odd and fault == "gain":
            seen = seen * factor
        if is_odd and fault == "offset":
            seen = seen + 60.0 * level * (factor - 1.0)
        noise = coloured(rng, count, level, memory)
        if fault == "camera_saturation":
            end = floor * 34.0
            seen = (
                end - soft * end * np.logaddexp(0.0, (end - seen) / (soft * end)) if soft > 0 else np.minimum(seen, end)
            )
        seen = seen + noise
        if fault == "frozen_frames":
            for start in rng.integers(5, count - 10, int(rng.integers(2, 5))):
                seen[start : start + int(rng.integers(3, 9))] = seen[start]
        tension = None
        if fault in CELL:
            tension = found.tension * (factor if fault == "load_cell_scale" else 1.0)
            tension = tension + (0.4 * (factor - 1.0) if fault == "load_cell_offset" else 0.0)
            tension = tension + 0.005 * rng.standard_normal(count)
        run = make_run(stroke, seen, name=f"run_{number}", length=length, tension=tension)
        runs.append(replace(run, time=time))
        noises.append(max(level, float(np.sqrt(np.mean(noise**2)))))
    return Bench(tuple(runs), fault, f"run_{odd}" if fault in OF_A_RUN else None, tuple(noises))


def _driven(rng: np.random.Generator, stroke: np.ndarray, fault: str) -> np.ndarray:
    """Return the stroke (m) that the tendon really sees."""
    if fault == "zero":
        return stroke + rng.choice((-1.0, 1.0)) * rng.uniform(0.15e-3, 0.5e-3)
    if fault == "lost_steps":
        for at in np.sort(rng.uniform(0.25, 0.7, int(rng.integers(1, 4)))):
            stroke = stroke - rng.uniform(0.1e-3, 0.35e-3) * (np.arange(stroke.size) >= at * stroke.size)
    return stroke


def answered(bench: Bench) -> Diagnosis:
    """Return the diagnosis of a recording."""
    return diagnose_joint(CONFIG, bench.runs)


def widths(bench: Bench, answer: Diagnosis) -> float:
    """Return the largest error of a run, or of what was kept back, under the model that is answered, in noise widths."""
    worst = 0.0
    for curve, noise in zip(answer.curves, bench.noise, strict=True):
        left = curve.run.response - curve.corrected
        worst = max(worst, float(np.sqrt(np.nanmean(left**2))) / noise)
    kept = answer.comparison.refitted.held_out if answer.comparison is not None else None
    return max(worst, (kept or 0.0) / max(bench.noise))


def is_blind(bench: Bench, answer: Diagnosis) -> bool:
    """Return whether agreement is said of more than noise."""
    return answer.verdict in ("agrees", "parameters") and widths(bench, answer) > MOST_WIDTHS


def is_right(bench: Bench, answer: Diagnosis) -> bool:
    """Return whether the fault is named first, or nothing where there is none."""
    if not bench.name:
        return answer.verdict in ("agrees", "parameters")
    return [effect.id for effect in answer.effects][:1] == [bench.name]


def main() -> None:
    """Print what is not right, and the counts."""
    parser = argparse.ArgumentParser(description=__doc__)
    parser.add_argument("--seeds", default="0:300")
    parser.add_argument("--fault", choices=FAULTS)
    given = parser.parse_args()
    first, last = map(int, given.seeds.split(":"))
    counts: Counter[tuple[str, str]] = Counter()
    blind = 0
    for seed in range(first, last):
        bench = draw(seed, given.fault)
        answer = answered(bench)
        right, is_bad = is_right(bench, answer), is_blind(bench, answer)
        counts[bench.fault, "right" if right else answer.verdict] += 1
        blind += is_bad
        if not right or is_bad:
            said = ", ".join(effect.id for effect in answer.effects)
            mark = " BLIND" if is_bad else ""
            print(
                f"{seed} {bench.fault} {bench.run}: {answer.verdict} {said} {widths(bench, answer):.1f}{mark}",
                flush=True,
            )
    for (fault, what), count in sorted(counts.items()):
        print(f"{fault:22} {what:12} {count}")
    print(f"agreement said of more than {MOST_WIDTHS} noise widths: {blind} of {last - first}")


if __name__ == "__main__":
    main()
