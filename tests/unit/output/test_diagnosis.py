"""What a diagnosis looks like, whatever found it: page, JSON, picture, report; made by hand, so no fit is run."""

import json
import re
from dataclasses import replace
from html.parser import HTMLParser
from io import StringIO
from math import inf, nan
from pathlib import Path

import pytest

from coast_cli.diagnosis.answer import Diagnosis, Level, Named, SideBySide, Value
from coast_cli.diagnosis.locate import Region
from coast_cli.effects.library.backlash import Backlash
from coast_cli.errors import UsageError
from coast_cli.output import diagnosis_json, diagnosis_page
from coast_cli.output.diagnosis import DiagnosisAnswer, Outputs, write_diagnosis
from coast_cli.output.diagnosis_report import report_page
from coast_cli.output.diagnosis_words import HEADLINES, measured, percent
from coast_cli.output.provenance import provenance
from coast_cli.recordings.read import read_recordings
from coast_cli.spec.load import load_config

GOLDEN = Path(__file__).parents[2] / "golden"
ROOT = GOLDEN.parents[1]
BACKLASH = Named(
    "backlash",
    "physics",
    "actuator",
    "play in the actuator",
    "x(t) = clip(x(t-), X1(t), X1(t) + width)",
    0.97,
    {"width_mm": Value(0.1801, 0.0042, at_bound=False)},
)
PHYSICS = Diagnosis(
    verdict="physics",
    reason="the named effects explain what the base model leaves over",
    noise=0.25,
    noise_unit="curvature_per_m",
    where=(
        Region("direction", "release", None, None, 0.998, 1e-20),
        Region("stroke", None, 0.8901, 3.7999, 0.83, 0.0004),
        Region("rate", None, 0.1, 0.1, 0.31, 0.002),
    ),
    effects=(BACKLASH,),
    parameters={
        "youngs_modulus_gpa": Value(42.71, 0.23, at_bound=False),
        "deadband_mm": Value(0.0, nan, at_bound=True),
    },
    configured={"youngs_modulus_gpa": 42.6, "deadband_mm": 1.2},
    comparison=SideBySide(
        "curvature_per_m",
        ("large-40",),
        "the runs named",
        Level(2.2, 1.9),
        Level(1.1, 0.98),
        Level(0.24, 0.31),
        0.76,
        0.24,
    ),
    notes=("deadband_mm is on its bound",),
    model_effects=(Backlash(0.1801),),
    model_parameters={"youngs_modulus_gpa": 42.71, "deadband_mm": 0.0},
)
INSUFFICIENT = Diagnosis(
    "insufficient",
    "only 6 samples can be fitted",
    0.25,
    "bend_deg",
    next_recording="load and release, 200 samples or more",
)
UNEXPLAINED = replace(
    PHYSICS,
    verdict="unexplained",
    effects=(),
    attempts=("backlash", "gravity"),
    model_effects=(),
    reason="0.5 1/m is left that no effect of the catalogue explains",
)
AMBIGUOUS = replace(
    PHYSICS,
    verdict="ambiguous",
    alternatives=(("coulomb_friction",), ("capstan_hysteresis", "gravity")),
    next_recording="release sweeps from two different strokes, with tension recorded",
)
AGREES = replace(
    PHYSICS,
    verdict="agrees",
    effects=(),
    where=(),
    model_effects=(),
    notes=(),
    reason="the model as configured agrees with the recording within its noise",
)
BY_HAND = {
    "physics": PHYSICS,
    "insufficient": INSUFFICIENT,
    "unexplained": UNEXPLAINED,
    "ambiguous": AMBIGUOUS,
    "agrees": AGREES,
}


@pytest.fixture(scope="module")
def answer_of():
    config = load_config(ROOT / "configs" / "tubes.toml")
    recordings = read_recordings([ROOT / "examples" / "diagnose" / "recording.csv"], config)
    origin = provenance(config, recordings=[("recording.csv", "ab" * 32)], options={"max_effects": 5}, seed=0)
    return lambda diagnosis: DiagnosisAnswer(diagnosis, config, recordings, origin, ("a note of the reader.",))


def page(answer):
    stream = StringIO()
    diagnosis_page.render(answer, stream)
    text = stream.getvalue()
    return re.sub(r"^.*tubes\.toml(?=  sha256)", "tubes.toml", text, flags=re.MULTILINE)


@pytest.mark.parametrize("name", BY_HAND)
def test_the_page_to_the_character(answer_of, name):
    assert page(answer_of(BY_HAND[name])) == (GOLDEN / f"diagnosis-{name}.txt").read_text(encoding="utf-8")


@pytest.mark.parametrize("name", BY_HAND)
def test_the_page_fits_eighty_columns_and_gives_five_answers_in_order(answer_of, name):
    text = page(answer_of(BY_HAND[name]))
    assert max(map(len, text.splitlines())) <= 80
    assert re.findall(r"^(\d)\. ", text, re.MULTILINE) == list("12345")


