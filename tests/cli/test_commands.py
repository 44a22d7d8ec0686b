"""What each command does: its rows, its options, its notes and its exit code."""

import csv
import io
import json
import tomllib
from itertools import pairwise
from xml.etree import ElementTree as ET

import pytest

from coast_cli.output.columns import COLUMNS

COMMANDS = {
    "rank-pairs": ("{config}",),
    "snap": ("{config}",),
    "stroke": ("{config}", "--kappa", "0:40:10", "--x2", "20,30"),
    "beam": ("{config}", "--tube", "OT4", "--points", "7"),
    "pattern": ("{config}", "--tube", "OT4", "--kerf", "0.02"),
    "check": ("{config}",),
    "validate": ("{config}",),
    "explain": ("depth_mm",),
}


def rows(ran):
    return json.loads(ran.out)["rows"]


@pytest.mark.parametrize("command", COMMANDS)
def test_the_rows_are_the_documented_columns_in_every_format(coast, reference, command):
    words = [word.format(config=reference) for word in COMMANDS[command]]
    ran = coast(command, *words, "--format", "json")
    answer = json.loads(ran.out)
    assert ran.code == 0
    assert answer["schema"] == f"coast.{command}/1"
    assert all(list(row) == list(COLUMNS[command]) for row in answer["rows"])
    lines = list(csv.DictReader(io.StringIO(coast(command, *words, "--format", "csv").out)))
    assert len(lines) == len(answer["rows"])
    for line, row in zip(lines, answer["rows"], strict=True):
        assert list(line) == list(row)
        for name, value in row.items():
            shown = "" if value is None else str(value).lower() if isinstance(value, bool) else str(value)
            assert line[name] == shown
    assert coast(command, *words).out.splitlines()[0].strip()


@pytest.mark.parametrize("command", COMMANDS)
def test_the_same_input_gives_the_same_bytes(coast, reference, command):
    words = [word.format(config=reference) for word in COMMANDS[command]]
    assert coast(command, *words, "-f", "json") == coast(command, *words, "-f", "json")


def test_provenance_says_versions_digest_and_options(coast, reference):
    origin = json.loads(coast("rank-pairs", reference, "--rigidity", "series", "-f", "json").out)["provenance"]
    assert set(origin["versions"]) == {"coast", "python", "numpy", "scipy"}
    assert len(origin["configs"][0]["sha256"]) == 64
    assert origin["options"]["rigidity"] == "series"


def test_the_rank_table_shows_both_rigidities_and_what_the_other_would_choose(coast, reference, edited):
    ran = coast("rank-pairs", reference)
    heading = " ".join(ran.out.splitlines()[:3])
    assert heading.count("rigidity_") == 4
    assert heading.count("ratio_mean") == heading.count("ratio_series") == 1
    assert "by series rigidity the same pair ranks first" in ran.err
    other = edited(("natural_curvature_per_m = 1.1 ", "natural_curvature_per_m = 8.0 "))
    first = {
        measure: rows(coast("rank-pairs", other, "-f", "json", "--rigidity", measure))[0]["sample"]
        for measure in ("mean", "series")
    }
    assert first["mean"] != first["series"]
    assert f"by series rigidity another pair, {first['series']} (" in coast("rank-pairs", other).err
    assert f"by mean rigidity another pair, {first['mean']} (" in coast("rank-pairs", other, "--rigidity", "series").err


def test_weights_and_sections_change_the_ranking(coast, reference):
    straightest = rows(coast("rank-pairs", reference, "--weights", "1,0,0", "-f", "json"))
    assert straightest[0]["sample"] == "S1"
    assert [row["total_precurvature_rad"] for row in straightest] == sorted(
        row["total_precurvature_rad"] for row in straightest
    )
    softer = rows(coast("rank-pairs", reference, "--section", "chord", "-f", "json"))
    stiffer = {row["sample"]: row["total_rigidity_series_n_m2"] for row in straightest}
    assert all(row["total_rigidity_series_n_m2"] < stiffer[row["sample"]] for row in softer)


