"""Draw a robot, a protocol and what is left out from a seed, and scale it to stand where its level wants it.

An effect's size is the RMS that survives a refit of the base model, in noise widths.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import replace

import numpy as np

from examples.concealed.bending import strain_per_curvature
from examples.concealed.camera import draw_noise
from examples.concealed.design import Robot, draw_robot
from examples.concealed.laws import BENCH, FAR, JOINT_EFFECTS, NEAR_SPAN, OUTSIDE, RECIPES, TWINS
from examples.concealed.lumped import Data, rivals
from examples.concealed.protocol import Needs, Protocol, draw_protocol, requested_protocol
from examples.concealed.recipes import Context
from examples.concealed.refit import base_tension, refit, surviving
from examples.concealed.world import Played, World, play_protocol

LEVELS = {
    "L0": 0.20,
    "LP": 0.05,
    "L1": 0.26,
    "L2": 0.07,
    "L3": 0.05,
    "L4": 0.07,
    "L5": 0.06,
    "L6": 0.09,
    "L8": 0.08,
    "L9": 0.07,
}
# Sizes of the main effect, in noise widths above the refitted base model.
SIZES = {"L3": (0.5, 3.0), "L4": (8.0, 30.0), "L6": (3.0, 30.0), "L8": (3.0, 30.0), "L9": (2.0, 20.0)}
# What an amplitude is worth where the law does nothing, if not zero.
NEUTRAL = {"scale": 1.0, "gain": 1.0, ("notch_crack", "compliance_ratio"): 1.0}
# Stiffness absorbs these in the response; only a load cell sees them.
SHOWN_BY_TENSION = ("transmission_compliance", "load_cell_scale", "load_cell_offset")
NOISE_RANGE = {"curvature": (0.05, 0.5), "bend": (0.1, 0.6), "notch": (0.1, 0.6)}


def draw_world(
    seed: int, level: str | None = None, effect: str | None = None
) -> tuple[World, str, list[str], dict[str, float]]:
    """Robot, protocol, effects, noise of a seed; the effects' names, main one first; their sizes in noise widths."""
    rng = np.random.default_rng([seed, 20230714])
    if level is None:
        known = (("L1", JOINT_EFFECTS), ("L6", OUTSIDE), ("L9", BENCH))
        drawn = str(rng.choice(list(LEVELS), p=list(LEVELS.values())))
        level = next((name for name, laws in known if effect in laws), drawn)
    for attempt in range(98):
        # Many protocols are tried before another effect is taken: none is rarer for being harder to show.
        names = _choose_effects(np.random.default_rng([seed, 78, attempt // 14]), level, effect)
        found = _try_world(np.random.default_rng([seed, 77, attempt]), seed, level, names)
        if found is not None:
            return found[0], level, found[1], found[2]
    raise RuntimeError(f"seed {seed}: no protocol shows {effect} at {level}")


def _choose_effects(rng: np.random.Generator, level: str, effect: str | None) -> list[str]:
    # What only a load cell sees has no size in noise widths of the camera.
    catalogue = [name for name in JOINT_EFFECTS if level not in ("L3", "L4") or name not in SHOWN_BY_TENSION]
    if level in ("L0", "LP"):
        return []
    if level == "L4":
        first = effect or str(rng.choice(catalogue))
        others = [name for name in catalogue if name != first and name not in TWINS.get(first, ())]
        return [first, str(rng.choice(others))]
    if level == "L5":
        return [
            effect
            or str(
                rng.choice(
                    [
                        "sensor_lag",
                        "camera_scale",
                        "camera_offset",
                        "sensor_lag",
                        "capstan_hysteresis",
                        "tendon_creep",
                        "thermal_drift",
                        "tendon_permanent_set",
                        "coulomb_friction",
                    ]
                )
            )
        ]
    if level == "L6":
        return [effect] if effect else _outsiders(rng)
    if level == "L9":
        return [effect or str(rng.choice(list(BENCH)))]
    if level == "L2":
        return [effect or str(rng.choice([name for name in catalogue if name in HIDING]))]
    # A camera's scale is a stiffness to every recording of curvature alone: levels L2 and L5 hold it.
    return [effect or str(rng.choice([name for name in catalogue if name != "camera_scale"]))]


def _outsiders(rng: np.random.Generator) -> list[str]:
    """Return one law near the span, two at once, or one far from it."""
    near = list(NEAR_SPAN)
    style = str(rng.choice(["one", "two", "far"], p=[0.6, 0.25, 0.15]))
    if style == "far":
        return [str(rng.choice(list(FAR)))]
    first, second = (str(name) for name in rng.choice(near, 2, replace=False))
    sheaths = {"stribeck_sheath", "drying_sheath"}
    return [first] if style == "one" or {first, second} == sheaths else [first, second]


def _loading_only(p: Protocol) -> bool:
    return p.kinds() == {"load"}


def _one_length(p: Protocol) -> bool:
    return p.lengths == 1


# The further recording that shows what was hidden.
REVEALING = {
    "capstan_hysteresis": "release",
    "coulomb_friction": "release",
    "backlash": "release",
    "tendon_permanent_set": "release",
    "sensor_lag": "rates",
    "thermal_drift": "release",
    "tendon_creep": "holds",
    "tendon_superelasticity": "lengths",
    "tube_superelasticity": "lengths",
    "precurvature": "slack",
    "camera_offset": "slack",
    "camera_scale": "lengths",
    "bending_length_offset": "lengths",
    "tip_load": "slack",
    "gravity": "slack",
}


def _held_out(rng: np.random.Generator, protocol: Protocol, needs: Sequence[Needs]) -> int | None:
    """Return a run without which the recording still shows what it showed; none when there are fewer than three."""
    if len(protocol.runs) < 3:
        return None
    for run in rng.permutation(len(protocol.runs)):
        if all(need(protocol.without(int(run))) for need in needs):
            return int(run)
    return None


# Protocols in which the base model's own parameters absorb the effect, or nothing can show it.
HIDING: dict[str, Needs] = {
    "capstan_hysteresis": _loading_only,
    "coulomb_friction": _loading_only,
    "backlash": _loading_only,
    "tendon_permanent_set": _loading_only,
    "sensor_lag": lambda p: _loading_only(p) and p.has_time,
    "thermal_drift": _loading_only,
    "tendon_creep": _loading_only,
    "tendon_superelasticity": lambda p: _one_length(p) and not p.has_tension,
    "tube_superelasticity": lambda p: _one_length(p) and not p.has_tension and p.response != "notch",
    "precurvature": lambda p: not p.slack_start and p.response != "notch",
    "camera_offset": lambda p: not p.slack_start and p.response != "notch",
    "camera_scale": _one_length,
    "bending_length_offset": _one_length,
    "tip_load": lambda p: _one_length(p) and p.response != "notch",
    "gravity": _one_length,
}


def _try_world(
    rng: np.random.Generator, seed: int, level: str, names: list[str]
) -> tuple[World, list[str], dict[str, float]] | None:
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
    curvature = _largest_curvature(rng, actual, protocol, names, wrist=wrist)
    if _tendon_strain(actual, protocol, curvature) > 0.025:
        return None
    noise = draw_noise(rng, slow=level in ("L0", "LP"))
    low, high = NOISE_RANGE[protocol.response]
    sigma = float(np.exp(rng.uniform(np.log(low), np.log(high))))
    world = World(robot, actual, {}, noise, sigma, curvature, protocol, [seed, int(rng.integers(2**31))], held_out)
    if not names:
        return world, names, {}
    context = _context(actual, protocol, curvature)
    world.effects = {name: RECIPES[name].draw(rng, context) for name in names}
    for values in world.effects.values():
        if not _knee_within(values, context):
            return None
        if values.get("full") == 0.0:
            values["full"] = _full_scale(world)
    if level == "L2":
        return _hide(rng, world, names)
    wanted = SIZES.get(level, (3.0, 40.0))
    target = float(np.exp(rng.uniform(np.log(wanted[0]), np.log(wanted[1]))))
    behind = target * rng.uniform(0.35, 0.9) if level == "L6" else float(rng.uniform(1.0, 4.0))
    if names[0] in ("doubled_rows", *SHOWN_BY_TENSION):
        # What does not touch the response is not scaled by it.
        sizes = _sizes(world, names)
        return (world, names, sizes) if sizes[names[0]] >= RECIPES[names[0]].floor else None
    found = _scale(world, names, target, wanted[0], behind)
    if found is None or level in ("L4", "L6", "L9"):
        return found
    world.twins = find_rivals(world, names[0])
    # L1 and L5 promise that the recording can tell; elsewhere a rival is part of the truth.
    return None if world.twins and level in ("L1", "L5") else found


def _knee_within(values: dict[str, object], context: Context) -> bool:
    """Return whether a knee that a data sheet gives lies inside the range, with enough of it on either side."""
    knees = {
        "knee_tension_n": context.tension,
        "knee_strain": context.curvature * strain_per_curvature(context.joint),
        "contact_curvature_per_m": context.curvature,
    }
    return all(0.3 < float(values[key]) / largest < 0.85 for key, largest in knees.items() if key in values)  # type: ignore[arg-type]


def _hide(rng: np.random.Generator, world: World, names: list[str]) -> tuple[World, list[str], dict[str, float]] | None:
    """Give a hidden effect a size that the recording which would reveal it shows clearly."""
    further = requested_protocol(rng, REVEALING[names[0]], world.protocol)
    revealed = replace(world, protocol=further)
    target = float(np.exp(rng.uniform(np.log(5), np.log(25))))
    if _scale(revealed, names, target, 3.5, 0.0) is None:
        return None
    world.effects, world.sigma = revealed.effects, revealed.sigma
    world.twins = find_rivals(world, names[0])
    return world, names, _sizes(world, names)


def find_rivals(world: World, name: str) -> tuple[str, ...]:
    """Other names that this recording, noise and colour considered, cannot well tell from the true one."""
    effects = {name: world.effects[name]}
    played = play_protocol(world.actual, world.protocol, effects, world.curvature, world.streams)
    train = played.rows.run != (-1 if world.held_out is None else world.held_out)
    data = Data(played.rows, played.time, played.response.mean(axis=1), train)
    colour = {"ar": float(world.noise["correlation"]), "drift": 0.6}.get(str(world.noise["kind"]), 0.0)  # type: ignore[arg-type]
    tension = world.protocol.has_tension
    return tuple(rivals(name, data, world.sigma, colour, tension=tension))


def _scale(
    world: World,
    names: list[str],
    target: float,
    least: float,
    second: float,
) -> tuple[World, list[str], dict[str, float]] | None:
    """Set noise level and amplitude so that the main effect stands `target` noise widths above the refitted base."""
    low, high = NOISE_RANGE[world.protocol.response]
    full = _full_scale(world)
    for _ in range(4):
        everything = world.effects
        world.effects = {names[0]: everything[names[0]]}
        size = _sizes(world, names[:1])[names[0]] * world.sigma
        world.effects = everything
        if not np.isfinite(size) or size <= 0:
            return None
        # An effect is a modest share of the range: a large multiple asks for a quiet camera, not a huge effect.
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
    if sizes[names[0]] < worst or (len(names) == 2 and not 0.55 * second < sizes[names[1]] < 1.8 * second):
        return None
    return world, names, sizes


def _full_scale(world: World) -> float:
    """Largest response of the base model, in the recording's unit."""
    return float(play_protocol(world.actual, world.protocol, {}, world.curvature, world.streams).response.max())


def _amplify(world: World, name: str, ratio: float) -> bool:
    """Scale an effect's amplitude within its physical limits; false when it did not move."""
    recipe, parameters = RECIPES[name], world.effects[name]
    key = recipe.amplitude
    neutral, before = NEUTRAL.get((name, key), NEUTRAL.get(key, 0.0)), float(parameters[key])  # type: ignore[arg-type]
    value = neutral + (before - neutral) * ratio
    low, high = recipe.limits
    if name == "thermal_drift":
        high = 0.4 if parameters["acts_on"] == "stiffness" else 20.0
    value = float(np.clip(value, low, high)) if neutral else float(np.sign(value) * np.clip(abs(value), low, high))
    parameters[key] = value
    return abs(value - before) > 0.02 * abs(before - neutral)


def _sizes(world: World, names: list[str]) -> dict[str, float]:
    """RMS of each effect that survives a refit of the base model, in noise widths."""
    played = play_protocol(world.actual, world.protocol, world.effects, world.curvature, world.streams)
    clean = play_protocol(world.actual, world.protocol, {}, world.curvature, world.streams).response
    if names[0] in SHOWN_BY_TENSION:
        return {names[0]: _tension_size(played)}
    if len(names) == 1:
        return {names[0]: surviving(played.rows, played.response) / world.sigma}
    out = {}
    for name in names:
        others = {key: value for key, value in world.effects.items() if key != name}
        without = play_protocol(world.actual, world.protocol, others, world.curvature, world.streams).response
        out[name] = surviving(played.rows, clean + played.response - without) / world.sigma
    return out


def _tension_size(played: Played) -> float:
    """RMS of the tension that the base model, refitted to the response, does not explain, in widths of its noise.

    A load cell's noise is about half a per cent of full scale.
    """
    best, _ = refit(played.rows, played.response)
    left = played.tension - base_tension(played.rows, best)
    return float(np.sqrt(np.mean(left**2)) / (0.005 * played.tension.max()))


def _actual(rng: np.random.Generator, robot: Robot, level: str) -> Robot:
    """Return the robot as it is: off its nominal numbers by calibration error, or (LP) by much more."""
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
            deadband = joint.deadband + rng.uniform(0.12, 0.5) * 1e-3 * (
                1 if joint.deadband < 0.6e-3 else rng.choice([-1, 1])
            )
    return replace(
        robot,
        joint=replace(joint, youngs_modulus=modulus, pulley_friction=friction, notch_friction=eta, deadband=deadband),
    )


def _largest_curvature(
    rng: np.random.Generator, actual: Robot, protocol: Protocol, names: Sequence[str], *, wrist: bool
) -> float:
    """Return a largest curvature (1/m) that keeps tendon strain and notch bend believable.

    Where a law has its knee where a data sheet puts it, the range reaches past the knee.
    """
    reach = next((RECIPES[name].reach for name in names if RECIPES[name].reach), None)
    if reach is not None:
        curvature = reach(rng, actual.joint)
        return curvature if wrist else min(curvature, 70.0, *(2.6 / plan.length for plan in protocol.runs))
    if wrist:
        return float(np.radians(rng.uniform(6, 22)) / actual.joint.middle.pitch)
    curvature = rng.uniform(10, 45)
    for plan in protocol.runs:
        alone = replace(protocol, runs=(plan,))
        curvature *= min(1.0, 0.013 / _tendon_strain(actual, alone, curvature))
        curvature = min(curvature, 2.3 / plan.length)
    return float(curvature)


def _tendon_strain(actual: Robot, protocol: Protocol, curvature: float) -> float:
    """Return the largest strain of the tendon over all runs, nought without a tendon."""
    if actual.joint.tendon_length == 0:
        return 0.0
    joints = [(actual.pair(plan.outer, plan.middle), plan.length) for plan in protocol.runs]
    return max(
        float(joint.stroke(np.array(curvature), length)[1]) * joint.tendon_compliance / joint.tendon_length
        for joint, length in joints
    )


def _context(actual: Robot, protocol: Protocol, curvature: float) -> Context:
    plans = protocol.runs
    joints = [actual.pair(plan.outer, plan.middle) for plan in plans]
    tops = [joint.stroke(np.array(curvature), plan.length) for joint, plan in zip(joints, plans, strict=True)]
    span = float(np.median([float(stroke) - joint.deadband for (stroke, _), joint in zip(tops, joints, strict=True)]))
    return Context(
        joints[0],
        actual,
        curvature,
        float(np.median([float(tension) for _, tension in tops])),
        max(span, 1e-6) * 1e3,
        float(np.median([plan.time[-1] for plan in plans])),
        protocol.dt,
        protocol.response == "bend",
        len(plans),
    )
