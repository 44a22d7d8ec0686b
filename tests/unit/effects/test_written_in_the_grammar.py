"""Every effect that a joint shows can be written in the grammar: laws fitted to its prediction reproduce it, without noise.

Base parameters (modulus, dead band) are free, as in a diagnosis. What is left is told as a share of what the effect changes.
"""

from dataclasses import replace

import numpy as np
import pytest

from coast_cli.diagnosis.joint.problem import with_base
from coast_cli.effects.catalogue import effects_of
from coast_cli.effects.effect import History
from coast_cli.effects.forward import Layout, predict
from coast_cli.effects.unnamed import UnnamedLaw, remember, variable_of
from coast_cli.spec.build import build_joint
from coast_cli.spec.load import REFERENCE, load_config

JOINT = build_joint(load_config(REFERENCE), "OT4", "MT1")
KNOWN = effects_of("joint")
LAYOUT = Layout("curvature", 1, 120.0)
LEGS = ((0.0, 3.6e-3, 36), (3.6e-3, 3.6e-3, 10), (3.6e-3, 1.8e-3, 18), (1.8e-3, 3.0e-3, 12), (3.0e-3, 0.2e-3, 28))
FULL = ((0.0, 3.6e-3, 40), (3.6e-3, 0.2e-3, 40))


def run(length, step, number, legs=LEGS):
    stroke = np.concatenate([np.linspace(a, b, n, endpoint=False) for a, b, n in legs])
    time, lengths = 400.0 * number + step * np.arange(stroke.size), np.full(stroke.size, length)
    blank = History(time, stroke, None, lengths, run=number)
    return replace(blank, load=predict(JOINT, [], [blank], LAYOUT)[0].tension)


BOTH = (run(0.035, 1.0, 0), run(0.022, 0.3, 1))
ONE = BOTH[:1]
# Release from another height follows a path of its own, which the grammar has no cell for: one loop is written.
LOOP = (run(0.022, 1.0, 0, FULL),)
WORDS = {
    "k": ("structure", "curvature", "none", 8),
    "k3": ("structure", "curvature", "none", 3),
    "kf": ("structure", "curvature", "friction", 3),
    "kr": ("structure", "curvature", "relaxation", 2),
    "kl": ("structure", "bending_length", "none", 2),
    "v": ("structure", "rate", "none", 3),
    "t": ("transmission", "curvature", "none", 3),
    "tf": ("transmission", "curvature", "friction", 3),
    "tt": ("transmission", "time", "none", 5),
    "st": ("structure", "time", "none", 5),
    "xf": ("drive", "stroke", "friction", 1),
    "xp": ("drive", "stroke", "period", 2),
    "xs": ("drive", "time", "step", 1),
    "x": ("drive", "stroke", "none", 5),
    "f": ("tendon", "tension", "none", 8),
    "f3": ("tendon", "tension", "none", 3),
    "fm": ("tendon", "tension", "maximum", 3),
    "fr": ("tendon", "tension", "relaxation", 2),
    "s": ("sensor", "curvature", "none", 8),
    "sr": ("sensor", "curvature", "relaxation", 1),
    "sp": ("sensor", "time", "period", 2),
    "sc": ("sensor", "run", "none", 2),
    "c": ("load_cell", "tension", "none", 2),
}
# Values, laws, their setting, runs, and the share of the change (of response and tension) that may be left.
WRITTEN = {
    "leadscrew_pitch_error": ({"sine_mm": 0.05, "cosine_mm": 0.02}, "xp", 0.635e-3, BOTH, 0.005),
    "backlash": ({"width_mm": 0.2}, "xf", 0.0, BOTH, 0.005),
    "bending_length_offset": ({"offset_mm": 2.0}, "x t kl", 0.0, BOTH, 0.005),
    "bending_length_label": ({"run": 0.0, "error_mm": 4.0}, "x t", 0.0, ONE, 0.005),
    "lost_steps": ({"lost_mm": 0.3, "time_s": 60.5}, "xs", 60.5, ONE, 0.01),
    "transmission_compliance": ({"compliance_mm": 0.1}, "f", 0.0, BOTH, 0.005),
    "tendon_superelasticity": ({"knee_n": 1.0, "extra_compliance": 1.0, "knee_width": 0.2}, "f", 0.0, BOTH, 0.005),
    "tendon_creep": ({"fraction": 0.2, "time_constant_s": 15.0}, "fr f3", 15.0, BOTH, 0.005),
    "tendon_permanent_set": ({"slack_mm_per_n": 0.1}, "fm", 1.0, BOTH, 0.005),
    "capstan_hysteresis": ({"pulley_friction": 0.05}, "tf t", 0.0, BOTH, 0.005),
    "distributed_notch_friction": ({"coefficient": 0.2}, "t tf", 0.0, ONE, 0.12),
    "chord_section": ({"share": 0.5}, "k3", 0.0, BOTH, 0.005),
    "notch_end_effect": ({"table_share": 1.0}, "k3", 0.0, BOTH, 0.005),
    "precurvature": ({"curvature_per_m": 4.0}, "k3", 0.0, BOTH, 0.005),
    "tip_load": ({"force_mn": 2.0}, "k3 kl", 0.0, BOTH, 0.06),
    "gravity": ({"share": 0.8}, "k3 kl", 0.0, BOTH, 0.05),
    "tube_superelasticity": ({"knee_strain": 0.004, "stiffness_lost": 0.5, "knee_width": 0.15}, "k", 0.0, BOTH, 0.01),
    "tube_hysteresis": (
        {"upper_plateau_mpa": 120.0, "lower_plateau_mpa": 40.0, "stiffness_lost": 0.6},
        "k kf",
        0.0,
        LOOP,
        0.05,
    ),
    "notch_closure": ({"closure_ratio": 0.03, "added_stiffness": 2.0}, "k", 0.0, BOTH, 0.03),
    "snap_through": ({"curvature_per_m": 12.0, "drop": 0.1, "sharpness": 0.4, "back": 0.9}, "k kf", 0.0, BOTH, 0.2),
    "coulomb_friction": ({"holds_per_m": 1.0}, "kf", 0.0, BOTH, 0.005),
    "viscous_friction": ({"time_constant_s": 2.0}, "kr v", 2.0, BOTH, 0.25),
    "thermal_drift": ({"stiffness_change": 0.2, "time_constant_s": 60.0}, "tt st", 0.0, ONE, 0.005),
    "sensor_lag": ({"time_constant_s": 1.5}, "sr", 1.5, BOTH, 0.005),
    "camera_scale": ({"scale": 1.1}, "s", 0.0, BOTH, 0.005),
    "camera_offset": ({"offset": 2.0}, "s", 0.0, BOTH, 0.005),
    "periodic_disturbance": ({"sine": 0.5, "cosine": 0.2, "period_s": 7.0}, "sp", 7.0, BOTH, 0.005),
    "run_differs": ({"run": 1.0, "offset": 1.0}, "sc", 0.0, BOTH, 0.005),
    "camera_saturation": ({"level": 20.0}, "s", 0.0, BOTH, 0.05),
    "frozen_frames": ({"fraction": 0.1}, "s", 0.0, BOTH, 0.005),
    "load_cell_scale": ({"scale": 1.1}, "c", 0.0, BOTH, 0.005),
    "load_cell_offset": ({"offset_n": 0.1}, "c", 0.0, BOTH, 0.005),
}
SCALES = {"drive": 0.1, "tendon": 0.1, "transmission": 0.05, "structure": 1.0, "sensor": 1.0, "load_cell": 0.1}
STEP, ROUNDS = 1e-2, 25


