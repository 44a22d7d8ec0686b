"""What no named effect explains: whether there is still structure in a residual, and of what kind.

Two tests, neither of which knows any physics. *Repeats*: a Gaussian process on the drive's state (drive, direction,
largest drive so far, bending length, time) is trained on other runs and must predict this one; coloured noise cannot be
predicted from another run. *Smooth*: the residual is likelier as a smooth curve plus white noise than as AR(1) noise,
whose paths are rough. Both give the size of the structure, for comparison with the noise and with what was explained.
"""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from coast_cli.diagnosis.fit import Fit
from coast_cli.diagnosis.joint.problem import JointProblem
from coast_cli.diagnosis.noise_model import NoiseBank
from coast_cli.mechanics.section import FloatArray

_MOST_SAMPLES = 300
_WIDTHS = (0.07, 0.25, 0.7)


@dataclass(frozen=True, slots=True)
class Structure:
    """Structure left in a residual.

    Attributes:
        size: RMS of the structure, SI. noise: RMS of the rest, SI.
        repeats: share of the residual's power that other runs (or other blocks of the one run) predict.
        smooth: nats by which a smooth curve is likelier than coloured noise.
        memory: whether direction or history is needed to predict it.
    """

    size: float
    noise: float
    repeats: float
    smooth: float
    memory: bool


def find_structure(problem: JointProblem, fitted: Fit) -> Structure:
    """Return the structure that a fit leaves in the response it was fitted to."""
    residual = fitted.residual
    power = float(np.mean(residual**2)) if residual.size else 0.0
    repeats, memory = _repeats(problem, residual)
    smooth_bank = NoiseBank([rows for _, _, rows in problem.sequences], kernel="smooth")
    smooth = smooth_bank.evidence(residual)
    nats = smooth.log_likelihood - fitted.evidence.log_likelihood
    share = max(repeats, 0.0)
    if nats > 0.0:
        share = max(share, 1.0 - smooth_bank.white_share(smooth.colour))
    return Structure(
        size=float(np.sqrt(power * share)),
        noise=float(np.sqrt(power * (1.0 - min(share, 1.0)))),
        repeats=repeats,
        smooth=float(nats),
        memory=memory,
    )


def _repeats(problem: JointProblem, residual: FloatArray) -> tuple[float, bool]:
    """Return the best share predicted across runs over a few feature sets, and whether that set holds memory."""
    features, groups = _features(problem)
    if residual.size < 24 or np.unique(groups).size < 2:
        return 0.0, False
    stride = max(1, residual.size // _MOST_SAMPLES)
    chosen = slice(None, None, stride)
    target, groups = residual[chosen], groups[chosen]
    sets = {
        ("drive",): False,
        ("drive", "length"): False,
        ("drive", "direction"): True,
        ("drive", "direction", "largest"): True,
        ("drive", "direction", "length"): True,
        ("drive", "rate"): True,
        ("time",): False,
    }
    best, memory = 0.0, False
    for names, remembers in sets.items():
        if any(name not in features for name in names):
            continue
        inputs = np.stack([features[name][chosen] for name in names], axis=1)
        for width in _WIDTHS:
            share = _predicted_share(inputs / width, target, groups)
            if share > best + 0.02:
                best, memory = share, remembers
    return best, memory


def _predicted_share(inputs: FloatArray, target: FloatArray, groups: FloatArray) -> float:
    """Return 1 - error of predicting each group from the others / its power, by kernel ridge regression."""
    square = np.sum(inputs**2, axis=1)
    kernel = np.exp(-0.5 * np.maximum(square[:, np.newaxis] + square - 2.0 * inputs @ inputs.T, 0.0))
    error = 0.0
    for group in np.unique(groups):
        test = groups == group
        train = ~test
        if not np.any(train):
            return 0.0
        normal = kernel[np.ix_(train, train)] + 0.3 * np.eye(int(train.sum()))
        predicted = kernel[np.ix_(test, train)] @ np.linalg.solve(normal, target[train])
        error += float(np.sum((target[test] - predicted) ** 2))
    return 1.0 - error / max(float(np.sum(target**2)), 1e-300)


def _features(problem: JointProblem) -> tuple[dict[str, FloatArray], FloatArray]:
    """Return named features scaled to about 0..1 and the group of each fitted sample: its run, or a block of one run."""
    parts: dict[str, list[FloatArray]] = {}
    groups = []
    peak = max(float(np.max(np.abs(run.drive), initial=1e-12)) for run in problem.runs)
    longest = max(float(np.max(run.bending_length)) for run in problem.runs)
    fitted_runs = {index for index, _, rows in problem.sequences if rows.size}
    for index, column, rows in problem.sequences:
        run = problem.runs[index]
        values = {
            "drive": run.drive / peak,
            "direction": 2.0 * run.direction.astype(float),
            "largest": np.maximum.accumulate(run.drive) / peak,
            "length": np.nan_to_num(run.bending_length / longest * 3.0),  # a device has none
        }
        if run.time is not None and run.time.size:
            span = max(float(np.ptp(run.time)), 1e-12)
            values["time"] = (run.time - run.time[0]) / span
            speed = np.abs(np.gradient(run.drive)) / np.maximum(np.gradient(run.time), 1e-9)
            values["rate"] = speed / max(float(np.max(speed)), 1e-30)
        if run.response.shape[1] > 1:
            values = {name: value + 0.0 for name, value in values.items()}
            values["length"] = values["length"] + 1.5 * column
        for name, value in values.items():
            parts.setdefault(name, []).append(value[rows])
        block = (np.arange(len(run)) * 8 // max(len(run), 1))[rows]
        groups.append(np.full(rows.size, float(index)) if len(fitted_runs) > 1 else block.astype(float))
    size = sum(group.size for group in groups)
    joined = {name: np.concatenate(value) for name, value in parts.items()}
    return {name: value for name, value in joined.items() if value.size == size}, np.concatenate(groups)
