"""``coast report``: one page that needs nothing from outside, whole or not at all, whatever others wrote into its inputs."""

import json
import re
import sys
from html.parser import HTMLParser
from pathlib import Path

import pytest

import coast_cli.output.report
from coast_cli.output.report import NO_PICTURES

ROOT = Path(__file__).parents[2]
RECORDING = ROOT / "examples" / "diagnose" / "recording.csv"
VOID = {"meta", "img", "br"}
SAMPLED = ("--samples", "50")
QUICK = ("--samples", "0", "--kappa", "0:40:20", "--x2", "20")


class Page(HTMLParser):
    """What a reader sees of a page, and what it would fetch; tags must be closed in order."""

    def __init__(self, text):
        super().__init__()
        self.open, self.tags, self.attributes, self.text = [], [], [], ""
        self.feed(text)
        self.close()
        assert self.open == []

    def handle_starttag(self, tag, attrs):
        self.tags.append(tag)
        self.attributes += attrs
        if tag not in VOID:
            self.open.append(tag)

    def handle_endtag(self, tag):
        assert self.open.pop() == tag

    def handle_data(self, data):
        self.text += data if "style" not in self.open else ""

    def values(self, *names):
        return [value for name, value in self.attributes if name in names]


@pytest.fixture(scope="module")
def whole(tmp_path_factory):
    """The report of the reference input and the example's recording, made once."""
    from coast_cli.__main__ import main

    pytest.importorskip("matplotlib", reason="not here: matplotlib, the extra [plot]")
    path = tmp_path_factory.mktemp("report") / "report.html"
    words = ["report", ROOT / "configs" / "tubes.toml", RECORDING, *SAMPLED, "-o", path]
    assert main([str(word) for word in words]) == 0
    return path


def test_the_page_needs_nothing_from_outside(whole):
    text = whole.read_text(encoding="utf-8")
    page = Page(text)
    assert not {"script", "link", "iframe", "object"} & set(page.tags)
    assert all(link.startswith(("data:image/svg+xml;base64,", "data:image/png;base64,")) for link in page.values("src"))
    assert all(link.startswith("#") for link in page.values("href"))
    assert not re.search(r"https?://|url\(|@import", text)
    assert "@media print" in text


def test_every_mark_is_in_the_font_that_the_page_names(whole):
    """In the one that matplotlib brings along, so that no browser is needed to see it."""
    from matplotlib.font_manager import findfont, get_font

    text = Page(whole.read_text(encoding="utf-8")).text
    marks = {mark for mark in text if mark > "\x7f"}
    font = get_font(findfont("DejaVu Sans"))
    assert '"DejaVu Sans"' in whole.read_text(encoding="utf-8")
    assert len(marks) >= 5
    assert {mark for mark in marks if not font.get_char_index(ord(mark))} == set()


def test_it_has_no_more_than_three_sheets_hold(whole):
    """Rows, pictures and words; a browser prints as many on three sheets (`test_report_in_a_browser.py`)."""
    page = Page(whole.read_text(encoding="utf-8"))
    assert page.tags.count("tr") <= 190
    assert page.tags.count("img") <= 9
    assert len(page.text.split()) <= 2600


def test_every_table_scrolls_in_its_own_place(whole):
    text = whole.read_text(encoding="utf-8")
    assert text.count("<table>") == text.count('<div class="wide"><table>') > 5


def test_every_link_leads_to_a_section(whole):
    page = Page(whole.read_text(encoding="utf-8"))
    assert [link[1:] for link in page.values("href")] == page.values("id")
    assert page.values("id") == [
        "diagnosis",
        "checks",
        "tolerances",
        "ranking",
        "strokes",
        "shapes",
        "inputs",
        "provenance",
    ]


def test_the_page_says_what_the_commands_say(whole, coast, reference):
    page = Page(whole.read_text(encoding="utf-8"))
    assert "17 of 42 marked as assumed in the file, 4 left to defaults of the program" in page.text
    assert "1 of 12 by score, on the Pareto front" in page.text
    assert "5 of 5 limits hold" in page.text
    assert "4.791" in page.text  # stroke at 40/m and 40 mm
    pairs = json.loads(coast("rank-pairs", reference, "-f", "json").out)["rows"]
    assert page.text.count("●") == 1 + sum(row["pareto"] for row in pairs)
    assert "backlash: play in the actuator" in page.text
    assert "defaults of the program" in page.text
    digest = coast("rank-pairs", reference).out.split()[-1]
    assert digest in page.text
    assert len(page.values("src")) == 6


def test_the_picture_of_the_readme_is_what_the_command_draws(coast, reference, tmp_path):
    shown = ROOT / "coast_cli" / "guide" / "pair.svg"
    assert coast("report", reference, "-o", tmp_path / "pair.svg").code == 0
    drawn = (tmp_path / "pair.svg").read_text(encoding="utf-8")
    numbers = [re.findall(r"-?\d+\.?\d*", text) for text in (drawn, shown.read_text(encoding="utf-8"))]
    assert len(numbers[0]) > 100
    assert [float(number) for number in numbers[0]] == pytest.approx([float(number) for number in numbers[1]], abs=2e-4)
    assert len(drawn) < 10_000
    assert f"({shown.relative_to(ROOT).as_posix()})" in (ROOT / "README.md").read_text(encoding="utf-8")


