"""Let `coast diagnose` answer every case, each in a process of its own.

What is answered is not asked again. An answer is written whole or not at all, so the run may be stopped anywhere.
Where a laboratory shelf lies beside a case and the first answer proposes a next recording, the proposal is read for
what it asks, that recording is added, and the case is asked once more.
"""

from __future__ import annotations

import json
import os
import re
import subprocess
import sys
import time
from dataclasses import dataclass, replace
from pathlib import Path
from typing import Any

from examples.concealed.protocol import REQUESTS
from examples.concealed.seal import KEY, BrokenSealError
from examples.concealed.work import spread

ROOT = Path(__file__).resolve().parents[2]
PATIENCE_S = 600
UNKNOWN = re.compile(r"no such effect to leave out; found '([^']+)'")
ONE_THREAD = {"OMP_NUM_THREADS": "1", "OPENBLAS_NUM_THREADS": "1", "MKL_NUM_THREADS": "1"}


@dataclass(frozen=True)
class Question:
    """One case to answer: its folder, runs to hold out, names to conceal, further words for `coast diagnose`.

    `folder` is where below `out` the answer goes, `root` where the package lies that answers.
    """

    out: Path
    case: Path
    held_out: tuple[str, ...] = ()
    without: tuple[str, ...] = ()
    further: tuple[str, ...] = ()
    folder: str = "answers"
    root: Path = ROOT

    @property
    def target(self) -> Path:
        """Where the answer goes."""
        return self.out / self.folder / f"{self.case.name}.json"

    @property
    def model(self) -> Path:
        """Where the saved model goes."""
        return self.out / self.folder / f"{self.case.name}.model.toml"


def coast(*arguments: str, root: Path = ROOT) -> tuple[int, str, str]:
    """Exit code, stdout and stderr of one `coast` command, by the package that lies in `root`."""
    done = subprocess.run(
        [sys.executable, "-m", "coast_cli", *arguments],
        cwd=root,
        env=os.environ | ONE_THREAD,
        capture_output=True,
        text=True,
        timeout=PATIENCE_S,
        check=False,
    )
    return done.returncode, done.stdout, done.stderr


def questions(out: Path, further: tuple[str, ...] = (), folder: str = "answers") -> list[Question]:
    """Return all cases of a folder, in the order of their names."""
    held_out, without = (
        json.loads((out / name).read_text(encoding="utf-8")) for name in ("held_out.json", "without.json")
    )
    cases = sorted(path for path in (out / "cases").iterdir() if path.is_dir())
    return [
        Question(out, case, tuple(held_out.get(case.name, ())), tuple(without.get(case.name, ())), further, folder)
        for case in cases
    ]


def run(
    out: Path,
    jobs: int = 2,
    cluster: str | None = None,
    further: tuple[str, ...] = (),
    label: str | None = None,
) -> int:
    """Answer what is not answered yet; returns how many cases were asked. Refused once the seal is open.

    With a `label` the answers, given with `further` words, stand beside ours as those of another answer.
    """
    folder = f"answers-{label}" if label else "answers"
    every = questions(out, further, folder)
    (out / folder).mkdir(exist_ok=True)
    waiting = [question for question in every if not answered(question.target)]
    sys.stderr.write(f"{len(every) - len(waiting)} of {len(every)} answered already\n")
    if waiting and (out / KEY).exists():
        raise BrokenSealError(f"{out / KEY} is there: what is answered now has seen the truths")
    for count, _ in enumerate(spread(answer, waiting, jobs, cluster), 1):
        if count % 20 == 0 or count == len(waiting):
            sys.stderr.write(f"{count} of {len(waiting)}\n")
    return len(waiting)


def answered(path: Path) -> bool:
    """Return whether a case has its answer: one that ended without is asked again."""
    return path.exists() and json.loads(path.read_text(encoding="utf-8"))["diagnosis"] is not None


def answer(question: Question) -> None:
    """Ask once, and once more with the recording that the first answer proposed, where there is a shelf to take it from."""
    recordings = sorted(question.case.glob("*.csv"))
    first = ask(question, recordings, question.model)
    shelf = question.out / "laboratory" / question.case.name
    if shelf.is_dir() and first["diagnosis"]:
        asked = requests(str(first["diagnosis"].get("next_recording") or ""))
        first["requested"] = asked
        if asked:
            # One proposed recording holds all the runs its words ask for.
            first["second"] = ask(question, [*recordings, *(shelf / f"{request}.csv" for request in asked)], None)
    partial = question.target.with_suffix(".partial")
    partial.write_text(json.dumps(first, sort_keys=True), encoding="utf-8")
    partial.replace(question.target)


def ask(question: Question, recordings: list[Path], model: Path | None) -> dict[str, Any]:
    """Call `coast diagnose` once: exit code, seconds, held-out runs, answer (or none) and the end of stderr."""
    arguments = ["diagnose", str(question.case / "tubes.toml"), *map(str, recordings), "--format", "json"]
    for name in question.held_out:
        arguments += ["--hold-out", name]
    if question.without:
        arguments += ["--without", ",".join(question.without)]
    if model is not None:
        arguments += ["--save-model", str(model)]
    begin = time.perf_counter()
    try:
        code, stdout, stderr = coast(*arguments, *question.further, root=question.root)
    except subprocess.TimeoutExpired:
        code, stdout, stderr = -1, "", "timed out"
    try:
        diagnosis = json.loads(stdout)
    except json.JSONDecodeError:
        diagnosis = None
    unknown = UNKNOWN.search(stderr)
    if diagnosis is None and unknown and unknown[1] in question.without:
        # What the catalogue does not hold need not be concealed from it.
        kept = tuple(name for name in question.without if name != unknown[1])
        return ask(replace(question, without=kept), recordings, model)
    if diagnosis is not None and "verdict" not in diagnosis:
        # The envelope of other commands: one row of answer.
        rows = diagnosis.get("rows") or [None]
        diagnosis = rows[0] if isinstance(rows[0], dict) and "verdict" in rows[0] else None
    return {
        "exit": code,
        "seconds": round(time.perf_counter() - begin, 3),
        "held_out": list(question.held_out),
        "without": list(question.without),
        "diagnosis": diagnosis,
        "stderr": stderr[-600:],
    }


def requests(words: str) -> list[str]:
    """Return what a proposal in words asks for, by its first mention."""
    found = {
        name: match.start()
        for name, (pattern, _) in REQUESTS.items()
        if (match := re.search(pattern, words, re.IGNORECASE))
    }
    return sorted(found, key=found.__getitem__)
