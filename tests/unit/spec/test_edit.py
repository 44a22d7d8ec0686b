"""Numbers are written into a configuration and every comment stays; whatever the text, what is written says the document."""

import tomllib
from copy import deepcopy

import pytest
from hypothesis import given
from hypothesis import strategies as st

from coast_cli.spec.edit import written
from coast_cli.spec.positions import line_comments


def test_what_does_not_change_is_kept_to_the_character(reference_text):
    assert written(tomllib.loads(reference_text), reference_text) == reference_text


def test_a_number_changes_in_place_and_its_comment_says_where_it_comes_from(reference_text):
    document = tomllib.loads(reference_text)
    document["joint"]["deadband_mm"] = 1.5
    text = written(document, reference_text, {("joint", "deadband_mm"): "fitted"})
    changed = [pair for pair in zip(reference_text.splitlines(), text.splitlines(), strict=True) if pair[0] != pair[1]]
    assert changed == [
        (
            "deadband_mm = 1.2                    # paper, subtracted from its plots",
            "deadband_mm = 1.5                    # fitted; was 1.2: paper, subtracted from its plots",
        )
    ]


def test_keys_tables_and_tubes_are_added(reference_text):
    document = tomllib.loads(reference_text)
    document["outer"]["section"] = "chord"
    document["outer"]["notch"]["more"] = 1
    document["outer"]["samples"][1]["notch"] = {"cut_mm": 0.2}
    document["outer"]["samples"].append({"name": "OT9", "depth_mm": [0.3, 0.4]})
    document["corrections"] = {"backlash": {"width_mm": 0.2, "recording": "joint"}}
    text = written(document, reference_text, {("outer", "section"): "asked for"})
    assert tomllib.loads(text) == document
    assert 'section = "chord"  # asked for\n' in text
    assert [*line_comments(text).values()][:40] != []
    assert set(line_comments(reference_text).values()) <= set(line_comments(text).values())
    assert text.index('name = "OT9"') < text.index("[middle]")


def test_a_table_goes_and_the_comments_of_the_others_stay(reference_text):
    document = tomllib.loads(reference_text)
    del document["checks"], document["inner"], document["joint"]["notch_friction"]
    text = written(document, reference_text)
    assert tomllib.loads(text) == document
    assert "# paper, subtracted from its plots" in text
    assert "max_stroke_mm" not in text


@pytest.mark.parametrize(
    "text",
    [
        "a = 1",
        "a = 1\r\nb = 2 # two\r\n",
        "x = { a = 1 } # why\n",
        "x.y.z = 1 # deep\nb = 2\n",
        "[[t]]\na = 1\n[t.u]\nb = 2 # two\n[[t]]\n",
        'a = """\nmany # no comment\nlines"""  # one\n',
        "a = [\n 1, # one\n 2, # two\n]\n",
        "t = [{ a = 1 }, { a = 2 }]\n",
        "# only a comment\n[empty] # nothing\n",
    ],
)
def test_every_form_of_toml_takes_every_kind_of_change(text):
    before = tomllib.loads(text)
    for change in (_first_number, _new_key, _new_table, _new_item, _one_less):
        document = deepcopy(before)
        change(document)
        assert tomllib.loads(written(document, text)) == document


def _first_number(document):
    for key, value in document.items():
        if isinstance(value, int):
            document[key] = 7.5
            return
        if isinstance(value, dict):
            _first_number(value)


def _new_key(document):
    document["new key"] = [1, "two"]
    for value in document.values():
        if isinstance(value, dict):
            value["n"] = True


def _new_table(document):
    document["fresh"] = {"deep": {"a": 1.5}}


def _one_less(document):
    document.pop(next(iter(document)))


def _new_item(document):
    for value in document.values():
        if isinstance(value, list) and isinstance(value[0], dict):
            value.append({"a": 3, "in": {"b": 4}})


numbers = st.floats(allow_nan=False, allow_infinity=False) | st.integers(-(2**60), 2**60)
keys = st.text("ab -_.é\"'", min_size=1, max_size=4)
documents = st.recursive(
    st.dictionaries(keys, numbers | st.text(max_size=5) | st.lists(numbers, max_size=3), max_size=4),
    lambda inner: st.dictionaries(keys, inner | st.lists(inner, min_size=1, max_size=2), max_size=3),
    max_leaves=8,
)


@given(documents, documents)
def test_whatever_is_asked_for_is_what_is_said(one, other):
    import tomli_w

    assert tomllib.loads(written(other, tomli_w.dumps(one))) == other
