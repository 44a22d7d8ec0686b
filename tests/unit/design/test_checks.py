"""Every limit passes and fails; how far a pair reaches is where the first limit ends it, by both routes."""

import numpy as np
import pytest

from coast_cli.__main__ import main
from coast_cli.design.checks import check_design, jump_told, limits_told
from coast_cli.design.limits import at_the_point
from coast_cli.design.snapping import snap_rows
from coast_cli.design.stroke import stroke_table
from coast_cli.errors import BadInput
from coast_cli.mechanics.joint import stroke
from coast_cli.mechanics.tubes import tubes_of
from coast_cli.spec.build import build
from coast_cli.spec.load import load_config_text

# a key, its value where the reference input passes, and where it fails
LIMITS = {
    "max_tension_n": ("2.04", "2.03"),
    "max_web_strain": ("0.0061", "0.006"),
    "min_closure_margin": ("28.0", "28.2"),
    "fatigue": ("{ cycles = 1000 }", "{ max_strain_amplitude = 0.003 }"),
    "min_bend_deg": ("{ value = 122.0, bending_length_mm = 40.0 }", "{ value = 145.0, bending_length_mm = 40.0 }"),
}


def checked(text, *lines, pair=None):
    rows = check_design(build(load_config_text("\n".join((text, *lines, "")))), pair)
    return {row["check"]: row for row in rows}


@pytest.mark.parametrize("key", LIMITS)
def test_each_limit_passes_and_fails(reference_text, key):
    passing, failing = LIMITS[key]
    assert checked(reference_text, f"{key} = {passing}")[key]["passed"]
    rows = checked(reference_text, f"{key} = {failing}")
    assert [name for name, row in rows.items() if not row["passed"]] == [key]


def test_the_reach_ends_where_the_stroke_is_used_up(reference_text):
    row = checked(reference_text, "min_bend_deg = { value = 145.0, bending_length_mm = 40.0 }")["min_bend_deg"]
    assert row["stopped_by"] == "stroke above 6 mm (checks.max_stroke_mm)"
    joint = build(load_config_text(reference_text)).joint()
    curvature = np.radians(row["value"]) / 0.04
    assert float(stroke(joint, curvature, 0.04).stroke) == pytest.approx(6e-3, rel=1e-9)


@pytest.mark.parametrize(
    ("lines", "stopped"),
    [
        (("max_web_strain = 0.007",), "web strain (checks.max_web_strain)"),
        (("max_tension_n = 2.1",), "tension above 2.1 N (checks.max_tension_n)"),
    ],
)
def test_the_reach_names_the_limit_that_ends_it(reference_text, lines, stopped):
    wanted = "min_bend_deg = { value = 10.0, bending_length_mm = 40.0 }"
    assert checked(reference_text, *lines, wanted)["min_bend_deg"]["stopped_by"] == stopped


def test_the_forecast_of_a_jump_is_a_limit_on_the_pair(reference_text):
    for pair, passed in (("OT4/MT1", True), ("OT3/MT1", False)):
        row = checked(reference_text, "min_snap_margin = 0.0", pair=pair)["min_snap_margin"]
        assert row["passed"] is passed
    whole = snap_rows(build(load_config_text(reference_text)))
    margins = [one["margin"] for one in whole if (one["outer"], one["middle"]) == ("OT3", "MT1")]
    assert row["value"] == pytest.approx(min(margins))


def test_with_no_other_limit_the_notches_end_the_bend(reference_text):
    text = reference_text[: reference_text.index("[checks]")] + "[checks]\n"
    row = checked(text, "min_bend_deg = { value = 10.0, bending_length_mm = 40.0 }")["min_bend_deg"]
    closing = build(load_config_text(reference_text)).joint().closure_curvature
    assert row["value"] == pytest.approx(np.degrees(0.04 * closing))
    assert row["stopped_by"] == "notch faces touch"


