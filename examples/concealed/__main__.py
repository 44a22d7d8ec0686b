"""`python -m examples.concealed laws|make|run|score|all|table|drift`: see README.md."""

from __future__ import annotations

import argparse
import shlex
import sys
from pathlib import Path

from examples.concealed.seal import Job

STEPS = {
    "laws": "print the laws that leave the catalogue, their near twins and the digest that freezes them",
    "make": "write recordings and seal the truth",
    "run": "let coast diagnose every case",
    "score": "digest the answers, open the seal, print the table",
    "all": "make, run, score",
    "table": "print the figures of the kept answers",
    "tune": "set deciding numbers of the diagnosis on tuning seeds",
    "odds": "set how far names are to be believed on tuning seeds",
    "drift": "ask some of the kept cases again and write by how much the answers have moved",
}


def _seeds(text: str) -> range:
    first, _, last = text.partition(":")
    return range(int(first), int(last))


def parser() -> argparse.ArgumentParser:
    """Return the command line."""
    top = argparse.ArgumentParser(
        prog="python -m examples.concealed", description="Recordings with something left out: make, run, score."
    )
    steps = top.add_subparsers(dest="step", required=True)
    for name, text in STEPS.items():
        step = steps.add_parser(name, help=text)
        if name != "laws":
            step.add_argument("--jobs", type=int, default=2, help="processes on this machine")
        if name in ("make", "run", "score", "all", "tune", "odds"):
            step.add_argument("--out", type=Path, required=True, help="folder of the cases, answers and table")
        if name in ("make", "run", "all"):
            step.add_argument(
                "--cluster", metavar="ADDRESS", help="dask scheduler (tcp://host:port) instead of processes"
            )
        if name in ("make", "score", "all"):
            # The seal's key is made of these words: score is given the same as make.
            step.add_argument("--seeds", type=_seeds, required=True, help="FIRST:LAST, the last not included")
            step.add_argument("--level", action="append", help="only these levels, in turn (repeat)")
            step.add_argument(
                "--effect", action="append", help="only these effects, in turn (repeat); catalogue: all of it"
            )
            step.add_argument("--shapes", action="store_true", help="shapes instead of joint recordings")
        if name in ("run", "all"):
            step.add_argument("--label", help="keep these answers as answers-LABEL: another answer on the same cases")
            step.add_argument("--further", default="", help='further words for coast diagnose, as "--max-effects 1"')
        if name in ("score", "all"):
            step.add_argument("--baselines", type=int, default=0, help="also run the other answers on this many cases")
            step.add_argument("--plots", action="store_true", help="draw the pictures beside the table")
            step.add_argument("--details", action="store_true", help="print what was said of what, and the worst cases")
            step.add_argument("--sha256", help="the digest of the truths printed by make")
            step.add_argument("--keep", action="store_true", help="keep the judgements in tests/concealed")
        if name == "table":
            step.add_argument("--details", action="store_true", help="print what was said of what, and the worst cases")
            step.add_argument(
                "--into", type=Path, action="append", default=[], help="also put the table into this page"
            )
            step.add_argument("--plots", type=Path, help="also draw the pictures into this folder")
        if name in ("tune", "odds"):
            step.add_argument("--seeds", type=_seeds, required=True, help="FIRST:LAST, below those that are scored")
            step.add_argument("--write", action="store_true", help="write what was found into the module")
        if name == "tune":
            step.add_argument(
                "--threshold", action="append", required=True, metavar="NAME=V,V", help="values to try (repeat)"
            )
        if name == "drift":
            step.add_argument("--cases", type=int, default=150)
    return top


def asked(given: argparse.Namespace) -> list[Job]:
    """Return the cases that the words of a command ask for."""
    from examples.concealed.laws import JOINT_EFFECTS

    # A camera's scale is a stiffness to curvature alone: there is nothing to conceal.
    catalogue = [name for name in JOINT_EFFECTS if name != "camera_scale"]
    levels: list[str | None] = given.level or [None]
    effects: list[str | None] = catalogue if given.effect == ["catalogue"] else given.effect or [None]
    kind = "shape" if given.shapes else "joint"
    turns = len(given.seeds)
    return [(kind, given.seeds[i], levels[i % len(levels)], effects[i % len(effects)]) for i in range(turns)]


