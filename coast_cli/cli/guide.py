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
    """Print a page of the guide, one a topic; without a topic, list the pages."""
    from coast_cli.errors import UsageError, nearest
    from coast_cli.output.standard_streams import to_stdout

    pages = {path.stem: path.read_text(encoding="utf-8") for path in sorted(PAGES.glob("*.md"))}
    if topic is None:
        width = max(map(len, pages))
        text = "".join(f"{name:{width}}  {_title(page)}\n" for name, page in pages.items())
    elif topic in pages:
        text = pages[topic]
    else:
        hint = nearest(topic, pages) or "`coast guide` lists them."
        raise UsageError(f"{topic}: there is no page of that name in the guide. {hint}")
    to_stdout(lambda stream: stream.write(text))


def _title(page: str) -> str:
    return page.partition("\n")[0].removeprefix("# ")
