"""The odds of names are set by maximum likelihood, on tuning seeds alone, and written where they decide."""

import numpy as np
import pytest

from coast_cli.diagnosis import thresholds
from coast_cli.diagnosis.joint.odds import Against
from examples.concealed import odds
from examples.concealed.tune import ROOT, THRESHOLDS, line_of


def test_weights_are_found_again_from_answers_that_were_drawn_with_them():
    rng = np.random.default_rng(5)
    figures = rng.uniform(0.0, 2.0, (4000, 3))
    right = rng.uniform(size=4000) < 1.0 / (1.0 + np.exp(figures @ [2.0, 0.0, 1.0] - 3.0))
    found = odds.fitted(figures, right)
    assert found == pytest.approx([3.0, 2.0, 0.0, 1.0], abs=0.3)
    assert (found[1:] >= 0.0).all()


def test_probability_and_share_agree_in_every_bin():
    rng = np.random.default_rng(6)
    figures = rng.uniform(0.0, 2.0, (2000, 1))
    right = rng.uniform(size=2000) < 1.0 / (1.0 + np.exp(2.0 * figures[:, 0] - 2.0))
    words = odds.report(odds.fitted(figures, right), ["left"], figures, right)
    bins = [line.split() for line in words.splitlines() if line.startswith("given")]
    assert len(bins) == odds.BINS
    assert all(abs(float(line[1].rstrip(",")) - float(line[3])) < 0.08 for line in bins)


def test_seeds_that_are_scored_are_refused(tmp_path):
    with pytest.raises(ValueError, match="those above are for scoring"):
        odds.collect(tmp_path, range(29_990, 30_010), 1)


def test_every_figure_has_its_weight_and_all_are_written(tmp_path):
    names = list(Against(*(0.0 for _ in range(8))).table())
    (tmp_path / THRESHOLDS).parent.mkdir(parents=True)
    (tmp_path / THRESHOLDS).write_text((ROOT / THRESHOLDS).read_text(encoding="utf-8"), encoding="utf-8")
    odds.put(np.arange(9) / 8, names, 0.55, tmp_path)
    text = (tmp_path / THRESHOLDS).read_text(encoding="utf-8")
    assert float(line_of("NAMED_FROM", text)[2]) == 0.55
    for place, name in enumerate(["constant", *names]):
        assert hasattr(thresholds, f"ODDS_{name.upper()}")
        assert f"ODDS_{name.upper()} = Threshold({round(place / 8, 2):g}," in text


@pytest.mark.parametrize(
    ("verdict", "named", "others", "expected"),
    [
        ("physics", ["backlash"], [], True),
        ("physics", ["coulomb_friction", "backlash"], [], False),
        ("ambiguous", ["coulomb_friction"], [["backlash"]], True),
    ],
)
def test_the_first_name_is_what_is_judged_and_any_of_a_group(verdict, named, others, expected):
    truth = {"level": "L1", "effects": [{"id": "backlash"}]}
    found = {"verdict": verdict, "effects": [{"id": one} for one in named], "attempts": [], "alternatives": others}
    assert odds.is_right(found, truth) is expected
    assert odds.is_right(found, truth | {"level": "L8"}) is False


def test_names_are_given_from_where_the_answers_are_worth_most():
    given = np.array([0.95, 0.9, 0.7, 0.6])
    right, outside = np.array([True, True, False, False]), np.array([False, False, True, True])
    worths = odds.worth(given, right, outside)
    best = odds.FROM[worths.argmax()]
    assert 0.7 <= round(float(best), 2) < 0.9
    assert worths.max() == 1.0
