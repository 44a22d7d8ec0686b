"""One concealed case from one seed: a nominal configuration, recordings, and the truth that is sealed away.

Levels: L0 clean, LP a configured parameter is wrong, L1 one effect the recording can show, L2 one effect that the
recording's calibration absorbs, L3 one effect under the noise, L4 a second effect behind a bigger one, L5 a sensor
artefact or its physical twin, L6 something outside the catalogue, L8 an effect of the catalogue that the answering side
is told to forget, L9 a bench fault.
"""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass, field, replace

import numpy as np
from numpy.typing import NDArray

from examples.concealed.bending import strain_per_curvature
from examples.concealed.camera import noisy
from examples.concealed.design import Joint, config_text
from examples.concealed.draw import draw_world
from examples.concealed.faults import doubled_rows
from examples.concealed.laws import BENCH_NAMES, NEAR_TWINS, OUTSIDE, RECIPES, TWINS
from examples.concealed.protocol import REQUESTS, RunPlan, requested_protocol
from examples.concealed.refit import base_response, refit
from examples.concealed.world import Array, Played, World, play_protocol


@dataclass(frozen=True)
class Case:
    """A recording with its configuration (both handed out) and its truth (sealed).

    `held_out` names the run kept from fitting; `laboratory` holds the further recordings that an answer may ask for;
    `without` the effects that are concealed from the catalogue.
    """

    config_text: str
    files: dict[str, str]
    truth: dict[str, object]
    held_out: tuple[str, ...] = ()
    laboratory: Mapping[str, str] = field(default_factory=dict)
    without: tuple[str, ...] = ()


def make_case(seed: int, level: str | None = None, effect: str | None = None) -> Case:
    """Return the case of a seed, always the same bytes; `level` and `effect` restrict what is drawn."""
    world, level, names, sizes = draw_world(seed, level, effect)
    case = record(world, seed, level, names, sizes)
    case.truth["asked"] = effect
    return case


def record(world: World, seed: int, level: str, names: list[str], sizes: Mapping[str, float]) -> Case:
    """Play the world's protocol, add misfit and noise, and write the files and the truth."""
    played = play_protocol(world.actual, world.protocol, world.effects, world.curvature, world.streams)
    rng = np.random.default_rng([*world.streams, 5])
    truth = played.response + misfit(rng, played, world)
    seen = camera(rng, world, truth, played)
    copies = np.arange(played.rows.run.size)
    if doubled := world.effects.get("doubled_rows"):
        copies = doubled_rows(copies.size, float(doubled["share"]), rng)  # type: ignore[arg-type]
    files, runs = write_files(rng, world, played, seen, copies=copies)
    joint, given = world.actual.joint, world.robot.joint
    sealed: dict[str, object] = {
        "level": level,
        "seed": seed,
        "kind": "joint",
        "effects": [_effect(name, world, runs, sizes.get(name, 0.0)) for name in names],
        "twins": sorted({*world.twins, *TWINS.get(names[0], ())}) if names else [],
        "identifiable": level not in ("L2", "L3"),
        "where": [] if not names or names[0] in OUTSIDE else where(world, played, names[0], runs),
        "noise": {"sigma": world.sigma, **world.noise},
        "unit": {"curvature": "curvature_per_m", "bend": "bend_deg", "notch": "notch_deg"}[world.protocol.response],
        "parameters": _numbers(joint),
        "configured": {**_numbers(given), "wrap_angle_rad": given.wrap_angle},
        "bends_mm": {name: world.protocol.runs[i].length * 1e3 for i, name in enumerate(runs)},
        "protocol": {name: world.protocol.runs[i].kind for i, name in enumerate(runs)},
        "response": {
            name: np.round(truth[copies][played.rows.run[copies] == i], 6).tolist() for i, name in enumerate(runs)
        },
    }
    sealed["base_held_out"] = base_held_out(played, world.held_out)
    held_out = () if world.held_out is None else (runs[world.held_out],)
    laboratory = {}
    if level == "L2":
        for number, request in enumerate(REQUESTS):
            laboratory[request] = further_recording(world, request, number)
    return Case(config_text(world.robot), files, sealed, held_out, laboratory, without(level, names, world.twins))


def base_held_out(played: Played, held_out: int | None) -> float | None:
    """Return the error (RMS, the recording's unit) of the base model, fitted to the other runs, on the noiseless held-out one."""
    if held_out is None:
        return None
    test = played.rows.run == held_out
    best, _ = refit(played.rows.subset(~test), played.response[~test])
    left = played.response[test] - base_response(played.rows.subset(test), best)[:, None]
    return float(np.sqrt(np.mean(left**2)))


