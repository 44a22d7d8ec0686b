"""A mapping proposed for a file that nobody has mapped: from its names, their units, its ranges and what follows what.

It is a file to edit: what was guessed stands beside what it was guessed from.
"""

from __future__ import annotations

import re
from dataclasses import dataclass
from pathlib import Path
from typing import TYPE_CHECKING

import numpy as np

from coast_cli.errors import BadInput
from coast_cli.recordings.columns import DRIVES, RESPONSES, Column, parse
from coast_cli.recordings.table import Dialect, Table, bytes_of, read_table
from coast_cli.units import unit_of

if TYPE_CHECKING:
    from collections.abc import Iterable, Sequence

    from numpy.typing import NDArray

    Floats = NDArray[np.float64]

TIME = ("time", "timestamp", "stamp", "seconds", "sec", "clock", "t")
DRIVE = ("stroke", "command", "cmd", "commanded", "drive", "motor", "setpoint", "desired", "reference", "ref", "target")
DRIVE_TOO = ("extension", "displacement", "input", "actuator", "servo", "spindle", "pull", "x1", "tension")
ANSWER = ("curvature", "kappa", "bend", "bending", "angle", "jaw", "tip", "measured", "actual", "position", "response")
ANSWER_TOO = ("output", "deflection", "force", "load", "y", "theta")
LOAD = ("load", "torque", "moment", "weight")
RUN = ("run", "trial", "test", "specimen", "sweep", "repeat", "rep")
NEITHER = ("current", "voltage", "temperature", "raw", "error", "velocity", "speed", "acceleration")
LENGTHS = ("x2", "bending", "length")
BRACKETS = re.compile(r"[\[(]\s*([^\[\]()]{1,8}?)\s*[\])]\s*$")
NO_DRIVE, NO_ANSWER = ("a moment", "a time", "a curvature"), ("a moment", "a time")
HEAD_LINES = 200
MOST_RUNS = 200
STEADY = 0.5  # of the mean step: what the steps of a clock spread by
RESTARTS = 0.05  # of the steps: a clock begins again with each run
FOLLOWS, COPIES = 0.3, 0.99999  # correlations: from which a response follows, and from which it is the drive again
_FORMS = {
    "a length": ("stroke", "position"),
    "a force": ("tension", "force"),
    "an angle": (None, "bend"),
    "a curvature": (None, "curvature"),
}


@dataclass(frozen=True, eq=False)
class _Candidate:
    """A column of numbers: its name, the words of it, its unit (what, suffix), its values (NaN where there is none)."""

    name: str
    words: tuple[str, ...]
    what: str | None
    suffix: str
    values: Floats

    def points(self, *lists: Sequence[str]) -> float:
        """Return how well its words go with lists of words, the first counting more."""
        found = [2.0 / (1 + rank) for rank, known in enumerate(lists) for word in self.words if word in known]
        return max(found, default=0.0)

    @property
    def is_odd(self) -> bool:
        """Whether a word says that it is neither drive nor response."""
        return any(word in NEITHER for word in self.words)


def suggest(path: str) -> str:
    """Return the text of a mapping file for a recording; lines that begin a guess end in what it rests on.

    Raises:
        BadInput: the file cannot be read, or holds no two columns of numbers that vary.
    """
    if Path(path).suffix.lower() == ".mat":
        from coast_cli.recordings.matlab import read_mat

        dialect, table = Dialect(), read_mat(path)[0]
    else:
        dialect = _dialect_of(path)
        table = read_table(path, dialect)
    lines = _of_our_names(table) or _guessed(table, path)
    head = f"# Proposed for {_plain(Path(path).name)}; edit it, then give it as the columns of a recording"
    return "\n".join([head, "[columns]", *lines, *_rows(dialect)]) + "\n"


def _of_our_names(table: Table) -> list[str]:
    """Return lines for a file that has our names already, both a drive and a response; none where it has not."""
    own = [column for column in map(parse, table.names) if isinstance(column, Column)]
    what = {column.quantity for column in own}
    if not (what & {*DRIVES} and what & {*RESPONSES}) and not {"x", "y"} <= what:
        return []
    return [_line(column.name, column.name) for column in own]


def _guessed(table: Table, path: str) -> list[str]:
    candidates = [one for one in (_candidate(table, name) for name in table.names) if one is not None]
    varied = [one for one in candidates if np.nanmax(one.values) > np.nanmin(one.values)]
    clock = _clock(varied)
    rest = [one for one in varied if one is not clock and one.name.lower() not in RUN]
    pair = _pair(rest)
    if pair is None:
        allowed = "a drive and a response, in columns of numbers that vary"
        raise BadInput("nothing to suggest", file=path, found=", ".join(table.names), allowed=allowed)
    drive, response, follows = pair
    load = _best((one for one in rest if one not in (drive, response)), LOAD, ("a force", "a moment"), drive, response)
    lines = []
    if clock is not None:
        lines.append(_line(f"time{clock.suffix if clock.what == 'a time' else '_s'}", clock.name))
    lines += [_drive_line(drive), _response_line(response, drive, follows)]
    if load is not None:
        lines.append(_line(f"load{load.suffix}", load.name, note="what the far end carries? else leave it out"))
    length = _best((one for one in candidates if one not in (drive, response)), LENGTHS, ("a length",), drive, response)
    if length is not None:
        lines.append(_line(f"bending_length{length.suffix}", length.name))
    runs = _runs(table, (clock, drive, response, load))
    return [*lines, f"run = {_quoted(runs if len(runs) > 1 else runs[0])}"] if runs else lines


