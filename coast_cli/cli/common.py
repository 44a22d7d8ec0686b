"""Options that commands have without saying so: values that stand for the file's, what is shown, how much is said."""

from __future__ import annotations

from collections.abc import Callable, Mapping
from contextlib import nullcontext
from functools import wraps
from inspect import Parameter, signature
from pathlib import Path
from typing import Annotated, Any, get_type_hints

import typer

from coast_cli.cli.paths import READS
from coast_cli.errors import UsageError
from coast_cli.output.view import VIEW, View

_TABLE: dict[str, Any] = {
    "wide": Annotated[bool, typer.Option("--wide", help="show every column, however narrow the terminal")],
    "show": Annotated[str | None, typer.Option("--show", metavar="NAME,...", help="show these columns, in this order")],
    "sort": Annotated[
        str | None, typer.Option("--sort", metavar="NAME", help="sort by a column; -NAME: largest first")
    ],
    "top": Annotated[int | None, typer.Option("--top", min=1, help="show so many rows only")],
}
_CHANGES: Any = Annotated[
    list[str] | None,
    typer.Option("--set", metavar="KEY=VALUE", help="another value than the file's, repeatable: joint.deadband_mm=1.1"),
]
_EFFECTS: Any = Annotated[
    list[Path] | None,
    typer.Option("--effects", metavar="FILE.py", help="effects of your own (a program, which is run); repeatable"),
    READS,
]
# Work that is shared out starts new processes, which know the built-in effects alone.
_SHARED_OUT = {"explore", "tolerance"}
_QUIET: Any = Annotated[bool, typer.Option("--quiet", "-q", help="no notes and no progress on stderr, errors only")]


def with_common_options(command: Callable[..., Any], *, prints_table: bool) -> Callable[..., Any]:
    """Return a command that takes the common options too: those of tables where it prints one."""
    hints = get_type_hints(command, include_extras=True)
    parameters = signature(command).parameters
    reads = [name for name in ("config", "configs") if name in parameters]
    takes_effects = (reads and command.__name__ not in _SHARED_OUT) or command.__name__ in {"explain", "effects"}
    options = {
        **({"changes": _CHANGES} if reads else {}),
        **({"own_effects": _EFFECTS} if takes_effects else {}),
        **(_TABLE if prints_table else {}),
        "quiet": _QUIET,
    }
    added = {name: hint for name, hint in options.items() if name not in parameters}

    @wraps(command)
    def run(**given: Any) -> Any:  # noqa: ANN401
        own = {name: given.pop(name) for name in added}
        changes, files = own.pop("changes", None) or [], own.pop("own_effects", None) or []
        _refuse_swapped(given)
        token = VIEW.set(View(show=_names(own.pop("show", None)), **own))
        try:
            with _using(files), _changing([given[name] for name in reads], changes):
                return command(**given)
        finally:
            VIEW.reset(token)

    plain = [parameters[name].replace(annotation=hints[name]) for name in parameters]
    more = [
        Parameter(name, Parameter.KEYWORD_ONLY, annotation=hint, default=False if name in {"wide", "quiet"} else None)
        for name, hint in added.items()
    ]
    run.__signature__ = signature(command).replace(parameters=[*plain, *more])  # type: ignore[attr-defined]
    run.__annotations__ = {**hints, **added}
    return run


def _names(text: str | None) -> tuple[str, ...]:
    return tuple(name.strip() for name in (text or "").split(",") if name.strip())


def _using(files: list[Path]) -> Any:  # noqa: ANN401
    """Return what lets effects of the user's own take part."""
    if not files:
        return nullcontext()
    from coast_cli.effects.own import using_effects

    return using_effects(files)


def _changing(given: list[Any], changes: list[str]) -> Any:  # noqa: ANN401
    """Return what puts changes in place of what the configurations given say."""
    if not changes:
        return nullcontext()
    from coast_cli.spec.changes import changing

    files = [file for one in given for file in (one if isinstance(one, list) else [one]) if file is not None]
    if not files:
        raise UsageError("--set changes what a configuration says: name one.")
    return changing(files, changes)


def _refuse_swapped(given: Mapping[str, Any]) -> None:
    """Refuse a recording where the configuration belongs; what its text would be refused for says nothing of that.

    Raises:
        UsageError: saying the order.
    """
    config = given.get("config")
    read = [*(given.get("recordings") or ()), given.get("path"), given.get("protocol")]
    named = [path for path in read if isinstance(path, Path) and path.suffix.lower() == ".toml"]
    if named and isinstance(config, Path) and config.suffix.lower() != ".toml":
        raise UsageError(f"{config} is not a configuration and {named[0]} is: the configuration comes first.")
