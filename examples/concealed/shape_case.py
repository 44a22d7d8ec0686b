"""Concealed shapes: photographs of single tubes and assembled pairs under their weight, with one thing left out.

The base that a user can calibrate is one modulus for all tubes and the natural curvature of each; an effect is
level L1 when what survives that calibration, and the tip's movement, stand clear of the noise of the points. A pair
is the composite beam.
"""

from __future__ import annotations

from collections.abc import Iterable
from dataclasses import replace

import numpy as np

from examples.concealed.case import Case
from examples.concealed.design import Joint, Robot, Tube, config_text
from examples.concealed.shape_recipes import (
    SHAPE_EFFECTS,
    SHAPE_HIDING,
    SHAPE_NEUTRAL,
    SHAPE_OUTSIDE,
    SHAPE_RECIPES,
    SHAPE_SENSOR,
    has_pairs,
    single_tubes,
    tube_count,
)
from examples.concealed.shape_scene import Array, Scene, ShapeRun, photograph, tubes_of

SHAPE_LEVELS = {"L0": 0.25, "LP": 0.07, "L1": 0.42, "L2": 0.08, "L3": 0.06, "L5": 0.03, "L6": 0.09}
_DRAWN_FROM: dict[str, Iterable[str]] = {"L2": SHAPE_HIDING, "L5": SHAPE_SENSOR, "L6": SHAPE_OUTSIDE}


def draw_stock(rng: np.random.Generator) -> Robot:
    """Outer and middle tubes in stock, soft enough to sag visibly and stiff enough not to hang."""
    mm = 1e-3
    od = round(rng.uniform(0.32, 0.44), 2)
    inner = round(od - 2 * round(rng.uniform(0.035, 0.05), 3), 3)
    out_id = round(od + rng.uniform(0.03, 0.06), 3)
    out_od = round(out_id + rng.uniform(0.08, 0.12), 3)
    cut, uncut = 0.3, round(float(rng.choice([0.2, 0.3, 0.4])), 3)
    mixed = rng.random() < 0.5
    total = rng.uniform(60, 110)

    def tube(name: str, diameter: float, bore: float) -> Tube:
        c, u = (
            (round(float(rng.choice([0.2, 0.3, 0.4, 0.6])), 3), round(float(rng.choice([0.2, 0.3, 0.5])), 3))
            if mixed
            else (cut, uncut)
        )
        return Tube(
            name,
            diameter * mm,
            bore * mm,
            round(diameter * rng.uniform(0.60, 0.80), 3) * mm,
            c * mm,
            u * mm,
            max(int(total / (c + u)), 20),
            round(float(rng.uniform(0.8, 11.0)), 1),
        )

    outers = tuple(tube(f"OT{i + 1}", out_od, out_id) for i in range(int(rng.integers(2, 5))))
    middles = tuple(tube(f"MT{i + 1}", od, inner) for i in range(int(rng.integers(1, 4))))
    joint = Joint(
        outers[0],
        middles[0],
        round(rng.uniform(38, 65), 1) * 1e9,
        0.2965,
        round(np.pi, 6),
        1.0063,
        1.2e-3,
        0.038e-3,
        53.965e9,
        0.38868,
    )
    return Robot(outers, middles, joint, (round(inner * 0.8, 3) * mm, round(inner * 0.5, 3) * mm))


