"""One concealed case from one seed: a nominal configuration, recordings, and the truth that is sealed away.

Levels: L0 clean, LP a configured parameter is wrong, L1 one effect the recording can show, L2 one effect that the
recording's calibration absorbs, L3 one effect under the noise, L4 a second effect behind a bigger one, L5 a sensor
artefact or its physical twin, L6 something outside the catalogue.
"""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass, field, replace

import numpy as np

from examples.concealed.camera import noisy
from examples.concealed.design import config_text
from examples.concealed.draw import draw_world
from examples.concealed.protocol import REQUESTS, requested_protocol
from examples.concealed.recipes import OUTSIDE, RECIPES, TWINS
from examples.concealed.world import Array, Played, World, play_protocol


@dataclass(frozen=True)
class Case:
    """A recording with its configuration (both handed out) and its truth (sealed).

    `held_out` names the run kept from fitting; `laboratory` holds the further recordings that an answer may ask for.
    """

    config_text: str
    files: dict[str, str]
    truth: dict[str, object]
    held_out: tuple[str, ...] = ()
    laboratory: Mapping[str, str] = field(default_factory=dict)


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
    files, runs = write_files(rng, world, played, camera(rng, world, truth, played))
    sealed: dict[str, object] = {
        "level": level,
        "seed": seed,
        "kind": "joint",
        "effects": [
            {
                "id": name,
                "kind": RECIPES[name].kind,
                "component": RECIPES[name].component,
                "noise_widths": round(sizes.get(name, 0.0), 3),
                "parameters": world.effects[name],
            }
            for name in names
        ],
        "twins": sorted({*world.twins, *TWINS.get(names[0], ())}) if names else [],
        "near": list(RECIPES[names[0]].near) if names else [],
        "identifiable": level not in ("L2", "L3"),
        "where": [] if not names or names[0] in OUTSIDE else where(world, played, names[0]),
        "noise": {"sigma": world.sigma, **world.noise},
        "unit": {"curvature": "curvature_per_m", "bend": "bend_deg", "notch": "notch_deg"}[world.protocol.response],
        "parameters": {
            "youngs_modulus_gpa": world.actual.joint.youngs_modulus / 1e9,
            "pulley_friction": world.actual.joint.pulley_friction,
            "notch_friction": world.actual.joint.notch_friction,
            "deadband_mm": world.actual.joint.deadband * 1e3,
        },
        "configured": {
            "youngs_modulus_gpa": world.robot.joint.youngs_modulus / 1e9,
            "pulley_friction": world.robot.joint.pulley_friction,
            "notch_friction": world.robot.joint.notch_friction,
            "deadband_mm": world.robot.joint.deadband * 1e3,
            "wrap_angle_rad": world.robot.joint.wrap_angle,
        },
        "bends_mm": {name: world.protocol.runs[i].length * 1e3 for i, name in enumerate(runs)},
        "protocol": {name: world.protocol.runs[i].kind for i, name in enumerate(runs)},
        "response": {name: np.round(truth[played.rows.run == i], 6).tolist() for i, name in enumerate(runs)},
    }
    held_out = () if world.held_out is None else (runs[world.held_out],)
    laboratory = {}
    if level == "L2":
        for number, request in enumerate(REQUESTS):
            laboratory[request] = further_recording(world, request, number)
    return Case(config_text(world.robot), files, sealed, held_out, laboratory)


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
    """Return the response as recorded; noise runs on through a run and starts afresh in the next."""
    return np.concatenate(
        [noisy(truth[played.rows.run == run], world.sigma, world.noise, rng) for run in range(len(world.protocol.runs))]
    )


def misfit(rng: np.random.Generator, played: Played, world: World) -> Array:
    """Return a small smooth misfit of no name, 0.03 to 0.15 noise widths: "none" never means exact."""
    size = world.sigma * rng.uniform(0.03, 0.15)
    full = max(float(np.abs(played.response).max()), 1e-9)
    phase, turns = rng.uniform(0, 2 * np.pi), rng.uniform(0.5, 1.5)
    length = played.rows.length[:, None] / 0.04
    notch = np.arange(played.response.shape[1])[None, :]
    return size * np.sqrt(2) * np.sin(2 * np.pi * turns * played.response / full + phase + 1.5 * length + notch)


def write_files(
    rng: np.random.Generator,
    world: World,
    played: Played,
    seen: Array,
    *,
    style: str | None = None,
    one_file: bool = False,
) -> tuple[dict[str, str], list[str]]:
    """CSV text of one or several files and the names of the runs."""
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
    for row, run in enumerate(played.rows.run):
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


def where(world: World, played: Played, name: str) -> list[dict[str, object]]:
    """Return where the main effect acts: past its threshold where it has one, else where 90 % of it lies."""
    recipe, parameters = RECIPES[name], world.effects[name]
    others = {key: value for key, value in world.effects.items() if key != name}
    without = play_protocol(world.actual, world.protocol, others, world.curvature, world.streams)
    power = ((played.response - without.response) ** 2).sum(axis=1)
    base = play_protocol(world.actual, world.protocol, {}, world.curvature, world.streams)
    scale = {"curvature": 1.0, "bend": None, "notch": np.radians(1) / world.actual.joint.middle.pitch}[
        world.protocol.response
    ]
    bent = base.response.mean(axis=1) * (np.radians(1) / played.rows.length if scale is None else scale)
    values = {
        "stroke": played.rows.drive * 1e3,
        "tension": played.tension,
        "curvature": bent,
        "time": played.time,
        "bending_length": played.rows.length * 1e3,
    }
    threshold = {
        ("tendon_superelasticity", "tension"): "knee_tension_n",
        ("tube_superelasticity", "curvature"): "knee_curvature_per_m",
        ("notch_closure", "curvature"): "contact_curvature_per_m",
    }
    out: list[dict[str, object]] = []
    for axis in recipe.axes:
        if axis == "direction":
            out.append({"axis": axis, "value": "release", "low": None, "high": None})
        elif axis in values and power.sum() > 0:
            order = np.argsort(values[axis])
            share = np.cumsum(power[order]) / power.sum()
            low, high = (float(values[axis][order][np.searchsorted(share, q)]) for q in (0.05, 0.95))
            if key := threshold.get((name, axis)):
                low, high = float(parameters[key]), float(values[axis].max())  # type: ignore[arg-type]
            out.append({"axis": axis, "value": None, "low": low, "high": high})
        else:
            out.append({"axis": axis, "value": None, "low": None, "high": None})
    return out
