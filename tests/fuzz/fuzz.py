"""Coverage-guided fuzzing of one target, with atheris, which is no dependency of the project.

    python -m venv fuzzing && fuzzing/bin/pip install atheris -e '.[vision]'
    PYTHONPATH=. fuzzing/bin/python tests/fuzz/fuzz.py config --minutes 10 --out findings

The bytes are those that atheris and the target's own mutation make; what counts as a finding is said in ``hunt.py``.
"""

import argparse
import os
import pkgutil
import random
import sys
from importlib import import_module
from pathlib import Path

import atheris

with atheris.instrument_imports(include=["coast_cli", "tomllib"]):
    import tomllib  # noqa: F401

    import coast_cli

    for _module in pkgutil.walk_packages(coast_cli.__path__, "coast_cli."):
        if not _module.name.endswith(("__main__", "beam.compiled")):
            import_module(_module.name)

from tests.fuzz.hunt import LONGEST, TARGETS, Hunt, limit


class Fuzzer(Hunt):
    """One target, whose bytes atheris chooses."""

    def __init__(self, name: str, out: Path, minutes: float) -> None:
        super().__init__(name, out)
        self.cpu_limit = 60.0 * minutes

    def __call__(self, data: bytes) -> None:
        """Try one command line on these bytes."""
        if self.seconds > self.cpu_limit:
            sys.stderr.write(self.row())
            os._exit(0)
        self.attempt(data)
        if self.runs % 2000 == 0:
            sys.stderr.write(self.row())

    def next(self, data: bytes, limit: int, seed: int) -> bytes:
        """Half by structure, half by bytes; often from a whole seed again, since most of what is damaged is refused."""
        chance = random.Random(seed)
        if chance.random() < 0.4:
            return self.target.mutate(chance.choice(self.seeds), chance)[:limit]
        if chance.random() < 0.4:
            return self.target.mutate(data, chance)[:limit]
        return atheris.Mutate(data, limit)


def main() -> None:
    """Fuzz one target for a time."""
    parser = argparse.ArgumentParser(description=__doc__.partition("\n")[0])
    parser.add_argument("target", choices=TARGETS)
    parser.add_argument("--minutes", type=float, default=10.0, help="CPU time")
    parser.add_argument("--out", type=Path, default=Path("findings"))
    options = parser.parse_args()
    seeds = options.out / f"{options.target}-corpus"
    seeds.mkdir(parents=True, exist_ok=True)
    for number, data in enumerate(TARGETS[options.target].seeds()):
        (seeds / f"seed-{number:02d}").write_bytes(data)
    fuzzer = Fuzzer(options.target, options.out, options.minutes)
    arguments = [sys.argv[0], str(seeds), "-timeout=300", "-rss_limit_mb=0", f"-max_len={LONGEST}", "-len_control=0"]
    atheris.Setup(arguments, fuzzer, custom_mutator=fuzzer.next)
    limit()
    atheris.Fuzz()


if __name__ == "__main__":
    main()
