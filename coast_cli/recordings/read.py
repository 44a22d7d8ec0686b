"""Read recordings: CSV files in, runs in SI units out, or one sentence that says which cell is wrong."""

from __future__ import annotations

from dataclasses import dataclass, replace
from pathlib import Path
from typing import TYPE_CHECKING, TypeVar

import numpy as np

from coast_cli.errors import BadInput, nearest
from coast_cli.recordings.columns import Layout, find_layout
from coast_cli.recordings.model import JointRun, Natural, Recording, Recordings, ResponseKind, ShapeRun
from coast_cli.recordings.table import Table, read_table, segments
from coast_cli.units import MILLIMETRE

if TYPE_CHECKING:
    from collections.abc import Iterable, Iterator, Mapping, Sequence

    from numpy.typing import NDArray

    from coast_cli.mechanics.tube import NotchedTube
    from coast_cli.spec.config import Config

    Floats = NDArray[np.float64]

LENGTH_TOLERANCE = 1e-9
SHORTEST = 1e-6  # m, of a bending length, as in a configuration
NATURAL_SIDES: dict[str, Natural | None] = {"": None, "up": "up", "down": "down"}
AnyRun = TypeVar("AnyRun", JointRun, ShapeRun)


@dataclass(frozen=True)
class Defaults:
    """What a file may leave out, and the tubes that its names must be among (None where no config is given)."""

    outer: str | None = None
    middle: str | None = None
    bending_length: float | None = None
    outer_tubes: Mapping[str, NotchedTube] | None = None
    middle_tubes: Mapping[str, NotchedTube] | None = None


def read_recordings(
    paths: Sequence[str | Path],
    config: Config | None = None,
    *,
    columns: Mapping[str, str] | None = None,
    pair: str | None = None,
    bending_length_mm: float | None = None,
) -> Recordings:
    """Read CSV files of joint recordings, of shapes, or of both.

    Args:
        paths: one or many files; a file without a ``run`` column is one run, named after the file.
        config: its tubes are the names allowed, its ``joint.pair`` is what a file without tubes was made on. Without it
            names are not checked, and a lone ``tube`` of a shape counts as a middle tube.
        columns: our column name -> the file's own, e.g. ``{"stroke_mm": "X1"}``.
        pair: ``OUTER/MIDDLE`` or ``MIDDLE``, instead of ``joint.pair``.
        bending_length_mm: X2 of files without that column.

    Raises:
        BadInput: with file, line and column of the first thing that is wrong.
    """
    defaults = _defaults(config, pair, bending_length_mm)
    if not paths:
        raise BadInput("no recording given", allowed="one or more CSV files")
    names = [str(path) for path in paths]
    for index, name in enumerate(names):
        if name in names[:index]:
            raise BadInput("the file is given twice", file=name)
    joint: list[JointRun] = []
    shape: list[ShapeRun] = []
    sources: list[tuple[str, str]] = []
    notes: list[str] = []
    for path in names:
        table = read_table(path)
        layout = find_layout(table, columns)
        sources.append((path, table.digest))
        notes.extend(layout.notes)
        if table.decimal == ",":
            notes.append(f"{path}: read with semicolons between cells and decimal commas.")
        if layout.kind == "joint":
            joint.extend(_joint_runs(table, layout, defaults))
        else:
            shape.extend(_shape_runs(table, layout, defaults))
    notes.extend(_short_lengths(joint, defaults))
    runs_joint, runs_shape = _named_apart(joint, notes), _named_apart(shape, notes)
    return Recordings(
        joint=Recording("joint", runs_joint, tuple(sources), tuple(notes)) if joint else None,
        shape=Recording("shape", runs_shape, tuple(sources), tuple(notes)) if shape else None,
        sources=tuple(sources),
        notes=tuple(notes),
    )


def read_protocol(
    path: str | Path,
    config: Config,
    *,
    columns: Mapping[str, str] | None = None,
    pair: str | None = None,
    bending_length_mm: float | None = None,
) -> tuple[tuple[JointRun, ...], tuple[str, ...]]:
    """Read the runs of a recording that is only planned, and notes; without a response column it is a curvature of zero.

    Raises:
        BadInput: as ``read_recordings``.
    """
    table = read_table(str(path))
    if not any(name.lower().startswith(("curvature", "bend_", "notch")) for name in table.names):
        nothing = np.full(len(table.line), b"0")
        table = replace(table, names=(*table.names, "curvature_per_m"), columns=(*table.columns, nothing))
    layout = find_layout(table, columns)
    return tuple(_joint_runs(table, layout, _defaults(config, pair, bending_length_mm))), layout.notes


