"""No line of a table is wider than the terminal, whatever the answer; what is left out is named."""

import io
import re

import pytest
from hypothesis import given
from hypothesis import strategies as st

from coast_cli.output import table
from coast_cli.output.answer import Answer
from coast_cli.output.columns import COLUMNS, IMPORTANT
from coast_cli.output.layout import cell_width, fold

WIDTHS = (20, 60, 80, 120, 200)
LONG = (
    "sagt 'the pair cannot be assembled' since 0.45 mm of OT1 do not go through /a/very/long/path/without/a/space.toml"
)
cells = st.one_of(
    st.none(),
    st.booleans(),
    st.integers(),
    st.floats(allow_nan=False, allow_infinity=False),
    st.text("ab 导\u0301-_\n", max_size=60),
)


def rendered(answer, width, **options):
    stream = io.StringIO()
    table.render(answer, stream, width=width, **options)
    return stream.getvalue()


def answer_of(command, value=LONG):
    """An answer of a command with a value in every column: numbers where the name has a unit, else long words."""
    names = COLUMNS[command]
    row = {name: 0.000123456 if "_" in name else value for name in names}
    provenance = {"configs": [{"file": "some/folder/with/a/long/name/" * 3 + "tubes.toml", "sha256": "0" * 64}]}
    return Answer(command, [row, row], provenance)


@pytest.mark.parametrize("width", WIDTHS)
@pytest.mark.parametrize("command", COLUMNS)
@pytest.mark.parametrize("chosen", [False, True])
def test_no_line_of_any_command_is_wider_and_no_column_is_lost(command, width, chosen):
    text = rendered(answer_of(command), width, chosen=chosen)
    assert max(map(cell_width, text.splitlines())) <= width
    named = re.sub(r"\s", "", text.partition("not shown: ")[2]).partition("(--wide")[0].split(",")
    for name in set(COLUMNS[command]) - set(named):
        words = table._heading(name) if "─" in text else fold(name, width)
        assert all(word in text for word in words)
    assert set(named) - {""} <= set(COLUMNS[command])


@given(st.lists(st.fixed_dictionaries({"alpha_mm": cells, "b": cells, "c_and_more": cells}), max_size=4))
def test_any_row_fits(rows):
    for width in (20, 60):
        text = rendered(Answer("demo", rows), width)
        assert all(cell_width(line) <= width for line in text.split("\n"))


def test_wide_characters_take_two_columns():
    assert cell_width("导丝") == 4
    assert cell_width("e\u0301") == 1
    assert fold("导丝导丝导丝", 5) == ["导丝", "导丝", "导丝"]


def test_a_text_is_broken_at_its_spaces_first():
    assert fold("one two three", 7) == ["one two", "three"]
    assert fold("onetwothree", 4) == ["onet", "woth", "ree"]
    assert fold("", 4) == [""]


def test_the_important_columns_stay():
    row = dict.fromkeys(COLUMNS["rank-pairs"], 1.2345e-05)
    text = rendered(Answer("rank-pairs", [row]), 60)
    heading = text.partition("─")[0].replace("\n", " ").split()
    assert heading[:3] == ["rank", "outer", "middle"]
    assert "score" in heading
    assert "not shown: sample" in text


def test_what_is_important_exists():
    for command, names in IMPORTANT.items():
        assert set(names) <= set(COLUMNS[command])
        assert len(set(names)) == len(names)


def test_hardly_any_room_makes_a_record_a_block():
    text = rendered(Answer("demo", [{"name_of_the_first": "a", "name_of_the_other": 1.5}] * 2), 20)
    assert (
        text == "name_of_the_first\n  a\nname_of_the_other\n  1.5\n\nname_of_the_first\n  a\nname_of_the_other\n  1.5\n"
    )


def test_without_unicode_the_rule_is_ascii():
    stream = io.TextIOWrapper(io.BytesIO(), encoding="ascii")
    table.render(Answer("demo", [{"a": 1}]), stream)
    stream.seek(0)
    assert stream.read() == "a\n-\n1\n"
