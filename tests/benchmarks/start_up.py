"""Start-up as ratios to a bare interpreter, all timed in turn in one run: ``python tests/benchmarks/start_up.py``."""

import subprocess
import sys
import time
from pathlib import Path

CONFIG = Path(__file__).parents[2] / "configs" / "tubes.toml"
ROUNDS = 25
CASES = {
    "python -c pass": ("-c", "pass"),
    "coast --help": ("-m", "coast_cli", "--help"),
    "coast rank-pairs configs/tubes.toml": ("-m", "coast_cli", "rank-pairs", str(CONFIG)),
    "coast stroke --kappa 20 --x2 30": ("-m", "coast_cli", "stroke", str(CONFIG), "--kappa", "20", "--x2", "30"),
}


def seconds(words):
    start = time.perf_counter()
    subprocess.run([sys.executable, *words], check=True, capture_output=True)
    return time.perf_counter() - start


def main():
    best = dict.fromkeys(CASES, float("inf"))
    for _ in range(ROUNDS):
        for name, words in CASES.items():
            best[name] = min(best[name], seconds(words))
    bare = best["python -c pass"]
    print(f"best of {ROUNDS}, times a bare interpreter ({1e3 * bare:.1f} ms)")
    for name, fastest in best.items():
        print(f"{name:40} {fastest / bare:6.1f}")


if __name__ == "__main__":
    main()
