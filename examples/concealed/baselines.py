"""The other answers on the same cases: no correction, the true form refitted, i.i.d. BIC, a Gaussian process.

Sparse regression.

They see the recording as written. Only the true form is told what was concealed; it shows what a perfect naming
would be worth.
"""

from __future__ import annotations

import csv
from dataclasses import dataclass, replace
from pathlib import Path
from typing import Any

import numpy as np
from numpy.typing import NDArray

from examples.concealed.draw import draw_world
from examples.concealed.laws import RECIPES
from examples.concealed.lumped import FORMS, Data, fit_form
from examples.concealed.refit import SCALE, START, Rows, free_parameters
from examples.concealed.world import World, play_protocol

Array = NDArray[np.float64]

# Parameters of the true form that a user would have to find, besides its amplitude.
SECOND = {
    "tendon_superelasticity": "knee_tension_n",
    "tube_superelasticity": "knee_curvature_per_m",
    "notch_closure": "contact_curvature_per_m",
    "tendon_creep": "time_constant_s",
    "tendon_permanent_set": "threshold_n",
    "thermal_drift": "time_constant_s",
    "leadscrew_pitch_error": "phase_rad",
    "snap_through": "release_tension_n",
    "room_temperature_cycle": "period_s",
}


@dataclass(frozen=True)
class Other:
    """Errors on held-out rows against the recording and against the noiseless truth; what was named.

    Where something is.
    """

    name: str
    recorded: float
    noiseless: float
    named: str | None = None


def read_recording(case: Path) -> dict[str, dict[str, Array]]:
    """Columns of each run of a joint recording; the response as [row, k]."""
    runs: dict[str, list[dict[str, str]]] = {}
    for path in sorted(case.glob("*.csv")):
        with path.open(encoding="utf-8", newline="") as file:
            for row in csv.DictReader(file):
                runs.setdefault(row["run"], []).append(row)
    out = {}
    for name, rows in runs.items():
        seen = [key for key in rows[0] if key in ("curvature_per_m", "bend_deg") or key.startswith("notch_")]
        drive = np.array(
            [float(row["stroke_mm"]) * 1e-3 if "stroke_mm" in row else float(row["tension_n"]) for row in rows]
        )
        response = np.array([[float(row[key] or "nan") for key in seen] for row in rows])
        out[name] = {"drive": drive, "response": response}
    return out


def load(case: Path, truth: dict[str, Any], held_out: list[str]) -> tuple[World, Data, Array, Array]:
    """World of a case, its recorded rows, response [row, k], noiseless response [row, k]."""
    world, *_ = draw_world(int(truth["seed"]), truth["level"], truth.get("asked"))
    recording = read_recording(case)
    order = list(truth["response"])
    joints = tuple(world.robot.pair(plan.outer, plan.middle) for plan in world.protocol.runs)
    run = np.concatenate([np.full(len(recording[name]["drive"]), i) for i, name in enumerate(order)])
    drive = np.concatenate([recording[name]["drive"] for name in order])
    length = np.concatenate(
        [np.full(len(recording[name]["drive"]), world.protocol.runs[i].length) for i, name in enumerate(order)]
    )
    time = np.concatenate([plan.time[plan.recorded] for plan in world.protocol.runs])
    response = np.concatenate([recording[name]["response"] for name in order])
    exact = np.concatenate([np.array(truth["response"][name]) for name in order])
    train = ~np.isin(run, [order.index(name) for name in held_out])
    rows = Rows(joints, run, drive, length, world.protocol.response)
    # A lost frame is lost for every notch; the closed forms see the mean bend.
    return world, Data(rows, time, response.mean(axis=1), train), response, exact


def others(case: Path, truth: dict[str, Any], held_out: list[str]) -> list[Other]:
    """All other answers on one joint case with held-out runs."""
    world, data, response, exact = load(case, truth, held_out)
    test = ~data.train

    def error(name: str, fitted: Array, named: str | None = None) -> Other:
        shaped = fitted if fitted.ndim == 2 else fitted[:, None]
        off = (shaped - response)[test]
        return Other(
            name, float(np.sqrt(np.nanmean(off**2))), float(np.sqrt(np.mean((shaped - exact)[test] ** 2))), named
        )

    base = fit_form(None, data)
    forms = [base, *(fit_form(form, data) for form in FORMS)]
    rows = int(np.sum(data.train & np.isfinite(data.target)))
    best = min(forms, key=lambda fit: rows * np.log(max(fit.rss, 1e-12) / rows) + fit.parameters * np.log(rows))
    return [
        error("no correction", base.fitted),
        error("true form refitted", true_form(world, data, response, truth)),
        error("i.i.d. BIC", best.fitted, best.name),
        error("Gaussian process", base.fitted + gaussian_process(data, base.fitted)),
        error("sparse regression", base.fitted + sparse(data, base.fitted)),
    ]


