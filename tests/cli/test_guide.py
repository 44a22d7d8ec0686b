"""``coast guide``: every page is listed, printed as it stands, and an unknown topic is answered with the nearest."""

import pytest

from coast_cli.cli.guide import PAGES

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
