"""The report as a browser shows it: three sheets of A4, nothing wider than the window, no glyph missing, read in the dark too.

Where no browser is installed this witness is missing, and says so: a skip here is no pass. What can be held without one is
held in `test_report.py`, `unit/output/test_html.py` and `unit/output/test_figure_layout.py`: marks that the page's font has,
contrast of the style's colours in light and dark, tables that scroll in their place, as much as three sheets hold, and labels
that do not meet.
"""

import json
import re
import subprocess
from html import unescape
from pathlib import Path

import pytest

ROOT = Path(__file__).parents[2]
RECORDING = ROOT / "examples" / "diagnose" / "recording.csv"
# What cannot be seen from outside: how far elements stick out, whether marks have a glyph, contrast of text and ground.
PROBE = r"""<script>
const wide = [...document.querySelectorAll("p, li, h1, h2, h3, img, svg, figcaption, blockquote, footer, nav, .wide")]
  .filter(e => e.getBoundingClientRect().right > window.innerWidth + 1).map(e => e.tagName + " " + e.className);
const canvas = document.createElement("canvas"), pen = canvas.getContext("2d", { willReadFrequently: true });
canvas.width = canvas.height = 24;
const seen = mark => { pen.clearRect(0, 0, 24, 24); pen.font = "16px " + getComputedStyle(document.body).fontFamily;
  pen.fillText(mark, 2, 18); return pen.getImageData(0, 0, 24, 24).data.join(); };
const marks = [...new Set(document.body.innerText)].filter(m => m > "\x7f");
const missing = marks.filter(m => seen(m) === seen("\uffff") || seen(m) === seen(" ") && m.trim());
const light = colour => { const [r, g, b] = colour.match(/[\d.]+/g).map(v => (v / 255) ** 2.2);
  return .2126 * r + .7152 * g + .0722 * b; };
const contrast = [...document.querySelectorAll("body, a, .good, .bad, .unit, .quiet, figcaption, mark")].map(e => {
  let ground = e;
  while (/, 0\)$/.test(getComputedStyle(ground).backgroundColor) && ground.parentElement) ground = ground.parentElement;
  const both = [light(getComputedStyle(e).color), light(getComputedStyle(ground).backgroundColor)].sort((a, b) => b - a);
  return (both[0] + .05) / (both[1] + .05); });
const dark = matchMedia("(prefers-color-scheme: dark)").matches;
document.title = JSON.stringify({ wide, missing, marks: marks.length, dark, contrast: Math.min(...contrast),
  across: document.documentElement.scrollWidth - window.innerWidth });
</script>"""


@pytest.fixture(scope="module")
def browser(tmp_path_factory):
    """Run a browser without a window; where none is installed there is nothing to look with."""
    from coast_cli.output.pdf import browser as browser_here

    program = browser_here()
    if program is None:
        pytest.skip("not here: chromium or google-chrome")

    profile = tmp_path_factory.mktemp("profile")  # a home may be read-only, and is one for all tests

    def run(*words):
        own = f"--user-data-dir={profile}"
        quiet = (own, "--headless", "--no-sandbox", "--disable-gpu", "--hide-scrollbars", "--no-pdf-header-footer")
        ran = subprocess.run([program, *quiet, *words], capture_output=True, check=True, timeout=600)
        return ran.stdout.decode(errors="replace")

    try:
        run("--dump-dom", "about:blank")
    except (OSError, subprocess.CalledProcessError):  # Ubuntu's chromium-browser asks for a snap
        pytest.skip("not here: a chromium that starts")
    return run


@pytest.fixture(scope="module")
def page(tmp_path_factory):
    """The report of the reference input and the example's recording."""
    from coast_cli.__main__ import main

    pytest.importorskip("matplotlib", reason="not here: matplotlib, the extra [plot]")
    path = tmp_path_factory.mktemp("browser") / "report.html"
    words = ["report", ROOT / "configs" / "tubes.toml", RECORDING, "--samples", "2000", "-o", path]
    assert main([str(word) for word in words]) == 0
    return path


def looked_at(browser, page, *words):
    probed = page.with_name("probed.html")
    probed.write_text(page.read_text(encoding="utf-8").replace("</body>", f"{PROBE}</body>"), encoding="utf-8")
    shown = browser(*words, "--virtual-time-budget=5000", "--dump-dom", probed.as_uri())
    return json.loads(unescape(re.search(r"<title>(.*?)</title>", shown, re.DOTALL)[1]))


def test_it_prints_on_three_sheets(browser, page):
    pdf = page.with_suffix(".pdf")
    browser(f"--print-to-pdf={pdf}", page.as_uri())
    assert len(re.findall(rb"/Type\s*/Page\b(?!s)", pdf.read_bytes())) == 3


@pytest.mark.parametrize("width", [500, 800, 1400])
def test_nothing_sticks_out_of_the_window(browser, page, width):
    found = looked_at(browser, page, f"--window-size={width},1000")
    assert found["wide"] == []
    assert found["across"] <= 0


def test_every_mark_has_a_glyph(browser, page):
    found = looked_at(browser, page, "--window-size=900,1000")
    assert found["missing"] == []
    assert found["marks"] >= 5


@pytest.mark.parametrize("dark", [False, True])
def test_text_stands_out_from_its_ground(browser, page, dark):
    found = looked_at(browser, page, "--window-size=900,1000", *(["--force-dark-mode"] if dark else []))
    assert found["dark"] == dark
    assert found["contrast"] >= 4.5
