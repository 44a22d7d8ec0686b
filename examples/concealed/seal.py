"""Writing cases where the answering side may look, and their truth where it cannot be read before it has answered.

A case's folder is named by a hash; the folder holds a configuration and recordings and nothing else. All truths go to
one encrypted file (Fernet of the library `cryptography`). The key is made from the words that asked for the cases
(whoever knows the seeds could make the truths again anyway) and is written only by `open_seal`, which first prints the
digest of all answers. An answer that is not among those digested was given after the key, and is refused.
"""

from __future__ import annotations

import base64
import hashlib
import json
import sys
from collections.abc import Iterable
from pathlib import Path
from typing import Any

import numpy as np

from examples.concealed.case import Case

SEALED, KEY = "truth.sealed", "truth.key"
Job = tuple[str, int, str | None, str | None]


class BrokenSealError(Exception):
    """The truths are not those that were sealed, or an answer is younger than the key."""


def case_id(seed: int, kind: str) -> str:
    """Return a name that says nothing of what is inside."""
    return hashlib.sha256(f"concealed/{kind}/{seed}".encode()).hexdigest()[:12]


def build(job: Job) -> tuple[str, Case]:
    """One case of (kind "joint" or "shape", seed, level, effect)."""
    kind, seed, level, effect = job
    if kind == "shape":
        from examples.concealed.shape_case import make_shape_case

        return case_id(seed, kind), make_shape_case(seed, level, effect)
    from examples.concealed.case import make_case

    return case_id(seed, kind), make_case(seed, level, effect)


def key_of(jobs: Iterable[Job]) -> bytes:
    """Return the Fernet key of the cases that these jobs ask for."""
    words = json.dumps([list(job) for job in jobs])
    return base64.urlsafe_b64encode(hashlib.sha256(f"concealed truths {words}".encode()).digest())


def write(out: Path, cases: Iterable[tuple[str, Case]], key: bytes) -> str:
    """Write `out`/cases/<id>/ and the encrypted truths; returns the SHA-256 of the truths in plain."""
    from cryptography.fernet import Fernet

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
    for file, words in (("held_out.json", held_out), ("without.json", without)):
        (out / file).write_text(json.dumps(words, sort_keys=True, indent=0) + "\n", encoding="utf-8")
    blob = json.dumps(truths, sort_keys=True, default=_plain, separators=(",", ":")).encode()
    (out / SEALED).write_bytes(Fernet(key).encrypt(blob))
    digest = hashlib.sha256(blob).hexdigest()
    (out / f"{SEALED}.sha256").write_text(digest + "\n", encoding="utf-8")
    return digest


def answers_of(out: Path) -> dict[str, str]:
    """Return the SHA-256 of every answer and saved model by file name; caches of the scorer are no answers."""
    files = sorted(out.glob("answers*/*.json")) + sorted(out.glob("answers*/*.model.toml"))
    given = [path for path in files if path.suffix == ".toml" or path.stem.count(".") == 0]
    return {f"{path.parent.name}/{path.name}": hashlib.sha256(path.read_bytes()).hexdigest() for path in given}


def open_seal(out: Path, key: bytes) -> None:
    """Print the digest of all answers, then write the key; a key that is written already stays as it is."""
    if (out / KEY).exists():
        return
    given = answers_of(out)
    total = hashlib.sha256(json.dumps(given, sort_keys=True).encode()).hexdigest()
    sys.stderr.write(f"{len(given)} answers and models, SHA-256 {total}\n")
    sys.stderr.flush()
    words = {"answers": given, "digest": total, "key": key.decode()}
    (out / KEY).write_text(json.dumps(words, sort_keys=True, indent=0) + "\n", encoding="utf-8")


def unseal(out: Path, digest: str | None = None) -> dict[str, dict[str, Any]]:
    """Return the truths by case; refuses truths that were changed and answers that are younger than the key."""
    from cryptography.fernet import Fernet, InvalidToken

    if not (out / KEY).exists():
        raise BrokenSealError(f"{out / KEY} is not there: the seal is opened once the answers have been digested")
    words = json.loads((out / KEY).read_text(encoding="utf-8"))
    try:
        blob = Fernet(words["key"].encode()).decrypt((out / SEALED).read_bytes())
    except InvalidToken as error:
        raise BrokenSealError(
            f"{out / SEALED} does not open with {out / KEY}: other seeds, or a changed file"
        ) from error
    expected = digest or (out / f"{SEALED}.sha256").read_text(encoding="utf-8").strip()
    if hashlib.sha256(blob).hexdigest() != expected:
        raise BrokenSealError(f"{out / SEALED} has changed since it was sealed as {expected}")
    younger = [name for name, found in answers_of(out).items() if words["answers"].get(name) != found]
    if younger:
        raise BrokenSealError(f"younger than the key: {', '.join(younger[:5])} ({len(younger)} in all)")
    return dict(json.loads(blob))


def _plain(value: object) -> object:
    return value.item() if isinstance(value, np.generic) else list(value)  # type: ignore[call-overload]
