"""Pictures have one style, the same bytes for the same data, and take names as they are."""

import sys

import pytest

from coast_cli.errors import UsageError
from coast_cli.output.picture import FORMATS, Picture


def titled(text):
    return Picture((3.0, 2.0), lambda figure: figure.subplots().set_title(text))


@pytest.mark.parametrize("suffix", FORMATS)
def test_the_same_picture_gives_the_same_bytes(suffix):
    pytest.importorskip("matplotlib", reason="not here: matplotlib, the extra [plot]")
    first, second = (titled("a run").render(suffix[1:]) for _ in range(2))
    assert first == second
    assert b"202" not in first[:600]  # no date, wherever the format has one


@pytest.mark.parametrize("name", ["$\\nothing$", "a $ and a $", "<script>&", "übergröße 导丝"])
def test_a_name_is_drawn_as_it_is(tmp_path, name):
    pytest.importorskip("matplotlib", reason="not here: matplotlib, the extra [plot]")
    titled(name).write(tmp_path / "picture.svg")
    assert (tmp_path / "picture.svg").read_text(encoding="utf-8").rstrip().endswith("</svg>")


def test_another_suffix_is_refused(tmp_path):
    with pytest.raises(UsageError, match=r"allowed: \.png, \.svg, \.pdf"):
        titled("a").write(tmp_path / "picture.gif")


def test_without_matplotlib_it_is_one_sentence(monkeypatch):
    monkeypatch.setitem(sys.modules, "matplotlib.figure", None)
    with pytest.raises(UsageError, match=r"pip install matplotlib"):
        titled("a").render("png")
