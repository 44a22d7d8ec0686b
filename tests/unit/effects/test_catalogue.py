"""What every effect owes, walked over the whole catalogue: identity at null, finite in its range, no energy made."""

from __future__ import annotations

from dataclasses import replace

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from coast_cli.effects.catalogue import CATALOGUE, build_effects, effects_of, in_order
from coast_cli.effects.effect import STAGES, Effect, History
from coast_cli.effects.forward import Layout, Tables, predict
from coast_cli.errors import BadInput
from coast_cli.mechanics.joint import Joint, Tendon, curvature_from_stroke
from coast_cli.mechanics.tube import NotchedTube

LAYOUT = Layout("curvature", 1, 120.0)
SAMPLES = 60


def _tube(name: str, outer: float, inner: float, depth: float, count: int) -> NotchedTube:
    return NotchedTube(
        name,
        outer * 1e-3,
        inner * 1e-3,
        np.full(count, depth * 1e-3),
        np.full(count, 3e-4),
        np.full(count, 3e-4),
        45e9,
        6450.0,
        0.0,
    )


@pytest.fixture(scope="module")
def joint() -> Joint:
    return Joint(
        _tube("OT4", 0.25, 0.2, 0.4, 188),
        _tube("MT1", 0.18, 0.14, 0.243, 125),
        Tendon(3.8e-5, 53.965e9, 0.38868),
        42.6e9,
        0.2965,
        np.pi,
        1.0063,
        1.2e-3,
    )


