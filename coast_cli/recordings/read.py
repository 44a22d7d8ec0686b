"""Read recordings: files in, runs in SI units out, or one sentence that says which cell is wrong."""

from __future__ import annotations

from dataclasses import replace
from pathlib import Path
from typing import TYPE_CHECKING, TypeVar

import numpy as np

from coast_cli.errors import BadInput
from coast_cli.recordings.arrays import RecordingSource, as_sources, is_table, name_of, table_of
from coast_cli.recordings.columns import RESPONSES, ColumnLayout, find_layout
from coast_cli.recordings.device import SHORTEST, Defaults, TextColumn, defaults_of, joint_names, shape_tubes
from coast_cli.recordings.faults import fault_notes
from coast_cli.recordings.mapped import read_mapped
from coast_cli.recordings.mapping import ColumnMapping, as_mapping
from coast_cli.recordings.model import JointRun, Natural, Recording, Recordings, ResponseKind, ShapeRun
from coast_cli.recordings.table import Table, segments
from coast_cli.units import MILLIMETRE

if TYPE_CHECKING:
    from collections.abc import Iterable, Iterator, Mapping, Sequence

    from numpy.typing import NDArray

    from coast_cli.spec.config import Config

    Floats = NDArray[np.float64]

LENGTH_TOLERANCE = 1e-9
NATURAL_SIDES: dict[str, Natural | None] = {"": None, "up": "up", "down": "down"}
AnyRun = TypeVar("AnyRun", JointRun, ShapeRun)


def read_recordings(
    sources: RecordingSource | Sequence[RecordingSource],
    config: Config | None = None,
    *,
    columns: Mapping[str, str] | ColumnMapping | None = None,
    pair: str | None = None,
    bending_length_mm: float | None = None,
) -> Recordings:
    """Read joint recordings, shapes, or both: files of text with columns, MATLAB's ``.mat``, arrays or DataFrames.

    Args:
        sources: one or many of: the path of a file; arrays by the names of their columns, units in the names as in a
            file's header; a DataFrame. Without a ``run`` column each is one run, named after the file.
        config: its tubes are the names allowed, its ``joint.pair`` is what a file without tubes was made on. Without it
            names are not checked, and a lone ``tube`` of a shape counts as a middle tube.
        columns: our column name -> the file's own, e.g. ``{"stroke_mm": "X1"}``, or a mapping of ``load_mapping``.
        pair: ``OUTER/MIDDLE`` or ``MIDDLE``, instead of ``joint.pair``.
        bending_length_mm: X2 of files without that column.

    Raises:
        BadInput: with file, line and column of the first thing that is wrong.

    Example:
        >>> table = {"stroke_mm": [1.5, 2.5, 3.5], "curvature_per_m": [1.0, 10.0, 20.0], "bending_length_mm": 30.0}
        >>> run = coast.read_recordings(table, coast.load_config(coast.REFERENCE)).joint.runs[0]
        >>> run.pair, run.stroke.tolist()
        ('OT4/MT1', [0.0015, 0.0025, 0.0035])
    """
    defaults = defaults_of(config, pair, bending_length_mm)
    given = as_sources(sources)
    if not given:
        raise BadInput("no recording given", allowed="one or more CSV files")
    names = [name_of(source, index, len(given)) for index, source in enumerate(given)]
    for index, name in enumerate(names):
        if name in names[:index]:
            raise BadInput("the file is given twice", file=name)
    joint: list[JointRun] = []
    shape: list[ShapeRun] = []
    digests: list[tuple[str, str]] = []
    notes: list[str] = []
    mapping, ignored = as_mapping(columns), dict[str, None]()
    for path, source in zip(names, given, strict=True):
        table, spare, said = read_mapped(table_of(source, path) if is_table(source) else path, mapping)
        layout = find_layout(table)
        digests.append((path, table.digest))
        ignored.update(dict.fromkeys(spare))
        notes.extend((*said, *layout.notes))
        if table.decimal == ",":
            notes.append(f"{path}: read with decimal commas.")
        if layout.kind == "joint":
            joint.extend(_joint_runs(table, layout, defaults))
        else:
            shape.extend(_shape_runs(table, layout, defaults))
    if ignored:
        notes.append(f"not named by the mapping, and not used: {_listed(ignored)}.")
    notes.extend(_short_lengths(joint, defaults))
    runs_joint, runs_shape = _named_apart(joint, notes), _named_apart(shape, notes)
    notes.extend(fault_notes(runs_joint))
    return Recordings(
        joint=Recording("joint", runs_joint, tuple(digests), tuple(notes)) if joint else None,
        shape=Recording("shape", runs_shape, tuple(digests), tuple(notes)) if shape else None,
        sources=tuple(digests),
        notes=tuple(notes),
    )


def _listed(names: Iterable[str], most: int = 20) -> str:
    listed = list(names)
    return ", ".join(listed[:most]) + (f" and {len(listed) - most} more" if len(listed) > most else "")


