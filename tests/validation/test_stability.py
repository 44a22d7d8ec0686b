"""The same answer on any processor: neither last bits of a recording nor other instruction sets change what is printed.

    PYTHONPATH=. nice python tests/validation/test_stability.py --times 20

does at length what the tests do in short, and prints a table: a row for each recording, generated or real.
"""

import argparse
import json
import os
import subprocess
import sys
from dataclasses import replace
from pathlib import Path
from tempfile import TemporaryDirectory

import numpy as np
import pytest

from coast_cli.diagnosis.joint import diagnose_joint
from coast_cli.diagnosis.shapes import diagnose_shapes
from coast_cli.effects.library.backlash import Backlash
from coast_cli.effects.library.tendon_superelasticity import TendonSuperelasticity
from coast_cli.recordings.model import JointRun
from coast_cli.recordings.read import read_recordings
from coast_cli.spec.load import load_config, load_config_text
from tests.modelled_joint import CONFIG, recording

ROOT = Path(__file__).parents[2]
WRIST = ROOT.parent / "shared" / "recordings" / "notched_wrist"
EFFECTS = (TendonSuperelasticity(knee_n=0.9, extra_compliance=3.0, knee_width=0.05), Backlash(width_mm=0.15))


def printed(found):
    """Return what an answer shows: verdict, names, regions and numbers to the digits that are printed."""
    numbers = {name: value.value for name, value in found.parameters.items()}
    numbers |= {f"{e.id}.{name}": value.value for e in found.effects for name, value in e.parameters.items()}
    regions = [
        [r.axis, r.value, *(None if x is None else f"{x:.4g}" for x in (r.low, r.high, r.share))] for r in found.where
    ]
    return {
        "verdict": found.verdict,
        "effects": [effect.id for effect in found.effects],
        "alternatives": [list(ids) for ids in found.alternatives],
        "where": regions,
        "numbers": {name: f"{value:.4g}" for name, value in numbers.items()},
    }


def shaken(values, rng):
    """Return values (n, k) with their last bits changed at random."""
    return np.where(rng.random(values.shape) < 0.5, np.nextafter(values, np.inf), np.nextafter(values, -np.inf))


def generated():
    return CONFIG, recording(EFFECTS, noise=0.1, witness=True)


def readme():
    config = load_config(ROOT / "configs" / "tubes.toml")
    return config, read_recordings([ROOT / "examples" / "diagnose" / "recording.csv"], config).joint.runs


def wrist(name="A"):
    config = load_config(WRIST / "tubes.toml")
    return config, read_recordings([WRIST / f"wrist_{name}.csv"], config).joint.runs


def tip_load():
    """Return photographs of a tube with a load at its tip."""
    from examples.concealed.shape_case import make_shape_case

    case = make_shape_case(71002, "L1", "tip_load")
    config = load_config_text(case.config_text, "case")
    with TemporaryDirectory() as folder:
        paths = [Path(folder) / name for name in case.files]
        for path, text in zip(paths, case.files.values(), strict=True):
            path.write_text(text, encoding="utf-8")
        return config, read_recordings(paths, config).shape.runs


def diagnosed(config, runs, rng=None):
    """Return what is printed of a diagnosis, with last bits changed where random numbers are given."""
    if isinstance(runs[0], JointRun):
        if rng is not None:
            runs = [replace(run, response=shaken(run.response, rng)) for run in runs]
        return printed(diagnose_joint(config, runs))
    if rng is not None:
        runs = [replace(run, x=shaken(run.x, rng), y=shaken(run.y, rng)) for run in runs]
    return printed(diagnose_shapes(config, runs))


def is_unchanged(recorded, times):
    expected = diagnosed(*recorded)
    return [diagnosed(*recorded, np.random.default_rng(seed)) == expected for seed in range(times)]


def test_last_bits_of_a_recording_change_nothing():
    assert diagnosed(*generated())["verdict"] not in ("agrees", "parameters")
    assert all(is_unchanged(generated(), 3))