def true_form(world: World, data: Data, response: Array, truth: dict[str, Any]) -> Array:
    """Return the generator's own form with base and leading parameters refitted to the training rows."""
    from scipy.optimize import least_squares

    free = free_parameters(data.rows)
    knobs = [
        (effect["id"], key)
        for effect in truth["effects"]
        for key in (RECIPES[effect["id"]].amplitude, SECOND.get(effect["id"]))
        if key
    ]
    start = np.array([float(world.effects[name][key]) for name, key in knobs])  # type: ignore[arg-type]

    def model(x: Array) -> Array:
        base = START.copy()
        # Unknowns stand around one, so that a relative difference step is a step.
        base[free] = x[: free.size] - 1
        stiffness, eta, deadband = base * SCALE
        joint = world.actual.joint
        actual = replace(
            world.actual,
            joint=replace(
                joint,
                youngs_modulus=joint.youngs_modulus * np.exp(stiffness),
                notch_friction=joint.notch_friction + eta,
                deadband=max(joint.deadband + deadband, 0.0),
            ),
        )
        effects = {name: dict(values) for name, values in world.effects.items()}
        for (name, key), value, nominal in zip(knobs, x[free.size :], start, strict=True):
            effects[name][key] = nominal * value
        return play_protocol(
            actual, world.protocol, effects, world.curvature, world.streams, driven_for=world.actual
        ).response

    good = data.train[:, None] & np.isfinite(response)
    fit = least_squares(
        lambda x: (model(x) - response)[good] / world.sigma,
        np.ones(free.size + len(knobs)),
        loss="soft_l1",
        f_scale=3.0,
        x_scale=0.05,
        diff_step=1e-3,
        max_nfev=10,
    )
    return model(fit.x)


def _features(data: Data, base: Array) -> Array:
    drive = (data.rows.drive - data.rows.drive.min()) / max(data.span, 1e-12)
    peak, direction = np.empty_like(drive), np.empty_like(drive)
    for rows in data.runs():
        peak[rows] = np.maximum.accumulate(drive[rows])
        step = np.gradient(drive[rows]) if rows.size > 1 else np.zeros(rows.size)
        direction[rows] = np.tanh(step / (np.abs(step).mean() + 1e-12))
    return np.column_stack([drive, 0.5 * direction, peak, data.rows.length / 0.03, 0 * base])


def gaussian_process(data: Data, base: Array) -> Array:
    """Residual of the base model by a Gaussian process on drive, direction, largest drive so far and bending length."""
    from scipy.linalg import cho_factor, cho_solve

    features = _features(data, base)
    chosen = np.flatnonzero(data.train & np.isfinite(data.target))
    chosen = chosen[:: max(1, chosen.size // 300)]
    seen = data.target[chosen] - base[chosen]
    seen = np.clip(
        seen, *(np.median(seen) + np.array([-1, 1]) * 8 * (1.4826 * np.median(np.abs(seen - np.median(seen))) + 1e-9))
    )
    size = max(float(np.std(seen)), 1e-9)

    def kernel(a: Array, b: Array, width: float) -> Array:
        return np.exp(-0.5 * ((a[:, None] - b[None]) ** 2).sum(axis=2) / width**2)

    best, answer = np.inf, np.zeros_like(base)
    for width in (0.15, 0.3, 0.6, 1.2):
        for noise in (0.1, 0.3, 0.7, 1.0):
            gram = kernel(features[chosen], features[chosen], width) + (noise**2 + 1e-8) * np.eye(chosen.size)
            factor = cho_factor(gram, lower=True)
            weights = cho_solve(factor, seen / size)
            scale = float(seen @ weights) / size / chosen.size
            likelihood = 0.5 * chosen.size * np.log(max(scale, 1e-12)) + float(np.log(np.diag(factor[0])).sum())
            if likelihood < best:
                best, answer = likelihood, size * kernel(features, features[chosen], width) @ weights
    return answer


def sparse(data: Data, base: Array) -> Array:
    """Residual of the base model by matching pursuit over a polynomial and hysteresis library, stopped by BIC."""
    drive, direction, peak, length, _ = _features(data, base).T
    k, t = base / max(data.top, 1e-9), data.elapsed()
    screw = 2e3 * np.pi * data.rows.drive / 0.635
    library = np.column_stack(
        [
            np.ones_like(k),
            k,
            k**2,
            k**3,
            direction,
            direction * k,
            peak - drive,
            (peak - drive) * k,
            length,
            length * k,
            t,
            t * k,
            np.sin(screw),
            np.cos(screw),
            np.maximum(k - 0.4, 0),
            np.maximum(k - 0.6, 0),
            np.maximum(k - 0.8, 0),
        ]
    )
    good = data.train & np.isfinite(data.target)
    seen = data.target[good] - base[good]
    library = library / (np.linalg.norm(library[good], axis=0) + 1e-12)
    chosen: list[int] = []
    best, weights = good.sum() * np.log(np.mean(seen**2) + 1e-18), np.zeros(0)
    left = seen
    for _ in range(6):
        trial = [*chosen, int(np.argmax(np.abs(library[good].T @ left)))]
        solved = np.linalg.lstsq(library[good][:, trial], seen, rcond=None)[0]
        left = seen - library[good][:, trial] @ solved
        score = good.sum() * np.log(np.mean(left**2) + 1e-18) + len(trial) * np.log(good.sum())
        if score >= best:
            break
        best, chosen, weights = score, trial, solved
    return library[:, chosen] @ weights if chosen else np.zeros_like(base)
