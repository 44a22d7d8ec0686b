"""``coast snap``: wrong lengths and configurations without a joint are refused in one sentence."""

from pathlib import Path

import pytest


@pytest.mark.parametrize("length", ["0", "-3", "75.1", "nan"])
def test_a_length_that_the_tubes_do_not_have(coast, reference, length):
    ran = coast("snap", reference, f"--x2={length}")
    assert (ran.code, ran.out) == (2, "")
    assert "allowed: above 0 and at most the notched length, 75 mm" in ran.err
    assert len(ran.err.splitlines()) == 1


def test_without_a_tendon(coast, edited):
    ran = coast("snap", edited)
    assert (ran.code, ran.out) == (3, "")
    assert "needs pairs, a joint and its tendon" in ran.err


@pytest.fixture
def edited(tmp_path, reference):
    text = Path(reference).read_text(encoding="utf-8")
    start = text.index("[tendon]")
    path = tmp_path / "bare.toml"
    path.write_text(text[:start] + text[text.index("[joint]") : text.index("[checks]")], encoding="utf-8")
    return str(path)


def test_it_says_that_it_is_a_forecast(coast, reference):
    assert "against no robot" in coast("snap", reference).err
