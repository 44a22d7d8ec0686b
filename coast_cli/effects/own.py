"""Effects of a user's own: classes of a Python file, or of an installed package, that stand in the catalogue like any other.

Such a file is a program: it is run. What it holds is tried on a small joint and a small tube before it takes part, so that a
class that breaks the contract is refused with the reason instead of spoiling a diagnosis.
"""

from __future__ import annotations

import sys
from collections.abc import Iterable, Iterator, Sequence
from contextlib import contextmanager
from functools import cache
from pathlib import Path
from typing import TYPE_CHECKING

from coast_cli.errors import BadInput

if TYPE_CHECKING:
    from types import ModuleType

    from coast_cli.effects.effect import Effect

GROUP = "coast.effects"  # of entry points, each an effect's class
_LARGEST = 1_000_000  # bytes
# File and SHA-256 of what takes part now, for the provenance of answers.
SOURCES: list[tuple[str, str]] = []


@contextmanager
def using_effects(files: Sequence[Path]) -> Iterator[None]:
    """Let the effects of files take part, besides those of installed packages, as long as the context lasts.

    Raises:
        BadInput: a file is no Python or fails, holds no effect, or one that breaks the contract.
    """
    from coast_cli.effects.catalogue import CATALOGUE

    add_installed()
    before, said = dict(CATALOGUE), list(SOURCES)
    try:
        for file in files:
            _add(_classes_of(file), str(file))
        yield
    finally:
        CATALOGUE.clear()
        CATALOGUE.update(before)
        SOURCES[:] = said


@cache
def add_installed() -> None:
    """Let the effects of installed packages take part, once.

    Raises:
        BadInput: one cannot be loaded, or breaks the contract.
    """
    from importlib.metadata import entry_points

    for point in entry_points(group=GROUP):
        named = f"{point.value} (entry point {point.name} of {GROUP})"
        try:
            kind = point.load()
        except Exception as error:
            raise BadInput(f"cannot be loaded: {type(error).__name__}: {error}", file=named) from error
        _add([kind], named)


def _add(kinds: Iterable[object], file: str) -> None:
    from coast_cli.effects.catalogue import CATALOGUE
    from coast_cli.effects.contract import broken
    from coast_cli.effects.effect import Effect

    for kind in kinds:
        if not (isinstance(kind, type) and issubclass(kind, Effect)):
            raise BadInput("is no effect's class", file=file, allowed="a class made of stages, as OnStructure")
        reason = f"there is an effect {kind.id!r} already" if getattr(kind, "id", "") in CATALOGUE else broken(kind)
        if reason is not None:
            raise BadInput(f"{kind.__name__} is no effect: {reason}", file=file, line=_line_of(kind))
        CATALOGUE[kind.id] = kind


def _line_of(kind: type[Effect]) -> int | None:
    from inspect import getsourcelines

    try:
        return getsourcelines(kind)[1]
    except (OSError, TypeError):
        return None


def _classes_of(file: Path) -> list[type[Effect]]:
    """Run a file and return the effects that it defines itself, in their order."""
    from coast_cli.effects.effect import Effect

    module = _run(file)
    found = [v for v in vars(module).values() if isinstance(v, type) and issubclass(v, Effect)]
    own = [kind for kind in found if kind.__module__ == module.__name__ and not kind.__name__.startswith("_")]
    if not own:
        hint = "`coast guide effects` has an example."
        raise BadInput(
            "there is no effect in it", file=file, allowed="a class made of stages, as OnStructure", hint=hint
        )
    return own


def _run(file: Path) -> ModuleType:
    from hashlib import sha256
    from importlib.util import module_from_spec, spec_from_file_location

    try:
        text = file.read_bytes()
    except OSError as error:
        raise BadInput(f"cannot be read: {error.strerror}", file=file) from error
    if file.suffix != ".py" or len(text) > _LARGEST:
        raise BadInput("is no file of effects", file=file, allowed=f"a .py file of at most {_LARGEST // 1000} kB")
    digest = sha256(text).hexdigest()
    name = f"coast_effects_{digest[:12]}"
    spec = spec_from_file_location(name, file)
    if spec is None or spec.loader is None:
        raise BadInput("is no file of effects", file=file, allowed="a .py file")
    module = module_from_spec(spec)
    sys.modules[name] = module  # where its dataclasses look for their own names
    try:
        spec.loader.exec_module(module)
    except Exception as error:
        raise BadInput(
            f"fails when it is run: {type(error).__name__}: {error}", file=file, line=_failed(error, file)
        ) from error
    SOURCES.append((str(file), digest))
    return module


def _failed(error: Exception, file: Path) -> int | None:
    from traceback import extract_tb

    if isinstance(error, SyntaxError):
        return error.lineno
    lines = [frame.lineno for frame in extract_tb(error.__traceback__) if Path(frame.filename) == file]
    return lines[-1] if lines else None
