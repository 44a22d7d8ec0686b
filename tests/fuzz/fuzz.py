"""Coverage-guided fuzzing by hand, with atheris, which is no dependency of the project.

    python -m venv fuzzing && fuzzing/bin/pip install atheris -e '.[vision]'
    PYTHONPATH=. fuzzing/bin/python tests/fuzz/fuzz.py config --minutes 10 --out findings

A target of ``targets.py`` is given bytes that atheris and the target's own mutation make. Whatever is no refusal in one
sentence is written to the folder, once for each place that raised, with the command line that found it; so is a run of
more than 20 s or one that takes more than 1 GB. What is mended goes into ``cases/``, where ``test_cases.py`` replays it.
"""

import argparse
import os
import pkgutil
import random
import resource
import signal
import sys
import tempfile
import time
import traceback
from importlib import import_module
from pathlib import Path

import atheris

with atheris.instrument_imports(include=["coast_cli", "tomllib"]):
    import tomllib  # noqa: F401

    import coast_cli

    for _module in pkgutil.walk_packages(coast_cli.__path__, "coast_cli."):
        if not _module.name.endswith(("__main__", "beam.compiled")):
            import_module(_module.name)

from tests.fuzz.targets import TARGETS

SECONDS, BYTES = 20, 2**30


class TooSlow(BaseException):
    """A run took more than its time; not an Exception, so that nothing takes it for its own."""


class Fuzzer:
    """One target, and what was found in it."""

    def __init__(self, name: str, out: Path, minutes: float) -> None:
        self.name, self.target, self.out = name, TARGETS[name], out
        self.file = Path(tempfile.mkdtemp()) / f"fuzzed{self.target.suffix}"
        self.runs, self.refused, self.seen, self.seeds = 0, 0, set(), self.target.seeds()
        self.started, self.cpu_limit = time.process_time(), 60.0 * minutes
        self.memory = resource.getrusage(resource.RUSAGE_SELF).ru_maxrss * 1024

    def __call__(self, data: bytes) -> None:
        """Try one command line on these bytes."""
        if time.process_time() - self.started > self.cpu_limit:
            self.say()
            os._exit(0)
        self.file.write_bytes(data)
        command = self.target.command(data)
        self.runs += 1
        signal.setitimer(signal.ITIMER_VIRTUAL, SECONDS)
        try:
            self.refused += self.target.try_one(self.file) is None
        except (Exception, TooSlow) as error:  # noqa: BLE001  # anything is a finding
            self.keep(error, data, command)
        finally:
            signal.setitimer(signal.ITIMER_VIRTUAL, 0)
        most = resource.getrusage(resource.RUSAGE_SELF).ru_maxrss * 1024
        if most > self.memory + BYTES:
            self.keep(MemoryError(f"{(most - self.memory) / 2**20:.0f} MB more"), data, command)
        self.memory = max(most, self.memory)
        if self.runs % 2000 == 0:
            self.say()

    def keep(self, error: BaseException, data: bytes, command: tuple[str, ...]) -> None:
        """Write down a finding whose place was not seen before."""
        frames = [frame for frame in traceback.extract_tb(error.__traceback__) if "fuzz" not in frame.filename]
        own = [frame for frame in frames if "coast_cli" in frame.filename][-1:]
        place = (type(error).__name__, *(f"{Path(frame.filename).name}:{frame.lineno}" for frame in own))
        if type(error).__name__ == "Finding":
            place += (str(error)[:30],)
        if place in self.seen:
            return
        self.seen.add(place)
        stem = f"{self.name}-{len(self.seen):03d}"
        (self.out / f"{stem}{self.target.suffix}").write_bytes(data)
        text = "".join(traceback.format_exception(error))
        (self.out / f"{stem}.txt").write_text(f"{' '.join(command)}\n{text}", encoding="utf-8", errors="replace")
        sys.stderr.write(f"FOUND {stem}: {place}: {str(error)[:200]!r}\n")

    def say(self) -> None:
        """Tell how far it is."""
        cpu = time.process_time() - self.started
        sys.stderr.write(
            f"{self.name}: {self.runs} runs, {self.refused} refused, {cpu / 60:.1f} CPU-minutes, "
            f"{len(self.seen)} findings, {self.memory / 2**20:.0f} MB\n"
        )

    def mutate(self, data: bytes, limit: int, seed: int) -> bytes:
        """Half by structure, half by bytes; often from a whole seed again, since most of what is damaged is refused."""
        chance = random.Random(seed)
        if chance.random() < 0.4:
            return self.target.mutate(chance.choice(self.seeds), chance)[:limit]
        if chance.random() < 0.4:
            return self.target.mutate(data, chance)[:limit]
        return atheris.Mutate(data, limit)


def _too_slow(*_: object) -> None:
    raise TooSlow


def main() -> None:
    """Fuzz one target for a time."""
    parser = argparse.ArgumentParser(description=__doc__.partition("\n")[0])
    parser.add_argument("target", choices=TARGETS)
    parser.add_argument("--minutes", type=float, default=10.0, help="CPU time")
    parser.add_argument("--out", type=Path, default=Path("findings"))
    options = parser.parse_args()
    options.out.mkdir(parents=True, exist_ok=True)
    seeds = options.out / f"{options.target}-corpus"
    seeds.mkdir(exist_ok=True)
    for number, data in enumerate(TARGETS[options.target].seeds()):
        (seeds / f"seed-{number:02d}").write_bytes(data)
    resource.setrlimit(resource.RLIMIT_AS, (8 * BYTES, 8 * BYTES))
    fuzzer = Fuzzer(options.target, options.out, options.minutes)
    arguments = [sys.argv[0], str(seeds), "-timeout=300", "-rss_limit_mb=0", "-max_len=60000", "-len_control=0"]
    atheris.Setup(arguments, fuzzer, custom_mutator=fuzzer.mutate)
    signal.signal(signal.SIGVTALRM, _too_slow)
    atheris.Fuzz()


if __name__ == "__main__":
    main()
