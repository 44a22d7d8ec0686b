"""One concealed case from one seed: a nominal configuration, recordings, and the truth that is sealed away.

Levels: L0 clean, LP a configured parameter is wrong, L1 one effect the recording can show, L2 one effect that the recording's
calibration absorbs, L3 one effect under the noise, L4 a second effect behind a bigger one, L5 a sensor artefact or its physical
twin, L6 something outside the catalogue.
"""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass, field, replace

import numpy as np
from numpy.typing import NDArray

from examples.concealed.camera import draw_noise, noisy, observe
from examples.concealed.design import Joint, Robot, config_text, draw_robot
from examples.concealed.mechanism import Effects, simulate
from examples.concealed.protocol import REQUESTS, Needs, Protocol, RunPlan, draw_protocol, requested_protocol
from examples.concealed.recipes import JOINT_EFFECTS, OUTSIDE, RECIPES, TWINS, Context
from examples.concealed.refit import Rows, surviving

Array = NDArray[np.float64]

LEVELS = {"L0": 0.22, "LP": 0.06, "L1": 0.34, "L2": 0.09, "L3": 0.06, "L4": 0.08, "L5": 0.07, "L6": 0.08}
NEUTRAL = {"stiffness_ratio": 1.0, "scale": 1.0, "compliance_ratio": 1.0}
NOISE_RANGE = {"curvature": (0.05, 0.5), "bend": (0.1, 0.6), "notch": (0.1, 0.6)}


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


@dataclass
class World:
    """Everything that stays the same when a case is recorded again with another protocol."""

    robot: Robot
    actual: Robot
    effects: dict[str, dict[str, object]]
    noise: dict[str, object]
    sigma: float
    curvature: float
    protocol: Protocol
    streams: list[int] = field(default_factory=list)
    held_out: int | None = None


# -- simulation of a whole protocol ---------------------------------------------------------------------------------------


@dataclass(frozen=True)
class Played:
    """Noiseless rows of all runs."""

    rows: Rows
    time: Array
    tension: Array
    response: Array


def drive_range(joint: Joint, plan: RunPlan, curvature: float, protocol: Protocol, slack: float) -> tuple[float, float]:
    """Smallest and largest drive of a run (m, or N without a tendon)."""
    top, tension = joint.stroke(np.array(curvature), plan.length)
    if joint.tendon_radius == 0:
        return 0.02 * float(tension), float(tension)
    span = float(top) - joint.deadband
    low = joint.deadband - slack * span if protocol.slack_start else joint.deadband + slack * span / 2
    return max(low, 0.0), float(top)


def play_protocol(actual: Robot, protocol: Protocol, effects: Effects, curvature: float, seed: Sequence[int]) -> Played:
    """The noiseless recording of every run; the same seed gives the same notches whatever the effects are."""
    joints, index, drives, lengths, times, tensions, responses = [], [], [], [], [], [], []
    for number, plan in enumerate(protocol.runs):
        rng = np.random.default_rng([*seed, number])
        joint = actual.pair(plan.outer, plan.middle)
        share = rng.uniform(0.82, 1.0)
        low, high = drive_range(joint, plan, curvature * share, protocol, rng.uniform(0.04, 0.2))
        drive = low + (high - low) * plan.fraction
        notch_rng = np.random.default_rng([*seed, 1000 + number])
        if effects:
            trace = simulate(joint, plan.length, drive, plan.time, effects, notch_rng, largest=curvature, density=actual.density)
            response = observe(trace.theta, trace.weight, trace.length, plan.time, plan.length, protocol.response, effects, curvature)
            tension = trace.tension
            response, tension = response[plan.recorded], tension[plan.recorded]
            if drop := effects.get("clock_drop"):
                response = dropped_clock(response, float(drop["at_share"]), int(drop["frames"]))  # type: ignore[arg-type]
        else:
            response, tension = clean_response(joint, plan, drive[plan.recorded], protocol.response)
        joints.append(joint)
        index.append(np.full(plan.recorded.size, number))
        drives.append(drive[plan.recorded])
        lengths.append(np.full(plan.recorded.size, plan.length))
        times.append(plan.time[plan.recorded])
        tensions.append(tension)
        responses.append(response)
    rows = Rows(tuple(joints), np.concatenate(index), np.concatenate(drives), np.concatenate(lengths), protocol.response)
    return Played(rows, np.concatenate(times), np.concatenate(tensions), np.concatenate(responses))