def draw_runs(rng: np.random.Generator, robot: Robot) -> tuple[ShapeRun, ...]:
    """Which tubes are photographed, which way up, with how many points."""
    stock: list[tuple[int | None, int | None]] = [(i, None) for i in range(len(robot.outers))] + [
        (None, i) for i in range(len(robot.middles))
    ]
    style = str(rng.choice(["one", "flips", "stock", "stock_flips", "pair"], p=[0.12, 0.3, 0.2, 0.2, 0.18]))
    count = int(np.exp(rng.uniform(np.log(40), np.log(300))))

    def points() -> Array:
        grid = np.linspace(0, 1, count)
        grid[1:-1] += rng.uniform(-0.3, 0.3, count - 2) / count
        return grid

    def one(outer: int | None, middle: int | None, *, up: bool) -> ShapeRun:
        return ShapeRun(outer, middle, up, points())

    order = [stock[i] for i in rng.permutation(len(stock))]
    if style == "pair":
        matching = [
            (i, j)
            for i, o in enumerate(robot.outers)
            for j, m in enumerate(robot.middles)
            if (o.cut, o.uncut, o.count) == (m.cut, m.uncut, m.count)
        ]
        if matching:
            pair = matching[int(rng.integers(len(matching)))]
            runs = [one(*pair, up=True)] + ([one(*pair, up=False)] if rng.random() < 0.7 else [one(*pair, up=True)])
            if rng.random() < 0.6:
                runs += [one(pair[0], None, up=True), one(None, pair[1], up=False)]
            return tuple(runs)
        style = "flips"
    if style == "one":
        up = bool(rng.random() < 0.5)
        return tuple(one(*order[0], up=up) for _ in range(int(rng.integers(1, 3))))
    if style == "flips":
        return tuple(one(*order[0], up=up) for _ in range(int(rng.integers(1, 3))) for up in (True, False))
    chosen = order[: int(rng.integers(3, 6))]
    if style == "stock":
        return tuple(one(*which, up=which[1] is None) for which in chosen)
    return tuple(one(*which, up=up) for which in chosen for up in (True, False))


def make_shape_case(seed: int, level: str | None = None, effect: str | None = None) -> Case:
    """Return the shape case of a seed; `level` and `effect` restrict what is drawn."""
    rng = np.random.default_rng([seed, 70823])
    if level is None:
        level = (
            "L1"
            if effect in SHAPE_EFFECTS
            else "L5"
            if effect in SHAPE_SENSOR
            else "L6"
            if effect in SHAPE_OUTSIDE
            else str(rng.choice(list(SHAPE_LEVELS), p=list(SHAPE_LEVELS.values())))
        )
    for attempt in range(60):
        try:
            case = _try_shape(np.random.default_rng([seed, 91, attempt]), seed, level, effect)
        except ArithmeticError:
            continue
        if case is not None:
            return case
    raise RuntimeError(f"seed {seed}: no shapes show {effect} at {level}")


def _try_shape(rng: np.random.Generator, seed: int, level: str, effect: str | None) -> Case | None:
    names = [] if level in ("L0", "LP") else [effect or str(rng.choice(list(_DRAWN_FROM.get(level, SHAPE_EFFECTS))))]
    donor = names[0] if names else str(rng.choice(list(SHAPE_EFFECTS)))
    recipe = SHAPE_RECIPES.get(donor)
    for _ in range(200):
        robot = draw_stock(rng)
        runs = draw_runs(rng, robot)
        alone = single_tubes(runs) and tube_count(runs) == 1
        if alone if level == "L2" else recipe is not None and recipe.needs(runs):
            break
    else:
        return None
    modulus = robot.joint.youngs_modulus * (1 + float(np.clip(rng.normal(0, 0.02), -0.06, 0.06)))
    tubes = [*robot.outers, *robot.middles]
    natural = {
        tube.name: tube.natural_curvature * (1 + float(np.clip(rng.normal(0, 0.01), -0.03, 0.03))) for tube in tubes
    }
    if has_pairs(runs) or rng.random() < 0.2:
        modulus, natural = robot.joint.youngs_modulus, {tube.name: tube.natural_curvature for tube in tubes}
    if level == "LP":
        modulus = robot.joint.youngs_modulus * float(rng.choice([rng.uniform(0.6, 0.85), rng.uniform(1.15, 1.4)]))
    parameters = (
        {}
        if not names
        else {
            names[0]: SHAPE_RECIPES[names[0]].draw(rng)
            if names[0] in SHAPE_RECIPES
            else {"in_plane": float(rng.uniform(0.5, 0.9))}
        }
    )
    clean = Scene(robot, runs, modulus, natural, {})
    base = [photograph(clean, run) for run in runs]
    if max(float(np.abs(points).max()) for points in base) < 1.0:
        return None
    scene = replace(clean, effects=parameters)
    sigma = float(np.exp(rng.uniform(np.log(0.01), np.log(0.15))))
    size: dict[str, float] = {}
    if names:
        wanted = (
            float(np.exp(rng.uniform(np.log(0.15), np.log(0.7))))
            if level == "L3"
            else float(np.exp(rng.uniform(np.log(1.2), np.log(15))))
        )
        scaled = _scale_shape(scene, base, names[0], wanted, sigma, level)
        if scaled is None:
            return None
        scene, sigma, size = scaled
    return _record(rng, seed, level, names, scene, base, sigma, size)