def test_coupled_assembly_is_another_answer(coast, reference):
    separate = rows(coast("rank-pairs", reference, "-f", "json"))
    coupled = rows(coast("rank-pairs", reference, "--assembly", "coupled", "-f", "json"))
    assert len(coupled) == 12
    assert {row["sample"] for row in coupled} == {row["sample"] for row in separate}
    first = {row["sample"]: row["total_precurvature_rad"] for row in separate}
    assert any(abs(row["total_precurvature_rad"] - first[row["sample"]]) > 1e-3 for row in coupled)


def test_a_pair_that_cannot_be_assembled_is_last_with_its_reason(coast, edited):
    config = edited(('name = "MT2"', 'name = "MT2"\nouter_diameter_mm = 0.44\ninner_diameter_mm = 0.34'))
    found = rows(coast("rank-pairs", config, "-f", "json"))
    assert len(found) == 12
    assert [row["middle"] for row in found[-4:]] == ["MT2"] * 4
    assert all("does not go into" in row["reason"] and row["score"] is None for row in found[-4:])
    assert all(row["reason"] is None for row in found[:-4])
    assert [row["rank"] for row in found] == list(range(1, 13))
    assert "does not go into the outer tube" in coast("rank-pairs", config).out


def test_the_leading_tube_is_said(coast, reference):
    for row in rows(coast("rank-pairs", reference, "-f", "json")):
        assert row["leading_tube"] == ("outer" if row["signed_precurvature_rad"] > 0 else "middle")


def test_ranking_needs_both_tubes(coast, reference_text, tmp_path):
    start, end = reference_text.index("[outer]"), reference_text.index("[middle]")
    config = tmp_path / "one.toml"
    config.write_text((reference_text[:start] + reference_text[end:]).replace('pair = "OT4/MT1"', 'pair = "MT1"'))
    ran = coast("rank-pairs", config)
    assert (ran.code, ran.out) == (3, "")
    assert "no [outer] table" in ran.err
    assert coast("stroke", config, "--kappa", "20", "--x2", "20").code == 0
    assert "needs an outer tube" in coast("check", config).err


def test_stroke_takes_lists_and_ranges(coast, reference):
    found = rows(coast("stroke", reference, "--kappa", "0:40:5", "--x2", "20,30", "-f", "json"))
    assert len(found) == 18
    assert [row["curvature_per_m"] for row in found[:9]] == [0, 5, 10, 15, 20, 25, 30, 35, 40]
    assert found[0]["stroke_mm"] == pytest.approx(1.2)


@pytest.mark.parametrize(
    "words",
    [
        ("--kappa", "x", "--x2", "20"),
        ("--kappa", "20", "--x2", "20:10:1"),
        ("--kappa", "20", "--x2", "0:10:0"),
        ("--kappa", "1:2:3:4", "--x2", "20"),
        ("--kappa", "0:1:1e-9", "--x2", "20"),
        ("--kappa", "nan", "--x2", "20"),
        ("--kappa", "inf", "--x2", "20"),
        ("--kappa", "-5", "--x2", "20"),
        ("--kappa", "1e300", "--x2", "20"),
        ("--kappa", "20", "--x2", "0"),
        ("--kappa", "20", "--x2", "500"),
        ("--kappa", "20", "--stroke", "2", "--x2", "20"),
        ("--x2", "20"),
        ("--kappa", "20"),
    ],
)
def test_stroke_refuses_what_it_cannot_read(coast, reference, words):
    ran = coast("stroke", reference, *words)
    assert (ran.code, ran.out) == (2, "")
    assert ran.err.count("\n") == 1


def test_stroke_without_a_config_says_what_it_reads(coast, reference, tmp_path, monkeypatch):
    monkeypatch.chdir(tmp_path)
    ran = coast("stroke", "--kappa", "20", "--x2", "20", "-f", "csv")
    assert ran.code == 0
    assert "the reference input that ships in the package" in ran.err
    assert '"file": "reference.toml"' in coast("stroke", "--kappa", "20", "--x2", "20", "-f", "json").out
    (tmp_path / "configs").mkdir()
    changed = reference.read_text().replace("deadband_mm = 1.2", "deadband_mm = 0.2")
    (tmp_path / "configs" / "tubes.toml").write_text(changed)
    other = coast("stroke", "--kappa", "20", "--x2", "20", "-f", "csv")
    assert "configs/tubes.toml" in other.err
    assert other.out != ran.out


