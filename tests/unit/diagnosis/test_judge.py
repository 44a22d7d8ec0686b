"""Every rule of the judge by itself, and that the rules begin again when the leading set was replaced."""

from types import SimpleNamespace

import pytest

from coast_cli.diagnosis.joint.case import excess
from coast_cli.diagnosis.joint.rules import (
    JOINT_RULES,
    names_explain,
    what_does_not_carry_over_is_dropped,
    what_is_redundant_is_dropped,
)
from coast_cli.diagnosis.judge import (
    Leftover,
    Ruling,
    effects_are_named,
    first_effect_is_disputed,
    judge,
    nothing_is_named,
    rivals_are_left,
    structure_is_left,
)
from coast_cli.diagnosis.shapes.judge import (
    SHAPE_RULES,
    names_explain_shapes,
    only_parameters_are_named,
    unseen_points_are_missed,
)


def effect(identifier, kind="physics"):
    return SimpleNamespace(id=identifier, kind=kind)


def hypothesis(*effects, rmse=1.0):
    return SimpleNamespace(
        ids=tuple(one.id for one in effects), fit=SimpleNamespace(effects=effects, rmse=rmse), paid=0.0
    )


def case(*effects, **facts):
    leading = hypothesis(*effects)
    known = {
        "leading": leading,
        "by_importance": leading.ids,
        "rivals": (),
        "agrees": "it agrees",
        "alike": "alike",
        "moved": "moved",
        "parameters_moved": False,
        "floor": 1.0,
        "allowed_share": 0.35,
        "explained": 10.0,
        "leftover": Leftover(0.0, "something is left"),
    }
    return SimpleNamespace(**{**known, **facts})


def level(train, held_out):
    return SimpleNamespace(train=train, held_out=held_out)


def compared(before, after):
    return SimpleNamespace(refitted=level(before, before), with_effects=level(after, after))


@pytest.mark.parametrize(
    ("size", "explained", "ruled"), [(0.5, 0.1, False), (2.0, 10.0, False), (2.0, 1.0, True), (4.0, 10.0, True)]
)
def test_structure_counts_beside_the_noise_and_beside_what_was_explained(size, explained, ruled):
    found = structure_is_left(case(explained=explained, leftover=Leftover(size, "left")))
    assert found == (Ruling("unexplained", "left") if ruled else None)


def test_nothing_named_is_agreement_unless_parameters_moved():
    assert nothing_is_named(case()) == Ruling("agrees", "it agrees")
    assert nothing_is_named(case(parameters_moved=True)) == Ruling("parameters", "moved")
    assert nothing_is_named(case(effect("backlash"))) is None


def test_a_joint_is_ambiguous_where_a_rival_lacks_the_first_effect():
    leading = (effect("backlash"), effect("gravity"))
    shared, other = hypothesis(effect("backlash")), hypothesis(effect("sensor_lag"))
    assert first_effect_is_disputed(case(*leading, rivals=(shared,))) is None
    assert first_effect_is_disputed(case(*leading, rivals=(shared, other))) == Ruling("ambiguous", "alike")


def test_shapes_are_ambiguous_where_there_is_any_rival():
    assert rivals_are_left(case(effect("gravity"))) is None
    rival = hypothesis(effect("gravity"), effect("tip_load"))
    assert rivals_are_left(case(effect("gravity"), rivals=(rival,))) == Ruling("ambiguous", "alike")


@pytest.mark.parametrize(
    ("kinds", "verdict"),
    [
        (("sensor",), "sensor"),
        (("physics", "sensor"), "physics"),
        (("parameter", "sensor"), "sensor"),
        (("sensor", "physics"), "sensor"),
        (("parameter",), "physics"),
    ],
)
def test_the_most_important_effect_says_whether_it_is_the_sensor(kinds, verdict):
    effects = [effect(f"e{number}", kind) for number, kind in enumerate(kinds)]
    assert effects_are_named(case(*effects)).verdict == verdict


