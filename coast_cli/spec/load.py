"""Read a configuration: bytes to text to TOML to document, each refusal one sentence with its place."""

from __future__ import annotations

import re
import tomllib
from collections.abc import Iterator
from pathlib import Path
from typing import TYPE_CHECKING, Any, get_args

from pydantic import BaseModel, ValidationError

from coast_cli.errors import BadInput, nearest
from coast_cli.spec.changes import changed
from coast_cli.spec.config import Config, Origin
from coast_cli.spec.explore import check_explore
from coast_cli.spec.positions import key_positions
from coast_cli.spec.transmission import NOTCHED, TRANSMISSION, TransmissionFields
from coast_cli.spec.tubes import MISSING, check_tubes
from coast_cli.spec.values import NUMBER, REFUSED, TABLE

if TYPE_CHECKING:
    from pydantic_core import ErrorDetails

    from coast_cli.spec import positions

REFERENCE = Path(__file__).with_name("reference.toml")
LARGEST_FILE = 5_000_000
_ADVICE = {
    "missing": MISSING,
    "extra_forbidden": "there is no such key",
    "too_short": "nothing in it",
}
_TAGS = {
    NUMBER,
    TABLE,
    "[key]",
    NOTCHED,
    TRANSMISSION,
}  # in pydantic's locations: the tags of a union, and the key of a dict
_EXPECTED = {"model_type": "a table", "dict_type": "a table", "tuple_type": "a list"}


def load_config(path: str | Path) -> Config:
    """Read and validate a TOML configuration; ``path`` is text or a Path.

    Raises:
        BadInput: the file cannot be read, is not UTF-8 or not TOML, or breaks a rule of the document or geometry.

    Example:
        >>> coast.load_config(coast.REFERENCE).environment.gravity_m_per_s2
        9.81
    """
    return load_config_text(read_text(path), str(path))


def load_config_text(text: str, name: str = "<text>") -> Config:
    """Validate the text of a configuration; ``name`` stands for its file in errors.

    Example:
        >>> coast.load_config_text("gravity = 9.81")
        Traceback (most recent call last):
        coast_cli.errors.BadInput: <text>:1:1: gravity: there is no such key; allowed: ...
    """
    config, refused = read_document(text, name)
    if config is None:
        raise next(refused)
    check_tubes(config)
    check_explore(config)
    return config


def read_document(text: str, name: str) -> tuple[Config | None, Iterator[BadInput]]:
    """Return what a text says, or None with what is wrong with its keys and values, the one to tell first before others.

    Raises:
        BadInput: it is no TOML, or empty.
    """
    try:
        tables = tomllib.loads(text)
    except ValueError as error:  # TOMLDecodeError, or an integer of thousands of digits
        raise not_toml(error, text, name) from None
    except RecursionError:
        raise BadInput("nested too deeply", file=name) from None
    if not tables:
        raise BadInput("the file is empty", file=name, line=1, hint="Run `coast init` for a commented example.")
    origin = Origin(name, key_positions(text), text)
    try:
        config = Config.model_validate(tables)
    except ValidationError as error:
        return None, _refusals(error.errors(include_url=False), origin)
    config._origin = origin  # noqa: SLF001  # the one place that knows it
    return config, iter(())


def read_text(path: str | Path) -> str:
    """Return the text of a UTF-8 file; a folder, a huge file or one that cannot be read is refused."""
    path = Path(path)
    try:
        with path.open("rb") as stream:
            data = stream.read(LARGEST_FILE + 1)  # of a pipe nobody knows the size
        if len(data) > LARGEST_FILE:
            raise BadInput("the file is too large", file=path, allowed=f"at most {LARGEST_FILE} bytes")
        return changed(data.decode("utf-8-sig"), str(path))
    except FileNotFoundError:
        raise BadInput("there is no such file", file=path, hint=_similar_files(path)) from None
    except IsADirectoryError:
        raise BadInput("this is a folder, not a file", file=path) from None
    except PermissionError:
        raise BadInput("no permission to read it", file=path) from None
    except UnicodeDecodeError as error:
        line = error.object.count(b"\n", 0, error.start) + 1
        found = f"byte 0x{error.object[error.start]:02x}"
        raise BadInput("not UTF-8 text", file=path, line=line, found=found, allowed="UTF-8") from None
    except (OSError, ValueError) as error:
        reason = getattr(error, "strerror", None) or error
        raise BadInput(f"cannot be read ({reason})", file=path) from None