def planted(identifier, values):
    kind = KNOWN[identifier]
    return kind(**{**{p.name: p.null for p in kind.parameters}, **values})


def seen(effects, runs, what, base=(0.0, 0.0)):
    joint = with_base(JOINT, {"youngs_modulus_gpa": 42.6 * np.exp(base[0]), "deadband_mm": 1.2 + base[1]})
    found = predict(joint, effects, list(runs), LAYOUT)
    return np.concatenate([one.tension if what == "load_cell" else one.response[:, 0] for one in found])


def laws_of(words, setting, runs):
    """Laws with a small amplitude each, over the range that the base model reaches."""
    plain = predict(JOINT, [], list(runs), LAYOUT)
    laws = []
    for number, word in enumerate(words.split(), start=1):
        place, variable, memory, count = WORDS[word]
        kept = setting if memory in ("relaxation", "period", "step", "maximum") else 5e-5
        parts = []
        for history, one in zip(runs, plain, strict=True):
            series = variable_of(variable, history, one.tension, one.response[:, 0], memory)
            parts.append(remember(series, history, memory, kept))
        reached = np.concatenate(parts)
        low, high = float(reached.min()), float(1.05 * reached.max() + 1e-12)
        weights = [0.2 * SCALES[place]] + [0.0] * (count - 1)
        laws.append(UnnamedLaw(place, variable, memory, kept, low, high, tuple(weights), number=number))
    return laws


def closest(target, laws, runs, what):
    """Base parameters and amplitudes by Levenberg and Marquardt; returns what is left, RMS."""
    sizes = np.array([0.01, 0.01] + [SCALES[law.place] for law in laws for _ in law.weights])
    edges = 2 + np.cumsum([0] + [len(law.weights) for law in laws])

    def left(vector):
        values = vector * sizes
        made = [
            law.with_values(np.array([*values[a:b], *law.values()[len(law.weights) :]]))
            for law, a, b in zip(laws, edges, edges[1:], strict=False)
        ]
        return target - seen(made, runs, what, values[:2])

    vector = np.array([0.0, 0.0] + [w / SCALES[law.place] for law in laws for w in law.weights])
    residual, damping = left(vector), 1e-3
    for _ in range(ROUNDS):
        columns = [(left(vector + STEP * unit) - residual) / STEP for unit in np.eye(vector.size)]
        jacobian = -np.stack(columns, axis=1)
        for _ in range(4):
            square = jacobian.T @ jacobian
            square += damping * np.diag(np.diag(square) + 1e-9)
            tried = vector + np.linalg.lstsq(square, jacobian.T @ residual, rcond=None)[0]
            after = left(tried)
            if after @ after < residual @ residual:
                better = (after @ after) < 0.998 * (residual @ residual)
                vector, residual, damping = tried, after, 0.2 * damping
                break
            damping *= 10.0
        else:
            break
        if not better:
            break
    return float(np.sqrt(np.mean(residual**2)))


def test_every_effect_is_written():
    assert set(WRITTEN) == set(KNOWN)


@pytest.mark.parametrize("identifier", WRITTEN)
def test_an_effect_of_the_catalogue_is_a_law_of_the_grammar(identifier):
    values, words, setting, runs, share = WRITTEN[identifier]
    what = "load_cell" if words == "c" else "response"
    target = seen([planted(identifier, values)], runs, what)
    change = float(np.sqrt(np.mean((target - seen([], runs, what)) ** 2)))
    left = closest(target, laws_of(words, setting, runs), runs, what)
    assert left <= share * max(change, 1e-3)
