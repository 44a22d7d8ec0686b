"""What every effect of shapes owes: it declares itself, its null changes nothing, its whole range answers, it shows."""

from __future__ import annotations

from types import SimpleNamespace

import numpy as np
import pytest

from coast_cli.diagnosis.shapes.build import build_shape_problem
from coast_cli.diagnosis.shapes.problem import ShapeProblem
from coast_cli.effects.catalogue import CATALOGUE, build_effects, effects_of, in_order
from coast_cli.effects.corrections import correction_parameters
from coast_cli.effects.effect import declared
from coast_cli.effects.shape_stages import TUBE, OnShapes
from coast_cli.errors import BadInput
from coast_cli.recordings.model import ShapeRun
from coast_cli.spec.load import load_config_text

CONFIG = """
version = 1
[materials.nitinol]
youngs_modulus_gpa = 45.0
density_kg_per_m3 = 6450.0
[outer]
material = "nitinol"
outer_diameter_mm = 0.5
inner_diameter_mm = 0.4
notch = { cut_mm = 0.3, uncut_mm = 0.3, count = 90 }
samples = [{ name = "O", depth_mm = 0.35, natural_curvature_per_m = 3.0 }]
[middle]
material = "nitinol"
outer_diameter_mm = 0.36
inner_diameter_mm = 0.28
notch = { cut_mm = 0.3, uncut_mm = 0.3, count = 90 }
samples = [{ name = "M", depth_mm = 0.26, natural_curvature_per_m = 6.0 }]
"""


def residual(problem, *effects):
    """Return the residual of the configured model with effects, m."""
    return problem.residuals([(problem.configured(), effects)])[0]


def _run(name: str, outer: str | None, middle: str | None) -> ShapeRun:
    x = np.linspace(0.0, 54e-3, 60)
    return ShapeRun(name, "shapes.csv", np.arange(60), outer, middle, x, 1e-3 * np.sin(x / 0.05), "up")


@pytest.fixture(scope="module")
def problem() -> ShapeProblem:
    runs = [_run("o", "O", None), _run("m", None, "M"), _run("p", "O", "M")]
    return build_shape_problem(load_config_text(CONFIG, "tubes.toml"), runs)


@pytest.fixture(params=effects_of("shapes").values(), ids=effects_of("shapes").keys())
def effect(request) -> type[OnShapes]:
    return request.param


def test_it_declares_itself(effect):
    said = declared(effect, "shapes")
    for text in (said.title, effect.component, said.equation, said.source, said.decided_by):
        assert len(text) > 3
    assert effect.kind in ("physics", "sensor", "parameter")
    for parameter in said.parameters:
        assert parameter.low <= parameter.null <= parameter.high
        assert parameter.source
    assert all(p.expected is None for p in said.parameters if p not in effect.fitted())


def test_its_null_changes_nothing(problem, effect):
    clean = residual(problem)
    homogenised = 2e-7 if effect.is_local else 1e-9  # a local effect is solved notch by notch, the rest is not
    assert residual(problem, effect.null()) == pytest.approx(clean, abs=homogenised)


def test_its_whole_range_answers(problem, effect):
    random = np.random.default_rng(5)
    for _ in range(8):
        share = random.uniform(size=len(effect.fitted()))
        values = np.array([p.low + s * (p.high - p.low) for p, s in zip(effect.fitted(), share, strict=True)])
        assert np.all(np.isfinite(residual(problem, effect.null().with_fitted(values))))


def test_its_starts_show_and_lie_in_range(problem, effect):
    clean = residual(problem)
    starts = effect.starts(problem.scene)
    assert starts
    for parameter in effect.parameters_on("shapes"):
        assert all(parameter.low <= getattr(start, parameter.name) <= parameter.high for start in starts)
    assert max(np.max(np.abs(residual(problem, start) - clean)) for start in starts[:6]) > 1e-7
    assert np.all(effect.widths(problem.scene) > 0.0)


def test_what_sits_on_one_tube_leaves_the_others(problem):
    tilted = [e for e in effects_of("shapes").values() if TUBE in e.parameters_on("shapes")]
    assert len(tilted) == 5
    for effect in tilted:
        start = next(s for s in effect.starts(problem.scene) if s.tube == 2.0)
        changed = residual(problem, start) != residual(problem)
        assert [index for index, rows in enumerate(problem.slices) if changed[rows].any()] == [1, 2]


def test_a_tip_force_has_the_sign_that_it_has_on_a_joint(problem):
    """Positive bends towards positive curvature: a tip that is pulled up, and a joint that bends more."""
    state = problem.state(problem.configured(), ())
    pulled = problem.state(problem.configured(), (CATALOGUE["tip_load"](force_mn=0.05),))
    free, lifted = problem.forward.lines([(0, state), (0, pulled)])
    assert lifted.y[0, -1] > free.y[0, -1]
    segment = SimpleNamespace(bending_length=0.03, position=None)
    moment = CATALOGUE["tip_load"](force_mn=0.05).moment(np.zeros(1), np.full(1, 10.0), 1, segment)
    assert moment[0] < 0.0  # less is left for the tendon to give


def test_effects_act_in_one_order():
    some = [CATALOGUE[name].null() for name in ("camera_scale", "base_tilt", "notch_depth_error")]
    assert [effect.id for effect in in_order(some)] == ["notch_depth_error", "base_tilt", "camera_scale"]


def test_a_corrections_table_serves_joints_and_shapes():
    table = {"base_tilt": {"angle_deg": 2.0}, "backlash": {"width_mm": 0.2}, "gravity": {"in_plane_share": 0.9}}
    assert [effect.id for effect in build_effects(table)] == ["backlash"]
    assert [effect.id for effect in build_effects(table, "shapes")] == ["base_tilt", "gravity"]
    assert {"base_tilt", "backlash"} <= set(correction_parameters(CATALOGUE))


@pytest.mark.parametrize(
    "table", [{"base_tild": {"angle_deg": 1.0}}, {"base_tilt": {"angle": 1.0}}, {"base_tilt": {"angle_deg": 99.0}}]
)
def test_a_wrong_correction_is_refused(table):
    with pytest.raises(BadInput):
        build_effects(table)
