"""Whatever is done to the reference input: no traceback, a documented exit code, and never a NaN in an answer."""

import json
import math
import re
from pathlib import Path

import pytest
from hypothesis import HealthCheck, given, settings
from hypothesis import strategies as st

from coast_cli.__main__ import main

TEXT = (Path(__file__).parents[2] / "configs" / "tubes.toml").read_text(encoding="utf-8")
LINES = TEXT.splitlines()
NUMBERS = [match.span() for match in re.finditer(r"(?<![\w.#])\d+(\.\d+)?(?=[\s,}])", TEXT)]
WORDS = [match.span() for match in re.finditer(r"\b[a-z_]{4,}\b", TEXT.partition("version")[2])]
COMMANDS = [
    ("rank-pairs", "{config}", "--format", "json"),
    ("rank-pairs", "{config}", "--format", "json", "--rigidity", "series", "--section", "chord"),
    ("stroke", "{config}", "--kappa", "0,20,400", "--x2", "5,30", "--format", "json"),
    ("stroke", "{config}", "--stroke", "0,2,30", "--x2", "5,30", "--format", "json"),
    ("check", "{config}", "--format", "json"),
    ("beam", "{config}", "--tube", "OT1", "--points", "5", "--format", "json"),
    ("validate", "{config}", "--format", "json"),
]
VALUES = [
    "0",
    "-1",
    "-0.0",
    "nan",
    "inf",
    "-inf",
    "1e308",
    "1e-308",
    "5e-324",
    "9" * 400,
    "true",
    '"x"',
    "[]",
    "{}",
    "[[1]]",
    "{ value = 1 }",
    "{ value = 1, min = 0, max = 2 }",
    "2026-01-01",
    "0x1F",
    "1_0",
    "",
    "=",
    "0.4999999",
    "1e6",
    "100",
]


def cut(draw):
    return TEXT[: draw(st.integers(0, len(TEXT)))]


def drop_a_line(draw):
    at = draw(st.integers(0, len(LINES) - 1))
    return "\n".join(LINES[:at] + LINES[at + 1 :])


def repeat_a_line(draw):
    at = draw(st.integers(0, len(LINES) - 1))
    return "\n".join(LINES[: at + 1] + LINES[at:])


def swap_two_lines(draw):
    lines = list(LINES)
    one, other = (draw(st.integers(0, len(lines) - 1)) for _ in range(2))
    lines[one], lines[other] = lines[other], lines[one]
    return "\n".join(lines)


def another_number(draw):
    start, end = draw(st.sampled_from(NUMBERS))
    value = draw(st.one_of(st.sampled_from(VALUES), st.floats(0.01, 100.0).map(repr), st.integers(1, 400).map(str)))
    return TEXT[:start] + value + TEXT[end:]


def a_typo(draw):
    start, end = draw(st.sampled_from(WORDS))
    offset = TEXT.index("version") + len("version")
    at = offset + draw(st.integers(start, end - 1))
    return TEXT[:at] + draw(st.sampled_from(["", "x", "\x00", "é", '"', "]", "\n", " ", "\t", "#"])) + TEXT[at + 1 :]


def other_bytes(draw):
    at = draw(st.integers(0, len(TEXT) - 1))
    return TEXT[:at].encode() + draw(st.binary(min_size=1, max_size=4)) + TEXT[at + 1 :].encode()


DAMAGES = [cut, drop_a_line, repeat_a_line, swap_two_lines, another_number, a_typo, other_bytes]


@st.composite
def damaged(draw):
    content = draw(st.sampled_from(DAMAGES))(draw)
    return content if isinstance(content, bytes) else content.encode("utf-8", "surrogatepass")


def numbers_in(value):
    if isinstance(value, dict | list):
        for inner in value.values() if isinstance(value, dict) else value:
            yield from numbers_in(inner)
    elif isinstance(value, float):
        yield value


@settings(max_examples=400, deadline=None, suppress_health_check=[HealthCheck.function_scoped_fixture])
@given(content=damaged(), command=st.sampled_from(COMMANDS))
@pytest.mark.filterwarnings("ignore::RuntimeWarning")  # an overflow is refused by its result, whose place is known
def test_damage_is_refused_in_a_sentence_or_answered_in_numbers(tmp_path, capsys, content, command):
    path = tmp_path / "tubes.toml"
    path.write_bytes(content)
    code = main([word.format(config=path) for word in command])
    out, err = capsys.readouterr()
    assert code in {0, 1, 2, 3, 4}
    assert "Traceback" not in err
    assert "internal error" not in err
    # A file that cannot be read is a row of its own among the checks of others, as it is to validate.
    if code in {2, 3, 4} and command[0] not in {"validate", "check"}:
        assert out == ""
        assert err.count("\n") >= 1
    if code == 3:
        assert "tubes.toml" in err
    if out:
        answer = json.loads(out)
        assert answer["rows"]
        assert all(math.isfinite(value) for value in numbers_in(answer))