@pytest.mark.skipif(not WRIST.is_dir(), reason="not here")
def test_last_bits_of_a_real_recording_change_nothing():
    assert all(is_unchanged(wrist(), 2))


def test_last_bits_of_shapes_change_nothing():
    assert all(is_unchanged(tip_load(), 1))


SCRIPT = """
import json
from tests.validation.test_stability import {source}, diagnosed
print(json.dumps(diagnosed(*{source}())))
"""


def other_processor(source, settings):
    """Return what a diagnosis says in a process of its own, on a processor that lacks what the settings name."""
    return json.loads(on_other_processor(settings, "-c", SCRIPT.format(source=source)))


def on_other_processor(settings, *words):
    """Return what Python prints with the given words on a processor that lacks what the settings name."""
    own = {"OPENBLAS_NUM_THREADS": "1", "PYTHONPATH": str(ROOT), "PYTHONIOENCODING": "utf-8"}
    command, environment = [sys.executable, "-W", "ignore", *words], {**os.environ, **own, **settings}
    done = subprocess.run(command, cwd=ROOT, env=environment, capture_output=True, encoding="utf-8", check=True)
    return done.stdout


def other_instruction_sets():
    """Return the settings of processors that this one can stand for: without vectors, and with those of ten years ago."""
    try:
        from numpy._core import _multiarray_umath as core
    except ImportError:
        from numpy.core import _multiarray_umath as core
    extra = [name for name in core.__cpu_dispatch__ if core.__cpu_features__.get(name)]
    without = {"NPY_DISABLE_CPU_FEATURES": " ".join(extra)} if extra else {}
    has_avx2 = core.__cpu_features__.get("AVX2") and core.__cpu_features__.get("FMA3")
    return [{"OPENBLAS_CORETYPE": "Prescott", **without}, *([{"OPENBLAS_CORETYPE": "Haswell"}] if has_avx2 else [])]


@pytest.mark.parametrize("source", ["generated", "readme", "wrist"])
def test_other_instruction_sets_change_nothing(source):
    if source == "wrist" and not WRIST.is_dir():
        pytest.skip("not here")
    expected = diagnosed(*{"generated": generated, "readme": readme, "wrist": wrist}[source]())
    for settings in other_instruction_sets():
        assert other_processor(source, settings) == expected


@pytest.mark.parametrize("line", ["explain tendon_creep", "rank-pairs {model}", "stroke {model} --kappa 0,20 --x2 20"])
def test_pages_print_the_same_on_other_instruction_sets(coast, reference_text, tmp_path, line):
    model = tmp_path / "corrected.toml"
    model.write_text(f"{reference_text}\n[corrections.backlash]\nwidth_mm = 0.17\n", encoding="utf-8")
    words = [word.format(model=model) for word in line.split()]
    expected = coast(*words).out
    assert expected
    for settings in other_instruction_sets():
        assert on_other_processor(settings, "-m", "coast_cli", *words) == expected


def main():
    """Print for each recording how many of so many answers, and of how many instruction sets, were the same."""
    parser = argparse.ArgumentParser(description=__doc__.partition("\n")[0])
    parser.add_argument("--times", type=int, default=20)
    sources = [generated, readme, tip_load, *([wrist] if WRIST.is_dir() else [])]
    times = parser.parse_args().times
    sys.stdout.write(f"{'recording':12} {'last bits':>10} {'instructions':>12}\n")
    for source in sources:
        same = is_unchanged(source(), times)
        sets = [other_processor(source.__name__, other) == diagnosed(*source()) for other in other_instruction_sets()]
        shown = f"{sum(same)}/{len(same)}", f"{1 + sum(sets)}/{1 + len(sets)}"
        sys.stdout.write(f"{source.__name__:12} {shown[0]:>10} {shown[1]:>12}\n")
        sys.stdout.flush()


if __name__ == "__main__":
    main()
