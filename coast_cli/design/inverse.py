"""The inverse design: what to cut so that a pair has wanted figures, how well that is determined, or the nearest to it.

Bounded least squares from several starts, the Jacobian by central differences of one batch of
pairs, the starting pair first. Where the targets leave variables free, one of the solutions is given and said to be so.
"""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass, replace
from typing import Any

import numpy as np
from numpy.typing import NDArray

from coast_cli.design.figures import FIGURES, POINT_FIGURES, pair_columns
from coast_cli.design.limits import assembles, at_the_point
from coast_cli.design.space import RoleSpace, role_space
from coast_cli.errors import BadInput, NotConverged, UsageError, nearest
from coast_cli.mechanics.pairs import bent, listed_pairs
from coast_cli.mechanics.section import FloatArray
from coast_cli.mechanics.tube import NotchedTube
from coast_cli.mechanics.tubes import Tubes, tubes_of
from coast_cli.spec.build import Design
from coast_cli.spec.explore import Explore
from coast_cli.spec.tubes import Role
from coast_cli.units import MILLIMETRE

Row = dict[str, Any]
REACHED = 1e-9  # relative; a target this near counts as met
VARIABLES = ("depth_mm", "cut_mm", "uncut_mm", "outer_diameter_mm", "inner_diameter_mm")
_STARTS, _SURVEY = 24, 512  # where the overlap cuts through a pitch, a total has a kink for each notch
_STEP = 1e-6  # of a range, for central differences
_STEPS = 200  # of one descent
_FREE = 1e-6  # singular value, relative to the largest, below which a direction is free
_FIELDS = ("kind", "name", "start", "wanted", "value", "low", "high", "at_bound", "determined", "change_per_percent")


@dataclass(frozen=True, slots=True)
class Variable:
    """One number that may change: of which role, which key, its bounds and its start, mm."""

    role: Role
    key: str
    low: float
    high: float
    start: float

    @property
    def name(self) -> str:
        """The variable as the user writes it, e.g. ``outer.depth_mm``."""
        return f"{self.role}.{self.key}"


@dataclass(frozen=True)
class Found:
    """An inverse design.

    Attributes:
        rows: one a target and one a variable. reached: whether every target is met.
        values: of the variables by name, mm. curvatures: natural curvature of each role's new tube as files have it, 1/m.
        notes: for the user.
    """

    rows: list[Row]
    reached: bool
    values: Mapping[str, float]
    curvatures: Mapping[str, float]
    notes: tuple[str, ...]


def inverse_design(design: Design, pair: tuple[str, str], targets: Mapping[str, float], vary: Sequence[str]) -> Found:
    """Return the values of the variables that give a pair the wanted figures, or the nearest.

    Args:
        pair: outer and middle tube that the design starts from; what does not vary is theirs.
        targets: by column of ``FIGURES`` or ``POINT_FIGURES``. vary: e.g. ``outer.depth_mm``.

    Raises:
        UsageError: an unknown target or variable. BadInput: a variable has no range. NotConverged: nothing was solved.
    """
    problem = _problem(design, pair, targets, vary)
    best = _solve(problem)
    figures = problem.figures(best[None])
    reached_values = {name: float(figures[name][0]) for name in targets}
    reached = all(
        abs(reached_values[name] - target) <= REACHED * problem.size(name) for name, target in targets.items()
    )
    rows = [
        _row(kind="target", name=name, start=problem.nominal[name], wanted=target, value=reached_values[name])
        for name, target in targets.items()
    ]
    rows += _variable_rows(problem, best, reached=reached)
    values = {item.name: float(value) for item, value in zip(problem.variables, best, strict=True)}
    curvatures: dict[str, float] = {
        part.role: sign * float(np.interp(problem.depth(part.role, best), *part.measured))
        for part, sign in ((problem.outer, 1.0), (problem.middle, -1.0))
    }
    return Found(rows, reached, values, curvatures, _notes(problem, rows, reached=reached))