@pytest.fixture(scope="module")
def runs() -> list[History]:
    up, down = np.linspace(0.0, 4e-3, SAMPLES), np.linspace(4e-3, 0.0, SAMPLES)
    stroke = np.concatenate([up, down, up[: SAMPLES // 2]])
    time = 0.1 * np.arange(stroke.size)
    load = np.linspace(0.0, 1.0, stroke.size)
    return [
        History(time, stroke, None, np.full(stroke.size, length), run=number, load=load)
        for number, length in enumerate((0.02, 0.035))
    ]


def _middle_of_range(effect: type[Effect]) -> Effect:
    """An effect at a size that shows, from its own starts."""
    scales = {
        "": 1.0,
        "curvature": 40.0,
        "strain": 0.004,
        "stress": 170.0,
        "closure": 0.04,
        "tension": 1.6,
        "duration": 15.0,
        "response": 40.0,
        "stroke": 4.0,
        "period": 20.0,
        "compliance": 1.0,
        "runs": 2.0,
    }
    return effect(
        **{
            p.name: float(np.clip(p.starts[-1 if p.name == "level" else 0] * scales[p.relative_to], p.low, p.high))
            for p in effect.parameters
        }
    )


def _responses(joint: Joint, effects: list[Effect], runs: list[History]) -> np.ndarray:
    return np.concatenate([prediction.response[:, 0] for prediction in predict(joint, effects, runs, LAYOUT)])


@pytest.mark.parametrize("effect", effects_of("joint").values(), ids=effects_of("joint").keys())
class TestEveryEffect:
    def test_declares_itself(self, effect):
        assert effect.stage in STAGES
        assert effect.kind in ("physics", "sensor", "parameter")
        for text in (effect.title, effect.component, effect.equation, effect.source, effect.decided_by):
            assert len(text) > 3
        for parameter in effect.parameters:
            assert parameter.source
            assert parameter.low <= parameter.null <= parameter.high
            assert parameter.starts

    def test_null_is_the_identity(self, effect, joint, runs):
        np.testing.assert_array_equal(_responses(joint, [effect.null()], runs), _responses(joint, [], runs))

    def test_it_shows_at_its_starts(self, effect, joint, runs):
        if any(parameter.role == "found" for parameter in effect.parameters):
            return  # counted in the rows, which are then left out
        with_it, without = (predict(joint, effects, runs, LAYOUT) for effects in ([_middle_of_range(effect)], []))
        changes = [
            np.max(np.abs(one - other))
            for a, b in zip(with_it, without, strict=True)
            for one, other in ((a.response, b.response), (a.tension, b.tension))
        ]
        assert max(changes) > 1e-4

    def test_the_range_is_finite(self, effect, joint, runs):
        for end in ("low", "high"):
            for parameter in effect.parameters:
                extreme = replace(_middle_of_range(effect), **{parameter.name: getattr(parameter, end)})
                assert np.all(np.isfinite(_responses(joint, [extreme], runs))), parameter.name

    def test_no_loop_runs_backwards(self, effect, joint, runs):
        """Friction takes energy: at equal stroke the released segment is bent at least as far as the loading one."""
        if not effect.reverses:
            return
        for prediction in predict(joint, [_middle_of_range(effect)], runs, LAYOUT):
            load, release = prediction.response[:SAMPLES, 0], prediction.response[SAMPLES : 2 * SAMPLES, 0][::-1]
            assert np.all(release >= load - 1e-9)

    @settings(max_examples=15, deadline=None)
    @given(data=st.data())
    def test_any_value_in_range_answers(self, effect, joint, runs, data):
        values = [data.draw(st.floats(p.low, p.high)) for p in effect.parameters]
        response = _responses(joint, [effect.null().with_values(np.array(values))], runs[:1])
        assert np.all(np.isfinite(response))


def test_without_effects_it_is_the_paper_s_joint(joint, runs):
    for run, prediction in zip(runs, predict(joint, [], runs, LAYOUT), strict=True):
        closed = curvature_from_stroke(joint, run.stroke, run.bending_length)
        np.testing.assert_allclose(prediction.response[:, 0], closed.curvature, atol=1e-6)
        np.testing.assert_allclose(prediction.tension, closed.tension, atol=1e-8)


def test_the_order_of_listing_does_not_matter(joint, runs):
    effects = [_middle_of_range(effect) for effect in effects_of("joint").values()]
    np.testing.assert_array_equal(_responses(joint, effects[::-1], runs), _responses(joint, effects, runs))


def test_all_effects_compose(joint, runs):
    assert np.all(
        np.isfinite(_responses(joint, [_middle_of_range(effect) for effect in effects_of("joint").values()], runs))
    )


def test_tables_used_again_change_nothing(joint, runs):
    tables = Tables()
    capstan, play = CATALOGUE["capstan_hysteresis"](0.05), CATALOGUE["backlash"](0.1)
    stretchy = replace(joint, tendon=replace(joint.tendon, youngs_modulus=40e9), deadband=0.9e-3)
    for effects, of in (((capstan,), joint), ((capstan, play), stretchy), ((play,), joint), ((capstan,), stretchy)):
        for again, fresh in zip(
            predict(of, effects, runs, LAYOUT, tables), predict(of, effects, runs, LAYOUT), strict=True
        ):
            np.testing.assert_array_equal(again.response, fresh.response)
            np.testing.assert_array_equal(again.tension, fresh.tension)


def test_tables_that_are_given_up_in_the_middle_change_nothing(joint, monkeypatch):
    """Every length makes room for the next, so that new tables may stand where old ones stood."""
    monkeypatch.setattr(Tables, "_MOST", 1)
    stroke = np.linspace(1.5e-3, 3e-3, 20)
    runs = [History(None, stroke, None, np.full(20, length)) for length in np.tile(np.linspace(0.012, 0.036, 7), 3)]
    capstan = CATALOGUE["capstan_hysteresis"](0.05)
    for run, again in zip(runs, predict(joint, [capstan], runs, LAYOUT), strict=True):
        fresh = predict(joint, [capstan], [run], LAYOUT)[0]
        np.testing.assert_array_equal(again.response, fresh.response)


def test_a_shape_at_rest_that_drifts_ends_where_precurvature_stands(joint, runs):
    drift = CATALOGUE["thermal_drift"](rest_change_per_m=6.0, time_constant_s=1e-1)
    curved = CATALOGUE["precurvature"](6.0, 0.0)
    for late, still in zip(predict(joint, [drift], runs, LAYOUT), predict(joint, [curved], runs, LAYOUT), strict=True):
        np.testing.assert_allclose(late.response[20:], still.response[20:], atol=1e-6)
        np.testing.assert_allclose(late.tension[20:], still.tension[20:], atol=1e-8)


def test_slips_spread_along_the_path_round_the_corner_and_keep_the_branches(joint, runs):
    sharp, rounded = (
        predict(joint, [CATALOGUE["capstan_hysteresis"](0.05, 0.0, spread)], runs, LAYOUT)[0].response[:, 0]
        for spread in (0.0, 0.8)
    )
    np.testing.assert_allclose(rounded[:SAMPLES], sharp[:SAMPLES], atol=1e-9)
    low = slice(2 * SAMPLES - 12, 2 * SAMPLES)
    np.testing.assert_allclose(rounded[low], sharp[low], atol=0.02 * sharp.max())
    after = slice(SAMPLES, SAMPLES + 12)
    assert np.max(np.abs(np.diff(rounded[after], 2))) < 0.7 * np.max(np.abs(np.diff(sharp[after], 2)))


def test_a_sliding_bending_length_is_interpolated(joint):
    stroke = np.linspace(1.5e-3, 3e-3, 80)
    length = np.linspace(0.015, 0.035, 80)
    prediction = predict(joint, [], [History(None, stroke, None, length)], LAYOUT)[0]
    exact = curvature_from_stroke(joint, stroke, length).curvature
    np.testing.assert_allclose(prediction.response[:, 0], exact, rtol=5e-3)


@pytest.mark.parametrize(
    ("corrections", "words"),
    [
        ({"backslash": {"width_mm": 0.1}}, "backlash"),
        ({"backlash": {"widht_mm": 0.1}}, "width_mm"),
        ({"backlash": {"width_mm": -1.0}}, "0 to 50"),
    ],
)
def test_wrong_corrections_are_refused(corrections, words):
    with pytest.raises(BadInput, match=words):
        build_effects(corrections)


def test_corrections_come_back_in_order():
    effects = build_effects({"camera_offset": {"offset": 0.1}, "backlash": {"width_mm": 0.2}})
    assert [effect.id for effect in effects] == ["backlash", "camera_offset"]
    assert in_order(effects[::-1]) == effects


def test_a_recorded_load_is_a_force_at_the_tip(joint, runs):
    loaded = [replace(run, tip_force=np.full(run.stroke.size, 2e-3)) for run in runs]
    named = predict(joint, [CATALOGUE["tip_load"](force_mn=2.0)], runs, LAYOUT)
    for known, fitted in zip(predict(joint, [], loaded, LAYOUT), named, strict=True):
        assert known.response == pytest.approx(fitted.response)
    rising = [replace(run, tip_force=np.linspace(0.0, 2e-3, run.stroke.size)) for run in runs]
    for some, none, whole in zip(
        predict(joint, [], rising, LAYOUT), predict(joint, [], runs, LAYOUT), named, strict=True
    ):
        assert some.response[0] == pytest.approx(none.response[0])
        assert some.response[-1] == pytest.approx(whole.response[-1])
