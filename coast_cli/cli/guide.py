"""``coast guide``: the pages of the guide, in the terminal."""

from __future__ import annotations

from pathlib import Path
from typing import Annotated

import typer

PAGES = Path(__file__).parents[1] / "guide"


def guide(
    topic: Annotated[
        str | None, typer.Argument(metavar="[TOPIC]", help="the page to print; default: the list of pages")
    ] = None,
) -> None:
    """Print a page of the guide, one a topic; without a topic, list the pages.

    In a terminal that is narrower than the page its text is filled anew; a file or a pipe gets it as it stands.
    """
    from coast_cli.errors import UsageError, nearest
    from coast_cli.output.page_text import fitted
    from coast_cli.output.standard_streams import to_stdout
    from coast_cli.output.view import stdout_width

    pages = {path.stem: path.read_text(encoding="utf-8") for path in sorted(PAGES.glob("*.md"))}
    if topic is None:
        width = max(map(len, pages))
        text = "".join(_line(f"{name:{width}}  ", _title(page)) for name, page in pages.items())
    elif topic in pages:
        text = fitted(pages[topic], stdout_width(), topic)
    else:
        hint = nearest(topic, pages) or "`coast guide` lists them."
        raise UsageError(f"{topic}: there is no page of that name in the guide. {hint}")
    to_stdout(lambda stream: stream.write(text))


def _line(name: str, title: str) -> str:
    """Return the line of a page, its title below its name where the terminal is too narrow."""
    from textwrap import fill

    from coast_cli.output.view import stdout_width

    width = stdout_width() or len(name) + len(title)
    indent = " " * min(len(name), max(width - 12, 2))
    return f"{fill(title, width, initial_indent=name, subsequent_indent=indent, break_on_hyphens=False)}\n"


def _title(page: str) -> str:
    return page.partition("\n")[0].removeprefix("# ")
