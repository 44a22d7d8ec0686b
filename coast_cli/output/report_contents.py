"""What a report is made of, asked for from every part of the package that has something to say of a design."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass, field, replace
from typing import TYPE_CHECKING, Any

from coast_cli.design.checks import check_design
from coast_cli.design.rank import Ranking, RankOptions, rank
from coast_cli.design.shape import shape_columns
from coast_cli.design.stroke import stroke_table
from coast_cli.design.tolerance import tolerance_rows
from coast_cli.errors import BadInput
from coast_cli.output.progress import waiting
from coast_cli.output.provenance import provenance
from coast_cli.spec.build import Design
from coast_cli.spec.config import Config

if TYPE_CHECKING:
    from coast_cli.mechanics.joint import Joint
    from coast_cli.output.diagnosis import DiagnosisAnswer
    from coast_cli.recordings.model import Recordings

MOST_TUBES = 12
_UNNAMED = "the configuration names none"
_PAPER_LENGTHS = (0.020, 0.030, 0.040)
CURVATURES = tuple(float(number) for number in range(0, 41, 5))  # 1/m
_POINTS = 201  # of a shape; more than a picture shows


@dataclass(frozen=True)
class Wanted:
    """What is asked for: a pair (None: the configuration's), curvatures (1/m), bending lengths (m; None: by the tubes).

    ``samples`` over the tolerances, 0 for none; ``seed`` of their random numbers; runs to ``hold_out`` of a diagnosis.
    """

    pair: str | None = None
    curvatures: Sequence[float] = CURVATURES
    lengths: Sequence[float] | None = None
    samples: int = 10_000
    seed: int = 0
    hold_out: Sequence[str] = ()


@dataclass(frozen=True)
class DesignReport:
    """What a report says; a part that is None is left out, and ``missing`` says why.

    Attributes:
        config: as read. pair: ``OUTER/MIDDLE`` or one tube, what the report is about. chosen: why that pair.
        provenance: as of every answer. shapes, strokes: columns and notes.
        ranking: of all pairs. tolerance: rows, notes and sampled figures. samples: how many.
        checks: rows of ``coast check``. diagnosis: of the recordings, where some were given.
        missing: why a part is left out, by its name.
    """

    config: Config
    pair: str
    chosen: str
    provenance: Mapping[str, Any]
    shapes: tuple[Mapping[str, Any], Sequence[str]]
    rank_options: RankOptions
    ranking: Ranking | None
    strokes: tuple[Mapping[str, Any], Sequence[str]] | None
    tolerance: tuple[Sequence[Mapping[str, Any]], Sequence[str], Mapping[str, Any]] | None
    samples: int
    checks: Sequence[Mapping[str, Any]] | None
    diagnosis: DiagnosisAnswer | None = None
    missing: Mapping[str, str] = field(default_factory=dict)


def contents(design: Design, wanted: Wanted, recordings: Recordings | None = None) -> DesignReport:
    """Return everything a report says of a design.

    Raises:
        BadInput: the pair is unknown or left open, or the configuration contradicts itself.
        UsageError: curvatures or lengths that the joint cannot take.
        NotConverged: a part was not solved.
    """
    config, options = design.config, RankOptions()
    missing: dict[str, str] = {}
    ranking = rank(config, options) if design.outer and design.middle else None
    if ranking is None:
        missing["ranking"] = (
            "There is nothing to rank, as the configuration has no pairs of an outer and a middle tube."
        )
    pair, chosen = _pair(design, ranking, recordings, wanted.pair)
    outer, middle = design.pair(pair)
    strokes = None
    if config.joint is None:
        missing["strokes"] = "There is no stroke table, as the configuration has no [joint] table."
    else:
        strokes = _strokes(design, design.joint(pair), wanted)
    checks = _checks(design, pair, missing)
    shapes = _shapes(design, ranking, (outer, middle))
    tolerance = None
    if outer is None:
        missing["tolerances"] = "What tolerances do is answered for pairs only, and this joint is of one tube."
    elif wanted.samples == 0:
        missing["tolerances"] = "No samples were asked for (--samples 0)."
    else:
        with waiting(f"sampling {pair} over its tolerances"):
            tolerance = tolerance_rows(design, (outer, middle), samples=wanted.samples, seed=wanted.seed)
    shown = {"pair": pair, "samples": wanted.samples, "hold_out": list(wanted.hold_out)}
    origin = provenance(config, recordings=recordings.sources if recordings else (), options=shown, seed=wanted.seed)
    return DesignReport(
        config,
        pair,
        chosen,
        origin,
        shapes,
        options,
        ranking,
        strokes,
        tolerance,
        wanted.samples,
        checks,
        None if recordings is None else _diagnosis(config, recordings, wanted, origin),
        missing,
    )


def _pair(design: Design, ranking: Ranking | None, recordings: Recordings | None, asked: str | None) -> tuple[str, str]:
    """Return the pair and why it is that one: as asked, as configured, as recorded, or the first of the ranking."""
    if asked is not None:
        return "/".join(name for name in design.pair(asked) if name), "as asked for by --pair"
    joint = design.config.joint
    if design.joint_pair is None and recordings is not None and recordings.joint is not None:
        return recordings.joint.runs[0].pair, f"the first that was recorded: {_UNNAMED}"
    if design.joint_pair is None and ranking is not None and ranking.columns["reason"][0] is None:
        return f"{ranking.columns['outer'][0]}/{ranking.columns['middle'][0]}", f"first of the ranking: {_UNNAMED}"
    named = "/".join(name for name in design.pair() if name)
    return named, "the configuration's joint.pair" if joint is not None and joint.pair else "the only one there is"


def _strokes(design: Design, joint: Joint, wanted: Wanted) -> tuple[Mapping[str, Any], tuple[str, ...]]:
    longest = min(tube.length for tube in (joint.outer, joint.middle) if tube is not None)
    fitting = _PAPER_LENGTHS if longest >= max(_PAPER_LENGTHS) else (0.5 * longest, longest)
    found = stroke_table(joint, wanted.lengths or fitting, curvatures=wanted.curvatures, effects=design.effects)
    return found.columns, (*found.notes, *design.uncorrected_joint)


def _checks(design: Design, pair: str, missing: dict[str, str]) -> Sequence[Mapping[str, Any]] | None:
    config = design.config
    if config.checks is None:
        missing["checks"] = "There is nothing to check, as the configuration has no [checks] table."
        return None
    if config.joint is not None:
        config = config.model_copy(update={"joint": config.joint.model_copy(update={"pair": pair})})
    try:
        return check_design(replace(design, config=config))
    except BadInput as refusal:  # a limit that is not for this pair; the rest of the report stands
        missing["checks"] = f"The checks could not be made: {refusal}"
        return None


def _shapes(
    design: Design, ranking: Ranking | None, pair: tuple[str | None, str]
) -> tuple[Mapping[str, Any], tuple[str, ...]]:
    """Return the shapes of all tubes, or of so many as a picture takes: those of the pair, then by rank."""
    tubes = {tube.name: tube for tube in (*design.outer, *design.middle)}
    notes = (*design.notes, *design.uncorrected)
    if len(tubes) > MOST_TUBES:
        ranked = [] if ranking is None else [*zip(ranking.columns["outer"], ranking.columns["middle"], strict=True)]
        order = dict.fromkeys(name for names in (pair, *ranked) for name in names if name)
        chosen = list(order | dict.fromkeys(tubes))[:MOST_TUBES]
        notes = (*notes, f"{len(tubes) - MOST_TUBES} more tubes: `coast beam` gives their shapes.")
        tubes = {name: tube for name, tube in tubes.items() if name in chosen}
    return shape_columns(list(tubes.values()), design.gravity, method="arc", points=_POINTS), notes


def _diagnosis(config: Config, recordings: Recordings, wanted: Wanted, origin: Mapping[str, Any]) -> DiagnosisAnswer:
    from coast_cli.diagnosis.recorded import diagnose
    from coast_cli.output.diagnosis import DiagnosisAnswer

    with waiting(f"diagnosing {', '.join(recordings.run_names[:3])}"):
        found = diagnose(config, recordings, hold_out=wanted.hold_out)
    return DiagnosisAnswer(found, found.config_used(config), recordings, origin, recordings.notes)