@dataclass(frozen=True)
class _Problem:
    """The targets as a function of the variables."""

    design: Design
    tubes: tuple[NotchedTube, NotchedTube]
    outer: RoleSpace
    middle: RoleSpace
    variables: tuple[Variable, ...]
    targets: Mapping[str, float]
    nominal: Mapping[str, float]

    @property
    def bounds(self) -> tuple[FloatArray, FloatArray]:
        return np.array([item.low for item in self.variables]), np.array([item.high for item in self.variables])

    @property
    def start(self) -> FloatArray:
        return np.asarray(np.clip([item.start for item in self.variables], *self.bounds), dtype=float)

    def depth(self, role: str, values: FloatArray) -> float:
        """Return the notch depth of a role at values of the variables, mm."""
        for item, value in zip(self.variables, values, strict=True):
            if (item.role, item.key) == (role, "depth_mm"):
                return float(value)
        tube = self.tubes[0 if role == "outer" else 1]
        return float(tube.depth[0] / MILLIMETRE)

    def figures(self, values: FloatArray) -> dict[str, FloatArray]:
        """Return the figures at rows of values, shape (m, variables); NaN where a pair cannot be assembled."""
        outer, middle = (self._made(role, values) for role in ("outer", "middle"))
        possible = assembles(self.design.config, outer, middle)
        rows = np.flatnonzero(possible)
        columns = {name: np.full(len(values), np.nan) for name in (*FIGURES, *POINT_FIGURES)}
        if rows.size:
            some = outer.picked(rows), middle.picked(rows)
            solved = bent(some[0], self.design.gravity), bent(some[1], self.design.gravity)
            every = np.arange(rows.size)
            known = pair_columns(listed_pairs(*solved, (every, every))) | at_the_point(self.design, *some)
            for name, column in known.items():
                columns[name][rows] = column
        return columns

    def residual(self, values: FloatArray) -> FloatArray:
        """Return (reached - wanted) over the size of each target, shape (m, targets); 10 for a pair that cannot be."""
        figures = self.figures(values)
        table = [(figures[name] - wanted) / self.size(name) for name, wanted in self.targets.items()]
        return np.asarray(np.nan_to_num(np.stack(table, axis=1), nan=10.0))

    def size(self, name: str) -> float:
        """Return what counts as 100 % of a target: itself, or the starting pair's where that is larger."""
        return max(abs(self.targets[name]), abs(self.nominal[name]), 1e-12)

    def jacobian(self, values: FloatArray) -> FloatArray:
        """Return d residual / d share of each range, shape (targets, variables)."""
        low, high = self.bounds
        steps = _STEP * (high - low)
        up, down = np.minimum(values + np.diag(steps), high), np.maximum(values - np.diag(steps), low)
        table = self.residual(np.concatenate((up, down)))
        count = len(steps)
        width = np.diag(up - down) / (high - low)
        return np.asarray(((table[:count] - table[count:]) / width[:, None]).T)

    def _made(self, role: Role, values: FloatArray) -> Tubes:
        tube = self.tubes[0 if role == "outer" else 1]
        space = self.outer if role == "outer" else self.middle
        base = tubes_of([tube]).picked(np.zeros(len(values), dtype=np.int64))
        fields: dict[str, FloatArray] = {}
        for item, column in zip(self.variables, values.T, strict=True):
            if item.role == role:
                metres = column * MILLIMETRE
                if item.key.endswith("diameter_mm"):
                    fields[item.key.replace("diameter_mm", "radius")] = metres / 2.0
                else:
                    fields[item.key.removesuffix("_mm")] = metres[:, None]
        alike = {name: getattr(base, name)[:, :1] for name in ("depth", "cut", "uncut")}
        depth = fields.get("depth", alike["depth"])[:, 0] / MILLIMETRE
        made = replace(
            base, **{**alike, **fields, "natural_curvature": np.interp(depth, *space.measured), "end_length": 0.0}
        )
        return replace(made, end_length=space.end_length(made))


