"""What the answer on shapes says besides its figures: notes on its shape_limits, and the photographs that are missing."""

from __future__ import annotations

from coast_cli.diagnosis.fit import Fit
from coast_cli.diagnosis.shapes.problem import ShapeProblem
from coast_cli.diagnosis.thresholds import END_EFFECT_SPREAD

HIDDEN_IN_MODULUS = ("notch_end_effect", "chord_section", "notch_depth_error", "gravity")
SAME_TUBE_AGAIN = "the same tube once more unchanged, then turned by 90 degrees and clamped half as long"
ANOTHER_GEOMETRY = "another tube of the same material with another notch depth or cut length, both ways up"


def shape_limits(problem: ShapeProblem, *, agrees: bool) -> list[str]:
    """Return what the photographs cannot show, a sentence each."""
    notes = []
    if _one_way_up(problem):
        notes.append(
            f"{', '.join(_one_way_up(problem))}: photographed one way up only, so natural curvature and load "
            "are told apart by the shape of the bend alone"
        )
    alone = {photograph.tubes[0][0] for photograph in problem.photographs if not photograph.is_pair}
    assumed = [name for number, name in problem.scene.tubes.items() if number not in alone]
    if assumed and not agrees:
        notes.append(
            f"{', '.join(assumed)}: never photographed alone, so depth and natural curvature are taken as "
            "configured; an error of them looks like a fault of the assembly"
        )
    return notes


def spread_note(problem: ShapeProblem, final: Fit) -> list[str]:
    """Say by how much the end effect of each tube was found to differ from the table."""
    if not any(getattr(effect, "by_tube", 0.0) for effect in final.effects):
        return []
    found = problem.spreads(final.coordinates)
    parts = ", ".join(
        f"{problem.scene.tubes[n]} {100.0 * share:+.0f} %" for n, share in found.items() if abs(share) > 0.01
    )
    allowed = f"{100.0 * END_EFFECT_SPREAD:.0f} %"
    return (
        [f"the end effect of a tube may differ from its table by {allowed}, one standard deviation: {parts}"]
        if parts
        else []
    )


def _one_way_up(problem: ShapeProblem) -> list[str]:
    """Return the tubes and pairs that were not photographed both ways up."""
    sides: dict[str, set[float]] = {}
    for photograph in problem.photographs:
        sides.setdefault(photograph.run.pair, set()).add(photograph.upward)
    return [name for name, found in sides.items() if len(found) == 1]


def next_photograph(problem: ShapeProblem) -> str:
    """Return the photographs that are missing to separate natural curvature from load, or an empty text."""
    single = _one_way_up(problem)
    if not single:
        return ""
    way = {1.0: "down", -1.0: "up"}
    wanted = {p.run.pair: way[p.upward] for p in problem.photographs if p.run.pair in single}
    parts = ", ".join(f"{name} with natural = {side}" for name, side in wanted.items())
    return f"the same tubes turned over ({parts}), 40 points or more each: this separates natural curvature from load"
