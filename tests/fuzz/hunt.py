"""Fuzzing of every target in turn for a time, by the mutations of their structure and of their bytes.

    PYTHONPATH=. nice python tests/fuzz/hunt.py --minutes 30 --out findings

The targets share the processor time evenly. Whatever is no refusal in one sentence is written to the folder, once for
each place that raised, with the command line that found it; so is a run of more than 20 s or one that takes more than
1 GB. The table at the end, or where SIGTERM ends it, says how much was tried. What is mended goes into ``cases/``, where
``test_cases.py`` replays it.
"""

import argparse
import os
import random
import resource
import signal
import sys
import tempfile
import time
import traceback
import warnings
from pathlib import Path

from tests.fuzz import mappings, targets
from tests.fuzz.targets import Target

DIAGNOSES = Target(
    ".csv",
    (("diagnose", str(targets.CONFIG), "{file}", "--x2", "20", "--max-effects", "1", *targets.JSON),),
    targets.TARGETS["recording"].seeds,
    targets.mutate_csv,
)  # of seconds each: too slow for every test run
TARGETS = targets.TARGETS | mappings.TARGETS | {"diagnosis": DIAGNOSES}
SECONDS, BYTES = 20, 2**30
LONGEST = 60_000  # bytes of a file that is tried


class TooSlow(BaseException):
    """A run took more than its time; not an Exception, so that nothing takes it for its own."""


class Hunt:
    """One target, and what was found in it.

    Attributes:
        runs, refused: how many files were tried, and refused. seconds: of processor time. seen: where something was found.
    """

    def __init__(self, name: str, out: Path) -> None:
        self.name, self.target, self.out = name, TARGETS[name], out
        self.file = Path(tempfile.mkdtemp()) / f"fuzzed{self.target.suffix}"
        self.runs, self.refused, self.seconds, self.seen, self.seeds = 0, 0, 0.0, set(), self.target.seeds()

    def mutate(self, chance: random.Random) -> bytes:
        """Return a seed that was changed some times."""
        data = chance.choice(self.seeds)
        for _ in range(chance.choice((1, 1, 2, 3, 5))):
            data = self.target.mutate(data, chance) if chance.random() < 0.8 else mappings.mutate_bytes(data, chance)
        return data[:LONGEST]

    def attempt(self, data: bytes) -> None:
        """Try one command line on these bytes."""
        self.file.write_bytes(data)
        self.runs += 1
        began, memory = time.process_time(), _most_memory()
        signal.setitimer(signal.ITIMER_VIRTUAL, SECONDS)
        try:
            self.refused += self.target.try_one(self.file) is None
        except (Exception, TooSlow) as error:  # noqa: BLE001  # anything is a finding
            self.keep(error, data)
        finally:
            signal.setitimer(signal.ITIMER_VIRTUAL, 0)
            self.seconds += time.process_time() - began
        if _most_memory() > memory + BYTES:
            self.keep(MemoryError(f"{(_most_memory() - memory) / 2**20:.0f} MB more"), data)

    def keep(self, error: BaseException, data: bytes) -> None:
        """Write down a finding whose place was not seen before."""
        frames = [frame for frame in traceback.extract_tb(error.__traceback__) if "fuzz" not in frame.filename]
        own = [frame for frame in frames if "coast_cli" in frame.filename][-1:]
        place = (type(error).__name__, *(f"{Path(frame.filename).name}:{frame.lineno}" for frame in own))
        if isinstance(error, targets.Finding):
            place += (str(error)[:30],)
        if place in self.seen:
            return
        self.seen.add(place)
        self.out.mkdir(parents=True, exist_ok=True)
        stem = f"{self.name}-{len(self.seen):03d}"
        (self.out / f"{stem}{self.target.suffix}").write_bytes(data)
        text = f"{' '.join(self.target.command(data))}\n{''.join(traceback.format_exception(error))}"
        (self.out / f"{stem}.txt").write_text(text, encoding="utf-8", errors="replace")
        sys.stderr.write(f"FOUND {stem}: {place}: {str(error)[:200]!r}\n")

    def row(self) -> str:
        """Return how far it is."""
        minutes = self.seconds / 60.0
        return f"{self.name:12} {self.runs:8} {self.refused:8} {minutes:12.2f} {len(self.seen):8}\n"


def limit() -> None:
    """Let a run that takes too long, or all memory, be an error."""
    warnings.simplefilter("ignore")
    resource.setrlimit(resource.RLIMIT_AS, (8 * BYTES, 8 * BYTES))
    signal.signal(signal.SIGVTALRM, _too_slow)
    signal.signal(signal.SIGTERM, signal.default_int_handler)


def _too_slow(*_: object) -> None:
    raise TooSlow


def _most_memory() -> int:
    return resource.getrusage(resource.RUSAGE_SELF).ru_maxrss * 1024


def main() -> int:
    """Try all targets, or those that are named, for a time; return 1 where something was found."""
    parser = argparse.ArgumentParser(description=__doc__.partition("\n")[0])
    parser.add_argument("targets", nargs="*", choices=[[], *TARGETS], metavar="TARGET", help=", ".join(TARGETS))
    parser.add_argument("--minutes", type=float, default=30.0, help="processor time")
    parser.add_argument("--seed", type=int, default=0)
    parser.add_argument("--out", type=Path, default=Path("findings"))
    options = parser.parse_args()
    limit()
    out, chance = options.out.resolve(), random.Random(options.seed)
    hunts = [Hunt(name, out) for name in options.targets or TARGETS]
    os.chdir(tempfile.mkdtemp())  # where a command leaves what it keeps
    try:
        while sum(hunt.seconds for hunt in hunts) < 60.0 * options.minutes:
            hunt = min(hunts, key=lambda hunt: hunt.seconds)
            hunt.attempt(hunt.mutate(chance))
    except KeyboardInterrupt:
        pass  # the table tells how far it came
    sys.stdout.write(f"{'target':12} {'runs':>8} {'refused':>8} {'CPU-minutes':>12} {'findings':>8}\n")
    sys.stdout.writelines(hunt.row() for hunt in hunts)
    total = [sum(getattr(hunt, name) for hunt in hunts) for name in ("runs", "refused", "seconds")]
    found = sum(len(hunt.seen) for hunt in hunts)
    sys.stdout.write(f"{'all':12} {total[0]:8} {total[1]:8} {total[2] / 60.0:12.2f} {found:8}\n")
    return int(bool(found))


if __name__ == "__main__":
    sys.exit(main())
