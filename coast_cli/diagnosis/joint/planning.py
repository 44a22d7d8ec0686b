"""``coast plan`` without its command line: from what is planned to rows of what it could tell."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from typing import TYPE_CHECKING

import numpy as np

from coast_cli.diagnosis.joint.plan import Outlook, outlook
from coast_cli.diagnosis.joint.protocols import Bench, planned, standard
from coast_cli.errors import BadInput, UsageError
from coast_cli.rows import Rows
from coast_cli.units import DEGREE, MILLIMETRE

if TYPE_CHECKING:
    from coast_cli.recordings.arrays import RecordingSource
    from coast_cli.recordings.mapping import ColumnMapping
    from coast_cli.recordings.model import JointRun, ResponseKind
    from coast_cli.spec.config import Config

_CURVATURE_NOISE = 0.25  # 1/m: the paper's camera
_ANGLE_NOISE = 0.5  # degrees
_DIGITS = 3  # what sizing to 1 % is worth
_MOSTLY = 0.3
_LARGEST_DRIVE = 1e4  # mm or N
DRIVES = "allowed: LOW:TOP with 0 <= LOW < TOP, such as 0.6:4"
PlanRow = dict[str, str | float | bool | None]


@dataclass(frozen=True, eq=False, repr=False)
class Plan(Rows):
    """What a planned recording could tell.

    Attributes:
        rows: one for each effect, what is told apart first; sizes are in the units of their names.
        notes: what was assumed.
    """

    rows: tuple[PlanRow, ...]
    notes: tuple[str, ...]

    def _table(self) -> tuple[PlanRow, ...]:
        return self.rows


def plan(
    config: Config,
    protocol: RecordingSource | tuple[JointRun, ...],
    *,
    columns: Mapping[str, str] | ColumnMapping | None = None,
    pair: str | None = None,
    bending_length_mm: float | None = None,
    noise: float | None = None,
    tension_noise: float | None = None,
    size: float = 5.0,
) -> Plan:
    """Say which effects a planned recording would show, and which it could not tell apart.

    Args:
        config: of the tubes that are to be recorded.
        protocol: the drive: a file, arrays or a DataFrame as of ``read_recordings``, the response left out, e.g.
            ``{"stroke_mm": [...], "bending_length_mm": 30.0}``; or runs of ``sweep``.
        columns, pair, bending_length_mm: as of ``read_recordings``.
        noise: of the response, 1/m, or deg for angles; by default 0.25 1/m or 0.5 deg.
        tension_noise: of a load cell, N; None where tension is not recorded.
        size: RMS change of the response that each effect is simulated at, in noise levels.

    Raises:
        BadInput: the protocol cannot be read, never moves, or is too short for the parameters of the model.

    Example:
        >>> config = coast.load_config(coast.REFERENCE)
        >>> found = coast.plan(config, coast.sweep(config, (0.9e-3, 2.8e-3), [0.03]))
        >>> [row["visible"] for row in found.rows if row["effect"] == "backlash"]
        [True]
    """
    if isinstance(protocol, tuple):
        return _plan_of(config, protocol, (), (noise, tension_noise, size))
    from coast_cli.recordings.read import read_protocol

    runs, notes = read_protocol(protocol, config, columns=columns, pair=pair, bending_length_mm=bending_length_mm)
    return _plan_of(config, runs, notes, (noise, tension_noise, size))


def sweep(
    config: Config,
    drive: tuple[float, float],
    bending_lengths: Sequence[float],
    *,
    rate: float = 1e-4,
    hold: float = 0.0,
    response: str = "curvature",
    pair: str | None = None,
    records_tension: bool = False,
) -> tuple[JointRun, ...]:
    """Return a load and release at each bending length, to plan with.

    Args:
        drive: from and to, m of stroke, or N where the configuration has no tendon. bending_lengths: X2, m.
        config: of the tubes. pair: ``OUTER/MIDDLE``; None is the configuration's.
        rate: of the drive, m/s (or N/s). hold: at the top, s. response: "curvature" or "bend".
        records_tension: whether a load cell is read beside the stroke.

    Raises:
        UsageError: a drive or length that cannot be.

    Example:
        >>> runs = coast.sweep(coast.load_config(coast.REFERENCE), (0.9e-3, 2.8e-3), [0.02, 0.03])
        >>> [round(run.bending_length[0].item(), 3) for run in runs]
        [0.02, 0.03]
    """
    from coast_cli.spec.build import build

    if response not in ("curvature", "bend"):
        raise UsageError(f"response {response}: allowed: curvature, bend (notch by notch: give a protocol).")
    low, top = drive
    design = build(config)
    outer, middle = design.pair(pair)
    longest = design.joint(pair).middle.length
    for length in bending_lengths or [0.0]:
        if not 0.0 < length <= longest:
            allowed = f"above 0 and at most {longest / MILLIMETRE:g} mm"
            raise UsageError(f"bending lengths X2 are needed; allowed: {allowed}.")
    kind: ResponseKind = "bend" if response == "bend" else "curvature"
    bench = Bench(middle, outer, kind, 1, config.tendon is not None, records_tension)
    if not 0.0 <= low < top < _LARGEST_DRIVE * bench.unit:
        raise UsageError(f"drive {low / bench.unit:g}:{top / bench.unit:g}: {DRIVES}.")
    return standard(bench, low, top, bending_lengths, rate, hold).runs


def _plan_of(
    config: Config,
    runs: Sequence[JointRun],
    said: tuple[str, ...],
    levels: tuple[float | None, float | None, float],
) -> Plan:
    """Return the rows; ``levels``: noise, tension noise and size."""
    given, tension_noise, size = levels
    kind = runs[0].kind
    unit, usual, name = (1.0, _CURVATURE_NOISE, "1/m") if kind == "curvature" else (DEGREE, _ANGLE_NOISE, "deg")
    noise = usual if given is None else given
    if all(float(np.ptp(run.drive)) == 0.0 for run in runs):
        raise BadInput("the drive never moves", file=runs[0].source, allowed="a stroke or a tension that changes")
    problem = planned(config, runs, noise * unit, tension_noise)
    count = problem.observed.size
    if count < 3 * max(len(problem.base), 1):
        raise BadInput(
            "too few samples for the model's own parameters",
            file=runs[0].source,
            found=count,
            allowed=f"at least {3 * len(problem.base)}",
        )
    found = sorted(outlook(problem, size), key=_order)
    free = ", ".join(parameter.name for parameter in problem.base)
    assumed = " (assumed)" if given is None else ""
    notes = [
        f"noise {noise:g} {name}{assumed}; every effect has a size of {size:g} noise levels RMS, or all of its range.",
        f"refitted before anything is called visible: {free}.",
    ]
    if problem.tension_noise is None and runs[0].stroke is not None:
        notes.append("tension is not recorded: a tension noise, N, says how much it would add.")
    return Plan(tuple(_row(one) for one in found), (*said, *notes))


def _row(one: Outlook) -> PlanRow:
    row: PlanRow = {
        "effect": one.id,
        "component": one.component,
        "size": None,
        "change_noise": None,
        "visible_noise": None,
        "visible": one.is_visible,
        "closest": None,
        "apart_noise": None,
        "told_apart": one.is_told_apart,
        "reason": one.reason or None,
    }
    if one.effect is not None:
        sizes = [p.name for p in one.effect.parameters if p.role == "size"]
        row["size"] = " ".join(f"{name}={getattr(one.effect, name):.3g}" for name in sizes)
        row["change_noise"], row["visible_noise"] = round(one.change, _DIGITS), round(one.visible, _DIGITS)
        if one.is_visible:
            row["closest"], row["apart_noise"] = one.closest or None, round(one.apart, _DIGITS)
        else:
            taken = one.visible < _MOSTLY * one.change
            row["reason"] = "refitted parameters take it" if taken else "too small in its whole range"
    return row


def _order(one: Outlook) -> tuple[bool, bool, bool, float]:
    return (not one.is_told_apart, not one.is_visible, one.effect is None, -one.apart)