def main(arguments: list[str] | None = None) -> int:
    """Run one step; data go to stdout, the rest to stderr."""
    given = parser().parse_args(arguments)
    step = {"laws": _laws, "table": _table, "tune": _tune, "odds": _odds, "drift": _drift}.get(given.step)
    if step:
        step(given)
        return 0
    if given.step in ("make", "all"):
        _make(given)
    if given.step in ("run", "all"):
        _run(given)
    if given.step in ("score", "all"):
        _score(given)
    return 0


def _laws(_given: argparse.Namespace) -> None:
    from examples.concealed.laws import listing

    sys.stdout.write(listing())


def _make(given: argparse.Namespace) -> None:
    from examples.concealed.seal import build, key_of, write
    from examples.concealed.work import spread

    jobs = asked(given)
    digest = write(given.out, spread(build, jobs, given.jobs, given.cluster), key_of(jobs))
    sys.stderr.write(f"sealed {len(jobs)} truths, SHA-256 {digest}\n")


def _run(given: argparse.Namespace) -> None:
    from examples.concealed.runner import run

    run(given.out, given.jobs, given.cluster, tuple(shlex.split(given.further)), given.label)


def _score(given: argparse.Namespace) -> None:
    from examples.concealed.keep import keep
    from examples.concealed.report import details, table
    from examples.concealed.scorer import score
    from examples.concealed.seal import key_of, open_seal
    from examples.concealed.tune import FIRST_SCORED

    open_seal(given.out, key_of(asked(given)))
    scores = score(given.out, digest=given.sha256, baselines=given.baselines, jobs=given.jobs)
    sys.stdout.write(table(scores) + (f"\n{details(scores)}" if given.details else ""))
    if given.plots:
        from examples.concealed.pictures import draw_all

        draw_all(scores, given.out / "pictures")
    if given.keep:
        if given.seeds.start < FIRST_SCORED:
            raise SystemExit(f"seeds below {FIRST_SCORED} are for tuning: their figures are not kept")
        keep(scores)


def _table(given: argparse.Namespace) -> None:
    from examples.concealed.keep import kept, put, relation
    from examples.concealed.report import details, table

    scores = kept()
    sys.stdout.write(f"{relation()}\n\n{table(scores)}" + (f"\n{details(scores)}" if given.details else ""))
    for path in given.into:
        put(path, scores)
    if given.plots:
        from examples.concealed.pictures import draw_all

        draw_all(scores, given.plots)


def _tune(given: argparse.Namespace) -> None:
    from examples.concealed.tune import best, put, tune

    tried = {
        name: [float(v) for v in values.split(",")] for name, _, values in (t.partition("=") for t in given.threshold)
    }
    trials = tune(given.out.resolve(), given.seeds, tried, given.jobs)
    rows = "".join(f"| `{trial.name}` | {trial.value:g} | {trial.score:.4f} |\n" for trial in trials)
    sys.stdout.write(f"| number | value | mean score |\n|---|---|---|\n{rows}\n")
    sys.stdout.writelines(f"{name} = {trial.value:g}\n" for name, trial in best(trials).items())
    if given.write:
        put(trials)


def _odds(given: argparse.Namespace) -> None:
    from examples.concealed.odds import FROM, believed, collect, fitted, put, report, worth

    names, figures, judged = collect(given.out.resolve(), given.seeds, given.jobs)
    right, outside = judged.T
    weights = fitted(figures, right)
    sys.stdout.write(report(weights, names, figures, right))
    worths = worth(believed(weights, figures), right, outside)
    sys.stdout.writelines(f"named from {level:.2f}: {value:.3f}\n" for level, value in zip(FROM, worths, strict=True))
    if given.write:
        put(weights, names, round(float(FROM[worths.argmax()]), 2))


def _drift(given: argparse.Namespace) -> None:
    from examples.concealed.keep import measure_drift, relation

    measure_drift(given.cases, given.jobs)
    sys.stdout.write(relation() + "\n")


if __name__ == "__main__":
    sys.exit(main())