def _survives(scene: Scene, shapes: list[Array]) -> float:
    """RMS distance (mm) left when modulus and natural curvatures are refitted to noiseless shapes.

    Pairs refit the modulus.
    """
    from scipy.optimize import least_squares

    names = (
        sorted({tube.name for run in scene.runs for tube in tubes_of(scene.robot, run)})
        if not has_pairs(scene.runs)
        else []
    )
    target = np.concatenate(shapes)

    def residual(x: Array) -> Array:
        natural = dict(scene.natural) | {
            name: scene.natural[name] + 0.5 * step for name, step in zip(names, x[1:], strict=True)
        }
        trial = replace(scene, effects={}, modulus=scene.modulus * float(np.exp(np.clip(x[0], -2, 2))), natural=natural)
        return (np.concatenate([photograph(trial, run) for run in scene.runs]) - target).ravel()

    fit = least_squares(residual, np.zeros(1 + len(names)), max_nfev=8, diff_step=1e-4)
    return float(np.sqrt(2 * np.mean(fit.fun**2)))


def _scale_shape(
    scene: Scene, base: list[Array], name: str, wanted: float, sigma: float, level: str
) -> tuple[Scene, float, dict[str, float]] | None:
    """Bring what survives calibration to `wanted` noise widths: by amplitude, then by noise."""
    for _ in range(3):
        shapes = [photograph(scene, run) for run in scene.runs]
        left = _survives(scene, shapes)
        if level == "L2" or left <= 0:
            break
        sigma = float(np.clip(min(sigma, 3.0 / wanted), 0.008, 0.2))
        ratio = wanted * sigma / left
        if 0.85 < ratio < 1.15:
            break
        recipe = SHAPE_RECIPES[name]
        values = dict(scene.effects[name])
        neutral = (
            SHAPE_NEUTRAL.get(recipe.amplitude, 0.0) if name in ("camera_scale", "local_stiffness_defect") else 0.0
        )
        low, high = recipe.limits
        before = values[recipe.amplitude]
        value = neutral + (before - neutral) * ratio
        if name == "local_stiffness_defect" and before > 1:
            value = before
        value = (
            float(np.clip(value, low, max(high, before)))
            if neutral
            else float(np.sign(value) * np.clip(abs(value), low, high))
        )
        if abs(value - before) < 0.02 * abs(before - neutral):
            sigma = float(np.clip(left / wanted, 0.008, 0.2))
            break
        values[recipe.amplitude] = value
        scene = replace(scene, effects={name: values})
    shapes = [photograph(scene, run) for run in scene.runs]
    left = _survives(scene, shapes)
    tip = max(float(np.hypot(*(a[-1] - b[-1]))) for a, b in zip(shapes, base, strict=True))
    if level not in ("L2", "L3") and (left < 1.0 * sigma or tip < 3 * sigma):
        return None
    return scene, sigma, {"noise_widths": left / sigma, "tip_noise_widths": tip / sigma}