def without(level: str, names: list[str], rivals: tuple[str, ...]) -> tuple[str, ...]:
    """Return the names that leave-one-out conceals: the truth, its near twins, and what this recording cannot tell it from."""
    return tuple(sorted({names[0], *NEAR_TWINS.get(names[0], ()), *rivals})) if level == "L8" else ()


def _numbers(joint: Joint) -> dict[str, float]:
    return {
        "youngs_modulus_gpa": joint.youngs_modulus / 1e9,
        "pulley_friction": joint.pulley_friction,
        "notch_friction": joint.notch_friction,
        "deadband_mm": joint.deadband * 1e3,
    }


def _effect(name: str, world: World, runs: list[str], size: float) -> dict[str, object]:
    """Return what is true of one effect: name, component, size, parameters, what is known of its law, the run it is in."""
    recipe, parameters = RECIPES[name], world.effects[name]
    stages = recipe.nature.stages
    if name == "periodic_disturbance":
        stages = (str(parameters["acts_on"]),)
    return {
        "id": BENCH_NAMES.get(name, name),
        "law": name,
        "kind": recipe.kind,
        "component": recipe.component,
        "noise_widths": round(size, 3),
        "parameters": parameters,
        "nature": {**vars(recipe.nature), "stages": stages},
        "run": runs[int(parameters["run"])] if "run" in parameters else None,  # type: ignore[call-overload]
    }


def further_recording(world: World, request: str, number: int) -> str:
    """One more recording of the same world by a protocol that was asked for, as CSV text."""
    rng = np.random.default_rng([*world.streams, 9, number])
    again = replace(
        world, protocol=requested_protocol(rng, request, world.protocol), streams=[*world.streams, 9, number]
    )
    played = play_protocol(again.actual, again.protocol, again.effects, again.curvature, again.streams)
    truth = played.response + misfit(rng, played, again)
    files, _ = write_files(rng, again, played, camera(rng, again, truth, played), style=request + "_{}", one_file=True)
    return files["recording.csv"]


def camera(rng: np.random.Generator, world: World, truth: Array, played: Played) -> Array:
    """Return the response as recorded; noise runs on through a run and starts afresh in the next.

    A frame that is shown again shows its noise again.
    """
    measured = [
        noisy(truth[played.rows.run == run], world.sigma, world.noise, rng, branch_rows(plan))
        for run, plan in enumerate(world.protocol.runs)
    ]
    return np.concatenate(measured)[played.frames]


def branch_rows(plan: RunPlan) -> int:
    """Return how many rows lie between two reversals of a run, on average."""
    way = np.sign(np.diff(plan.fraction[plan.recorded]))
    way = way[way != 0]
    return plan.recorded.size // (1 + int(np.sum(way[1:] != way[:-1])))


def misfit(rng: np.random.Generator, played: Played, world: World) -> Array:
    """Return a small misfit of no name: a smooth one, and runs and notches that differ. "None" never means exact.

    Each part is 0.02 to 0.25 noise widths (RMS), drawn anew for every case.
    """
    smooth, between, along = world.sigma * np.exp(rng.uniform(np.log(0.02), np.log(0.25), 3))
    full = max(float(np.abs(played.response).max()), 1e-9)
    phase, turns = rng.uniform(0, 2 * np.pi), rng.uniform(0.5, 1.5)
    length = played.rows.length[:, None] / 0.04
    share = played.response / full
    wave = np.sqrt(2) * np.sin(2 * np.pi * turns * share + phase + 1.5 * length)
    run = rng.standard_normal(len(world.protocol.runs))[played.rows.run][:, None]
    notch = rng.standard_normal(played.response.shape[1])[None, :] * (played.response.shape[1] > 1)
    return smooth * wave + (between * run + along * notch) * share