def test_stroke_of_a_joint_driven_by_tension(coast, reference_text, tmp_path):
    config = tmp_path / "tension.toml"
    start, end = reference_text.index("[tendon]"), reference_text.index("[joint]")
    config.write_text(reference_text[:start] + reference_text[end:])
    ran = coast("stroke", config, "--kappa", "20", "--x2", "20", "-f", "json")
    row = rows(ran)[0]
    assert (row["stroke_mm"], row["tendon_strain"]) == (None, None)
    assert row["tension_n"] > 0
    assert "no [tendon]" in ran.err
    assert coast("stroke", config, "--stroke", "2", "--x2", "20").code == 3
    assert coast("check", config).code == 3


def test_stroke_past_the_closing_of_the_notches_is_noted(coast, reference):
    assert "notch faces touch above 1124 1/m" in coast("stroke", reference, "--kappa", "2000", "--x2", "5").err


@pytest.mark.parametrize("pair", ["OT9/MT1", "OT4/MT1/MT2", "OT4", "/"])
def test_an_unknown_pair_is_bad_input(coast, reference, pair):
    ran = coast("stroke", reference, "--kappa", "20", "--x2", "20", "--pair", pair)
    assert (ran.code, ran.out) == (3, "")
    assert ": pair: " in ran.err


def test_beam_points_are_places_on_the_same_curve(coast, reference):
    whole = rows(coast("beam", reference, "--tube", "OT4", "-f", "json"))
    some = rows(coast("beam", reference, "--tube", "OT4", "--points", "95", "-f", "json"))
    assert len(whole) == 2 * 188 + 1
    assert len(some) == 95
    for coarse, fine in zip(some, whole[::4], strict=True):
        for name in ("arc_length_mm", "x_mm", "y_mm", "angle_deg"):
            assert coarse[name] == pytest.approx(fine[name], abs=1e-9)


def test_beam_curvature_is_the_slope_of_its_angle(coast, reference):
    found = rows(coast("beam", reference, "--tube", "MT2", "--points", "30001", "-f", "json"))
    step = (found[1]["arc_length_mm"] - found[0]["arc_length_mm"]) / 1e3
    for before, after in pairwise(found[1000:1101]):
        slope = (after["angle_deg"] - before["angle_deg"]) * 3.141592653589793 / 180 / step
        if before["curvature_per_m"] == pytest.approx(after["curvature_per_m"], rel=1e-2):
            assert slope == pytest.approx(after["curvature_per_m"], rel=1e-2)


def test_beam_takes_several_tubes_and_the_papers_method(coast, reference):
    found = rows(coast("beam", reference, "--tube", "OT1", "--tube", "OT2", "--points", "3", "-f", "json"))
    assert [row["tube"] for row in found] == ["OT1"] * 3 + ["OT2"] * 3
    arc, projected = (
        rows(coast("beam", reference, "--tube", "OT1", "--points", "3", "--method", method, "-f", "json"))
        for method in ("arc", "projected")
    )
    assert projected[-1]["y_mm"] == pytest.approx(arc[-1]["y_mm"], abs=2.0)


def test_beam_refuses_an_unknown_tube(coast, reference):
    ran = coast("beam", reference, "--tube", "OT5")
    assert (ran.code, ran.out) == (3, "")
    assert "Did you mean" in ran.err


def test_check_passes_on_the_reference_and_fails_when_a_limit_is_tightened(coast, reference, edited):
    ran = coast("check", reference, "-f", "json")
    assert ran.code == 0
    assert all(row["passed"] for row in rows(ran))
    tight = edited(("max_total_precurvature_rad = 0.30", "max_total_precurvature_rad = 0.20"))
    ran = coast("check", tight, "-f", "json")
    assert ran.code == 1
    failed = [row for row in rows(ran) if not row["passed"]]
    assert [(row["check"], row["limit"]) for row in failed] == [("max_total_precurvature_rad", 0.2)]
    assert failed[0]["line"] == 82


