"""The same answer on any processor: neither last bits of a recording nor other instruction sets change what is printed."""

import json
import os
import subprocess
import sys
from dataclasses import replace
from pathlib import Path

import numpy as np
import pytest

from coast_cli.diagnosis.joint import diagnose_joint
from coast_cli.diagnosis.shapes import diagnose_shapes
from coast_cli.effects.library.backlash import Backlash
from coast_cli.effects.library.tendon_superelasticity import TendonSuperelasticity
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


def wrist():
    config = load_config(WRIST / "tubes.toml")
    return config, read_recordings([WRIST / "wrist_A.csv"], config).joint.runs


def test_last_bits_of_a_recording_change_nothing():
    config, runs = generated()
    expected = printed(diagnose_joint(config, runs))
    assert expected["effects"]
    for seed in range(3):
        rng = np.random.default_rng(seed)
        other = [replace(run, response=shaken(run.response, rng)) for run in runs]
        assert printed(diagnose_joint(config, other)) == expected


@pytest.mark.skipif(not WRIST.is_dir(), reason="not here")
def test_last_bits_of_a_real_recording_change_nothing():
    config, runs = wrist()
    expected = printed(diagnose_joint(config, runs))
    for seed in range(2):
        rng = np.random.default_rng(seed)
        other = [replace(run, response=shaken(run.response, rng)) for run in runs]
        assert printed(diagnose_joint(config, other)) == expected


def test_last_bits_of_shapes_change_nothing(tmp_path):
    from examples.concealed.shape_case import make_shape_case

    case = make_shape_case(71002, "L1", "tip_load")
    config = load_config_text(case.config_text, "case")
    paths = []
    for name, text in case.files.items():
        paths.append(tmp_path / name)
        paths[-1].write_text(text, encoding="utf-8")
    runs = read_recordings(paths, config).shape.runs
    expected = printed(diagnose_shapes(config, runs))
    rng = np.random.default_rng(0)
    other = [replace(run, x=shaken(run.x, rng), y=shaken(run.y, rng)) for run in runs]
    assert printed(diagnose_shapes(config, other)) == expected


SCRIPT = """
import json
from tests.validation.test_stability import {source}, printed
from coast_cli.diagnosis.joint import diagnose_joint
print(json.dumps(printed(diagnose_joint(*{source}()))))
"""


def other_processor(source, settings):
    """Return what is printed in a process of its own, on a processor that lacks what the settings name."""
    environment = {**os.environ, "OPENBLAS_NUM_THREADS": "1", "PYTHONPATH": str(ROOT), **settings}
    command = [sys.executable, "-W", "ignore", "-c", SCRIPT.format(source=source)]
    done = subprocess.run(command, cwd=ROOT, env=environment, capture_output=True, text=True, check=True)
    return json.loads(done.stdout)


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


@pytest.mark.parametrize("source", ["generated", "wrist"])
def test_other_instruction_sets_change_nothing(source):
    if source == "wrist" and not WRIST.is_dir():
        pytest.skip("not here")
    config, runs = {"generated": generated, "wrist": wrist}[source]()
    expected = printed(diagnose_joint(config, runs))
    for settings in other_instruction_sets():
        assert other_processor(source, settings) == expected
