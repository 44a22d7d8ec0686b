"""Time and memory of recordings: ``python tests/benchmarks/read_recordings.py`` reads and compares a million rows,
and calibrates 5 runs of 250 samples. Times are given beside ``numpy.loadtxt`` on the same file, in the same run.
"""

from __future__ import annotations

import resource
import tempfile
from pathlib import Path
from time import perf_counter

import numpy as np

from coast_cli.diagnosis.compare import compare
from coast_cli.diagnosis.joint.calibration import calibrate
from coast_cli.mechanics.joint import curvature_from_stroke
from coast_cli.recordings.read import read_recordings
from coast_cli.spec.build import build_joint
from coast_cli.spec.load import REFERENCE, load_config

HEADER = "run,time_s,outer,middle,bending_length_mm,stroke_mm,tension_n,curvature_per_m\n"


def write(path: Path, runs: int, samples: int, *, lengths: tuple[float, ...]) -> None:
    """Write runs of a sine drive through the paper's model, with white noise of 0.2 per m."""
    random = np.random.default_rng(0)
    joint = build_joint(load_config(REFERENCE), "OT4", "MT1")
    stroke = np.round(3.0 - 1.6 * np.cos(np.linspace(0.0, 6.0 * np.pi, samples)), 5)
    with path.open("w", encoding="utf-8") as stream:
        stream.write(HEADER)
        for run in range(runs):
            length = lengths[run % len(lengths)]
            curvature = curvature_from_stroke(joint, stroke * 1e-3, length * 1e-3).curvature
            seen = curvature + 0.2 * random.normal(size=samples)
            stream.writelines(
                f"r{run},{0.02 * index:.3f},OT4,MT1,{length:g},{x:.5f},{0.4 * x:.5f},{kappa:.5f}\n"
                for index, (x, kappa) in enumerate(zip(stroke, seen, strict=True))
            )


def main() -> None:
    config = load_config(REFERENCE)
    with tempfile.TemporaryDirectory() as folder:
        large, small = Path(folder) / "large.csv", Path(folder) / "small.csv"
        write(large, 200, 5000, lengths=(30.0,))
        write(small, 5, 250, lengths=(20.0, 25.0, 30.0, 35.0, 40.0))
        started = perf_counter()
        recordings = read_recordings([large], config)
        read = perf_counter() - started
        compare(config, recordings).rows()
        compared = perf_counter() - started
        megabytes = resource.getrusage(resource.RUSAGE_SELF).ru_maxrss / 1024.0
        started = perf_counter()
        np.loadtxt(large, delimiter=",", skiprows=1, usecols=(1, 4, 5, 6, 7))
        plain = perf_counter() - started
        runs = read_recordings([small], config)
        started = perf_counter()
        calibrate(config, runs)
        calibrated = perf_counter() - started
    print(
        f"a million rows: read in {read:.2f} s, read and compared in {compared:.2f} s, {megabytes:.0f} MB at the peak"
    )
    print(
        f"numpy.loadtxt of the five numeric columns alone: {plain:.2f} s; reading takes {read / plain:.1f} times that"
    )
    print(f"5 runs of 250 samples calibrated, with 7 refits of parts, in {calibrated:.2f} s")


if __name__ == "__main__":
    main()