def _record(
    rng: np.random.Generator,
    seed: int,
    level: str,
    names: list[str],
    scene: Scene,
    base: list[Array],
    sigma: float,
    size: dict[str, float],
) -> Case:
    robot, runs = scene.robot, scene.runs
    truth = [photograph(scene, run) for run in runs] if names else base
    correlation = float(rng.choice([0.0, 0.0, rng.uniform(0.3, 0.8)]))
    phase, turns, size_misfit = rng.uniform(0, 2 * np.pi), rng.uniform(0.5, 1.5), sigma * rng.uniform(0.03, 0.15)
    labels = [f"s{i + 1}" for i in range(len(runs))]
    flips = any(run.up != (run.middle is None or run.outer is not None) for run in runs) or rng.random() < 0.6
    single: list[str] = []
    paired: list[str] = []
    sealed_points = {}
    for label, run, exact in zip(labels, runs, truth, strict=True):
        points = (
            exact
            + (size_misfit * np.sin(2 * np.pi * turns * run.points + phase))[:, None]
            * np.array([0.2, 1.0])
            * run.points[:, None]
        )
        sealed_points[label] = np.round(points, 6).tolist()
        unit = rng.standard_normal(points.shape)
        for k in range(1, len(unit)):
            unit[k] = correlation * unit[k - 1] + np.sqrt(1 - correlation**2) * unit[k]
        seen = points + sigma * unit * np.minimum(run.points * 20, 1.0)[:, None]
        side = [("up" if run.up else "down")] if flips else []
        who = [tube.name for tube in tubes_of(robot, run)]
        (paired if len(who) == 2 else single).extend(
            ",".join([label, *who, *side, f"{x:.4f}", f"{y:.4f}"]) for x, y in seen
        )
    tail = (["natural"] if flips else []) + ["x_mm", "y_mm"]
    files = {}
    for name, columns, rows in (
        ("shapes.csv", ["run", "tube"], single),
        ("shapes_of_pairs.csv", ["run", "outer", "middle"], paired),
    ):
        if rows:
            files[name] = "\n".join([",".join([*columns, *tail]), *rows]) + "\n"
    recipe = SHAPE_RECIPES.get(names[0]) if names else None
    sealed: dict[str, object] = {
        "level": level,
        "seed": seed,
        "kind": "shape",
        "effects": [
            {
                "id": name,
                "kind": recipe.kind if recipe else "physics",
                "component": recipe.component if recipe else "environment",
                **size,
                "parameters": scene.effects[name],
            }
            for name in names
        ],
        "twins": list(SHAPE_HIDING.get(names[0], ())) if names and level == "L2" else [],
        "near": list(recipe.near) if recipe else [],
        "identifiable": level not in ("L2", "L3"),
        "where": _where(scene, names),
        "noise": {"sigma": sigma, "kind": "ar" if correlation else "white", "correlation": correlation},
        "unit": "shape_mm",
        "parameters": {"youngs_modulus_gpa": scene.modulus / 1e9, "natural_curvature_per_m": dict(scene.natural)},
        "configured": {"youngs_modulus_gpa": robot.joint.youngs_modulus / 1e9},
        "response": sealed_points,
    }
    # A photograph can be spared where the same tube lies the other way up in another one, or was taken twice.
    tubes = [(run.outer, run.middle) for run in runs]
    spare = [label for label, which in zip(labels, tubes, strict=True) if tubes.count(which) > 1]
    held_out = (spare[int(rng.integers(len(spare)))],) if len(runs) >= 3 and spare else ()
    return Case(config_text(robot), files, sealed, held_out)


def _where(scene: Scene, names: list[str]) -> list[dict[str, object]]:
    if not names or names[0] in SHAPE_OUTSIDE:
        return []
    values = scene.effects[names[0]]
    tube = tubes_of(scene.robot, scene.runs[0])[0]
    if names[0] == "local_stiffness_defect":
        cell = int(values["at_share"] * tube.count)
        low = cell * tube.pitch * 1e3
        return [
            {
                "axis": "arc_length",
                "value": None,
                "low": low,
                "high": low + values.get("pitches", 1.0) * tube.pitch * 1e3,
            }
        ]
    if names[0] in ("notch_depth_error", "precurvature_gradient"):
        return [{"axis": "run", "value": tube.name, "low": None, "high": None}]
    return [{"axis": "arc_length", "value": None, "low": None, "high": None}]