def clean_response(joint: Joint, plan: RunPlan, drive: Array, kind: str) -> tuple[Array, Array]:
    """The base model itself, the same in load and release."""
    if joint.tendon_radius == 0:
        kappa, tension = np.maximum(drive, 0) * joint.arm / (joint.gain(plan.length) * joint.rigidity), drive
    else:
        kappa = joint.curvature(drive, plan.length)
        tension = joint.stroke(kappa, plan.length)[1]
    if kind == "curvature":
        return kappa[:, None], tension
    if kind == "bend":
        return np.degrees(kappa * plan.length)[:, None], tension
    return np.degrees(np.repeat(kappa[:, None] * joint.middle.pitch, joint.middle.count, axis=1)), tension


def dropped_clock(response: Array, at_share: float, frames: int) -> Array:
    """Frames lost by the recorder: from there on each row holds an earlier frame."""
    start = int(at_share * len(response))
    take = np.arange(len(response))
    take[start:] = np.maximum(take[start:] - frames, start - 1)
    return response[take]


# -- drawing a case ---------------------------------------------------------------------------------------------------------


def make_case(seed: int, level: str | None = None, effect: str | None = None) -> Case:
    """The case of a seed. `level` and `effect` restrict what is drawn; the same arguments give the same bytes."""
    world, level, names, sizes = draw_world(seed, level, effect)
    return record(world, seed, level, names, sizes)