@pytest.mark.parametrize(
    ("old", "new", "check"),
    [
        ("min = 0.8, max = 4.0", "min = 3.6, max = 4.0", "rigidity_ratio"),
        ("min = 0.8, max = 4.0", "max = 3.0", "rigidity_ratio"),
        ("min = 0.8, max = 4.0", 'min = 1.2, rigidity = "series"', "rigidity_ratio"),
        ("value = 6.0", "value = 4.0", "max_stroke_mm"),
        ("max_tendon_strain = 0.012", "max_tendon_strain = 0.008", "max_tendon_strain"),
    ],
)
def test_each_limit_can_fail(coast, edited, old, new, check):
    ran = coast("check", edited((old, new)), "-f", "json")
    assert ran.code == 1
    assert [row["check"] for row in rows(ran) if not row["passed"]] == [check]


def test_check_takes_many_and_github_annotates_the_line(coast, reference, edited):
    tight = edited(("value = 6.0", "value = 4.0"))
    ran = coast("check", reference, tight, "-f", "github")
    assert ran.code == 1
    assert ran.out == (
        f"::error file={tight},line=84,title=coast check::OT4/MT1: max_stroke_mm is 4.7913, past its max of 4\n"
    )
    assert coast("check", reference, "-f", "github").out.startswith("::notice ")


def test_check_without_checks_is_bad_input(coast, reference_text, tmp_path):
    config = tmp_path / "tubes.toml"
    config.write_text(reference_text[: reference_text.index("[checks]")])
    ran = coast("check", config)
    assert ran.code == 3
    assert "no [checks] table" in ran.err
    config.write_text(reference_text[: reference_text.index("[checks]")] + "[checks]\n")
    ran = coast("check", config, "-f", "json")
    assert ran.code == 3
    assert "checks: no limit is given" in ran.err
    assert [(row["passed"], "no limit is given" in row["error"]) for row in rows(ran)] == [(False, True)]


def test_validate_takes_many_files_and_says_what_is_wrong(coast, reference, edited, tmp_path):
    wrong = edited(("depth_mm = 0.314", "depth_mm = 3.0"))
    ran = coast("validate", reference, wrong, tmp_path / "absent.toml", "-f", "json")
    assert ran.code == 3
    assert [(row["valid"], row["line"]) for row in rows(ran)] == [(True, None), (False, 24), (False, None)]
    assert "tubes.toml:24:1: outer.samples[0].depth_mm" in ran.err
    assert coast("validate", reference).code == 0


def test_init_writes_a_commented_config_on_which_every_command_runs(coast, tmp_path, monkeypatch):
    monkeypatch.chdir(tmp_path)
    assert coast("init").code == 0
    text = (tmp_path / "tubes.toml").read_text()
    assert text.count("#") > 20
    assert coast("init", "-").out == text
    for words in (("rank-pairs",), ("check",), ("validate",), ("stroke", "--kappa", "20", "--x2", "20")):
        assert coast(words[0], "tubes.toml", *words[1:]).code == 0
    again = coast("init")
    assert again.code == 2
    assert "--force" in again.err
    assert coast("init", "--force").code == 0


def test_schema_is_printed_or_written(coast, tmp_path):
    printed = coast("schema").out
    assert json.loads(printed)["title"] == "coast configuration"
    assert coast("schema", "-o", tmp_path / "schema.json").out == ""
    assert (tmp_path / "schema.json").read_text() == printed


def test_explain_knows_every_key_column_and_effect(coast, reference_text):
    from coast_cli.effects.catalogue import CATALOGUE

    document = tomllib.loads(reference_text)
    keys = [f"{table}.{key}" for table in ("joint", "tendon", "inner", "checks") for key in document[table]]
    columns = [column for command in COLUMNS.values() for column in command]
    for name in (*keys, *columns, *CATALOGUE):
        ran = coast("explain", name, "-f", "json")
        assert ran.code == 0, ran.err
        assert all(row["meaning"] for row in rows(ran))


def test_explain_of_an_effect_says_what_decides_and_gives_its_parameters(coast):
    found = rows(coast("explain", "tendon_creep", "-f", "json"))
    assert [row["kind"] for row in found[:2]] == ["physics effect of a joint", "recording that decides"]
    assert "hold" in found[1]["meaning"]
    assert [row["name"] for row in found[2:]] == ["tendon_creep.fraction", "tendon_creep.time_constant_s"]
    assert all(row["allowed"] and row["source"] for row in found[2:])


