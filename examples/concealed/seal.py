"""Writing cases where the answering side may look, and their truth where it may not.

A case's folder is named by a hash; the folder holds a configuration and recordings and nothing else. All truths go
to one file whose SHA-256 is printed before any answer exists and checked before any answer is scored.
"""

from __future__ import annotations

import hashlib
import json
from collections.abc import Iterable, Iterator
from concurrent.futures import ProcessPoolExecutor
from pathlib import Path
from typing import Any

import numpy as np

from examples.concealed.case import Case

SEALED = "truth.sealed.json"


class BrokenSealError(Exception):
    """The truths are not those whose hash was printed."""


def case_id(seed: int, kind: str) -> str:
    """Return a name that says nothing of what is inside."""
    return hashlib.sha256(f"concealed/{kind}/{seed}".encode()).hexdigest()[:12]


def build(job: tuple[str, int, str | None, str | None]) -> tuple[str, Case]:
    """One case of (kind "joint" or "shape", seed, level, effect)."""
    kind, seed, level, effect = job
    if kind == "shape":
        from examples.concealed.shape_case import make_shape_case

        return case_id(seed, kind), make_shape_case(seed, level, effect)
    from examples.concealed.case import make_case

    return case_id(seed, kind), make_case(seed, level, effect)


def build_all(jobs: list[tuple[str, int, str | None, str | None]], workers: int) -> Iterator[tuple[str, Case]]:
    """Cases in the order of the jobs, on `workers` processes."""
    if workers <= 1:
        yield from map(build, jobs)
        return
    with ProcessPoolExecutor(workers) as pool:
        yield from pool.map(build, jobs, chunksize=4)


def write(out: Path, cases: Iterable[tuple[str, Case]]) -> str:
    """Write `out`/cases/<id>/ and the sealed truths; returns the seal's SHA-256."""
    truths, held_out, without = {}, {}, {}
    for name, case in cases:
        folder = out / "cases" / name
        folder.mkdir(parents=True, exist_ok=True)
        (folder / "tubes.toml").write_text(case.config_text, encoding="utf-8")
        for file, text in case.files.items():
            (folder / file).write_text(text, encoding="utf-8")
        for request, text in case.laboratory.items():
            shelf = out / "laboratory" / name
            shelf.mkdir(parents=True, exist_ok=True)
            (shelf / f"{request}.csv").write_text(text, encoding="utf-8")
        truths[name] = case.truth
        held_out[name] = list(case.held_out)
        if case.without:
            without[name] = list(case.without)
    (out / "held_out.json").write_text(json.dumps(held_out, sort_keys=True, indent=0) + "\n", encoding="utf-8")
    (out / "without.json").write_text(json.dumps(without, sort_keys=True, indent=0) + "\n", encoding="utf-8")
    blob = json.dumps(truths, sort_keys=True, default=_plain, separators=(",", ":")).encode()
    (out / SEALED).write_bytes(blob)
    digest = hashlib.sha256(blob).hexdigest()
    (out / f"{SEALED}.sha256").write_text(digest + "\n", encoding="utf-8")
    return digest


def unseal(out: Path, digest: str | None = None) -> dict[str, dict[str, Any]]:
    """Return the truths by case id; refuses a file that is not the one sealed."""
    blob = (out / SEALED).read_bytes()
    expected = digest or (out / f"{SEALED}.sha256").read_text(encoding="utf-8").strip()
    if hashlib.sha256(blob).hexdigest() != expected:
        raise BrokenSealError(f"{out / SEALED} has changed since it was sealed as {expected}")
    return dict(json.loads(blob))


def _plain(value: object) -> object:
    return value.item() if isinstance(value, np.generic) else list(value)  # type: ignore[call-overload]