def _dialect_of(path: str) -> Dialect:
    """Return how a file is laid out: lines before the header, a mark of comments, a line of units, no header."""
    text = bytes_of(path)[: 2**20].decode("utf-8", "replace").removeprefix("\ufeff")
    lines = re.split(r"\r\n|\r|\n", text)[:HEAD_LINES]
    mark = next((mark for mark in ("%", "#", "//") if any(line.lstrip().startswith(mark) for line in lines)), None)
    kept = [
        (number, line)
        for number, line in enumerate(lines)
        if line.strip() and not (mark and line.lstrip().startswith(mark))
    ]
    shapes = [_cells(line) for _, line in kept]
    first = next(
        (at for at, cells in enumerate(shapes[:-1]) if _are_rows(shapes[at : at + 3]) and len(cells) > 1), None
    )
    if first is None:
        return Dialect(comment=mark)
    count = len(shapes[first])
    above = [at for at in range(max(first - 2, 0), first) if len(shapes[at]) == count]
    if not above:
        number = kept[first][0]
        return Dialect(_skipped(number, mark, lines), mark, tuple(f"column_{index}" for index in range(1, count + 1)))
    units_row = len(above) == 2 and all(len(cell) < 12 for cell in shapes[above[1]])
    header = kept[above[0] if units_row else above[-1]][0]
    return Dialect(_skipped(header, mark, lines), mark, units_row=units_row)


def _skipped(header: int, mark: str | None, lines: list[str]) -> int:
    """Return how many lines must be skipped: none where all before the header are empty or comments."""
    before = [line for line in lines[:header] if line.strip() and not (mark and line.lstrip().startswith(mark))]
    return header if before else 0


def _cells(line: str) -> list[str]:
    for separator in (";", "\t", ","):
        if separator in line:
            return [cell.strip().strip('"') for cell in line.split(separator)]
    return line.split()


def _are_rows(shapes: list[list[str]]) -> bool:
    """Whether lines have as many cells, most of them numbers."""
    numbers = [sum(_number(cell) for cell in cells) for cells in shapes]
    same = len({len(cells) for cells in shapes}) == 1
    return same and all(2 * many > len(cells) for many, cells in zip(numbers, shapes, strict=True))


def _number(cell: str) -> bool:
    return bool(re.fullmatch(r"[+-]?\d{0,40}[.,]?\d{0,40}([eE][+-]?\d{1,4})?", cell)) and any(map(str.isdigit, cell))


def _candidate(table: Table, name: str) -> _Candidate | None:
    try:
        values = table.numbers(name, may_be_missing=True)
    except BadInput:
        return None
    if not name or np.isnan(values).all():
        return None
    words = tuple(re.findall(r"[a-z]+\d*", re.sub(r"([a-z])([A-Z])", r"\1_\2", name)[:200].lower()))
    written = BRACKETS.search(name)  # "angle [deg]" says its unit as angle_deg does
    unit = unit_of(name if written is None else f"x_{written[1].replace('°', 'deg')}")
    what, suffix = (None, "") if unit is None else unit[:2]
    return _Candidate(name, words, what, suffix, values)


def _clock(candidates: list[_Candidate]) -> _Candidate | None:
    """Return the column that rises, by name, or all along in even steps."""
    steps = [(one, np.diff(one.values)) for one in candidates if not np.isnan(one.values).any()]
    named = [
        one
        for one, step in steps
        if (one.points(TIME) > 0.0 or one.what == "a time") and (step < 0.0).mean() < RESTARTS
    ]
    even = [one for one, step in steps if step.min() > 0.0 and np.std(step) < STEADY * np.mean(step)]
    return next(iter([*named, *even]), None)