def test_json_is_the_contract_and_never_holds_nan(answer_of):
    broken = replace(PHYSICS, noise=inf, comparison=replace(PHYSICS.comparison, tip_mm_refitted=nan))
    stream = StringIO()
    diagnosis_json.render(answer_of(broken), stream)
    document = json.loads(stream.getvalue(), parse_constant=pytest.fail)
    assert document["schema"] == "coast.diagnosis/1"
    assert document["noise"] == {"unit": "curvature_per_m", "value": None}
    assert document["where"][0] == {
        "axis": "direction",
        "value": "release",
        "low": None,
        "high": None,
        "unit": None,
        "share": 0.998,
        "p_value": 1e-20,
    }
    assert document["where"][2]["unit"] == "mm/s"
    assert document["effects"][0]["parameters"]["width_mm"] == {"value": 0.1801, "std": 0.0042, "at_bound": False}
    assert document["parameters"]["deadband_mm"] == {"value": 0.0, "std": None, "at_bound": True, "configured": 1.2}
    assert document["fit"]["tip_mm"] == {"refitted": None, "with_effects": 0.24}
    assert set(document["fit"]) == {
        "unit",
        "held_out_runs",
        "rule",
        "configured",
        "refitted",
        "with_effects",
        "tip_mm",
    }
    assert document["provenance"]["recordings"] == [{"file": "recording.csv", "sha256": "ab" * 32}]


def test_json_without_a_fit(answer_of):
    document = diagnosis_json.document(answer_of(INSUFFICIENT))
    assert document["fit"] is None
    assert document["effects"] == []
    assert document["notes"] == ["a note of the reader."]


@pytest.mark.parametrize(
    ("value", "words"),
    [
        (Value(42.714, 0.23, at_bound=False), "42.71 +- 0.23"),
        (Value(1.00628, 0.00009, at_bound=False), "1.006280 +- 0.000090"),
        (Value(1234.0, 56.0, at_bound=False), "1234 +- 56"),
        (Value(3.0, 0.1, at_bound=True), "3, on its bound"),
        (Value(3.0, 0.0, at_bound=False), "3, not determined"),
        (Value(3.0, inf, at_bound=False), "3, not determined"),
        (Value(0.0, 4.0, at_bound=False), "0 +- 4"),
        (Value(0.25, 3e-9, at_bound=False), "0.25"),
        (Value(0.5, 9.0, at_bound=False), "0.5 +- 9"),
    ],
)
def test_a_number_is_written_with_the_digits_that_count(value, words):
    assert measured(value) == words


def test_a_probability_near_one_is_not_rounded_up_to_it():
    assert percent(0.996) == "over 99 %"
    assert percent(0.83) == "83 %"


class Page(HTMLParser):
    def __init__(self):
        super().__init__()
        self.open, self.links, self.text = [], [], ""

    def handle_starttag(self, tag, attrs):
        if tag not in {"meta", "img", "br"}:
            self.open.append(tag)
        self.links += [value for name, value in attrs if name in {"src", "href"}]

    def handle_endtag(self, tag):
        assert self.open.pop() == tag

    def handle_data(self, data):
        self.text += data


@pytest.mark.parametrize("name", BY_HAND)
def test_the_report_needs_nothing_from_outside(answer_of, name):
    html = report_page(answer_of(BY_HAND[name]))
    parsed = Page()
    parsed.feed(html)
    assert parsed.open == []
    assert all(link.startswith("data:image/png;base64,") for link in parsed.links)
    assert len(parsed.links) == (name != "insufficient")
    assert "http" not in html
    assert HEADLINES[BY_HAND[name].verdict] in parsed.text
    assert "@media print" in html


def test_a_report_escapes_what_others_wrote(answer_of):
    html = report_page(answer_of(replace(INSUFFICIENT, notes=("run <script>alert(1)</script> & more",))))
    assert "<script>" not in html
    assert "&lt;script&gt;" in html


@pytest.mark.parametrize("suffix", ["png", "svg"])
def test_the_same_answer_gives_the_same_picture(answer_of, tmp_path, suffix):
    paths = [tmp_path / f"{number}.{suffix}" for number in (1, 2)]
    for path in paths:
        write_diagnosis(answer_of(PHYSICS), Outputs("json", plot=path))
    first, second = (path.read_bytes() for path in paths)
    assert first == second
    assert first[:4] == (b"\x89PNG" if suffix == "png" else b"<?xm")


@pytest.mark.parametrize(
    ("outputs", "said"),
    [
        (Outputs("csv"), "--format csv"),
        (Outputs(files=(Path("answer.csv"),)), "allowed: .txt, .json"),
        (Outputs(model=Path("model.json")), "allowed: .toml"),
        (Outputs(plot=Path("plot.gif")), "allowed: .png, .svg"),
        (Outputs(report=Path("report.pdf")), "allowed: .html"),
    ],
)
def test_outputs_that_cannot_be_are_refused_before_any_fit(outputs, said):
    with pytest.raises(UsageError, match=re.escape(said)):
        outputs.check()


def test_a_plot_without_matplotlib_is_one_sentence(monkeypatch):
    monkeypatch.setitem(__import__("sys").modules, "matplotlib.figure", None)
    with pytest.raises(UsageError, match=r"pip install matplotlib"):
        Outputs(plot=Path("plot.png")).check()


def write_golden():
    config = load_config(ROOT / "configs" / "tubes.toml")
    recordings = read_recordings([ROOT / "examples" / "diagnose" / "recording.csv"], config)
    for name, diagnosis in BY_HAND.items():
        text = page(DiagnosisAnswer(diagnosis, config, recordings, provenance(config)))
        (GOLDEN / f"diagnosis-{name}.txt").write_text(text, encoding="utf-8")


if __name__ == "__main__":
    write_golden()
