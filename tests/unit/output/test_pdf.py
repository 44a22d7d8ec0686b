"""A report as a PDF: by whatever prints here, and one sentence where nothing does."""

import sys
from types import SimpleNamespace

import pytest

import coast_cli as coast
from coast_cli.output import pdf
from tests.conftest import REFERENCE

PAGE = "<!doctype html><title>a</title><p>one</p>"


def browser_that(body, folder):
    """A program in place of a browser; what it is told to print goes where it is told."""
    program = folder / "browser"
    program.write_text(
        f"#!{sys.executable}\nimport sys\nwords = dict(w.split('=', 1) for w in sys.argv if '=' in w)\n{body}\n"
    )
    program.chmod(0o755)
    return str(program)


def test_a_browser_prints_it(tmp_path, monkeypatch):
    body = "open(words['--print-to-pdf'], 'wb').write(b'%PDF-1.4 ' + sys.argv[-1].encode())"
    monkeypatch.setattr(pdf, "browser", lambda: browser_that(body, tmp_path))
    path = tmp_path / "report.pdf"
    coast.report(coast.load_config(REFERENCE), path, samples=0, curvatures=[20.0], bending_lengths=[0.02])
    assert path.read_bytes().startswith(b"%PDF-1.4 file://")


@pytest.mark.parametrize("body", ["sys.exit(1)", "pass"])
def test_a_browser_that_does_not_print_leaves_no_file(tmp_path, monkeypatch, body):
    monkeypatch.setattr(pdf, "browser", lambda: browser_that(body, tmp_path))
    with pytest.raises(coast.UsageError, match=r"did not print the page: write an \.html file"):
        pdf.pdf_of(PAGE)


def test_without_a_browser_weasyprint_prints_it(monkeypatch):
    printer = SimpleNamespace(HTML=lambda string: SimpleNamespace(write_pdf=lambda: b"%PDF-1.7 " + string.encode()))
    monkeypatch.setattr(pdf, "browser", lambda: None)
    monkeypatch.setattr(pdf, "find_spec", lambda name: name)
    monkeypatch.setitem(sys.modules, "weasyprint", printer)
    assert pdf.pdf_of(PAGE) == b"%PDF-1.7 " + PAGE.encode()


def test_where_nothing_prints_it_is_one_sentence_before_any_work(tmp_path, monkeypatch):
    monkeypatch.setattr(pdf, "browser", lambda: None)
    monkeypatch.setattr(pdf, "find_spec", {}.get)
    with pytest.raises(coast.UsageError, match=r"needs chromium, google-chrome or weasyprint .* write report\.html"):
        coast.report(coast.load_config(REFERENCE), tmp_path / "report.pdf")
    assert list(tmp_path.iterdir()) == []