def _similar_files(path: Path) -> str | None:
    try:
        names = [entry.name for entry in path.parent.iterdir()]
    except OSError:
        return None
    return nearest(path.name, names) or None


def not_toml(error: ValueError, text: str, name: str) -> BadInput:
    """Return what ``tomllib`` says of a text, with its place."""
    place = re.search(r"\(at line (\d+), column (\d+)\)", str(error))
    message = re.sub(r"\s*\(at .*\)$", "", str(error))
    line, column = (int(place[1]), int(place[2])) if place else (text.count("\n") + 1, None)
    return BadInput(f"not valid TOML: {message[:1].lower()}{message[1:]}", file=name, line=line, column=column)


def _refusals(errors: list[ErrorDetails], origin: Origin) -> Iterator[BadInput]:
    """Return the refusals in order: misspelt keys first, since what they leave missing follows from them, then by place."""

    def order(error: ErrorDetails) -> tuple[bool, int]:
        place = origin.positions.get(_key_path(error))
        return (error["type"] != "extra_forbidden", place.line if place else 0)

    return (_refusal(error, origin) for error in sorted(errors, key=order))


def _refusal(error: ErrorDetails, origin: Origin) -> BadInput:
    path = _key_path(error)
    kind = error["type"]
    hint = None
    allowed = error.get("ctx", {}).get("allowed") if kind == REFUSED else _EXPECTED.get(kind)
    found: object = _shown(error["input"])
    if kind == "extra_forbidden":
        known = _known_keys(path[:-1], error["loc"])
        hint = nearest(str(path[-1]), known) or None
        found, allowed = None, ", ".join(known)
    elif kind == "missing":
        found = None
    message = _ADVICE.get(kind, error["msg"] if kind == REFUSED else "not allowed")
    return origin.refuse(path, message, found=found, allowed=allowed, hint=hint)


def _key_path(error: ErrorDetails) -> positions.Path:
    """Drop what pydantic adds to a location beyond keys and indices; the last of a key that is not known is its own."""
    *above, last = error["loc"]
    path = tuple(part for part in above if part not in _TAGS)
    return path if last in _TAGS and error["type"] != "extra_forbidden" else (*path, last)


def _shown(value: object) -> object:
    if isinstance(value, dict):
        return "a table"
    return "a list" if isinstance(value, list) and len(value) > 6 else value


def _known_keys(path: positions.Path, location: tuple[int | str, ...]) -> list[str]:
    """Return the keys that the table at a path may have; pydantic's location says which form a table has."""
    if path == ("joint",) and TRANSMISSION in location:
        return list(TransmissionFields.model_fields)
    kind: Any = Config
    for part in path:
        if isinstance(part, str):
            kind = kind.model_fields[part].annotation if _is_document(kind) else _item(kind)
        kind = _document_in(kind, keep_dict=True)
    return list(kind.model_fields) if _is_document(kind) else []


def _document_in(annotation: Any, *, keep_dict: bool) -> Any:  # noqa: ANN401
    """Return the document class inside an annotation such as ``tuple[Sample, ...] | None``."""
    if _is_document(annotation) or (keep_dict and getattr(annotation, "__origin__", None) is dict):
        return annotation
    for argument in get_args(annotation):
        found = _document_in(argument, keep_dict=keep_dict)
        if found is not None:
            return found
    return None


def _item(annotation: Any) -> Any:  # noqa: ANN401
    return get_args(annotation)[1]


def _is_document(annotation: Any) -> bool:  # noqa: ANN401
    return isinstance(annotation, type) and issubclass(annotation, BaseModel)
