"""Pieces of a page: text is escaped, words in backticks are code, a long name may be broken."""

import sys

from coast_cli.output.html import (
    Column,
    Group,
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
    html = table([Column("a<"), Column("b", "1/m", holds="text")], [Row(["<i>", Markup("<b>x</b>")], "fails")])
    assert "<th>a&lt;</th>" in html
    assert '<th class="text">b<br><span class="unit">1/m</span></th>' in html
    assert '<tr class="fails"><td>&lt;i&gt;</td><td class="text"><b>x</b></td></tr>' in html


def test_a_name_may_be_broken_only_where_it_is_long():
    html = table([Column("name", holds="key")], [Row(["OT4"]), Row(["x" * 61])])
    assert '<td class="key">OT4</td>' in html
    assert f'<td class="text">{"x" * 61}</td>' in html


def test_a_group_has_a_heading_over_all_columns():
    html = grouped([Column("a"), Column("b")], [Group("X2 & more", [Row(["1", "2"])], "said <so>")])
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
