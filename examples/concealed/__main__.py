"""`python -m examples.concealed make|run|score|all`: see README.md."""

from __future__ import annotations

import argparse
import sys
from pathlib import Path


def _seeds(text: str) -> range:
    first, _, last = text.partition(":")
    return range(int(first), int(last))


def parser() -> argparse.ArgumentParser:
    """Return the command line."""
    top = argparse.ArgumentParser(
        prog="python -m examples.concealed", description="Recordings with something left out: make, run, score."
    )
    steps = top.add_subparsers(dest="step", required=True)
    for name, text in (
        ("make", "write recordings and seal the truth"),
        ("run", "let coast diagnose every case"),
        ("score", "open the seal and print the table"),
        ("all", "make, run, score"),
    ):
        step = steps.add_parser(name, help=text)
        step.add_argument("--out", type=Path, required=True, help="folder of the cases, answers and table")
        step.add_argument("--jobs", type=int, default=2)
        if name in ("make", "all"):
            step.add_argument("--seeds", type=_seeds, required=True, help="FIRST:LAST, the last not included")
            step.add_argument("--level", action="append", help="only these levels (repeat)")
            step.add_argument("--effect", help="only this effect")
            step.add_argument("--shapes", action="store_true", help="shapes instead of joint recordings")
        if name in ("score", "all"):
            step.add_argument("--baselines", type=int, default=0, help="also run the other answers on this many cases")
            step.add_argument("--plots", action="store_true", help="confusion matrix and reliability as pictures")
            step.add_argument("--sha256", help="the seal printed by make")
    steps.add_parser(
        "laws", help="print the laws that leave the catalogue, the near twins and the digest that freezes them"
    )
    return top


def main(arguments: list[str] | None = None) -> int:
    """Run one step; the table goes to stdout, the rest to stderr."""
    given = parser().parse_args(arguments)
    if given.step == "laws":
        from examples.concealed.laws import listing

        sys.stdout.write(listing())
        return 0
    digest = getattr(given, "sha256", None)
    if given.step in ("make", "all"):
        from examples.concealed.seal import build_all, write

        kind = "shape" if given.shapes else "joint"
        levels = given.level or [None]
        jobs = [(kind, seed, levels[i % len(levels)], given.effect) for i, seed in enumerate(given.seeds)]
        digest = write(given.out, build_all(jobs, given.jobs))
        sys.stderr.write(f"sealed {len(jobs)} truths, SHA-256 {digest}\n")
    if given.step in ("run", "all"):
        from examples.concealed.runner import run

        run(given.out, given.jobs)
    if given.step in ("score", "all"):
        from examples.concealed.scorer import score

        sys.stdout.write(
            score(given.out, digest=digest, baselines=given.baselines, plots=given.plots, jobs=given.jobs).table()
        )
    return 0


if __name__ == "__main__":
    sys.exit(main())