def test_many_pairs_at_once_have_the_figures_of_one(reference_text):
    lines = [f"{key} = {passing}" for key, (passing, _) in LIMITS.items()]
    design = build(load_config_text("\n".join((reference_text, *lines, ""))))
    columns = at_the_point(design, tubes_of(design.outer), tubes_of([design.middle[1]] * len(design.outer)))
    figures = {"fatigue": "strain_amplitude", "min_closure_margin": "closure_margin", "min_bend_deg": "bend_deg"}
    for place, outer in enumerate(design.outer):
        for row in check_design(design, f"{outer.name}/{design.middle[1].name}"):
            if row["check"] in LIMITS:
                figure = figures.get(row["check"], row["check"].removeprefix("max_"))
                assert columns[figure][place] == pytest.approx(row["value"], rel=1e-9), row["check"]


def test_the_pair_asked_for_is_checked(reference_text):
    rows = checked(reference_text, pair="OT1/MT2")
    assert {row["pair"] for row in rows.values()} == {"OT1/MT2"}
    assert rows["max_total_precurvature_rad"]["value"] == pytest.approx(0.11938, abs=5e-6)


def test_corrections_act_on_what_is_reached(reference_text):
    wanted = "min_bend_deg = { value = 10.0, bending_length_mm = 40.0 }"
    held = (wanted, "[corrections.coulomb_friction]", "holds_per_m = 10.0", "spread = 0.0", "held_per_m = 0.0")
    plain, late = (checked(reference_text, *lines)["min_bend_deg"]["value"] for lines in ((wanted,), held))
    assert plain - 30.0 < late < plain - 5.0


@pytest.mark.parametrize("key", ["max_tension_n = 2.0", "max_web_strain = 0.01", "fatigue = {}"])
def test_a_limit_at_a_point_needs_the_point(reference_text, key):
    text = reference_text[: reference_text.index("[checks]")] + f"[checks]\n{key}\n"
    with pytest.raises(BadInput, match="at the point of max_stroke_mm, which is not given"):
        load_config_text(text)


def test_more_cycles_than_are_known_need_an_amplitude(reference_text):
    with pytest.raises(BadInput, match="no amplitude is known for so many cycles; found 20000000"):
        load_config_text(reference_text + "fatigue = { cycles = 20_000_000 }\n")
    own = "fatigue = { cycles = 20_000_000, max_strain_amplitude = 0.0031 }"
    assert checked(reference_text, own)["fatigue"]["passed"]


def test_where_the_fatigue_limit_comes_from_is_said(reference_text):
    def told(line):
        return limits_told(load_config_text(reference_text + f"fatigue = {line}\n"))

    assert "0.004 is assumed" in told("{}")[0]
    assert "0.0031 is of our rig" in told('{ max_strain_amplitude = 0.0031, source = "our rig" }')[0]
    assert limits_told(load_config_text(reference_text)) == ()
    with pytest.raises(BadInput, match="a source is named"):
        load_config_text(reference_text + 'fatigue = { source = "our rig" }\n')


def test_a_stroke_past_fatigue_or_near_closing_is_told(reference_text):
    config = load_config_text(reference_text + "fatigue = {}\nmin_closure_margin = 20.0\n")
    joint = build(config).joint()
    told = stroke_table(joint, [0.04], curvatures=[10.0, 80.0], checks=config.checks).notes
    assert any("80 1/m" in note and "(checks.fatigue)" in note for note in told)
    assert any("80 1/m" in note and "(checks.min_closure_margin)" in note for note in told)
    told = stroke_table(joint, [0.04], curvatures=[10.0], checks=config.checks).notes
    assert not any("checks." in note for note in told)


def test_a_check_tells_what_of_a_model_it_leaves_out(reference_text, tmp_path, capsys):
    file = tmp_path / "creeps.toml"
    file.write_text(reference_text + "[corrections.tendon_creep]\nfraction = 0.2\n", encoding="utf-8")
    assert main(["check", str(file)]) == 0
    assert "tendon_creep: acts with time, so left out of a slow first pull" in capsys.readouterr().err


def test_a_pair_that_would_jump_is_told(reference_text):
    design = build(load_config_text(reference_text + "min_snap_margin = 0.0\n"))
    assert jump_told(design, "OT4/MT1") == ()
    assert "below 0 (checks.min_snap_margin)" in jump_told(design, "OT3/MT1")[0]
    assert jump_told(build(load_config_text(reference_text)), "OT3/MT1") == ()
