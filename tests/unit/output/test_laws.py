"""What a diagnosis with laws without a name looks like: page, JSON, picture, report; made by hand, so no fit is run."""

import json
from dataclasses import replace
from io import StringIO

import numpy as np
import pytest

from coast_cli.diagnosis.unnamed.forms import Display
from coast_cli.diagnosis.unnamed.words import Known, describe
from coast_cli.effects.unnamed import UnnamedLaw
from coast_cli.output import diagnosis_json, diagnosis_page
from coast_cli.output.diagnosis import DiagnosisAnswer
from coast_cli.output.diagnosis_plot import plot_diagnosis, plot_laws
from coast_cli.output.diagnosis_report import report_page
from coast_cli.recordings.model import Recordings
from coast_cli.spec.load import REFERENCE, load_config
from tests.unit.output.test_diagnosis import PHYSICS

RUB = UnnamedLaw("structure", "curvature", "friction", 0.0, 2.0, 40.0, (1.5, 0.8, 0.3))
WALK = UnnamedLaw("drive", "time", "none", 0.0, 0.0, 60.0, (0.1, 0.02), number=2)
KNOWN = Known({1: 0.01 * np.eye(3)}, 12e-6, "a loop to 4 mm and back at X2 = 40 mm", (5.1, 1.1))
TOLD = describe([[RUB, WALK], [WALK]], Display("curvature"), [("coulomb_friction", 1.9)], KNOWN)
UNNAMED = replace(PHYSICS, verdict="unnamed", effects=(), model_effects=(RUB, WALK), unnamed=TOLD)


@pytest.fixture(scope="module")
def answer():
    return DiagnosisAnswer(UNNAMED, load_config(REFERENCE), Recordings(None, None))


def test_the_page_holds_sentence_equation_and_a_table_of_each_curve(answer):
    stream = StringIO()
    diagnosis_page.render(answer, stream)
    page = stream.getvalue()
    flat = " ".join(page.split())
    assert max(map(len, page.splitlines())) <= 80
    assert "dissipates 12 uJ in a loop to 4 mm and back" in flat
    assert "M -> M + EI*g on load, M - EI*g on release, g = " in flat
    assert "kappa (1/m) moment / EI against motion (1/m) 90 % from to" in flat
    assert "t (s) added stroke (mm)" in flat
    assert "its band is not known" in flat


@pytest.mark.parametrize("width", [40, 60, 80])
def test_a_narrow_terminal_gets_narrow_lines(answer, width):
    stream = StringIO()
    diagnosis_page.render(answer, stream, width=width)
    assert max(map(len, stream.getvalue().splitlines())) <= width


def test_json_holds_every_curve_with_its_band(answer):
    law = json.loads(json.dumps(diagnosis_json.document(answer), allow_nan=False))["unnamed"]
    assert law["curve"] == law["curves"][0]
    assert len(law["curve"]["x"]) == len(law["curve"]["low_90"]) == len(law["curve"]["high_90"])
    assert law["curves"][1]["low_90"] == []
    assert law["dissipated_uj"] == pytest.approx(12.0)
    assert [one["stage"] for one in law["laws"]] == ["structure", "drive", "drive"]


def test_the_picture_names_what_is_drawn_with_units():
    svg = plot_laws(TOLD.curves).render("svg")
    assert svg == plot_laws(TOLD.curves).render("svg")
    assert plot_diagnosis(UNNAMED).size[1] > plot_diagnosis(UNNAMED, laws=False).size[1]
    assert plot_diagnosis(UNNAMED).render("png")[:4] == b"\x89PNG"


def test_the_report_has_the_picture_and_the_table(answer):
    page = report_page(answer)
    assert "broken line: the equation" in page
    assert "moment / EI against motion (1/m)" in page
    assert "<script" not in page
