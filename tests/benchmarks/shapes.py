"""How often shapes are diagnosed right, on the concealed generator; prints figures, asserts nothing.

    python tests/benchmarks/shapes.py [--cases 20] [--clean 100] [--seed 1000]

Every effect is drawn over wide ranges, noise of the points from 8 to 200 micrometres, and shows by at least three noise
widths at the tip. The generator (examples/concealed) solves its beams by another method and imports nothing of coast_cli.
"""

from __future__ import annotations

import argparse
import sys
import tempfile
import time
from collections import Counter
from collections.abc import Iterator
from dataclasses import dataclass
from pathlib import Path

import numpy as np

ROOT = Path(__file__).resolve().parents[2]
sys.path.insert(0, str(ROOT))


@dataclass(frozen=True)
class Outcome:
    """One case: what was true, and the diagnosis with its seconds of processor time."""

    truth: dict
    config: object
    diagnosis: object
    seconds: float

    @property
    def named(self) -> list[str]:
        """Effects named, parameters after others."""
        return [effect.id for effect in self.diagnosis.effects]


def outcomes(level: str, effect: str | None, count: int, first: int) -> Iterator[Outcome]:
    """Draw cases and diagnose them, without their held-out photographs being named."""
    from coast_cli.diagnosis.shapes import diagnose_shapes
    from coast_cli.errors import BadInput
    from coast_cli.recordings.read import read_recordings
    from coast_cli.spec.load import load_config_text
    from examples.concealed.shape_case import make_shape_case

    seed = first
    drawn = 0
    while drawn < count:
        seed += 1
        try:
            case = make_shape_case(seed, level, effect)
        except RuntimeError:
            continue
        drawn += 1
        config = load_config_text(case.config_text, f"seed {seed}")
        with tempfile.TemporaryDirectory() as folder:
            paths = []
            for name, text in case.files.items():
                paths.append(Path(folder) / name)
                paths[-1].write_text(text, encoding="utf-8")
            runs = read_recordings(paths, config).shape.runs
        start = time.process_time()
        try:
            found = diagnose_shapes(config, runs)
        except BadInput as refusal:  # a picture so distorted that its points are no tube's
            print(f"  refused: {refusal}", file=sys.stderr)
            continue
        yield Outcome(case.truth, config, found, time.process_time() - start)


def wilson(good: int, count: int) -> str:
    """A share with its 95 % interval."""
    if not count:
        return "none"
    share, z = good / count, 1.96
    middle = (share + z**2 / 2 / count) / (1 + z**2 / count)
    half = z / (1 + z**2 / count) * float(np.sqrt(share * (1 - share) / count + z**2 / 4 / count**2))
    return f"{good}/{count} = {100 * share:.0f} % ({100 * (middle - half):.0f} to {100 * (middle + half):.0f})"


def main() -> None:
    """Run the cases and print the figures."""
    from examples.concealed.shape_case import SHAPE_EFFECTS, SHAPE_OUTSIDE, SHAPE_SENSOR

    parser = argparse.ArgumentParser(description=__doc__)
    parser.add_argument("--cases", type=int, default=20, help="of each effect")
    parser.add_argument("--clean", type=int, default=100)
    parser.add_argument(
        "--outside", type=int, default=0, help="of each artefact of the camera, and effect of no catalogue"
    )
    parser.add_argument("--seed", type=int, default=1000)
    options = parser.parse_args()
    clean = list(outcomes("L0", None, options.clean, options.seed))
    flagged = [case for case in clean if case.diagnosis.verdict not in ("agrees", "parameters")]
    which = [case.truth["seed"] for case in flagged]
    print(f"clean, flagged: {wilson(len(flagged), len(clean))} {which or ''}".rstrip(), flush=True)
    right = total = 0
    seconds = [case.seconds for case in clean]
    for effect in SHAPE_EFFECTS:
        cases = list(outcomes("L1", effect, options.cases, options.seed))
        first = [case for case in cases if case.named[:1] == [effect]]
        right, total = right + len(first), total + len(cases)
        seconds += [case.seconds for case in cases]
        missed = {
            case.truth["seed"]: " + ".join(case.named) or case.diagnosis.verdict for case in cases if case not in first
        }
        print(f"{effect}, named first: {wilson(len(first), len(cases))} {missed or ''}".rstrip(), flush=True)
        if effect == "local_stiffness_defect":
            print(f"  its place within a pitch: {wilson(sum(map(_placed, first)), len(first))}")
        if effect == "roll_misalignment":
            errors = [
                abs(_parameter(case, "angle_deg") - case.truth["effects"][0]["parameters"]["roll_deg"])
                for case in first
            ]
            print(f"  its angle within 2 degrees: {wilson(sum(error < 2.0 for error in errors), len(first))}")
    print(f"all effects, named first: {wilson(right, total)}")
    for effect in SHAPE_SENSOR if options.outside else ():
        cases = list(outcomes("L5", effect, options.outside, options.seed))
        said = Counter(" + ".join(case.named) or case.diagnosis.verdict for case in cases)
        print(f"sensor, {effect}: {dict(said)}", flush=True)
    for effect in SHAPE_OUTSIDE if options.outside else ():
        cases = list(outcomes("L6", effect, options.outside, options.seed))
        seconds += [case.seconds for case in cases]
        said = Counter(case.diagnosis.verdict for case in cases)
        print(
            f"outside the catalogue, {effect}: {dict(said)} {dict(Counter(' + '.join(c.named) for c in cases))}",
            flush=True,
        )
    print(f"processor seconds a case: mean {np.mean(seconds):.2f}, largest {np.max(seconds):.2f}")


def _parameter(case: Outcome, name: str) -> float:
    return case.diagnosis.effects[0].parameters[name].value


def _placed(case: Outcome) -> bool:
    """Whether the fitted place lies within one pitch of the true stretch."""
    low, high = (case.truth["where"][0][end] for end in ("low", "high"))
    pitch = (high - low) / case.truth["effects"][0]["parameters"]["pitches"]
    return low - pitch < _parameter(case, "arc_length_mm") < high + pitch


if __name__ == "__main__":
    main()