def draw_world(seed: int, level: str | None = None, effect: str | None = None) -> tuple[World, str, list[str], dict[str, float]]:
    """Robot, protocol, effects, noise of a seed; the effects' names, main one first; their sizes in noise widths."""
    rng = np.random.default_rng([seed, 20230714])
    if level is None:
        level = "L1" if effect in JOINT_EFFECTS else "L6" if effect in OUTSIDE else str(rng.choice(list(LEVELS), p=list(LEVELS.values())))
    for attempt in range(42):
        # The same effect is tried with many protocols before another is taken, so that none is rarer for being harder to show.
        names = _choose_effects(np.random.default_rng([seed, 78, attempt // 14]), level, effect)
        found = _try_world(np.random.default_rng([seed, 77, attempt]), seed, level, names)
        if found is not None:
            return found[0], level, found[1], found[2]
    raise RuntimeError(f"seed {seed}: no protocol shows {effect} at {level}")


def _choose_effects(rng: np.random.Generator, level: str, effect: str | None) -> list[str]:
    catalogue = list(JOINT_EFFECTS)
    if level in ("L0", "LP"):
        return []
    if level == "L4":
        first = effect or str(rng.choice(catalogue))
        others = [name for name in catalogue if name != first and name not in TWINS.get(first, ())]
        return [first, str(rng.choice(others))]
    if level == "L5":
        return [effect or str(rng.choice(["sensor_lag", "camera_scale", "camera_offset", "sensor_lag", "capstan_hysteresis", "tendon_creep",
                                          "thermal_drift", "tendon_permanent_set", "coulomb_friction"]))]
    if level == "L6":
        return [effect or str(rng.choice(list(OUTSIDE)))]
    if level == "L2":
        return [effect or str(rng.choice([name for name in catalogue if name in HIDING]))]
    # A camera's scale is a stiffness to every recording of curvature alone: levels L2 and L5 hold it.
    return [effect or str(rng.choice([name for name in catalogue if name != "camera_scale"]))]


def _loading_only(p: Protocol) -> bool:
    return p.kinds() == {"load"}


def _one_length(p: Protocol) -> bool:
    return p.lengths == 1


def _held_out(rng: np.random.Generator, protocol: Protocol, needs: Sequence[Needs]) -> int | None:
    """A run without which the recording still shows what it showed; none when there are fewer than three."""
    if len(protocol.runs) < 3:
        return None
    for run in rng.permutation(len(protocol.runs)):
        if all(need(protocol.without(int(run))) for need in needs):
            return int(run)
    return None


# Protocols in which the base model's own parameters absorb the effect, or nothing can show it.
HIDING: dict[str, Needs] = {
    "capstan_hysteresis": _loading_only, "coulomb_friction": _loading_only, "backlash": _loading_only, "tendon_permanent_set": _loading_only,
    "sensor_lag": lambda p: _loading_only(p) and p.has_time, "thermal_drift": _loading_only, "tendon_creep": _loading_only,
    "tendon_superelasticity": lambda p: _one_length(p) and not p.has_tension, "tube_superelasticity": lambda p: _one_length(p) and not p.has_tension and p.response != "notch",
    "precurvature": lambda p: not p.slack_start and p.response != "notch", "camera_offset": lambda p: not p.slack_start and p.response != "notch",
    "camera_scale": _one_length, "bending_length_offset": _one_length, "tip_load": lambda p: _one_length(p) and p.response != "notch", "gravity": _one_length,
}


def _try_world(rng: np.random.Generator, seed: int, level: str, names: list[str]) -> tuple[World, list[str], dict[str, float]] | None:
    donors = names or [str(rng.choice(list(JOINT_EFFECTS)))]
    wrist = all(RECIPES[name].wrist for name in donors) and rng.random() < min(RECIPES[name].wrist for name in donors)
    robot = draw_robot(rng, wrist=wrist)
    needs = [HIDING[names[0]]] if level == "L2" else [RECIPES[name].needs for name in donors]
    length = robot.middles[0].count * robot.middles[0].pitch if wrist else None
    for _ in range(300):
        protocol = draw_protocol(rng, len(robot.outers), len(robot.middles), wrist=length)
        held_out = _held_out(rng, protocol, needs)
        if all(need(protocol) for need in needs) and (held_out is not None or len(protocol.runs) < 3):
            break
    else:
        return None
    if protocol.slack_start and not wrist and robot.joint.deadband < 0.3e-3:
        robot = replace(robot, joint=replace(robot.joint, deadband=round(rng.uniform(0.3, 1.6), 2) * 1e-3))
    actual = _actual(rng, robot, level)
    curvature = _largest_curvature(rng, actual, protocol, wrist=wrist)
    noise = draw_noise(rng)
    low, high = NOISE_RANGE[protocol.response]
    sigma = float(np.exp(rng.uniform(np.log(low), np.log(high))))
    world = World(robot, actual, {}, noise, sigma, curvature, protocol, [seed, int(rng.integers(2**31))], held_out)
    if not names:
        return world, names, {}
    context = _context(actual, protocol, curvature)
    world.effects = {name: RECIPES[name].draw(rng, context) for name in names}
    if level == "L2":
        return world, names, _sizes(world, names)
    wanted = {"L3": (0.5, 3.0), "L4": (8.0, 30.0)}.get(level, (3.0, 40.0))
    target = float(np.exp(rng.uniform(np.log(wanted[0]), np.log(wanted[1]))))
    return _scale(rng, world, names, target, wanted[0], float(rng.uniform(1.0, 4.0)))


def _scale(rng: np.random.Generator, world: World, names: list[str], target: float, least: float, second: float,
           ) -> tuple[World, list[str], dict[str, float]] | None:
    """Set noise level first, then amplitude, until the main effect stands `target` noise widths above the refitted base."""
    low, high = NOISE_RANGE[world.protocol.response]
    full = _full_scale(world)
    for step in range(4):
        everything = world.effects
        world.effects = {names[0]: everything[names[0]]}
        size = _sizes(world, names[:1])[names[0]] * world.sigma
        world.effects = everything
        if not np.isfinite(size) or size <= 0:
            return None
        # A believable effect is a modest share of the range: a large multiple asks for a quiet camera, not a huge effect.
        world.sigma = float(np.clip(min(world.sigma, 0.08 * full / target), low, high))
        ratio = target * world.sigma / size
        if 0.9 < ratio < 1.12:
            break
        if not _amplify(world, names[0], ratio):
            world.sigma = float(np.clip(size / target, low, world.sigma))
            break
    if len(names) == 2:
        for _ in range(3):
            size = _sizes(world, names)[names[1]]
            if not np.isfinite(size) or size <= 0:
                return None
            if 0.85 < second / size < 1.2 or not _amplify(world, names[1], second / size):
                break
    sizes = _sizes(world, names)
    worst = min(0.8 * least, RECIPES[names[0]].floor * (2.0 if len(names) == 2 else 1.0))
    if sizes[names[0]] < worst or (len(names) == 2 and not 0.6 < sizes[names[1]] < 6):
        return None
    return world, names, sizes


def _full_scale(world: World) -> float:
    """Largest response of the base model, in the recording's unit."""
    return float(play_protocol(world.actual, world.protocol, {}, world.curvature, world.streams).response.max())


def _amplify(world: World, name: str, ratio: float) -> bool:
    """Scale an effect's amplitude within its physical limits; false when it did not move."""
    recipe, parameters = RECIPES[name], world.effects[name]
    key = recipe.amplitude
    neutral, before = NEUTRAL.get(key, 0.0), float(parameters[key])  # type: ignore[arg-type]
    value = neutral + (before - neutral) * ratio
    low, high = recipe.limits
    if name == "thermal_drift":
        high = 0.4 if parameters["acts_on"] == "stiffness" else 20.0
    if name == "clock_drop":
        value = float(round(value))
    value = float(np.clip(value, low, high)) if neutral else float(np.sign(value) * np.clip(abs(value), low, high))
    parameters[key] = value
    return abs(value - before) > 0.02 * abs(before - neutral)


def _sizes(world: World, names: list[str]) -> dict[str, float]:
    """RMS of each effect that survives a refit of the base model, in noise widths."""
    played = play_protocol(world.actual, world.protocol, world.effects, world.curvature, world.streams)
    clean = play_protocol(world.actual, world.protocol, {}, world.curvature, world.streams).response
    if len(names) == 1:
        return {names[0]: surviving(played.rows, played.response) / world.sigma}
    out = {}
    for name in names:
        others = {key: value for key, value in world.effects.items() if key != name}
        without = play_protocol(world.actual, world.protocol, others, world.curvature, world.streams).response
        out[name] = surviving(played.rows, clean + played.response - without) / world.sigma
    return out


def _actual(rng: np.random.Generator, robot: Robot, level: str) -> Robot:
    """The robot as it is: off its nominal numbers by calibration error, or (LP) by much more."""
    joint = robot.joint
    driven = joint.tendon_radius > 0
    if level != "LP" and rng.random() < 0.2:
        return robot
    modulus = joint.youngs_modulus * (1 + np.clip(rng.normal(0, 0.03), -0.08, 0.08))
    friction = joint.pulley_friction * (1 + np.clip(rng.normal(0, 0.05), -0.15, 0.15))
    eta = max(joint.notch_friction + rng.normal(0, 0.0005), 1.0) if driven else 1.0
    deadband = max(joint.deadband + rng.normal(0, 0.03e-3), 0.0) if driven else 0.0
    if level == "LP":
        which = rng.permutation(["modulus", "eta", "deadband"] if driven else ["modulus"])[: int(rng.integers(1, 3))]
        if "modulus" in which:
            modulus = joint.youngs_modulus * float(rng.choice([rng.uniform(0.6, 0.85), rng.uniform(1.15, 1.5)]))
        if "eta" in which:
            eta = joint.notch_friction + rng.uniform(0.003, 0.007)
        if "deadband" in which:
            deadband = joint.deadband + rng.uniform(0.12, 0.5) * 1e-3 * (1 if joint.deadband < 0.6e-3 else rng.choice([-1, 1]))
    return replace(robot, joint=replace(joint, youngs_modulus=modulus, pulley_friction=friction, notch_friction=eta, deadband=deadband))


def _largest_curvature(rng: np.random.Generator, actual: Robot, protocol: Protocol, *, wrist: bool) -> float:
    """A largest curvature (1/m) that keeps tendon strain and notch bend believable."""
    if wrist:
        return float(np.radians(rng.uniform(6, 22)) / actual.joint.middle.pitch)
    curvature = rng.uniform(10, 45)
    for plan in protocol.runs:
        joint = actual.pair(plan.outer, plan.middle)
        strain = float(joint.stroke(np.array(curvature), plan.length)[1]) * joint.tendon_compliance / joint.tendon_length
        curvature *= min(1.0, 0.013 / strain)
        curvature = min(curvature, 2.3 / plan.length)
    return float(curvature)


def _context(actual: Robot, protocol: Protocol, curvature: float) -> Context:
    plans = protocol.runs
    joints = [actual.pair(plan.outer, plan.middle) for plan in plans]
    tops = [joint.stroke(np.array(curvature), plan.length) for joint, plan in zip(joints, plans, strict=True)]
    span = float(np.median([float(stroke) - joint.deadband for (stroke, _), joint in zip(tops, joints, strict=True)]))
    return Context(joints[0], curvature, float(np.median([float(tension) for _, tension in tops])), max(span, 1e-6) * 1e3,
                   float(np.median([plan.time[-1] for plan in plans])), protocol.dt, protocol.response == "bend")


# -- writing the recording and its truth ------------------------------------------------------------------------------------


def record(world: World, seed: int, level: str, names: list[str], sizes: Mapping[str, float]) -> Case:
    """Play the world's protocol, add misfit and noise, and write the files and the truth."""
    played = play_protocol(world.actual, world.protocol, world.effects, world.curvature, world.streams)
    rng = np.random.default_rng([*world.streams, 5])
    truth = played.response + misfit(rng, played, world)
    files, runs = write_files(rng, world, played, camera(rng, world, truth, played))
    sealed: dict[str, object] = {
        "level": level, "seed": seed, "kind": "joint",
        "effects": [{"id": name, "kind": RECIPES[name].kind, "component": RECIPES[name].component, "noise_widths": round(sizes.get(name, 0.0), 3),
                     "parameters": world.effects[name]} for name in names],
        "twins": list(TWINS.get(names[0], ())) if names and level in ("L2", "L5") else [],
        "near": list(RECIPES[names[0]].near) if names else [],
        "identifiable": level not in ("L2", "L3"),
        "where": [] if not names or names[0] in OUTSIDE else where(world, played, names[0]),
        "noise": {"sigma": world.sigma, **world.noise},
        "unit": {"curvature": "curvature_per_m", "bend": "bend_deg", "notch": "notch_deg"}[world.protocol.response],
        "parameters": {"youngs_modulus_gpa": world.actual.joint.youngs_modulus / 1e9, "pulley_friction": world.actual.joint.pulley_friction,
                       "notch_friction": world.actual.joint.notch_friction, "deadband_mm": world.actual.joint.deadband * 1e3},
        "configured": {"youngs_modulus_gpa": world.robot.joint.youngs_modulus / 1e9, "pulley_friction": world.robot.joint.pulley_friction,
                       "notch_friction": world.robot.joint.notch_friction, "deadband_mm": world.robot.joint.deadband * 1e3},
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
    again = replace(world, protocol=requested_protocol(rng, request, world.protocol), streams=[*world.streams, 9, number])
    played = play_protocol(again.actual, again.protocol, again.effects, again.curvature, again.streams)
    truth = played.response + misfit(rng, played, again)
    files, _ = write_files(rng, again, played, camera(rng, again, truth, played), style="more_{}", one_file=True)
    return files["recording.csv"]


def camera(rng: np.random.Generator, world: World, truth: Array, played: Played) -> Array:
    """The response as recorded; noise runs on through a run and starts afresh in the next."""
    return np.concatenate([noisy(truth[played.rows.run == run], world.sigma, world.noise, rng) for run in range(len(world.protocol.runs))])


def misfit(rng: np.random.Generator, played: Played, world: World) -> Array:
    """A small smooth misfit of no name, 0.03 to 0.15 noise widths: "none" never means exact."""
    size = world.sigma * rng.uniform(0.03, 0.15)
    full = max(float(np.abs(played.response).max()), 1e-9)
    phase, turns = rng.uniform(0, 2 * np.pi), rng.uniform(0.5, 1.5)
    length = played.rows.length[:, None] / 0.04
    notch = np.arange(played.response.shape[1])[None, :]
    return size * np.sqrt(2) * np.sin(2 * np.pi * turns * played.response / full + phase + 1.5 * length + notch)


def write_files(rng: np.random.Generator, world: World, played: Played, seen: Array, *, style: str | None = None,
                one_file: bool = False) -> tuple[dict[str, str], list[str]]:
    """CSV text of one or several files and the names of the runs."""
    protocol, driven = world.protocol, world.actual.joint.tendon_radius > 0
    style = style or str(rng.choice(["run_{}", "r{}", "test{}", "{}"]))
    runs = [style.format(i + 1) for i in range(len(protocol.runs))]
    header = ["run"] + (["time_s"] if protocol.has_time else []) + ["outer", "middle", "bending_length_mm"]
    header += (["stroke_mm"] if driven else ["tension_n"]) + (["tension_n"] if protocol.has_tension and driven else [])
    header += {"curvature": ["curvature_per_m"], "bend": ["bend_deg"], "notch": [f"notch_{i + 1}_deg" for i in range(seen.shape[1])]}[protocol.response]
    encoder = float(rng.choice([0.0, 0.0, 4e-7])) if driven else 0.001 * float(played.tension.max())
    drive = played.rows.drive + encoder * rng.standard_normal(played.rows.drive.size)
    tension = played.tension + float(played.tension.max()) * rng.uniform(0.002, 0.008) * rng.standard_normal(played.tension.size)
    blocks: list[list[str]] = [[] for _ in protocol.runs]
    for row, run in enumerate(played.rows.run):
        plan = protocol.runs[run]
        cells = [runs[run]] + ([f"{played.time[row]:.4f}"] if protocol.has_time else [])
        cells += ["" if plan.outer is None else world.robot.outers[plan.outer].name, world.robot.middles[plan.middle].name, f"{plan.length * 1e3:.10g}"]
        cells += [f"{drive[row] * 1e3:.5f}" if driven else f"{drive[row]:.5f}"] + ([f"{tension[row]:.5f}"] if protocol.has_tension and driven else [])
        cells += ["" if np.isnan(value) else f"{value:.4f}" for value in seen[row]]
        blocks[run].append(",".join(cells))
    head = ",".join(header)
    if one_file or rng.random() < 0.7:
        return {"recording.csv": "\n".join([head, *(line for block in blocks for line in block)]) + "\n"}, runs
    return {f"recording_{i + 1}.csv": "\n".join([head, *block]) + "\n" for i, block in enumerate(blocks)}, runs


def where(world: World, played: Played, name: str) -> list[dict[str, object]]:
    """The axis and window in which the main effect acts: its threshold where it has one, else where 90 % of it lies."""
    recipe, parameters = RECIPES[name], world.effects[name]
    others = {key: value for key, value in world.effects.items() if key != name}
    without = play_protocol(world.actual, world.protocol, others, world.curvature, world.streams)
    power = ((played.response - without.response) ** 2).sum(axis=1)
    base = play_protocol(world.actual, world.protocol, {}, world.curvature, world.streams)
    scale = {"curvature": 1.0, "bend": None, "notch": np.radians(1) / world.actual.joint.middle.pitch}[world.protocol.response]
    bent = base.response.mean(axis=1) * (np.radians(1) / played.rows.length if scale is None else scale)
    values = {"stroke": played.rows.drive * 1e3, "tension": played.tension, "curvature": bent, "time": played.time, "bending_length": played.rows.length * 1e3}
    threshold = {("tendon_superelasticity", "tension"): "knee_tension_n", ("tube_superelasticity", "curvature"): "knee_curvature_per_m",
                 ("notch_closure", "curvature"): "contact_curvature_per_m"}
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