def _problem(design: Design, pair: tuple[str, str], targets: Mapping[str, float], vary: Sequence[str]) -> _Problem:
    config = design.config
    known = (*FIGURES, *POINT_FIGURES)
    for name in targets:
        if name not in known:
            hint = nearest(name, known)
            raise UsageError(f"target {name}: there is no such figure; allowed: {', '.join(known)}. {hint}".rstrip())
    explore = config.explore or Explore()
    outer, middle = (role_space(config, explore, role) for role in ("outer", "middle"))
    tubes = design.tube(pair[0]), design.tube(pair[1])
    for tube in tubes:
        if np.ptp(tube.depth) > 0.0:
            raise BadInput(f"{tube.name} has notches of different depths", hint="Start from a tube with one depth.")
    variables = tuple(
        _variable(name, {"outer": (outer, tubes[0]), "middle": (middle, tubes[1])}, design) for name in vary
    )
    problem = _Problem(design, tubes, outer, middle, variables, targets, {})
    nominal = {name: float(column[0]) for name, column in problem.figures(problem.start[None]).items()}
    for name in targets:
        if not np.isfinite(nominal[name]):
            needs = "it needs [joint], [tendon] and checks.max_stroke_mm, and tubes that go together"
            raise UsageError(f"target {name}: it has no value for {'/'.join(pair)}; {needs}.")
    return replace(problem, nominal=nominal)


def _variable(name: str, roles: Mapping[str, tuple[RoleSpace, NotchedTube]], design: Design) -> Variable:
    role, _, key = name.partition(".")
    allowed = [f"{one}.{two}" for one in roles for two in VARIABLES]
    if name not in allowed:
        hint = nearest(name, allowed)
        raise UsageError(f"variable {name}: there is none; allowed: {', '.join(allowed)}. {hint}".rstrip())
    space, tube = roles[role]
    plain = {
        "depth_mm": float(tube.depth[0]),
        "cut_mm": float(tube.cut[0]),
        "uncut_mm": float(tube.uncut[0]),
        "outer_diameter_mm": 2.0 * tube.outer_radius,
        "inner_diameter_mm": 2.0 * tube.inner_radius,
    }
    span = space.ranges.get(key)
    if span is not None:
        low, high = float(span.min), float(span.max)
    elif key == "depth_mm":
        low, high = float(space.measured[0][0]), float(space.measured[0][-1])
    else:
        raise design.config.refuse(("explore", role, key), "it may vary, but no range is given", allowed="{ min, max }")
    if not low < high:
        raise design.config.refuse((role, "samples"), f"{name} cannot vary: only one depth was measured")
    return Variable(space.role, key, low, high, plain[key] / MILLIMETRE)


def _solve(problem: _Problem) -> FloatArray:
    """Return the best values found from the starting pair and the most promising points of a Sobol sequence."""
    from scipy.stats import qmc

    from coast_cli.mechanics.least_squares import descend

    low, high = problem.bounds

    def residual(share: FloatArray) -> FloatArray:
        return np.asarray(problem.residual((low + share * (high - low))[None])[0])

    def jacobian(share: FloatArray) -> FloatArray:
        return problem.jacobian(low + share * (high - low))

    survey = low + (high - low) * qmc.Sobol(len(low), seed=0).random(_SURVEY)
    order = np.argsort(np.sum(problem.residual(survey) ** 2, axis=1), kind="stable")
    found: list[tuple[float, FloatArray]] = []
    for start in (problem.start, *survey[order[:_STARTS]]):
        share = np.clip((start - low) / (high - low), 1e-9, 1.0 - 1e-9)
        result = descend(
            residual,
            lambda at, _: jacobian(at),
            share,
            np.zeros_like(share),
            np.ones_like(share),
            steps=_STEPS,
            tolerance=1e-30,
        )
        values = low + np.clip(result.x, 0.0, 1.0) * (high - low)
        error = float(np.max(np.abs(result.residual)))
        if error <= REACHED:
            return values
        found.append((result.cost, values))
    if not found or not np.isfinite(found[0][0]):
        raise NotConverged("no pair of these ranges was solved: give other ranges.")
    return min(found, key=lambda item: item[0])[1]


