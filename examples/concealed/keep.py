"""The kept answers: every case's judgement in one compressed file, from which the README's figures are printed.

The file says of which code it is (a digest of `coast_cli`). Where the code has moved since, `measure_drift` asks a
sample of the cases again and writes by how much the answers moved, beside the digest of the code that gave them.
"""

from __future__ import annotations

import hashlib
import json
import lzma
import tempfile
from collections.abc import Sequence
from dataclasses import asdict, fields
from pathlib import Path
from typing import Any

from examples.concealed.figures import Scores
from examples.concealed.judge import Judgement, judge
from examples.concealed.report import short, table
from examples.concealed.runner import ROOT, answer, questions
from examples.concealed.seal import Job, build, case_id, write
from examples.concealed.work import spread

KEPT = ROOT / "tests" / "concealed" / "answers.jsonl.xz"
DRIFT = ROOT / "tests" / "concealed" / "drift.json"
# Marks of a page that holds the table, or its main rows.
BEGIN, END = "<!-- printed by `python -m examples.concealed table` -->", "<!-- end of the printed table -->"
BEGIN_SHORT = "<!-- main rows of `python -m examples.concealed table` -->"


def code_digest() -> str:
    """Return the SHA-256 of all that can change an answer: the modules and data files of coast_cli, not its pages."""
    total = hashlib.sha256()
    package = ROOT / "coast_cli"
    for path in sorted(package.rglob("*")):
        if path.suffix in (".py", ".toml", ".json"):
            total.update(path.relative_to(package).as_posix().encode() + b"\n" + path.read_bytes())
    return total.hexdigest()


def keep(scores: Scores, path: Path = KEPT) -> None:
    """Write all judgements, those of the other answers too, with the digest of the code; the same scores, the same bytes."""
    about = scores.about | {"code": code_digest()[:16]}
    lines: list[dict[str, Any]] = [{"about": about}]
    for name, judged in (("", scores.judgements), *sorted(scores.others.items())):
        lines += [{"answer": name} | _short(j) for j in judged]
    text = "\n".join(json.dumps(line, sort_keys=True, separators=(",", ":")) for line in lines)
    path.write_bytes(lzma.compress(text.encode(), preset=9))


def _short(j: Judgement) -> dict[str, Any]:
    """Return a judgement without what is absent, numbers to six digits."""
    return {key: _round(value) for key, value in asdict(j).items() if value not in (None, (), {}, "")}


def _round(value: object) -> object:
    if isinstance(value, float):
        return float(f"{value:.6g}")
    if isinstance(value, dict):
        return {key: _round(entry) for key, entry in value.items()}
    return [_round(entry) for entry in value] if isinstance(value, (list, tuple)) else value


def kept(path: Path = KEPT) -> Scores:
    """Return the scores that were kept."""
    lines = [json.loads(line) for line in lzma.decompress(path.read_bytes()).decode().splitlines()]
    judged: dict[str, list[Judgement]] = {}
    for line in lines[1:]:
        judged.setdefault(line.pop("answer"), []).append(_judgement(line))
    return Scores(judged.pop("", []), judged, lines[0]["about"])


EMPTY = dict.fromkeys(("truth", "laws", "sizes", "named", "group", "beliefs", "intervals"), ()) | {
    "noise": "",
    "figures": {},
}


def _judgement(line: dict[str, Any]) -> Judgement:
    """Return a judgement as it was kept: what was absent is None or empty."""
    values = {entry.name: line.get(entry.name, EMPTY.get(entry.name)) for entry in fields(Judgement)}
    return Judgement(**{name: _tuples(value) for name, value in values.items()})


def _tuples(value: object) -> Any:  # noqa: ANN401 -- whatever the field of a judgement is
    return tuple(_tuples(entry) for entry in value) if isinstance(value, list) else value