def write_files(
    rng: np.random.Generator,
    world: World,
    played: Played,
    seen: Array,
    *,
    style: str | None = None,
    one_file: bool = False,
    copies: NDArray[np.intp] | None = None,
) -> tuple[dict[str, str], list[str]]:
    """CSV text of one or several files and the names of the runs; `copies` are the rows to write, where some stand twice."""
    protocol, driven = world.protocol, world.actual.joint.tendon_radius > 0
    style = style or str(rng.choice(["run_{}", "r{}", "test{}", "{}"]))
    runs = [style.format(i + 1) for i in range(len(protocol.runs))]
    header = ["run"] + (["time_s"] if protocol.has_time else []) + ["outer", "middle", "bending_length_mm"]
    header += (["stroke_mm"] if driven else ["tension_n"]) + (["tension_n"] if protocol.has_tension and driven else [])
    header += {
        "curvature": ["curvature_per_m"],
        "bend": ["bend_deg"],
        "notch": [f"notch_{i + 1}_deg" for i in range(seen.shape[1])],
    }[protocol.response]
    encoder = float(rng.choice([0.0, 0.0, 4e-7])) if driven else 0.001 * float(played.tension.max())
    drive = played.rows.drive + encoder * rng.standard_normal(played.rows.drive.size)
    tension = played.tension + float(played.tension.max()) * rng.uniform(0.002, 0.008) * rng.standard_normal(
        played.tension.size
    )
    blocks: list[list[str]] = [[] for _ in protocol.runs]
    for row in np.arange(drive.size) if copies is None else copies:
        run = played.rows.run[row]
        plan = protocol.runs[run]
        cells = [runs[run]] + ([f"{played.time[row]:.4f}"] if protocol.has_time else [])
        cells += [
            "" if plan.outer is None else world.robot.outers[plan.outer].name,
            world.robot.middles[plan.middle].name,
            f"{plan.length * 1e3:.10g}",
        ]
        cells += [f"{drive[row] * 1e3:.5f}" if driven else f"{drive[row]:.5f}"] + (
            [f"{tension[row]:.5f}"] if protocol.has_tension and driven else []
        )
        cells += ["" if np.isnan(value) else f"{value:.4f}" for value in seen[row]]
        blocks[run].append(",".join(cells))
    head = ",".join(header)
    if one_file or rng.random() < 0.7:
        return {"recording.csv": "\n".join([head, *(line for block in blocks for line in block)]) + "\n"}, runs
    return {f"recording_{i + 1}.csv": "\n".join([head, *block]) + "\n" for i, block in enumerate(blocks)}, runs


def where(world: World, played: Played, name: str, runs: list[str]) -> list[dict[str, object]]:
    """Return where the main effect is to be found.

    That is past its threshold, where it has one, and on every axis the narrowest window that holds 90 % of what the
    refitted base model leaves of the noiseless response; a fault of one run is in that run and nowhere else.
    """
    recipe, parameters = RECIPES[name], world.effects[name]
    one_run = [] if "run" not in parameters else [_place("run", runs[int(parameters["run"])])]  # type: ignore[call-overload]
    if one_run and name != "lost_steps":
        return one_run
    left = ((played.response - refit(played.rows, played.response)[1][:, None]) ** 2).sum(axis=1)
    rows, joint = played.rows, world.actual.joint
    per_degree = np.radians(1) / (joint.middle.pitch if rows.kind == "notch" else rows.length)
    values = {
        "stroke" if joint.tendon_radius else "tension": rows.drive * (1e3 if joint.tendon_radius else 1.0),
        "curvature": played.response.mean(axis=1) * (1.0 if rows.kind == "curvature" else per_degree),
        "time": played.time,
        "bending_length": rows.length * 1e3,
    } | ({"tension": played.tension} if world.protocol.has_tension else {})
    out: list[dict[str, object]] = list(one_run)
    for axis, along in values.items():
        low, high = narrowest(along, left)
        # A window as wide as the axis says nothing of a place.
        if high - low <= 0.8 * float(np.ptp(along)):
            out.append(_place(axis, None, low, high))
        if key := THRESHOLDS.get((name, axis)):
            knee = float(parameters[key])  # type: ignore[arg-type]
            if key == "knee_strain":
                knee /= strain_per_curvature(joint)
            out.append(_place(axis, None, knee, float(along.max())))
    moving = np.concatenate([np.gradient(rows.drive[rows.run == run]) for run in range(len(world.protocol.runs))])
    load, release = (float(left[side].sum()) for side in (moving > 0, moving < 0))
    # A branch is where the excess is if it holds two thirds of it; else both are.
    sides = [side for side, held in (("load", load), ("release", release)) if held > (load + release) / 3]
    out += [_place("direction", side) for side in sides]
    listed = {entry["axis"] for entry in out}
    return out + [_place(axis) for axis in recipe.axes if axis not in listed]


def _place(
    axis: str, value: str | None = None, low: float | None = None, high: float | None = None
) -> dict[str, object]:
    return {"axis": axis, "value": value, "low": low, "high": high}


THRESHOLDS = {
    ("tendon_superelasticity", "tension"): "knee_tension_n",
    ("tube_superelasticity", "curvature"): "knee_strain",
    ("tube_hysteresis", "curvature"): "knee_strain",
    ("notch_closure", "curvature"): "contact_curvature_per_m",
}


def narrowest(along: Array, power: Array, share: float = 0.9) -> tuple[float, float]:
    """Return the narrowest window of `along` that holds this share of `power`."""
    order = np.argsort(along, kind="stable")
    held = np.concatenate([[0.0], np.cumsum(power[order])]) / max(float(power.sum()), 1e-300)
    last = np.searchsorted(held, held[:-1] + share, side="left")
    first = np.flatnonzero(last <= along.size)
    width = along[order][last[first] - 1] - along[order][first]
    best = first[int(np.argmin(width))]
    return float(along[order][best]), float(along[order][last[best] - 1])
