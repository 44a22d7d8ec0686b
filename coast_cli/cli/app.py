"""The command line as a whole: which commands there are, and that only the one asked for is loaded."""

from __future__ import annotations

import os
from collections.abc import Callable
from contextlib import nullcontext, redirect_stdout
from functools import wraps
from importlib import import_module
from io import StringIO
from typing import Annotated, Any

import typer

from coast_cli.cli.common import with_common_options
from coast_cli.cli.examples import epilog
from coast_cli.cli.paths import kept_apart
from coast_cli.errors import UsageError, nearest
from coast_cli.output.standard_streams import to_stdout
from coast_cli.version import __version__

INTERRUPTED = 130
_COMPLETES = "_COAST_COMPLETE"  # set by the shell that asks how a line may go on
FIRST = """coast: design and test the COAST guidewire robot.

What to do first:
  coast init                    write a commented configuration, tubes.toml
  coast rank-pairs tubes.toml   which outer and middle tube go together
  coast guide                   the pages of the guide, by topic
  coast help                    all commands; `coast help COMMAND` shows examples
"""
_HELP = {"help_option_names": ["-h", "--help"]}
# Each command and where its function is; `coast --help` loads them all, so their modules import nothing heavy.
COMMANDS = {
    "rank-pairs": "coast_cli.cli.rank_pairs:rank_pairs",
    "explore": "coast_cli.cli.explore:explore",
    "design": "coast_cli.cli.design:design",
    "snap": "coast_cli.cli.snap:snap",
    "stroke": "coast_cli.cli.stroke:stroke",
    "path": "coast_cli.cli.path:path",
    "beam": "coast_cli.cli.beam:beam",
    "pattern": "coast_cli.cli.pattern:pattern",
    "sensitivity": "coast_cli.cli.sensitivity:sensitivity",
    "check": "coast_cli.cli.check:check",
    "tolerance": "coast_cli.cli.tolerance:tolerance",
    "trace": "coast_cli.cli.trace:trace",
    "recordings": "coast_cli.cli.recordings:recordings",
    "calibrate": "coast_cli.cli.calibrate:calibrate",
    "compare": "coast_cli.cli.compare:compare",
    "diagnose": "coast_cli.cli.diagnose:diagnose",
    "plan": "coast_cli.cli.plan:plan",
    "report": "coast_cli.cli.report:report",
    "validate": "coast_cli.cli.validate:validate",
    "init": "coast_cli.cli.init:init",
    "schema": "coast_cli.cli.schema:schema",
    "explain": "coast_cli.cli.explain:explain",
    "effects": "coast_cli.cli.effects:effects",
    "guide": "coast_cli.cli.guide:guide",
}
# Those that print no table, or one of their own form.
TABLES = {*COMMANDS} - {"diagnose", "report", "init", "schema", "guide"}


def run(arguments: list[str]) -> int:
    """Run one command line and return its exit code.

    Raises:
        CoastError: what the command refuses, or that there is no such command.
        Exception: of the type that ``refusal`` returns, what typer refuses of the command line.
        KeyboardInterrupt: interrupted by the user.
    """
    if not arguments and _COMPLETES not in os.environ:
        to_stdout(lambda stream: stream.write(FIRST))
        return 0
    if arguments[:1] == ["help"]:
        arguments = [*arguments[1:], "--help"]
    asked = next((word for word in arguments if not word.startswith("-")), None)
    if asked is not None and asked not in COMMANDS:
        raise UsageError(f"there is no command {asked!r}. {_like(asked)} `coast --help` lists them.".replace("  ", " "))
    known = [asked] if asked in COMMANDS else list(COMMANDS)
    written = StringIO()  # help and version, which typer writes without a word for a full disk
    try:
        with redirect_stdout(written) if {"-h", "--help", "--version"} & {*arguments} else nullcontext():
            code = _app(known, listed=asked is None and _COMPLETES not in os.environ)(
                args=arguments, prog_name="coast", standalone_mode=False
            )
    except typer.Abort:  # what older versions of typer make of an interrupt
        raise KeyboardInterrupt from None
    to_stdout(lambda stream: stream.write(written.getvalue()))
    if code == INTERRUPTED:  # and what newer ones make of it, without a word
        raise KeyboardInterrupt
    return code if isinstance(code, int) else 0


def refusal() -> type[Exception]:
    """Return the type of what typer raises for a command line that it refuses; older versions raise click's own."""
    try:
        return import_module("typer.exceptions").TyperException  # type: ignore[no-any-return]
    except ModuleNotFoundError:
        return import_module("click").ClickException  # type: ignore[no-any-return]


def _app(names: list[str], *, listed: bool) -> Any:  # noqa: ANN401
    """Return the app of some commands; where they are only listed, without their options, which take time to read."""
    app = typer.Typer(rich_markup_mode=None, pretty_exceptions_enable=False, context_settings=_HELP)
    app.callback()(_coast)
    for name in names:
        module, function = COMMANDS[name].split(":")
        command = getattr(import_module(module), function)
        told = _telling(name, kept_apart(command))
        full = _nothing if listed else with_common_options(told, prints_table=name in TABLES)
        app.command(name, short_help=_first_sentence(command), epilog=epilog(name), context_settings=_HELP)(full)
    return app


def _nothing() -> None:
    """Stand for a command in a list."""


def _telling(name: str, command: Callable[..., Any]) -> Callable[..., Any]:
    """Return a command that gives a sign of life while it takes long."""

    @wraps(command)
    def run(**given: Any) -> Any:  # noqa: ANN401
        from coast_cli.output.progress import a_line_a_minute

        with a_line_a_minute(name):
            return command(**given)

    return run


def _first_sentence(command: Callable[..., object]) -> str:
    """Return what the list of commands says of one, whole where typer would cut it."""
    return " ".join((command.__doc__ or "").partition("\n\n")[0].partition(";")[0].split()).rstrip(".")


def _like(asked: str) -> str:
    begun = [name for name in COMMANDS if name.startswith(asked)]
    return f"Did you mean {' or '.join(begun)}?" if begun else nearest(asked, COMMANDS)


def _show_version(*, asked: bool) -> None:
    if asked:
        typer.echo(__version__)
        raise typer.Exit


def _coast(
    *,
    version: Annotated[
        bool, typer.Option("--version", help="Print the version and stop.", is_eager=True, callback=_show_version)
    ] = False,
) -> None:
    """Design and test the COAST guidewire robot: rank notched tube pairs, make stroke tables, check designs.

    Data goes to stdout, everything else to stderr. Exit codes: 0 fine, 1 checked and the answer is no, 2 usage,
    3 bad input, 4 not converged.
    """
