"""``coast plan`` without its command line: from what is planned to rows of what it could tell."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass
from pathlib import Path
from typing import TYPE_CHECKING

import numpy as np

from coast_cli.diagnosis.joint.plan import Outlook, outlook
from coast_cli.diagnosis.joint.protocols import Bench, planned, standard
from coast_cli.errors import BadInput, UsageError
from coast_cli.units import DEGREE, MILLIMETRE

if TYPE_CHECKING:
    from coast_cli.recordings.mapping import ColumnMapping
    from coast_cli.recordings.model import JointRun
    from coast_cli.spec.config import Config

_CURVATURE_NOISE = 0.25  # 1/m: the paper's camera
_ANGLE_NOISE = 0.5  # degrees
_DIGITS = 3  # what sizing to 1 % is worth
_MOSTLY = 0.3
PlanRow = dict[str, str | float | bool | None]


@dataclass(frozen=True)
class Plan:
    """Options of a plan: response ("curvature" or "bend"), noise (1/m or deg), tension noise (N), effect size, pair."""

    response: str
    noise: float | None
    tension_noise: float | None
    size: float
    pair: str | None

    def read(
        self, path: Path, config: Config, lengths: Sequence[float], columns: ColumnMapping
    ) -> tuple[tuple[JointRun, ...], tuple[str, ...]]:
        """Return the runs of a protocol file, and notes.

        Raises:
            UsageError: several --x2 for one file. BadInput: what the reader refuses.
        """
        from coast_cli.recordings.read import read_protocol

        if len(lengths) > 1:
            raise UsageError("--x2: one bending length goes with --protocol, for a file without that column.")
        length = lengths[0] if lengths else None
        return read_protocol(path, config, columns=columns, pair=self.pair, bending_length_mm=length)

    def sweep(
        self, config: Config, drive: str, lengths: Sequence[float], rate: float, hold: float
    ) -> tuple[JointRun, ...]:
        """Return a load and release at each bending length (mm), the drive ``LOW:TOP`` in mm or N.

        Raises:
            UsageError: a drive or length that cannot be.
        """
        from coast_cli.spec.build import build

        if self.response not in ("curvature", "bend"):
            raise UsageError(f"--response {self.response}: allowed: curvature, bend (notch by notch: --protocol).")
        low, top = _range(drive)
        design = build(config)
        outer, middle = design.pair(self.pair)
        longest = design.joint(self.pair).middle.length / MILLIMETRE
        for length in lengths or [0.0]:
            if not 0.0 < length <= longest:
                raise UsageError(f"--x2: bending lengths are needed; allowed: above 0 and at most {longest:g} mm.")
        bench = Bench(
            middle,
            outer,
            "bend" if self.response == "bend" else "curvature",
            1,
            config.tendon is not None,
            self.tension_noise is not None,
        )
        meters = [length * MILLIMETRE for length in lengths]
        return standard(bench, low * bench.unit, top * bench.unit, meters, rate * bench.unit, hold).runs


def plan_rows(config: Config, runs: Sequence[JointRun], plan: Plan) -> tuple[list[PlanRow], tuple[str, ...]]:
    """Return a row for each effect, what is told apart first, and notes on what was assumed.

    Raises:
        BadInput: the drive never moves, or is too short for the parameters of the model.
    """
    kind = runs[0].kind
    unit, usual, name = (1.0, _CURVATURE_NOISE, "1/m") if kind == "curvature" else (DEGREE, _ANGLE_NOISE, "deg")
    noise = usual if plan.noise is None else plan.noise
    if all(float(np.ptp(run.drive)) == 0.0 for run in runs):
        raise BadInput("the drive never moves", file=runs[0].source, allowed="a stroke or a tension that changes")
    problem = planned(config, runs, noise * unit, plan.tension_noise)
    count = problem.observed.size
    if count < 3 * max(len(problem.base), 1):
        raise BadInput(
            "too few samples for the model's own parameters",
            file=runs[0].source,
            found=count,
            allowed=f"at least {3 * len(problem.base)}",
        )
    found = sorted(outlook(problem, plan.size), key=_order)
    free = ", ".join(parameter.name for parameter in problem.base)
    assumed = " (assumed)" if plan.noise is None else ""
    notes = [
        f"noise {noise:g} {name}{assumed}; every effect has a size of {plan.size:g} noise levels RMS, or all of its range.",
        f"refitted before anything is called visible: {free}.",
    ]
    if problem.tension_noise is None and runs[0].stroke is not None:
        notes.append("tension is not recorded: --tension-noise N says how much it would add.")
    return [_row(one) for one in found], tuple(notes)


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


def _range(text: str) -> tuple[float, float]:
    low, colon, top = text.partition(":")
    try:
        values = float(low), float(top)
    except ValueError:
        values = (0.0, -1.0)
    if not colon or not 0.0 <= values[0] < values[1] < 1e4:
        raise UsageError(f"--drive {text}: allowed: LOW:TOP with 0 <= LOW < TOP, such as 0.6:4.")
    return values