def test_the_first_sheet_answers(whole):
    first = Page(whole.read_text(encoding="utf-8").partition("<nav>")[0] + "</body></html>")
    assert "✓ 5 of 5 limits hold as drawn; the nearest is max_total_precurvature_rad, 12 % from its limit" in first.text
    assert re.search(r"✗ The model leaves out physics\. Named: backlash \(\d\d %\)\.", first.text)
    assert "To scale: OT4 0.5 mm outside, 0.4 inside, 188 notches 0.4 deep" in first.text
    assert "svg" in first.tags
    assert "Stroke X1 at X2 of" in first.text
    assert "where the mismatch is" in first.text


def test_the_assumed_inputs_are_marked(whole):
    text = whole.read_text(encoding="utf-8")
    assert text.count("<mark>default</mark>") == 4
    assert text.count("<mark>assumed</mark>") == 17
    assert "&quot;assumed&quot; = the paper&#x27;s Tables I and II are not available to us" in text


def test_the_same_input_gives_the_same_bytes(whole, coast, reference, tmp_path):
    assert coast("report", reference, RECORDING, *SAMPLED, "-o", tmp_path / "again.html").code == 0
    assert (tmp_path / "again.html").read_bytes() == whole.read_bytes()


def test_stdout_stays_empty(coast, reference, tmp_path):
    ran = coast("report", reference, "--samples", "0", "-o", tmp_path / "report.html")
    assert (ran.code, ran.out, ran.err) == (0, "", "")
    assert "No samples were asked for" in (tmp_path / "report.html").read_text(encoding="utf-8")


def test_without_matplotlib_it_has_its_tables_and_says_how_to_get_pictures(coast, reference, tmp_path, monkeypatch):
    monkeypatch.setitem(sys.modules, "matplotlib.figure", None)
    ran = coast("report", reference, RECORDING, *QUICK, "-o", tmp_path / "report.html")
    page = Page((tmp_path / "report.html").read_text(encoding="utf-8"))
    assert ran.code == 0
    assert ran.err == f"coast: note: {NO_PICTURES}\n"
    assert "img" not in page.tags
    assert "pip install matplotlib" in page.text
    assert "OT4/MT1" in page.text


def test_what_others_wrote_is_text(coast, edited, tmp_path):
    config = edited(
        ("0.8        # assumed", '0.8        # assumed by <script>alert(1)</script> & "co"'),
        ("# Reference input:", "# <img src=x onerror=alert(1)> Reference input:"),
        name="a<b>&.toml",
    )
    recording = tmp_path / "r<script>.csv"
    rows = RECORDING.read_text(encoding="utf-8").replace("small-20", "<script>x</script>")
    recording.write_text(rows, encoding="utf-8")
    assert coast("report", config, recording, *QUICK, "-o", tmp_path / "report.html").code == 0
    page = Page((tmp_path / "report.html").read_text(encoding="utf-8"))
    assert "script" not in page.tags
    assert not [name for name, _ in page.attributes if name.startswith("on")]
    assert 'assumed by <script>alert(1)</script> & "co"' in page.text
    assert "a<b>&.toml" in page.text
    assert "r<script>.csv" in page.text


def test_a_failing_check_is_no_failure_of_the_report(coast, edited, tmp_path):
    config = edited(("value = 6.0", "value = 4.0"))
    ran = coast("report", config, *QUICK, "-o", tmp_path / "report.html")
    text = (tmp_path / "report.html").read_text(encoding="utf-8")
    assert ran.code == 0
    assert "4 of 5 limits hold as drawn; max_stroke_mm (max) fails" in text
    assert '<tr class="fails">' in text
    assert coast("check", config).code == 1


def test_the_pair_asked_for_is_the_pair_reported(coast, reference, tmp_path):
    assert coast("report", reference, "--pair", "OT1/MT2", *QUICK, "-o", tmp_path / "report.html").code == 0
    page = Page((tmp_path / "report.html").read_text(encoding="utf-8"))
    assert "OT1/MT2, as asked for by --pair" in page.text
    assert "10 of 12 by score, not on the Pareto front; OT4/MT1 ranks first" in page.text
    assert "limits hold for OT1/MT2 as drawn" in page.text


def test_a_joint_of_one_tube_has_what_there_is(coast, edited, reference_text, tmp_path):
    outer = reference_text[reference_text.index("[outer]") : reference_text.index("[middle]")]
    config = edited((outer, ""), ('pair = "OT4/MT1"', 'pair = "MT1"'))
    assert coast("report", config, *QUICK, "-o", tmp_path / "report.html").code == 0
    page = Page((tmp_path / "report.html").read_text(encoding="utf-8"))
    assert "There is nothing to rank" in page.text
    assert "What tolerances do is answered for pairs only" in page.text
    assert "a limit on a pair needs an outer tube" in page.text
    assert "Strokes of MT1" in page.text


