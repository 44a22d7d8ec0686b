"""The other answers on the same cases: no correction, the true form refitted, i.i.d. BIC, a Gaussian process.

Sparse regression.

They see the recording as written. Only the true form is told what was concealed; it shows what a perfect naming
would be worth.
"""

from __future__ import annotations

import csv
from dataclasses import replace
from pathlib import Path
from typing import Any

import numpy as np
from numpy.typing import NDArray

from examples.concealed.draw import draw_world
from examples.concealed.figures import TRUE_FORM
from examples.concealed.laws import RECIPES
from examples.concealed.lumped import FORMS, Data, fit_form
from examples.concealed.refit import START, Rows, free_parameters, trial_joint
from examples.concealed.world import World, play_protocol

Array = NDArray[np.float64]

# Parameters of the true form that a user would have to find, besides its amplitude.
SECOND = {
    "tendon_superelasticity": "knee_tension_n",
    "tube_superelasticity": "knee_strain",
    "tube_hysteresis": "lower_plateau",
    "viscous_friction": "knee_mm_per_s",
    "notch_closure": "contact_curvature_per_m",
    "tendon_creep": "time_constant_s",
    "tendon_permanent_set": "threshold_n",
    "thermal_drift": "housing_s",
    "leadscrew_pitch_error": "phase_rad",
    "snap_through": "release_tension_n",
    "drive_speed_slip": "knee_mm_per_s",
    "stribeck_sheath": "knee_mm_per_s",
    "drying_sheath": "exponent",
    "eccentric_pulley": "phase_rad",
    "jacket_relaxation": "time_constant_s",
    "jacket_softening": "scale_per_m",
    "stiffness_along": "at_mm",
    "periodic_disturbance": "period_s",
}


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


def others(case: Path, truth: dict[str, Any], held_out: list[str]) -> dict[str, dict[str, Any]]:
    """Return all other answers on one joint case with held-out runs: what they say, as an answer's JSON would, and errors."""
    world, data, response, exact = load(case, truth, held_out)
    test = ~data.train

    def answer(
        fitted: Array, verdict: str, name: str | None = None, law: dict[str, Any] | None = None
    ) -> dict[str, Any]:
        shaped = fitted if fitted.ndim == 2 else fitted[:, None]
        off = (shaped - response)[test]
        effect = {} if name is None else {"id": name, "kind": RECIPES[name].kind, "component": RECIPES[name].component}
        return {
            "diagnosis": {"verdict": verdict, "effects": [effect] if effect else [], "unnamed": law},
            "figures": {
                "recorded": float(np.sqrt(np.nanmean(off**2))),
                "noiseless": float(np.sqrt(np.mean((shaped - exact)[test] ** 2))),
            },
        }

    base = fit_form(None, data)
    forms = [base, *(fit_form(form, data) for form in FORMS)]
    rows = int(np.sum(data.train & np.isfinite(data.target)))

    def bic(rss: float, parameters: int) -> float:
        return rows * np.log(max(rss, 1e-12) / rows) + parameters * np.log(rows)

    best = min(forms, key=lambda fit: bic(fit.rss, fit.parameters))
    found = None if best.name == "none" else best.name
    process, terms = gaussian_process(data, base.fitted), sparse(data, base.fitted)
    true = truth["effects"][0]["id"] if truth["level"] not in ("L6", "L8") and truth["effects"] else None
    told = {"L0": "agrees", "LP": "parameters", "L6": "unexplained", "L8": "unexplained"}.get(truth["level"], "physics")
    return {
        "no correction": answer(base.fitted, "agrees"),
        TRUE_FORM: answer(true_form(world, data, response, truth), told) | _named(true, truth),
        "i.i.d. BIC": answer(best.fitted, RECIPES[found].kind if found else "agrees", found),
        "Gaussian process": answer(
            base.fitted + process, "unnamed" if np.any(process) else "agrees", law=RESIDUAL if np.any(process) else None
        ),
        "sparse regression": answer(
            base.fitted + terms, "unnamed" if np.any(terms) else "agrees", law=RESIDUAL if np.any(terms) else None
        ),
    }


# What a correction of the residual says of the law: something is added to the response, and no more.
RESIDUAL = {"stages": ["sensor"], "variables": [], "memory": None, "rate": None}


def _named(true: str | None, truth: dict[str, Any]) -> dict[str, Any]:
    """Return the answer of one who is told what was concealed, where it has a name."""
    if true is None:
        return {}
    effects = [{key: effect[key] for key in ("id", "kind", "component")} for effect in truth["effects"]]
    return {"diagnosis": {"verdict": effects[0]["kind"], "effects": effects, "where": truth["where"][:1]}}


def true_form(world: World, data: Data, response: Array, truth: dict[str, Any]) -> Array:
    """Return the generator's own form with base and leading parameters refitted to the training rows."""
    from scipy.optimize import least_squares

    free = free_parameters(data.rows)
    knobs = [
        (effect["law"], key)
        for effect in truth["effects"]
        for key in (RECIPES[effect["law"]].amplitude, SECOND.get(effect["law"]))
        if key
    ]
    start = np.array([float(world.effects[name][key]) for name, key in knobs])  # type: ignore[arg-type]

    def model(x: Array) -> Array:
        base = START.copy()
        # Unknowns stand around one, so that a relative difference step is a step.
        base[free] = x[: free.size] - 1
        actual = replace(world.actual, joint=trial_joint(world.actual.joint, base))
        actual = replace(actual, joint=replace(actual.joint, deadband=max(actual.joint.deadband, 0.0)))
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

    # White noise alone is the rival: without it a process would be found in every recording.
    best, answer = 0.5 * chosen.size * np.log(max(float(np.mean((seen / size) ** 2)), 1e-12)) - 3.0, np.zeros_like(base)
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
