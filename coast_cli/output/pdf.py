"""A page as a PDF: printed by a browser without a window, or by weasyprint, whichever is there."""

from __future__ import annotations

import shutil
import subprocess
import sys
from importlib import import_module
from importlib.util import find_spec
from pathlib import Path
from tempfile import TemporaryDirectory

from coast_cli.errors import UsageError

BROWSERS = ("chromium", "chromium-browser", "google-chrome", "google-chrome-stable", "chrome", "msedge")
_QUIET = (
    "--headless",
    "--disable-gpu",
    "--no-first-run",
    "--disable-extensions",
    "--disable-background-networking",
    "--no-pdf-header-footer",
)
_SECONDS = 120


def browser() -> str | None:
    """Return the program of a browser that prints, or None."""
    return next(filter(None, map(shutil.which, BROWSERS)), None)


def require_printer(path: Path) -> None:
    """Refuse a PDF where nothing can print one.

    Raises:
        UsageError: saying what to install, or to print the page by hand.
    """
    if browser() is None and find_spec("weasyprint") is None:
        raise UsageError(
            f"{path}: a PDF needs chromium, google-chrome or weasyprint (pip install weasyprint), and none is here: "
            f"write {path.stem}.html and print it from a browser."
        )


def pdf_of(page: str) -> bytes:
    """Return an HTML page as a PDF; it says when it was printed, so that its bytes are not always the same.

    Raises:
        UsageError: nothing can print, or the browser did not.
    """
    program = browser()
    if program is None:
        require_printer(Path("report.pdf"))
        content: bytes = import_module("weasyprint").HTML(string=page).write_pdf()
        return content
    with TemporaryDirectory(prefix="coast-") as folder:
        source, printed = Path(folder) / "page.html", Path(folder) / "page.pdf"
        source.write_text(page, encoding="utf-8")
        own = (f"--user-data-dir={folder}/profile", f"--print-to-pdf={printed}", source.as_uri())
        try:
            subprocess.run([program, *_QUIET, *_alone(), *own], capture_output=True, check=True, timeout=_SECONDS)
            return printed.read_bytes()
        except (OSError, subprocess.SubprocessError):
            raise UsageError(f"{program} did not print the page: write an .html file and print that.") from None


def _alone() -> tuple[str, ...]:
    """Return what a browser needs for the superuser, whom its sandbox refuses; the page is our own and has no script."""
    if sys.platform == "win32":
        return ()
    from os import geteuid

    return ("--no-sandbox",) if geteuid() == 0 else ()