def _variable_rows(problem: _Problem, best: FloatArray, *, reached: bool) -> list[Row]:
    low, high = problem.bounds
    jacobian = problem.jacobian(best)
    _, sizes, directions = np.linalg.svd(jacobian, full_matrices=True)
    kept = sizes > _FREE * max(float(sizes.max(initial=0.0)), 1e-300)
    rank = int(np.count_nonzero(kept))
    free = np.sum(directions[rank:] ** 2, axis=0)  # how much of each variable lies in free directions
    moved = np.linalg.norm(np.linalg.pinv(jacobian, rcond=_FREE), axis=1) * 0.01 * (high - low)
    rows = []
    for column, item in enumerate(problem.variables):
        edge: NDArray[np.bool_] = np.isclose(
            best[column], (item.low, item.high), rtol=0.0, atol=1e-6 * (item.high - item.low)
        )
        determined = bool(free[column] < _FREE)
        rows.append(
            _row(
                kind="variable",
                name=item.name,
                start=item.start,
                value=float(best[column]),
                low=item.low,
                high=item.high,
                at_bound=bool(edge.any()),
                determined=determined if reached else None,
                change_per_percent=float(moved[column]) if determined and reached else None,
            )
        )
    return rows


def _row(**values: Any) -> Row:  # noqa: ANN401
    return {**dict.fromkeys(_FIELDS), **values}


def _notes(problem: _Problem, rows: Sequence[Row], *, reached: bool) -> tuple[str, ...]:
    notes = [*problem.design.uncorrected]
    if not reached:
        notes.append("no design in these ranges reaches the target; this is the nearest.")
    free = [row["name"] for row in rows if row["determined"] is False]
    if free:
        notes.append(f"the targets leave {', '.join(free)} free: of many solutions this is one.")
    steps = [item.name for item in problem.variables if _stepped(problem, item)]
    if steps:
        notes.append(f"{', '.join(steps)}: solved as if any value could be made; the steps of [explore] are not kept.")
    if any(item.key in {"cut_mm", "uncut_mm"} for item in problem.variables):
        notes.append("the number of notches stays, so the notched length follows cut and uncut.")
    notes.append("natural curvature is that of the depth, linear between the measured samples.")
    return tuple(notes)


def _stepped(problem: _Problem, item: Variable) -> bool:
    span = (problem.outer if item.role == "outer" else problem.middle).ranges.get(item.key)
    return span is not None and span.step is not None


def designed_text(design: Design, pair: tuple[str, str], found: Found, name: str) -> str:
    """Return the TOML of the configuration with the designed tubes added and made its pair; it has been read back.

    Raises:
        BadInput: a designed number lies outside what a configuration may hold.
    """
    from coast_cli.spec.edit import written
    from coast_cli.spec.load import load_config_text

    document = design.config.model_dump(exclude_unset=True)
    names = []
    for role, base in zip(("outer", "middle"), pair, strict=True):
        sample: Row = dict(next(s for s in document[role]["samples"] if s["name"] == base))
        sample |= {"name": f"{base}-designed", "natural_curvature_per_m": found.curvatures[role]}
        for variable, value in found.values.items():
            one, _, key = variable.partition(".")
            if one == role:
                if key in {"cut_mm", "uncut_mm"}:
                    sample["notch"] = {**sample.get("notch", {}), key: value}
                else:
                    sample[key] = value
        document[role]["samples"] = [*document[role]["samples"], sample]
        names.append(sample["name"])
    if "joint" in document:
        document["joint"]["pair"] = "/".join(names)
    text = written(document, design.config.origin.text, {("joint", "pair"): "designed by coast design"})
    load_config_text(text, name)
    return text
