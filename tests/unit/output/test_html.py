"""Pieces of a page: text is escaped, words in backticks are code, a long name may be broken."""

import re
import sys

import pytest

from coast_cli.output.html import (
    _STYLE,
    Group,
    HtmlColumn,
    Markup,
    Row,
    bullets,
    figure,
    footer,
    grouped,
    paragraph,
    section,
    table,
)
from coast_cli.output.picture import Picture


def test_text_is_escaped_and_words_in_backticks_are_code():
    assert paragraph("run `coast <x>` & see") == "<p>run <code>coast &lt;x&gt;</code> &amp; see</p>"
    assert bullets(["`a`"]) == "<ul>\n<li><code>a</code></li>\n</ul>"


def test_nothing_to_say_is_nothing():
    assert paragraph("") == bullets([]) == ""
    assert section("A", "", "<p>b</p>") == "<section>\n<h2>A</h2>\n<p>b</p>\n</section>"


def test_cells_are_escaped_unless_they_are_markup():
    html = table([HtmlColumn("a<"), HtmlColumn("b", "1/m", holds="text")], [Row(["<i>", Markup("<b>x</b>")], "fails")])
    assert "<th>a&lt;</th>" in html
    assert '<th class="text">b<br><span class="unit">1/m</span></th>' in html
    assert '<tr class="fails"><td>&lt;i&gt;</td><td class="text"><b>x</b></td></tr>' in html


def test_a_name_may_be_broken_only_where_it_is_long():
    html = table([HtmlColumn("name", holds="key")], [Row(["OT4"]), Row(["x" * 61])])
    assert '<td class="key">OT4</td>' in html
    assert f'<td class="text">{"x" * 61}</td>' in html


def test_a_group_has_a_heading_over_all_columns():
    html = grouped([HtmlColumn("a"), HtmlColumn("b")], [Group("X2 & more", [Row(["1", "2"])], "said <so>")])
    assert '<tr class="group"><th colspan="2">X2 &amp; more<small>said &lt;so&gt;</small></th></tr>' in html


def test_a_footer_names_what_there_is():
    html = footer(
        {"versions": {"coast": "1"}, "options": {"hold_out": [], "pair": "A/B", "runs": ["x", "y"]}, "seed": 3}
    )
    assert html.count("<code>") == 4
    assert "hold_out" not in html
    assert "runs x, y" in html
    assert "seed 3" in html


def test_without_matplotlib_a_figure_is_nothing(monkeypatch):
    monkeypatch.setitem(sys.modules, "matplotlib.figure", None)
    assert figure(Picture((1.0, 1.0), lambda _: None), "a picture") == ""


def luminance(colour):
    """Relative luminance of a colour of the style (WCAG 2)."""
    digits = colour.lstrip("#")
    digits = "".join(2 * mark for mark in digits) if len(digits) == 3 else digits
    parts = [int(digits[at : at + 2], 16) / 255 for at in (0, 2, 4)]
    linear = [part / 12.92 if part <= 0.03928 else ((part + 0.055) / 1.055) ** 2.4 for part in parts]
    return 0.2126 * linear[0] + 0.7152 * linear[1] + 0.0722 * linear[2]


def contrast(one, other):
    low, high = sorted((luminance(one), luminance(other)))
    return (high + 0.05) / (low + 0.05)


@pytest.mark.parametrize("dark", [False, True])
def test_every_colour_of_text_stands_out_from_every_ground_it_may_stand_on(dark):
    """As a browser would show it; the test that looks at one runs only where one is installed."""
    light, _, rest = _STYLE.partition("@media (prefers-color-scheme: dark)")
    style = rest[: rest.index("@page")] if dark else light
    rules = re.findall(r"([^{}]+)\{([^{}]*)\}", style)
    texts = {colour for _, said in rules for colour in re.findall(r"(?<![-\w])color: (#\w+)", said)}
    grounds = {
        selector.strip(): colour
        for selector, said in rules
        for colour in re.findall(r"background: (#\w+)", said)
        if "img" not in selector
    }
    body = next(colour for selector, colour in grounds.items() if selector.endswith("body"))
    ink = re.search(r"body \{[^}]*[ ;]color: (#\w+)", style)[1]
    assert len(texts) >= 5
    assert {colour: contrast(colour, body) for colour in texts if contrast(colour, body) < 4.5} == {}
    assert {colour: contrast(ink, colour) for colour in grounds.values() if contrast(ink, colour) < 4.5} == {}


def test_what_is_wide_scrolls_in_its_own_place():
    html = table([HtmlColumn("a")], [Row(["1"])])
    assert html.startswith('<div class="wide"><table>')
    assert ".wide { overflow-x: auto;" in _STYLE
    assert "img { display: block; max-width: 100%;" in _STYLE
    assert not re.search(r"(?<!max-)(?<!min-)\bwidth: \d+(px|rem|em)", _STYLE)
