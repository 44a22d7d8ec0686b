"""``coast guide``: every page is listed, printed as it stands, and an unknown topic is answered with the nearest."""

import re
from collections import Counter

import pytest

from coast_cli.cli.guide import PAGES
from coast_cli.output.page_text import fitted

TOPICS = sorted(path.stem for path in PAGES.glob("*.md"))


def test_every_page_is_listed_with_its_title(coast):
    ran = coast("guide")
    assert (ran.code, ran.err) == (0, "")
    assert [line.split()[0] for line in ran.out.splitlines()] == TOPICS
    assert all(line.split(maxsplit=1)[1] for line in ran.out.splitlines())


@pytest.mark.parametrize("topic", TOPICS)
def test_a_page_is_printed_as_it_stands(coast, topic):
    ran = coast("guide", topic)
    assert (ran.code, ran.err) == (0, "")
    assert ran.out == (PAGES / f"{topic}.md").read_text(encoding="utf-8")
    assert ran.out.startswith("# ")
    assert ran.out.endswith("\n")


def test_an_unknown_topic_is_answered_with_the_nearest(coast):
    ran = coast("guide", "sensitive")
    assert (ran.code, ran.out) == (2, "")
    assert ran.err == "coast: sensitive: there is no page of that name in the guide. Did you mean sensitivity?\n"
    assert "`coast guide` lists them" in coast("guide", "wine").err


@pytest.mark.parametrize("width", [20, 40, 60, 80, 120])
def test_no_line_is_wider_than_the_terminal_and_no_word_is_lost(coast, monkeypatch, width):
    monkeypatch.setenv("COLUMNS", str(width))
    for topic in (None, *TOPICS):
        ran = coast("guide", *([topic] if topic else []))
        assert (ran.code, ran.err) == (0, "")
        assert max(map(len, ran.out.splitlines())) <= width
        if topic:
            marks = str.maketrans("", "", "|-: \n")
            page = (PAGES / f"{topic}.md").read_text(encoding="utf-8")
            page = re.sub(r"(?m)^\|[^|]*(\|.*\n\|[-|: ]+$)", r"\1", page)  # what heads the names of a table's rows
            if "…" not in ran.out:
                left = Counter(page.translate(marks)) - Counter(ran.out.translate(marks))
                assert sum(left.values()) == 0
            else:
                assert f"`coast guide {topic} > {topic}.md`" in " ".join(ran.out.split())


def test_running_text_is_filled_and_what_a_program_printed_keeps_its_lines():
    page = (
        "# A title\n\nSome words that\ngo on.\n\n- one item that is long\n- two\n\n```console\n$ coast a\n a  b\n```\n"
    )
    assert fitted(page, 18).splitlines() == [
        "# A title",
        "",
        "Some words that go",
        "on.",
        "",
        "- one item that is",
        "  long",
        "- two",
        "",
        "```console",
        "$ coast a",
        " a  b",
        "```",
    ]


def test_rows_that_a_program_printed_are_cut_and_its_other_lines_broken():
    page = "# A\n\n```console\n$ coast some command\nname   value   more\nwords that go on and on\n```\n"
    assert fitted(page, 16, "a").splitlines()[2:7] == [
        "```console",
        "$ coast some",
        "  command",
        "name   value   …",
        "words that go on",
    ]
    assert "cut: `coast guide a > a.md` has them whole." in " ".join(fitted(page, 16, "a").split())


def test_a_wide_table_becomes_a_record_a_row():
    page = "| name | means | guide |\n|---|---|---|\n| `coast a` | what it is | [a](a.md) |\n"
    assert fitted(page, 20).splitlines() == ["`coast a`", "  means: what it is", "  guide: [a](a.md)"]
    assert fitted(page, 60) == page