def read_protocol(
    source: RecordingSource,
    config: Config,
    *,
    columns: Mapping[str, str] | ColumnMapping | None = None,
    pair: str | None = None,
    bending_length_mm: float | None = None,
) -> tuple[tuple[JointRun, ...], tuple[str, ...]]:
    """Read the runs of a recording that is only planned, and notes; without a response column it is a curvature of zero.

    Raises:
        BadInput: as ``read_recordings``.
    """
    name = name_of(source, 0, 1)
    table, _, notes = read_mapped(table_of(source, name) if is_table(source) else name, as_mapping(columns))
    if not any(name.lower().startswith(("curvature", "bend_", "notch")) for name in table.names):
        nothing = np.full(len(table.line), b"0")
        table = replace(table, names=(*table.names, "curvature_per_m"), columns=(*table.columns, nothing))
    layout = find_layout(table)
    if layout.kind != "joint":
        raise table.error("no drive column", allowed="stroke_mm or tension_n")
    runs = tuple(_joint_runs(table, layout, defaults_of(config, pair, bending_length_mm)))
    return runs, (*notes, *layout.notes)


def _run_segments(table: Table, layout: ColumnLayout) -> list[tuple[str, int, int]]:
    """Return (name, start, stop) of each run; a run that begins a second time is refused."""
    count = len(table.line)
    column = layout.columns.get("run")
    if column is None:
        return [(Path(table.path).stem.strip("<>"), 0, count)]
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


def _joint_runs(table: Table, layout: ColumnLayout, defaults: Defaults) -> Iterable[JointRun]:
    columns = layout.columns
    values = {
        quantity: table.numbers(columns[quantity].name) * columns[quantity].factor
        for quantity in ("time", "bending_length", "stroke", "tension")
        if quantity in columns
    }
    loads = {
        quantity: table.numbers(columns[quantity].name, may_be_missing=True) * columns[quantity].factor
        for quantity in ("load", "load_moment")
        if quantity in columns
    }
    kind, response = _response(table, layout)
    if kind in ("position", "force") and defaults.has_tubes:
        allowed = "curvature_per_m, bend_deg or notch_1_deg ..., or a configuration of another device"
        raise table.error("no response of a notched joint", name=columns[kind].name, allowed=allowed)
    if "bending_length" not in values:
        if defaults.bending_length is None and defaults.has_tubes:
            raise table.error(
                "no bending_length_mm column", allowed="that column, or one bending length X2 in mm for the file"
            )
        length = np.nan if defaults.bending_length is None else defaults.bending_length
        values["bending_length"] = np.full(len(table.line), length)
    _check_positive_length(table, layout, values["bending_length"])
    outer, middle = TextColumn(table, layout, "outer"), TextColumn(table, layout, "middle")
    runs = []
    for name, start, stop in _run_segments(table, layout):
        rows = slice(start, stop)
        name_outer, name_middle = joint_names(table, outer, middle, (start, stop), defaults)
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
            **{name: _each_row(table, columns[name].name, start, loaded[rows]) for name, loaded in loads.items()},
        )
        _check_joint_run(table, layout, run, start, defaults)
        runs.append(run)
    return runs


def _each_row(table: Table, name: str, start: int, values: Floats) -> Floats:
    """Return a load in each row of a run; a single value stands for the whole run."""
    missing = np.isnan(values)
    if missing.any() and (~missing).sum() != 1:
        row = start + int(np.argmax(missing))
        raise table.error("an empty cell", name=name, row=row, allowed="a load in each row, or in one row of the run")
    return np.full(len(values), values[~missing][0]) if missing.any() else values


def _response(table: Table, layout: ColumnLayout) -> tuple[ResponseKind, Floats]:
    if layout.notches:
        parts = [table.numbers(column.name, may_be_missing=True) * column.factor for column in layout.notches]
        return "notch", np.column_stack(parts)
    kind = next(name for name in RESPONSES if name in layout.columns)
    column = layout.columns[kind]
    return kind, (table.numbers(column.name, may_be_missing=True) * column.factor)[:, None]


def _check_positive_length(table: Table, layout: ColumnLayout, length: Floats) -> None:
    if (length < SHORTEST).any():  # which NaN, no length at all, is not
        row = int(np.argmax(length < SHORTEST))
        raise table.error(
            "the bending length must be positive",
            name=layout.columns["bending_length"].name,
            row=row,
            found=f"{length[row] / MILLIMETRE:g} mm",
            allowed=f"from {SHORTEST / MILLIMETRE:g} mm",
        )


def _check_joint_run(table: Table, layout: ColumnLayout, run: JointRun, start: int, defaults: Defaults) -> None:
    if len(run) < 2:
        raise table.error(f"run {run.name!r} has one sample", row=start, allowed="at least two")
    for notch, values in zip(layout.notches, run.response.T, strict=False):
        if np.isnan(values).all():
            hint = "Notches count from the clamp, so that none can be left out."
            raise table.error(f"all of it is missing in run {run.name!r}", name=notch.name, row=start, hint=hint)
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


def _shape_runs(table: Table, layout: ColumnLayout, defaults: Defaults) -> Iterable[ShapeRun]:
    x, y = (table.numbers(layout.columns[name].name) * layout.columns[name].factor for name in ("x", "y"))
    texts = {name: TextColumn(table, layout, name) for name in ("tube", "outer", "middle", "natural")}
    runs = []
    for name, start, stop in _run_segments(table, layout):
        outer, middle = shape_tubes(table, texts, (start, stop), defaults)
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
