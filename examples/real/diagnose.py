"""Diagnose the real recordings of other devices, where they lie beside this checkout.

`python examples/real/diagnose.py --out FOLDER` runs the whole of `coast diagnose` on the notched wrists (trained on some
trials, judged on the others) and on the tendon-sheath manipulator (trained on the first cycle, judged on what follows),
prints each page and writes it, its JSON, its model and its picture. Both sets were made by others and carry no licence,
so nothing of them is in this repository: without `../shared/recordings` the script says "not here" and stops.
"""

from __future__ import annotations

import argparse
import subprocess
import sys
from pathlib import Path

RECORDINGS = Path(__file__).parents[2].parent / "shared" / "recordings"
CASES = {
    "wrist_A": ("notched_wrist", ["wrist_A.csv"], ["A3"]),
    "wrist_C": ("notched_wrist", ["wrist_C.csv"], ["C4", "C5"]),
    "sheath_000": ("tendon_sheath", ["sheath_000.csv"], []),
    "sheath_090": ("tendon_sheath", ["sheath_090.csv"], []),
    "sheath_180": ("tendon_sheath", ["sheath_180.csv"], []),
}


def diagnose(name: str, out: Path) -> int:
    """Run one diagnosis and return its exit code; the page goes to stdout and to files under ``out``."""
    folder, files, held_out = CASES[name]
    place = RECORDINGS / folder
    command = [sys.executable, "-m", "coast_cli", "diagnose", str(place / "tubes.toml")]
    command += [str(place / file) for file in files]
    command += [word for run in held_out for word in ("--hold-out", run)]
    command += ["--format", "table", "-o", str(out / f"{name}.txt"), "-o", str(out / f"{name}.json")]
    command += ["--save-model", str(out / f"{name}.toml"), "--plot", str(out / f"{name}.png")]
    print(f"== {name} ==", flush=True)
    return subprocess.run(command, check=False).returncode


def main() -> int:
    """Run every case that is there."""
    parser = argparse.ArgumentParser(description=__doc__.splitlines()[0])
    parser.add_argument("--out", type=Path, required=True, help="folder for pages, models and pictures")
    out = parser.parse_args().out
    if not RECORDINGS.is_dir():
        print("not here: the recordings of others lie in ../shared/recordings, which is absent")
        return 0
    out.mkdir(parents=True, exist_ok=True)
    return max(diagnose(name, out) for name in CASES)


if __name__ == "__main__":
    raise SystemExit(main())