def _defaults(config: Config | None, pair: str | None, bending_length_mm: float | None) -> Defaults:
    outer_tubes = middle_tubes = None
    if config is not None:
        from coast_cli.spec.build import build

        design = build(config)
        outer_tubes = {tube.name: tube for tube in design.outer}
        middle_tubes = {tube.name: tube for tube in design.middle}
        pair = pair or design.joint_pair
    outer, middle = (None, None) if pair is None else split_pair(pair)
    for name, tubes in ((outer, outer_tubes), (middle, middle_tubes)):
        if name and tubes is not None and name not in tubes:
            raise BadInput(
                "the pair names a tube that the config does not have",
                found=name,
                allowed=", ".join(tubes) or "none",
                hint=nearest(name, tubes) or None,
            )
    length = None if bending_length_mm is None else bending_length_mm * MILLIMETRE
    if length is not None and not (np.isfinite(length) and length >= SHORTEST):
        allowed = f"a length in mm from {SHORTEST / MILLIMETRE:g}"
        raise BadInput("the bending length must be positive", found=bending_length_mm, allowed=allowed)
    return Defaults(outer, middle, length, outer_tubes, middle_tubes)


def split_pair(pair: str) -> tuple[str | None, str]:
    """Split ``OUTER/MIDDLE`` into its names; ``MIDDLE`` alone is a joint of one tube."""
    outer, slash, middle = pair.partition("/")
    if not slash:
        outer, middle = "", outer
    if not middle.strip() or "/" in middle:
        raise BadInput("not a pair of tubes", found=pair, allowed="OUTER/MIDDLE, or MIDDLE for a joint of one tube")
    return outer.strip() or None, middle.strip()


def _run_segments(table: Table, layout: Layout) -> list[tuple[str, int, int]]:
    """Return (name, start, stop) of each run; a run that begins a second time is refused."""
    count = len(table.line)
    column = layout.columns.get("run")
    if column is None:
        return [(Path(table.path).stem, 0, count)]
    starts, names = table.texts(column.name)
    first: dict[str, int] = {}
    for name, (start, _) in zip(names, segments(starts, count), strict=True):
        if not name:
            raise table.error("an empty cell", name=column.name, row=start, allowed="the name of a run")
        if name in first:
            raise table.error(
                f"run {name!r} begins again; it began in line {table.line[first[name]]}",
                name=column.name,
                row=start,
                allowed="the rows of a run one after another",
            )
        first[name] = start
    return [(name, *stretch) for name, stretch in zip(names, segments(starts, count), strict=True)]


class _TextColumn:
    """A text column asked run by run: the one text of a stretch of rows, refused where it changes within a run."""

    def __init__(self, table: Table, layout: Layout, quantity: str) -> None:
        self._table = table
        self._column = layout.columns.get(quantity)
        if self._column is not None:
            self._starts, self._texts = table.texts(self._column.name)

    def __bool__(self) -> bool:
        return self._column is not None

    @property
    def name(self) -> str | None:
        """The column's name in the file."""
        return self._column.name if self._column else None

    def of(self, start: int, stop: int) -> str:
        """Return the text of the rows from ``start`` to ``stop``."""
        if self._column is None:
            return ""
        first = int(np.searchsorted(self._starts, start, side="right")) - 1
        last = int(np.searchsorted(self._starts, stop - 1, side="right")) - 1
        texts = self._texts[first : last + 1]
        for offset, text in enumerate(texts):
            if text != texts[0]:
                raise self._table.error(
                    "changes within a run",
                    name=self.name,
                    row=int(self._starts[first + offset]),
                    found=text,
                    allowed=texts[0] or "empty",
                )
        return texts[0]


def _checked_tube(
    table: Table, column: _TextColumn, start: int, name: str, tubes: Mapping[str, NotchedTube] | None
) -> str:
    if tubes is not None and name not in tubes:
        raise table.error(
            "a tube that the config does not have",
            name=column.name,
            row=start,
            found=name,
            allowed=", ".join(tubes) or "none",
            hint=nearest(name, tubes) or None,
        )
    return name