def test_where_no_pair_is_named_it_is_the_recorded_one_or_the_first_of_the_ranking(coast, edited, tmp_path):
    config = edited(('pair = "OT4/MT1"', ""))
    recording = tmp_path / "recording.csv"
    rows = "".join(f"OT3,MT2,20,{1.2 + 0.1 * k:g},{1.4 * k:g}\n" for k in range(7))
    recording.write_text("outer,middle,bending_length_mm,stroke_mm,curvature_per_m\n" + rows, encoding="utf-8")
    said = []
    for words in ((recording,), ()):
        assert coast("report", config, *words, *QUICK, "-o", tmp_path / "report.html").code == 0
        said.append(Page((tmp_path / "report.html").read_text(encoding="utf-8")).text)
    assert "OT3/MT2, the first that was recorded" in said[0]
    assert "The recording cannot decide." in said[0]
    assert "OT4/MT1, first of the ranking" in said[1]


def test_short_tubes_get_lengths_they_have(coast, edited, tmp_path):
    config = edited(
        ("count = 188", "count = 30"),
        ("count = 125", "count = 30"),
        ("bending_length_mm = 40.0", "bending_length_mm = 9.0"),
    )
    assert coast("report", config, "--samples", "0", "-o", tmp_path / "report.html").code == 0
    page = Page((tmp_path / "report.html").read_text(encoding="utf-8"))
    assert re.findall(r"X2 = (\S+) mm", page.text) == ["9", "18"]


@pytest.mark.parametrize(
    ("words", "code", "said"),
    [
        (("{config}", "no-recording.csv", "-o", "{out}"), 3, "no-recording.csv: cannot be read"),
        (("no-config.toml", "-o", "{out}"), 3, "there is no such file"),
        (("{config}", "{config}", "-o", "{out}"), 3, "tubes.toml"),
        (("{config}", "--pair", "OT9/MT1", "-o", "{out}"), 3, "there is no outer tube of that name"),
        (("{config}", "--kappa", "x", "-o", "{out}"), 2, "--kappa x"),
        (("{config}", "--x2", "4000", "-o", "{out}"), 2, "bending length 4000 mm"),
        (("{config}", "--hold-out", "none", "{recording}", "-o", "{out}"), 3, "there is no such run"),
        (("{config}", "-o", "report.docx"), 2, "allowed: .html, .htm"),
        (("{config}", "-o", "no/such/report.html"), 2, "there is no folder"),
        (("{config}",), 2, "--output"),
    ],
)
def test_what_cannot_be_is_one_sentence_and_leaves_no_file(coast, reference, tmp_path, monkeypatch, words, code, said):
    monkeypatch.chdir(tmp_path)
    out = tmp_path / "report.html"
    places = {"config": reference, "out": out, "recording": RECORDING}
    ran = coast("report", *(word.format(**places) for word in words), "--samples", "0")
    assert ran.code == code
    assert said in ran.err
    assert len(ran.err.splitlines()) == 1
    assert list(tmp_path.iterdir()) == []


def test_interrupted_it_leaves_what_was_there(coast, reference, tmp_path, monkeypatch):
    def interrupt(_):
        raise KeyboardInterrupt

    monkeypatch.setattr(coast_cli.output.report, "page_of", interrupt)
    out, kept = tmp_path / "report.html", tmp_path / "kept.html"
    kept.write_text("an older report", encoding="utf-8")
    assert coast("report", reference, "--samples", "0", "-o", out).code == 130
    assert coast("report", reference, "--samples", "0", "-o", kept).code == 130
    assert [path.name for path in tmp_path.iterdir()] == ["kept.html"]
    assert kept.read_text(encoding="utf-8") == "an older report"


LIMITS = """max_tension_n = 3.0
max_web_strain = 0.008
min_closure_margin = 1.5
fatigue = { cycles = 10_000_000 }
min_bend_deg = { value = 120.0, bending_length_mm = 40.0 }
min_snap_margin = 0.0
"""


def test_every_limit_is_reported_and_every_figure_has_a_name(coast, tmp_path, reference_text):
    from coast_cli.design.limits import point_figure_names
    from coast_cli.output.labels import LABELS
    from coast_cli.spec.config import Checks
    from coast_cli.spec.load import load_config_text

    text = reference_text + LIMITS
    assert set(point_figure_names(load_config_text(text))) <= set(LABELS)
    config = tmp_path / "limits.toml"
    config.write_text(text, encoding="utf-8")
    ran = coast("report", config, "-o", tmp_path / "report.html", "--samples", "40")
    assert ran.code == 0, ran.err
    page = Page((tmp_path / "report.html").read_text(encoding="utf-8"))
    assert all(name in page.text for name in Checks.model_fields)
    assert "11 of 11 limits hold" in page.text
    drawn = coast("tolerance", config, "--samples", "40", "--only", "check", "--plot", tmp_path / "figures.svg")
    assert drawn.code == 0, drawn.err
