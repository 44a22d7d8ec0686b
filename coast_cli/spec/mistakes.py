"""Everything that is wrong with a configuration at once, for who mends it; a command that runs on it needs the first only."""

from __future__ import annotations

from collections.abc import Callable, Iterator
from itertools import islice
from pathlib import Path

from coast_cli.errors import BadInput
from coast_cli.spec.build import build
from coast_cli.spec.config import Config
from coast_cli.spec.explore import check_explore
from coast_cli.spec.load import read_document, read_text
from coast_cli.spec.transmission import is_transmission
from coast_cli.spec.tubes import MISSING, rules

_MOST = 1000


def mistakes(path: str | Path) -> tuple[Config | None, list[BadInput]]:
    """Return a configuration, or None with every mistake that can be told apart, in the order of the file.

    A text that is no TOML has one, as nobody knows how it goes on. Keys and values are looked at first, then each tube and
    table, and only where those are right what needs them together.
    """
    try:
        config, refused = read_document(read_text(path), str(path))
    except BadInput as error:
        return None, [error]
    found = _without_consequences(list(islice(refused, _MOST)))
    if config is not None:
        found = list(_of_design(config))
    if config is None or found:
        return None, sorted(found, key=lambda error: (error.line or 0, error.column or 0))
    return config, []


def _of_design(config: Config) -> Iterator[BadInput]:
    told = set[str]()
    for rule in rules(config):
        if not (rule.of_all and told):
            yield from _new(rule.check, told)
    yield from _new(lambda: check_explore(config), told)
    if not told and not is_transmission(config):
        yield from _new(lambda: _check_joint(config), told)


def _new(check: Callable[[], object], told: set[str]) -> Iterator[BadInput]:
    """Yield what a check refuses, unless that was said before: tubes share what their stock says."""
    try:
        check()
    except BadInput as error:
        if str(error) not in told:
            told.add(str(error))
            yield error


def _check_joint(config: Config) -> None:
    design = build(config)
    if config.joint is not None and design.joint_pair is not None:
        design.joint()


def _without_consequences(found: list[BadInput]) -> list[BadInput]:
    """Leave out a key that is missing because it is misspelt beside, and a list that is empty because its items are wrong."""
    hints = {(_table(error), error.hint or "") for error in found if error.message != MISSING}

    def follows(error: BadInput) -> bool:
        name = (error.key or "").rpartition(".")[2]
        return error.message == MISSING and any(table == _table(error) and name in hint for table, hint in hints)

    keys = {error.key or "" for error in found}
    emptied = {key for key in keys if any(other.startswith(f"{key}[") for other in keys)}
    return [error for error in found if not (follows(error) or error.key in emptied)]


def _table(error: BadInput) -> str:
    return (error.key or "").rpartition(".")[0]