def _pair_names(
    table: Table, outer: _TextColumn, middle: _TextColumn, stretch: tuple[int, int], defaults: Defaults
) -> tuple[str | None, str]:
    """Return the tubes of a joint run: each from its column where there is one, else from the default pair."""
    name_outer: str | None = defaults.outer
    name_middle: str | None = defaults.middle
    if outer:
        name_outer = outer.of(*stretch) or None
        if name_outer:
            _checked_tube(table, outer, stretch[0], name_outer, defaults.outer_tubes)
    if middle:
        name_middle = middle.of(*stretch) or None
        if name_middle:
            _checked_tube(table, middle, stretch[0], name_middle, defaults.middle_tubes)
    if name_middle is None:
        raise table.error(
            "no middle tube is named",
            name=middle.name,
            row=stretch[0],
            allowed="a middle column, --pair OUTER/MIDDLE, or joint.pair in the configuration",
            hint="`coast recordings` takes a configuration with --config.",
        )
    return name_outer, name_middle


def _joint_runs(table: Table, layout: Layout, defaults: Defaults) -> Iterable[JointRun]:
    columns = layout.columns
    values = {
        quantity: table.numbers(columns[quantity].name) * columns[quantity].factor
        for quantity in ("time", "bending_length", "stroke", "tension")
        if quantity in columns
    }
    kind, response = _response(table, layout)
    if "bending_length" not in values:
        if defaults.bending_length is None:
            raise table.error("no bending_length_mm column", allowed="that column, or --x2 with the length in mm")
        values["bending_length"] = np.full(len(table.line), defaults.bending_length)
    _check_positive_length(table, layout, values["bending_length"])
    outer, middle = _TextColumn(table, layout, "outer"), _TextColumn(table, layout, "middle")
    runs = []
    for name, start, stop in _run_segments(table, layout):
        rows = slice(start, stop)
        name_outer, name_middle = _pair_names(table, outer, middle, (start, stop), defaults)
        run = JointRun(
            name=name,
            source=table.path,
            line=table.line[rows],
            time=values["time"][rows] if "time" in values else None,
            outer=name_outer,
            middle=name_middle,
            bending_length=values["bending_length"][rows],
            stroke=values["stroke"][rows] if "stroke" in values else None,
            tension=values["tension"][rows] if "tension" in values else None,
            response=response[rows],
            kind=kind,
        )
        _check_joint_run(table, layout, run, start, defaults)
        runs.append(run)
    return runs


def _response(table: Table, layout: Layout) -> tuple[ResponseKind, Floats]:
    if layout.notches:
        parts = [table.numbers(column.name, may_be_missing=True) * column.factor for column in layout.notches]
        return "notch", np.column_stack(parts)
    kind: ResponseKind = "curvature" if "curvature" in layout.columns else "bend"
    column = layout.columns[kind]
    return kind, (table.numbers(column.name, may_be_missing=True) * column.factor)[:, None]


def _check_positive_length(table: Table, layout: Layout, length: Floats) -> None:
    if (length < SHORTEST).any():
        row = int(np.argmax(length < SHORTEST))
        raise table.error(
            "the bending length must be positive",
            name=layout.columns["bending_length"].name,
            row=row,
            found=f"{length[row] / MILLIMETRE:g} mm",
            allowed=f"from {SHORTEST / MILLIMETRE:g} mm",
        )


def _check_joint_run(table: Table, layout: Layout, run: JointRun, start: int, defaults: Defaults) -> None:
    if len(run) < 2:
        raise table.error(f"run {run.name!r} has one sample", row=start, allowed="at least two")
    if not run.valid.any():
        raise table.error(f"every response of run {run.name!r} is missing", row=start, allowed="some that are not")
    if run.time is not None and (np.diff(run.time) < 0.0).any():
        row = start + 1 + int(np.argmax(np.diff(run.time) < 0.0))
        raise table.error(
            f"time goes back in run {run.name!r}",
            name=layout.columns["time"].name,
            row=row,
            found=f"{run.time[row - start]:g} s after {run.time[row - start - 1]:g} s",
        )
    tubes = [
        tubes[name]
        for name, tubes in ((run.outer, defaults.outer_tubes), (run.middle, defaults.middle_tubes))
        if name and tubes
    ]
    if not tubes:
        return
    if layout.notches and len(layout.notches) > tubes[-1].count:
        raise table.error(
            f"more notch columns than tube {run.middle!r} has notches",
            name=layout.notches[-1].name,
            row=start,
            found=str(len(layout.notches)),
            allowed=f"up to {tubes[-1].count}",
        )
    shortest = min(tubes, key=lambda tube: tube.length)
    too_long = run.bending_length > shortest.length + LENGTH_TOLERANCE
    if too_long.any():
        row = int(np.argmax(too_long))
        column = layout.columns.get("bending_length")
        raise table.error(
            f"the bending length of run {run.name!r} is longer than the notched length of {shortest.name!r}",
            name=column.name if column else None,
            row=start + row,
            found=f"{run.bending_length[row] / MILLIMETRE:g} mm",
            allowed=f"up to {shortest.length / MILLIMETRE:g} mm",
        )


