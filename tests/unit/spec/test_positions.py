"""Every key and array element of a TOML text is found, and found where it stands."""

import tomllib

import tomli_w
from hypothesis import given
from hypothesis import strategies as st

from coast_cli.spec.positions import key_positions, line_comments

bare = st.text("abcXYZ019_-", min_size=1, max_size=6)
quoted = st.text(st.characters(exclude_categories=["Cs"]), max_size=6)
keys = st.one_of(bare, quoted)
scalars = st.one_of(
    st.integers(-(2**62), 2**62),
    st.floats(allow_nan=False, allow_infinity=False),
    st.booleans(),
    st.text(st.characters(exclude_categories=["Cs"]), max_size=8),
    st.dates(),
)
values = st.recursive(
    scalars, lambda inner: st.lists(inner, max_size=4) | st.dictionaries(keys, inner, max_size=4), max_leaves=12
)
documents = st.dictionaries(keys, values, max_size=6)


def paths_of(value, path=()):
    items = value.items() if isinstance(value, dict) else enumerate(value) if isinstance(value, list) else ()
    for key, inner in items:
        yield (*path, key)
        yield from paths_of(inner, (*path, key))


@given(documents)
def test_every_path_of_a_written_document_is_found_and_no_other(document):
    text = tomli_w.dumps(document)
    assert set(key_positions(text)) == set(paths_of(tomllib.loads(text)))


@given(st.dictionaries(bare, values, max_size=6))
def test_a_key_is_placed_where_its_text_stands(document):
    text = tomli_w.dumps(document)
    lines = text.split("\n")
    for path, (line, column) in key_positions(text).items():
        rest = lines[line - 1][column - 1 :]
        if len(path) == 1:
            assert rest.lstrip("[").startswith(path[0])


@given(st.lists(st.tuples(bare, st.integers()), max_size=8, unique_by=lambda pair: pair[0]), st.booleans())
def test_lines_are_counted_whatever_comments_and_line_ends_stand_between(pairs, windows):
    end = "\r\n" if windows else "\n"
    text = "".join(f"# note [x] = 1{end}{end}{key} = {value} # 'quote{end}" for key, value in pairs)
    found = key_positions(text)
    assert found == {(key,): (3 * index + 3, 1) for index, (key, _) in enumerate(pairs)}


def test_the_forms_of_toml():
    text = "\n".join(  # noqa: FLY002  # a line each, to count them
        [
            "a.b = 1",
            '"x y".\'z.w\' = """',
            'text = 1 \\""" ] }',
            '"""""',
            "day = 1979-05-27 07:32:00 # [no]",
            "list = [ [1, 2], # one",
            "  {k = ']', 'm n' = 3}, ]",
            "[t.u]",
            "v = '''",
            "w = 2''''",
            "[[t.rows]]",
            "n = 1",
            "[t.rows.deep]",
            "p = {}",
            "[[t.rows]]",
            'n = "\\u0041\\\\"',
        ]
    )
    found = key_positions(text)
    assert set(found) == set(paths_of(tomllib.loads(text)))
    assert found["a", "b"] == (1, 3)
    assert found["x y", "z.w"] == (2, 7)
    assert found["list", 0, 1] == (6, 14)
    assert found["list", 1, "m n"] == (7, 13)
    assert found["t", "u"] == (8, 1)
    assert found["t", "rows", 0, "deep", "p"] == (14, 1)
    assert found["t", "rows", 1, "n"] == (16, 1)


def test_quoted_keys_are_read_with_their_escapes():
    assert list(key_positions('"a\\u0062\\n\\"" = 1')) == [('ab\n"',)]


def test_comments_are_found_by_line_and_marks_inside_texts_are_none():
    text = "# head\na = 1 # one\nb = \"# no\" # two\nc = [ # three\n  1,\n]\nd = '''\n# no\n'''\n[t] #\n"
    assert line_comments(text) == {1: "head", 2: "one", 3: "two", 4: "three", 10: ""}


def test_a_comment_at_the_very_end_needs_no_line_end():
    assert line_comments("a = 1\n# last") == {2: "last"}
