"""Let `coast diagnose` answer every case, two at a time, in processes of their own.

What is answered is not asked again.

An answer is written whole or not at all, so the run may be stopped anywhere. Where a laboratory shelf lies beside a
case and the first answer proposes a next recording, the proposal is read for what it asks, that recording is added,
and the case is asked once more.
"""

from __future__ import annotations

import json
import os
import re
import subprocess
import sys
import time
from concurrent.futures import ThreadPoolExecutor, as_completed
from pathlib import Path
from typing import Any

from examples.concealed.protocol import REQUESTS

ROOT = Path(__file__).resolve().parents[2]
PATIENCE_S = 600
ONE_THREAD = {"OMP_NUM_THREADS": "1", "OPENBLAS_NUM_THREADS": "1", "MKL_NUM_THREADS": "1"}


def coast(*arguments: str) -> tuple[int, str, str]:
    """Exit code, stdout and stderr of one `coast` command."""
    done = subprocess.run(
        [sys.executable, "-m", "coast_cli", *arguments],
        cwd=ROOT,
        env=os.environ | ONE_THREAD,
        capture_output=True,
        text=True,
        timeout=PATIENCE_S,
        check=False,
    )
    return done.returncode, done.stdout, done.stderr


def run(out: Path, jobs: int = 2) -> int:
    """Answer what is not answered yet; returns how many cases were asked."""
    cases = sorted(path for path in (out / "cases").iterdir() if path.is_dir())
    held_out = json.loads((out / "held_out.json").read_text(encoding="utf-8"))
    without = json.loads((out / "without.json").read_text(encoding="utf-8"))
    answers = out / "answers"
    answers.mkdir(exist_ok=True)
    waiting = [case for case in cases if not _answered(answers / f"{case.name}.json")]
    sys.stderr.write(f"{len(cases) - len(waiting)} of {len(cases)} answered already\n")
    pool = ThreadPoolExecutor(max(jobs, 1))
    try:
        futures = [
            pool.submit(answer, out, case, held_out.get(case.name, []), without.get(case.name, [])) for case in waiting
        ]
        for count, future in enumerate(as_completed(futures), 1):
            future.result()
            if count % 20 == 0 or count == len(waiting):
                sys.stderr.write(f"{count} of {len(waiting)}\n")
    except KeyboardInterrupt:
        sys.stderr.write("stopping; the same command goes on from here\n")
        pool.shutdown(wait=True, cancel_futures=True)
        raise
    pool.shutdown()
    return len(waiting)


def _answered(path: Path) -> bool:
    """Return whether a case has its answer: one that ended without is asked again."""
    return path.exists() and json.loads(path.read_text(encoding="utf-8"))["diagnosis"] is not None


def answer(out: Path, case: Path, held_out: list[str], without: list[str]) -> None:
    """Ask once, and once more with the recording that the first answer proposed.

    Where there is a shelf to take it from.
    """
    first = ask(case, sorted(case.glob("*.csv")), held_out, out / "answers" / f"{case.name}.model.toml", without)
    shelf = out / "laboratory" / case.name
    if shelf.is_dir() and first["diagnosis"]:
        asked = requests(str(first["diagnosis"].get("next_recording") or ""))
        first["requested"] = asked
        if asked:
            # One proposed recording holds all the runs its words ask for.
            more = [shelf / f"{request}.csv" for request in asked]
            first["second"] = ask(case, [*sorted(case.glob("*.csv")), *more], held_out, None, without)
    target = out / "answers" / f"{case.name}.json"
    partial = target.with_suffix(".partial")
    partial.write_text(json.dumps(first, sort_keys=True), encoding="utf-8")
    partial.replace(target)


def ask(
    case: Path, recordings: list[Path], held_out: list[str], model: Path | None, without: list[str]
) -> dict[str, Any]:
    """Call `coast diagnose` once: exit code, seconds, held-out runs, answer (or none) and the end of stderr."""
    arguments = ["diagnose", str(case / "tubes.toml"), *map(str, recordings), "--format", "json"]
    for name in held_out:
        arguments += ["--hold-out", name]
    if without:
        arguments += ["--without", ",".join(without)]
    if model is not None:
        arguments += ["--save-model", str(model)]
    begin = time.perf_counter()
    try:
        code, stdout, stderr = coast(*arguments)
    except subprocess.TimeoutExpired:
        code, stdout, stderr = -1, "", "timed out"
    try:
        diagnosis = json.loads(stdout)
    except json.JSONDecodeError:
        diagnosis = None
    if diagnosis is not None and "verdict" not in diagnosis:
        # The envelope of other commands: one row of answer.
        rows = diagnosis.get("rows") or [None]
        diagnosis = rows[0] if isinstance(rows[0], dict) and "verdict" in rows[0] else None
    return {
        "exit": code,
        "seconds": round(time.perf_counter() - begin, 3),
        "held_out": held_out,
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