def _short_lengths(runs: Sequence[JointRun], defaults: Defaults) -> Iterator[str]:
    """Say where a bending length is shorter than one pitch, as it is where metres are taken for millimetres."""
    for run in runs:
        tube = (defaults.middle_tubes or {}).get(run.middle)
        if tube is not None and np.min(run.bending_length, initial=np.inf) < np.min(tube.pitch):
            pitch = np.min(tube.pitch) / MILLIMETRE
            yield f"{run.source}: run {run.name!r} has a bending length below one pitch, {pitch:g} mm: is it in mm?"


def _shape_runs(table: Table, layout: Layout, defaults: Defaults) -> Iterable[ShapeRun]:
    x, y = (table.numbers(layout.columns[name].name) * layout.columns[name].factor for name in ("x", "y"))
    texts = {name: _TextColumn(table, layout, name) for name in ("tube", "outer", "middle", "natural")}
    runs = []
    for name, start, stop in _run_segments(table, layout):
        outer, middle = _shape_tubes(table, texts, (start, stop), defaults)
        side = texts["natural"].of(start, stop).lower()
        if side not in NATURAL_SIDES:
            raise table.error(
                "a side that is not known",
                name=texts["natural"].name,
                row=start,
                found=side,
                allowed="up, down or empty",
            )
        if stop - start < 3:
            raise table.error(f"shape {name!r} has {stop - start} points", row=start, allowed="at least three")
        rows = slice(start, stop)
        run = ShapeRun(name, table.path, table.line[rows], outer, middle, x[rows], y[rows], NATURAL_SIDES[side])
        step = np.hypot(np.diff(run.x), np.diff(run.y))
        if (step == 0.0).any():
            raise table.error(f"two points of shape {name!r} coincide", row=start + 1 + int(np.argmax(step == 0.0)))
        runs.append(run)
    return runs


def _shape_tubes(
    table: Table, texts: Mapping[str, _TextColumn], stretch: tuple[int, int], defaults: Defaults
) -> tuple[str | None, str | None]:
    if not texts["tube"]:
        if not texts["outer"] and not texts["middle"] and defaults.middle is None:
            raise table.error("no tube is named", allowed="a tube column, outer and middle columns, or --pair")
        outer = texts["outer"].of(*stretch) if texts["outer"] else ""
        middle = texts["middle"].of(*stretch) if texts["middle"] else ""
        if not texts["outer"] and not texts["middle"]:
            return defaults.outer, defaults.middle
        if not outer and not middle:
            raise table.error("no tube is named", row=stretch[0], allowed="an outer tube, a middle tube or both")
        if outer:
            _checked_tube(table, texts["outer"], stretch[0], outer, defaults.outer_tubes)
        if middle:
            _checked_tube(table, texts["middle"], stretch[0], middle, defaults.middle_tubes)
        return outer or None, middle or None
    name = texts["tube"].of(*stretch)
    if not name:
        raise table.error("an empty cell", name=texts["tube"].name, row=stretch[0], allowed="the name of a tube")
    if "/" in name:
        outer_name, middle_name = split_pair(name)
        return outer_name, middle_name
    if defaults.outer_tubes is None or defaults.middle_tubes is None:
        return None, name
    known = {**defaults.outer_tubes, **defaults.middle_tubes}
    _checked_tube(table, texts["tube"], stretch[0], name, known)
    return (name, None) if name in defaults.outer_tubes else (None, name)


def _named_apart(runs: list[AnyRun], notes: list[str]) -> tuple[AnyRun, ...]:
    """Put the file before the name of runs whose name stands in several files."""
    files: dict[str, set[str]] = {}
    for run in runs:
        files.setdefault(run.name, set()).add(run.source)
    shared = sorted(name for name, sources in files.items() if len(sources) > 1)
    if not shared:
        return tuple(runs)
    stems = {run.source: Path(run.source).stem for run in runs}
    unique = len(set(stems.values())) == len(stems)
    notes.append(f"run {', '.join(shared)} stands in several files; such runs are named FILE:RUN.")
    return tuple(
        replace(run, name=f"{stems[run.source] if unique else run.source}:{run.name}") if run.name in shared else run
        for run in runs
    )
