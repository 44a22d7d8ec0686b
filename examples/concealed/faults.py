"""What goes wrong at the bench behind the robot's back: the camera's view, its frames, the load cell, something swinging."""

from __future__ import annotations

from collections.abc import Mapping

import numpy as np
from numpy.typing import NDArray

Array = NDArray[np.float64]
Effects = Mapping[str, Mapping[str, object]]


def breathing(time: Array, swing: Mapping[str, object]) -> Array:
    """Return a wave between about -1 and 1 that dwells at one end and whose periods are not quite equal."""
    turns = time / swing["period_s"] + swing["phase"]
    turns = turns + swing["unevenness"] * np.sin(2 * np.pi * turns / 7.3)
    return 2 * ((1 + np.cos(2 * np.pi * turns)) / 2) ** swing["shape"] - 1


def seen_by_camera(seen: Array, time: Array, effects: Effects, run: int, rng: np.random.Generator) -> Array:
    """Return the response [row, k] of run number `run` before noise, with the faults of the camera and of this run."""
    if (odd := effects.get("run_differs_gain")) and odd["run"] == run:
        seen = seen * odd["gain"]
    if (odd := effects.get("run_differs_offset")) and odd["run"] == run:
        seen = seen + odd["offset"]
    if (swing := effects.get("periodic_disturbance")) and swing["acts_on"] == "sensor":
        seen = seen + swing["amplitude"] * swing["full"] * breathing(time, swing)[:, None]
    if end := effects.get("camera_saturation"):
        level, width = (1 - end["lost_share"]) * end["full"], end["soft"] * end["full"]
        seen = level - width * np.logaddexp(0.0, (level - seen) / width)
    return seen[shown_frames(len(seen), effects, rng)]


def shown_frames(rows: int, effects: Effects, rng: np.random.Generator) -> NDArray[np.intp]:
    """Return the number of the frame that each row of a run shows."""
    frozen = effects.get("frozen_frames")
    return np.arange(rows) if frozen is None else frozen_rows(rows, frozen, rng)


def frozen_rows(rows: int, frozen: Mapping[str, object], rng: np.random.Generator) -> NDArray[np.intp]:
    """Return which frame each row shows where frames are repeated in bursts; what repeats shows the noise of its frame too."""
    take = np.arange(rows)
    count = int(frozen["bursts"])  # type: ignore[call-overload]
    lengths = np.maximum(rng.dirichlet(np.full(count, 4.0)) * frozen["share"] * rows, 2).astype(int)
    for start, length in zip(np.sort(rng.integers(0, max(rows - 2, 1), count)), lengths, strict=True):
        take[start : start + length] = take[start]
    return take


def doubled_rows(rows: int, share: float, rng: np.random.Generator) -> NDArray[np.intp]:
    """Return the rows of a file in which a share of the rows stands twice, one after the other."""
    return np.sort(np.concatenate([np.arange(rows), rng.choice(rows, int(share * rows), replace=False)]))


def load_cell(tension: Array, effects: Effects, along: Array) -> Array:
    """Return the tension (N) that the load cell shows; `along` runs from 0 to 1 through the run's time."""
    if scale := effects.get("load_cell_scale"):
        full = max(float(tension.max()), 1e-9)
        tension = tension * (scale["scale"] + scale["bow"] * tension / full)
    if offset := effects.get("load_cell_offset"):
        tension = tension + offset["offset_n"] * (1 + offset["warming"] * along)
    return tension