def test_explain_answers_an_unknown_name_with_the_nearest(coast):
    ran = coast("explain", "backlsh")
    assert (ran.code, ran.out) == (2, "")
    assert "Did you mean backlash" in ran.err


def test_version(coast):
    from coast_cli import __version__

    ran = coast("--version")
    assert (ran.code, ran.out.strip()) == (0, __version__)


def test_one_broken_file_does_not_hide_the_others(coast, reference, edited, tmp_path):
    broken, late = edited(("depth_mm = 0.314", "depth_mm = 3.0"), name="broken.toml"), tmp_path / "absent.toml"
    report = tmp_path / "report.xml"
    ran = coast("check", reference, broken, late, "-f", "github", "-o", report)
    assert ran.code == 3
    lines = ran.out.splitlines()
    assert lines[0].startswith(
        f"::error file={broken},line=24,title=coast check::{broken}:24:1: outer.samples[0].depth_mm"
    )
    assert lines[1].startswith(f"::error file={late},line=1,title=coast check::")
    assert len(lines) == 2
    suites = ET.parse(report).getroot()
    assert [(one.get("tests"), one.get("errors")) for one in suites] == [("5", "0"), ("1", "1"), ("1", "1")]
    assert (suites.get("tests"), suites.get("failures"), suites.get("errors")) == ("7", "0", "2")
    tight = edited(("max_stroke_mm = { value = 6.0", "max_stroke_mm = { value = 4.0"), name="tight.toml")
    assert coast("check", tight, reference).code == 1
    assert coast("check", tight, broken).code == 3


def test_check_takes_a_pair(coast, reference):
    ran = coast("check", reference, "--pair", "OT3/MT2", "-f", "json")
    assert {row["pair"] for row in rows(ran)} == {"OT3/MT2"}
    assert json.loads(ran.out)["provenance"]["options"] == {"pair": "OT3/MT2"}
    assert coast("check", reference, "--pair", "OT9/MT2").code == 3


def test_stroke_says_which_limits_are_passed(coast, reference):
    assert "past a limit" not in coast("stroke", reference, "--kappa", "40", "--x2", "40").err
    far = coast("stroke", reference, "--kappa", "40,300", "--x2", "40")
    assert far.code == 0
    for words in (
        "tendon strain above 0.012 (checks.max_tendon_strain)",
        "stroke above 6 mm",
        "web strain 0.0451 above",
    ):
        assert f"past a limit from 300 1/m over 40 mm: {words}" in far.err
    mad = coast("stroke", reference, "--stroke", "700", "--x2", "20").err  # 434 N, and not in silence
    for words in ("notch faces touch", "stroke above 6 mm", "web strain 1.58 above 0.054, where nitinol keeps a set"):
        assert f"past a limit from 1.052e+04 1/m over 20 mm: {words}" in mad
    metres = coast("stroke", reference, "--stroke", "1e5", "--x2", "20")
    assert (metres.code, metres.out) == (3, "")
    assert "stroke_length 100 m; millimetres?; allowed: at most 0.75 m" in metres.err
    assert (
        "every curvature is below 0.5 1/m, a radius of metres: is it in 1/m?"
        in coast("stroke", reference, "--kappa", "0,0.02", "--x2", "30").err
    )
    tense = coast("stroke", reference, "--stroke", "5", "--x2", "20,40")
    assert "past a limit from 54.28 1/m over 20 mm: web strain 0.00816 above 0.008" in tense.err


def test_a_joint_without_a_tendon_is_held_to_its_tension(coast, reference_text, tmp_path):
    start, end = reference_text.index("[tendon]"), reference_text.index("[joint]")
    config = tmp_path / "tension.toml"
    config.write_text(f"{reference_text[:start]}{reference_text[end:]}max_tension_n = 0.7\n", encoding="utf-8")
    ran = coast("stroke", config, "--kappa", "10,20", "--x2", "20")
    assert ran.code == 0
    assert "past a limit from 20 1/m over 20 mm: tension above 0.7 N (checks.max_tension_n)" in ran.err
    assert ran.err.count("past a limit") == 1