def _pair(candidates: list[_Candidate]) -> tuple[_Candidate, _Candidate, float] | None:
    """Return the drive and the response that go best together by name, and how the one follows the other."""
    found: list[tuple[float, int, _Candidate, _Candidate, float]] = []
    for drive in candidates:
        for response in candidates:
            if (
                drive is response
                or drive.what in ("a moment", "a time", "a curvature")
                or response.what in ("a moment", "a time")
            ):
                continue
            follows = _correlation(drive.values, response.values)
            shared = len({*drive.words} & {*response.words} - {drive.suffix.strip("_")})
            points = drive.points(DRIVE, DRIVE_TOO) - drive.points(ANSWER) + response.points(ANSWER, ANSWER_TOO)
            points += (
                0.5 * min(shared, 1) + (2.0 * abs(follows) if abs(follows) > FOLLOWS else -3.0) - response.points(DRIVE)
            )
            points -= 3.0 * (drive.is_odd + response.is_odd) + 1.0 * (abs(follows) > COPIES)
            found.append((round(points, 6), -len(found), drive, response, follows))
    best = max(found, default=None)
    return None if best is None else best[2:]


def _correlation(one: Floats, other: Floats) -> float:
    both = np.isfinite(one) & np.isfinite(other)
    if both.sum() < 3 or np.ptp(one[both]) == 0.0 or np.ptp(other[both]) == 0.0:
        return 0.0
    with np.errstate(all="ignore"):
        found = float(np.corrcoef(one[both], other[both])[0, 1])
    return found if np.isfinite(found) else 0.0


def _best(
    candidates: Iterable[_Candidate],
    words: Sequence[str],
    kinds: Sequence[str],
    drive: _Candidate,
    response: _Candidate,
) -> _Candidate | None:
    """Return the column whose words and unit go with a load, best one named after the response."""
    beside = {*response.words} | {*drive.words}
    found = [
        (one.points(words) + len({*one.words} & {*response.words}) - 0.5 * len({*one.words} - beside), -index, one)
        for index, one in enumerate(candidates)
        if one.what in kinds and any(word in words for word in one.words)
    ]
    return max(found, default=(0.0, 0, None))[2]


def _drive_line(drive: _Candidate) -> str:
    ours = _FORMS.get(drive.what or "", (None, None))[0]
    if ours is not None:
        return _line(f"{ours}{drive.suffix}", drive.name)
    scale = {"_rad": 10.0}.get(drive.suffix, 0.1 if drive.what else 1.0)
    each = f" for each {drive.suffix[1:]}" if drive.suffix else ""
    return _line("stroke_mm", drive.name, scale=scale, note=f"mm{each} is a guess: give the radius that pulls")


def _response_line(response: _Candidate, drive: _Candidate, follows: float) -> str:
    note = f"follows {drive.name}, correlation {follows:.2f}"
    ours = _FORMS.get(response.what or "", (None, None))[1]
    sign = -1.0 if follows < 0.0 else 1.0
    if ours is None:
        return _line("bend_deg", response.name, scale=sign, note=f"{note}; its unit is a guess")
    return _line(f"{ours}{response.suffix}", response.name, scale=sign if sign < 0.0 else None, note=note)


def _runs(table: Table, taken: Sequence[_Candidate | None]) -> list[str]:
    """Return the columns that say which run a row is of: stretches of one text or number, each met once."""
    used = {one.name for one in taken if one is not None}
    found = []
    for name in table.names:
        if name not in used and {*re.findall(r"[a-z]+", name.lower())} & {*RUN}:
            texts = table.texts(name)[1]
            if 1 < len(texts) <= MOST_RUNS and all(texts):
                found.append(name)
    return found if found and _are_runs(table, found) else []


def _are_runs(table: Table, names: list[str]) -> bool:
    """Whether the rows of each run, named by columns together, stand one after another."""
    stretches = [table.texts(name) for name in names]
    starts = np.unique(np.concatenate([begins for begins, _ in stretches]))
    runs = [tuple(texts[int(np.searchsorted(begins, at, "right")) - 1] for begins, texts in stretches) for at in starts]
    return len(set(runs)) == len(runs)


def _line(ours: str, theirs: str, *, scale: float | None = None, note: str = "") -> str:
    key = ours if re.fullmatch(r"[A-Za-z0-9_-]+", ours) else _quoted(ours)
    value = _quoted(theirs) if scale is None else f"{{ from = {_quoted(theirs)}, scale = {scale:g} }}"
    return f"{key} = {value}" + (f"  # {_plain(note)}" if note else "")


def _plain(text: str) -> str:
    """Return a text that a comment can hold."""
    return re.sub(r"[^ -~]", "?", text)[:160]


def _quoted(value: str | list[str]) -> str:
    import tomli_w

    each = [
        tomli_w.dumps({"x": one}).partition("=")[2].strip() for one in ([value] if isinstance(value, str) else value)
    ]
    return each[0] if isinstance(value, str) else f"[{', '.join(each)}]"


def _rows(dialect: Dialect) -> list[str]:
    lines = ["[rows]"]
    if dialect.skip:
        lines.append(f"skip = {dialect.skip}")
    if dialect.comment is not None:
        lines.append(f"comment = {_quoted(dialect.comment)}")
    if dialect.units_row:
        lines.append("units_row = true")
    if dialect.names is not None:
        lines.append(f"names = {_quoted(list(dialect.names))}")
    return lines if len(lines) > 1 else []