def relation(path: Path = KEPT, drift: Path = DRIFT) -> str:
    """Return in a sentence how the code as it stands relates to the code whose answers are kept."""
    then, now = kept(path).about["code"], code_digest()[:16]
    if then == now:
        return f"Made by the code as it stands (`coast_cli` {now})."
    moved = f"The code has moved since these answers were given (`coast_cli` {then} then, {now} now)"
    found = json.loads(drift.read_text(encoding="utf-8")) if drift.exists() else {}
    if found.get("from") != then:
        return f"{moved}; by how much the answers moved has not been measured."
    of = "now" if found["to"] == now else f"at {found['to']}, on the way"
    return (
        f"{moved}: asked again {of}, {found['verdicts']} of {found['cases']} verdicts and {found['names']} first names "
        f"are others, and the mean score is {found['score_after']:.3f} where it was {found['score_before']:.3f}."
    )


def put(path: Path, scores: Scores) -> None:
    """Put the table of these scores, or its main rows, between the marks of a page."""
    words = path.read_text(encoding="utf-8")
    for begin, text in ((BEGIN, table(scores)), (BEGIN_SHORT, short(scores))):
        before, found, rest = words.partition(begin + "\n")
        if found:
            _, _, after = rest.partition(END)
            path.write_text(f"{before}{found}{text}{END}{after}", encoding="utf-8")
            return
    raise ValueError(f"{path} lacks the lines {BEGIN!r} and {END!r}, between which the table goes")


def held(path: Path) -> bool | None:
    """Whether a page holds between its marks what is printed; None without marks."""
    words, scores = path.read_text(encoding="utf-8"), kept()
    for begin, text in ((BEGIN, table(scores)), (BEGIN_SHORT, short(scores))):
        _, found, rest = words.partition(begin + "\n")
        if found:
            return rest.partition(END)[0] == text
    return None


def sample(judged: Sequence[Judgement], count: int) -> list[Judgement]:
    """Return `count` judgements, each level in turn, in the order of the names of the cases."""
    levels: dict[str, list[Judgement]] = {}
    for j in sorted(judged, key=lambda j: j.case):
        levels.setdefault(j.level, []).append(j)
    turns = [j for turn in range(len(judged)) for mine in levels.values() for j in mine[turn : turn + 1]]
    return turns[:count]


def measure_drift(count: int, workers: int, path: Path = KEPT, drift: Path = DRIFT) -> dict[str, Any]:
    """Ask `count` of the kept cases again and write by how much verdicts, first names and the mean score have moved."""
    scores = kept(path)
    chosen = sample(scores.judgements, count)
    jobs: list[Job] = [(j.kind, j.seed, j.level, None) for j in chosen]
    with tempfile.TemporaryDirectory() as folder:
        out = Path(folder)
        made = dict(spread(build, jobs, workers))
        write(out, made.items(), b"A" * 43 + b"=")
        (out / "answers").mkdir()
        for _ in spread(answer, questions(out), workers):
            pass
        now = {
            name: judge(name, case.truth, json.loads((out / "answers" / f"{name}.json").read_text(encoding="utf-8")))
            for name, case in made.items()
        }
    # Errors are not computed again, so scores are compared without them.
    pairs = [(j, now[case_id(j.seed, j.kind)]) for j in chosen]
    found = {
        "from": scores.about["code"],
        "to": code_digest()[:16],
        "cases": len(pairs),
        "verdicts": sum(a.verdict != b.verdict for a, b in pairs),
        "names": sum(a.named[:1] != b.named[:1] for a, b in pairs),
        "score_before": round(sum(a.score for a, _ in pairs) / max(len(pairs), 1), 4),
        "score_after": round(sum(b.score for _, b in pairs) / max(len(pairs), 1), 4),
        "moved": {a.case: [a.verdict, b.verdict] for a, b in pairs if a.verdict != b.verdict},
    }
    drift.write_text(json.dumps(found, indent=1, sort_keys=True) + "\n", encoding="utf-8")
    return found
