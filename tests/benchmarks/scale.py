"""What size costs: seconds and bytes against tubes, notches, pairs and samples, ``python tests/benchmarks/scale.py [--large]``.

Processor times of this process and its children, each size in a fresh process, so that memory is its own. ``--large`` adds
ten million and a hundred million pairs and a million samples. Nothing is asserted.
"""

import resource
import subprocess
import sys
import time
from importlib.util import find_spec
from pathlib import Path
from tempfile import TemporaryDirectory

import numpy as np

ROOT = Path(__file__).parents[2]
SPACE = """
[explore]
tubes = {tubes}
refinements = 2
[explore.outer]
depth_mm = {{ min = 0.314, max = 0.400 }}
[explore.middle]
depth_mm = {{ min = 0.243, max = 0.287 }}
"""


def command(*words) -> tuple[float, float]:
    """Processor time (s) and most memory (MB) of a command in a process of its own."""
    probe = (
        "import resource, subprocess, sys; done = subprocess.run(sys.argv[1:], capture_output=True, text=True);"
        "used = resource.getrusage(resource.RUSAGE_CHILDREN);"
        "sys.stderr.write(done.stderr if done.returncode else '');"
        "print(used.ru_utime + used.ru_stime, used.ru_maxrss / 1024.0)"
    )
    words = [sys.executable, "-c", probe, sys.executable, *map(str, words)]
    seconds, megabytes = subprocess.run(words, check=True, capture_output=True, text=True, cwd=ROOT).stdout.split()
    return float(seconds), float(megabytes)


def line(name: str, sizes, costs) -> None:
    """Print what each size takes, and the slope of the straight line through them."""
    seconds, memory = np.array([cost[0] for cost in costs]), [cost[1] for cost in costs]
    slope = np.polyfit(sizes, seconds, 1, w=1.0 / seconds)[0]
    power = np.polyfit(np.log(sizes), np.log(seconds), 1)[0]
    shown = ", ".join(f"{size:.3g}: {s:.2f} s {m:.0f} MB" for size, s, m in zip(sizes, seconds, memory, strict=True))
    print(f"{name:32} {1e6 * slope:8.2f} us each, power {power:.2f} ({shown})", flush=True)


def explored(tubes: int, folder: Path) -> tuple[float, float]:
    path = folder / f"{tubes}.toml"
    path.write_text((ROOT / "configs" / "tubes.toml").read_text(encoding="utf-8") + SPACE.format(tubes=tubes))
    return command("-m", "coast_cli", "explore", path, "--top", 1, "-o", folder / f"{tubes}.json")


def beams(count: int, notches: int) -> tuple[float, float]:
    from coast_cli.mechanics.beam import solve_segments
    from tests.benchmarks.beams import GRAVITY, tubes

    columns = tubes(count, notches=notches)
    start = time.process_time()
    solve_segments(columns[0] * 188 / notches, *columns[1:], gravity=(0.0, -GRAVITY))
    return time.process_time() - start, resource.getrusage(resource.RUSAGE_SELF).ru_maxrss / 1024.0


def main() -> None:
    large = "--large" in sys.argv
    counts, notches = (500, 1000, 2000, 4000), (50, 100, 200, 400)
    line("tubes of 188 notches", counts, [beams(count, 188) for count in counts])
    line("notches of 1,000 tubes", notches, [beams(1000, many) for many in notches])
    with TemporaryDirectory() as folder:
        sides = (316, 1000, 3162, 10_000) if large else (316, 1000)
        line("pairs explored", np.square(sides), [explored(side, Path(folder)) for side in sides])
    samples = (20_000, 45_000)
    line("samples, numpy", samples, [tolerated(count) for count in samples])
    if large and find_spec("numba"):
        samples = (100_000, 1_000_000)
        line("samples, [fast]", samples, [tolerated(count) for count in samples])


def tolerated(samples: int) -> tuple[float, float]:
    return command("-m", "coast_cli", "tolerance", "configs/tubes.toml", "--samples", samples, "--only", "check")


if __name__ == "__main__":
    sys.path.insert(0, str(ROOT))
    main()
