"""Recordings made with the package's own forward model, for unit tests: what is fitted is then known exactly."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import replace

import numpy as np

from coast_cli.diagnosis.joint.build import build_joint_problem
from coast_cli.diagnosis.joint.problem import with_base
from coast_cli.effects.effect import Effect
from coast_cli.effects.forward import History, Layout, predict
from coast_cli.recordings.model import JointRun
from coast_cli.spec.build import build_joint
from coast_cli.spec.load import REFERENCE, load_config

TOP = 4.0e-3
CONFIG = load_config(REFERENCE)


def cycle(top: float = TOP, step: float = 0.08e-3, bottom: float = 0.0) -> np.ndarray:
    """Return a stroke (m): up, half back, up again, down."""
    legs = [(0.0, top), (top, 0.5 * top), (0.5 * top, 0.8 * top), (0.8 * top, bottom)]
    return np.concatenate([np.linspace(a, b, max(2, round(abs(b - a) / step)), endpoint=False) for a, b in legs])


def make_run(
    stroke, response, *, name="a", length=0.03, tension=None, rate=0.2e-3, clock=True, kind="curvature", middle="MT1"
):
    """Return a stroke-driven run as the reader would."""
    stroke, response = np.asarray(stroke), np.asarray(response)
    travel = np.concatenate([[0.0], np.cumsum(np.maximum(np.abs(np.diff(stroke)), 1e-6))])
    return JointRun(
        name,
        f"{name}.csv",
        np.arange(stroke.size) + 2,
        travel / rate if clock else None,
        "OT4",
        middle,
        np.full(stroke.size, length),
        stroke,
        tension,
        response.reshape(stroke.size, -1),
        kind,
    )


def recording(
    effects: Sequence[Effect] = (),
    *,
    lengths: Sequence[float] = (0.035, 0.02, 0.035),
    noise: float = 0.1,
    memory: float = 0.0,
    seed: int = 0,
    values: dict[str, float] | None = None,
    witness: bool = False,
    **changes,
) -> list[JointRun]:
    """Return runs of the reference pair with effects, base parameters replaced by ``values``, and AR(1) noise."""
    rng = np.random.default_rng(seed)
    joint = with_base(build_joint(CONFIG, "OT4", "MT1"), values or {})
    blank = []
    for number, length in enumerate(lengths):
        stroke = cycle(TOP * (0.85 if length < 0.03 else 1.0))
        blank.append(make_run(stroke, np.zeros(stroke.size), name=f"run_{number}", length=length, **changes))
    histories = [History(run.time, run.stroke, None, run.bending_length, run=n) for n, run in enumerate(blank)]
    found = predict(joint, effects, histories, Layout("curvature", 1, 160.0))
    runs = []
    for run, prediction in zip(blank, found, strict=True):
        response = prediction.response[:, 0] + coloured(rng, len(run), noise, memory)
        tension = prediction.tension + 0.01 * rng.standard_normal(len(run)) if witness else None
        runs.append(replace(run, response=response[:, np.newaxis], tension=tension))
    return runs


def coloured(rng: np.random.Generator, size: int, level: float, memory: float) -> np.ndarray:
    """Return AR(1) noise of a level and memory."""
    white = rng.standard_normal(size)
    out = np.empty(size)
    value = white[0]
    for row in range(size):
        value = value if row == 0 else memory * value + np.sqrt(1.0 - memory**2) * white[row]
        out[row] = value
    return level * out


def problem_of(runs: Sequence[JointRun], held=None):
    """Return the problem of fitting the reference configuration to runs."""
    return build_joint_problem(CONFIG, runs, held)