def test_numbers_of_the_tubes_alone_are_parameters():
    assert only_parameters_are_named(case(effect("notch_depth_error", "parameter"))).verdict == "parameters"
    assert only_parameters_are_named(case(effect("notch_depth_error", "parameter"), effect("tip_load"))) is None


def joint_case(*effects, carried=(), parts=(), before=1.0, after=1.0, of_parts=None):
    """Return a case whose sets in ``carried`` predict unseen rows; ``led_by`` says by what the case would be led."""
    facts = {
        "is_settled": False,
        "carries_over": lambda fit: tuple(one.id for one in fit.effects) in carried,
        "missed": lambda fit: {**(of_parts or {}), tuple(e.id for e in effects): after}.get(
            tuple(e.id for e in fit.effects), before
        ),
        "contest": SimpleNamespace(parts=lambda: parts, base=hypothesis()),
        "led_by": lambda leading: leading.ids,
    }
    return case(*effects, **facts)


def test_a_set_that_does_not_carry_over_gives_way_to_a_part_that_does():
    one, two = effect("backlash"), effect("gravity")
    parts = (hypothesis(two), hypothesis(one))
    rule = what_does_not_carry_over_is_dropped
    assert rule(joint_case(one, two, carried=[("backlash", "gravity")], parts=parts)) is None
    assert rule(joint_case(one, two, carried=[("backlash",)], parts=parts)) == ("backlash",)
    assert rule(joint_case()) is None


def test_an_effect_without_which_unseen_rows_are_predicted_as_well_is_redundant():
    one, two = effect("backlash"), effect("gravity")
    parts = (hypothesis(one), hypothesis(two))
    rule = what_is_redundant_is_dropped
    assert rule(joint_case(one, two, parts=parts, after=0.5, of_parts={("backlash",): 0.6})) is None
    assert rule(joint_case(one, two, parts=parts, after=0.5, of_parts={("gravity",): 0.502})) == ("gravity",)
    assert rule(joint_case(one, parts=(), after=0.5)) is None


@pytest.mark.parametrize(("before", "after", "ruled"), [(1.0, 0.5, False), (1.0, 1.2, False), (1.0, 3.0, True)])
def test_unseen_points_may_be_missed_as_far_as_noise_lets_expect(monkeypatch, before, after, ruled):
    monkeypatch.setattr("coast_cli.diagnosis.shapes.judge.expected_of", lambda *_: 1.0)
    facts = {
        "comparison": compared(before, after),
        "problem": None,
        "kept_back": SimpleNamespace(rows=()),
    }
    found = unseen_points_are_missed(case(effect("tip_load"), **facts))
    assert (found is not None) == ruled
    assert found is None or found.verdict == "unexplained"


@pytest.mark.parametrize(("rmse", "repeats", "size"), [(1.5, 0.0, 0.0), (2.0, 0.0, 3.0**0.5), (1.5, 0.64, 1.2)])
def test_excess_is_above_the_noise_or_repeats(rmse, repeats, size):
    assert excess(SimpleNamespace(rmse=rmse), 1.0, repeats, 1.9) == pytest.approx(size)


def test_the_rules_begin_again_with_a_changed_case():
    def shrink(size):
        return size - 1 if size > 1 else None

    def rule(size):
        return Ruling("physics", f"{size} left")

    assert judge(3, (shrink, rule)) == (1, Ruling("physics", "1 left"))


def test_rules_that_come_to_no_verdict_are_an_error():
    with pytest.raises(ValueError, match="no verdict"):
        judge(1, (lambda _: None,))


@pytest.mark.parametrize("rules", [JOINT_RULES, SHAPE_RULES])
def test_the_last_rule_always_rules_and_every_rule_says_what_it_is(rules):
    assert rules[-1] in (names_explain, names_explain_shapes)
    assert all((rule.__doc__ or "").startswith("Rule: ") for rule in rules)
    assert len({rule.__name__ for rule in rules}) == len(rules)
