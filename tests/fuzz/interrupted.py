"""Kill and resume: commands are ended at a random moment and run again, until their files are those of an undisturbed run.

    PYTHONPATH=. python tests/fuzz/interrupted.py --trials 50

In turn ``explore`` with and without ``--all``, ``explore`` on a dask cluster whose scheduler or worker dies, ``tolerance``,
``report`` and ``diagnose -o``; by SIGTERM, SIGINT, SIGHUP or SIGKILL. A trial fails where a file is there in half, where
anything but sentences is said, or where the files of the last, undisturbed run differ by a byte from those of the first.
"""

import argparse
import json
import os
import random
import shutil
import signal
import subprocess
import sys
import tempfile
import time
from collections import Counter
from contextlib import contextmanager
from pathlib import Path

ROOT = Path(__file__).parents[2]
RECORDING = ROOT / "examples" / "diagnose" / "recording.csv"
SPACE = """
[explore]
tubes = 160
refinements = 0
[explore.outer]
depth_mm = { min = 0.314, max = 0.400 }
[explore.middle]
depth_mm = { min = 0.243, max = 0.287 }
"""
COMMANDS = {
    "explore --all": ("explore", "space.toml", "--all", "pairs.csv", "-o", "front.json"),
    "explore": ("explore", "space.toml", "-o", "front.json"),
    "explore --cluster": ("explore", "space.toml", "--all", "pairs.csv", "-o", "front.json", "--cluster", "{address}"),
    "explore --jobs": ("explore", "space.toml", "--all", "pairs.csv", "-o", "front.json", "--jobs", "2"),
    "tolerance": ("tolerance", "tubes.toml", "--samples", "8192", "-o", "answer.json"),
    "tolerance --jobs": ("tolerance", "tubes.toml", "--samples", "8192", "-o", "answer.json", "--jobs", "2"),
    "report": ("report", "tubes.toml", "rec.csv", "-o", "page.html", "--samples", "50"),
    "diagnose -o": (
        "diagnose",
        "tubes.toml",
        "rec.csv",
        "-o",
        "answer.json",
        "--save-model",
        "model.toml",
        "--max-effects",
        "1",
    ),
}
SIGNALS = ("SIGTERM", "SIGTERM", "SIGINT", "SIGHUP", "SIGKILL")
MOST_KILLS = 3
INPUTS = {"space.toml", "tubes.toml", "rec.csv"}


def environment() -> dict[str, str]:
    """Return what a command needs to find the package."""
    path = os.pathsep.join([str(ROOT), *filter(None, [os.environ.get("PYTHONPATH")])])
    return {**os.environ, "PYTHONPATH": path, "OPENBLAS_NUM_THREADS": "1"}


def prepared(folder: Path) -> Path:
    """Return a folder with the inputs."""
    folder.mkdir(parents=True)
    text = (ROOT / "configs" / "tubes.toml").read_text(encoding="utf-8")
    (folder / "tubes.toml").write_text(text, encoding="utf-8")
    (folder / "space.toml").write_text(text + SPACE, encoding="utf-8")
    shutil.copy(RECORDING, folder / "rec.csv")
    return folder


def start(folder: Path, words: tuple[str, ...], address: str = "") -> subprocess.Popen[str]:
    """Start a command as a shell in the foreground does."""
    from tests.from_a_shell import popen

    command = [sys.executable, "-m", "coast_cli", *(word.format(address=address) for word in words)]
    pipes = {"stdout": subprocess.PIPE, "stderr": subprocess.PIPE}
    return popen(command, prepare=_listens, cwd=folder, env=environment(), **pipes)


def _listens() -> None:
    signal.signal(signal.SIGHUP, signal.SIG_DFL)


@contextmanager
def cluster():
    """Yield the address, scheduler and worker of a dask cluster of this machine."""
    with tempfile.TemporaryDirectory() as place:
        note, quiet = Path(place) / "scheduler.json", {"stdout": subprocess.DEVNULL, "stderr": subprocess.DEVNULL}

        def run(*words: str) -> subprocess.Popen[bytes]:
            command = [sys.executable, "-m", f"distributed.cli.{words[0]}", *words[1:], "--scheduler-file", str(note)]
            return subprocess.Popen([*command, "--no-dashboard"], env=environment(), cwd=place, **quiet)

        running = [run("dask_scheduler", "--host", "127.0.0.1", "--port", "0")]
        running.append(
            run("dask_worker", "--nthreads", "1", "--no-nanny", "--local-directory", str(Path(place) / "dask"))
        )
        try:
            while not (note.exists() and note.read_text(encoding="utf-8").endswith("}")):
                time.sleep(0.05)
            yield json.loads(note.read_text(encoding="utf-8"))["address"], *running
        finally:
            for process in running[::-1]:
                process.kill()
                process.wait()


def files(folder: Path) -> dict[str, bytes]:
    """Return what a command wrote."""
    return {path.name: path.read_bytes() for path in folder.iterdir() if path.is_file() and path.name not in INPUTS}


def check_left(folder: Path, code: int, said: str) -> None:
    """Fail where something but sentences is said, or a file is there in half."""
    if any(not line.startswith("coast: ") for line in said.splitlines()):
        raise AssertionError(f"no sentence, exit code {code}: {said}")
    names = {path.name for path in folder.iterdir()} - INPUTS
    strays = [name for name in names if name.startswith(".coast-")]
    if strays:
        raise AssertionError(f"left behind: {strays}")


def trial(name: str, seconds: float, whole: dict[str, bytes], chance: random.Random) -> tuple[int, list[str]]:
    """End a command some times, then let it run; return how often it was ended, and how."""
    with tempfile.TemporaryDirectory() as place:
        folder, ways = prepared(Path(place) / "work"), []
        for _ in range(chance.randint(1, MOST_KILLS)):
            if name == "explore --cluster":
                ways.append(_on_a_cluster(folder, seconds, chance))
            else:
                ways.append(_ended(start(folder, COMMANDS[name]), folder, seconds, chance))
            if not ways[-1]:  # it was faster
                break
        if not set(whole) <= set(files(folder)):
            finished = start(folder, tuple(word for word in COMMANDS[name] if word not in {"--cluster", "{address}"}))
            _, said = finished.communicate()
            if finished.returncode:
                raise AssertionError(f"exit code {finished.returncode}: {said}")
        if files(folder) != whole:
            raise AssertionError(f"other bytes: {sorted(files(folder))}")
        left = [path.name for path in folder.iterdir() if path.name.endswith(".part")]
        if left:
            raise AssertionError(f"left behind: {left}")
        return len([way for way in ways if way]), ways


def _ended(running: subprocess.Popen[str], folder: Path, seconds: float, chance: random.Random) -> str:
    way = chance.choice(SIGNALS)
    time.sleep(0.1 + 0.9 * chance.random() * seconds)
    if running.poll() is None:
        running.send_signal(getattr(signal, way))
    _, said = running.communicate()
    if running.returncode == 0:
        return ""
    if way != "SIGKILL":  # what Python's own helpers say then is not ours
        check_left(folder, running.returncode, said)
    return way


def _on_a_cluster(folder: Path, seconds: float, chance: random.Random) -> str:
    with cluster() as (address, scheduler, _):
        running = start(folder, COMMANDS["explore --cluster"], address)
        time.sleep(2.0 + chance.random() * seconds)
        if chance.random() < 0.7:
            scheduler.kill()
            _, said = running.communicate()
            check_left(folder, running.returncode, said)
            return "scheduler" if running.returncode else ""
        return _ended(running, folder, 0.5, chance)


def main() -> None:
    """Run the trials and print what befell."""
    parser = argparse.ArgumentParser(description=__doc__.partition("\n")[0])
    parser.add_argument("--trials", type=int, default=50)
    parser.add_argument("--seed", type=int, default=0)
    options = parser.parse_args()
    chance, known, ended, failed = random.Random(options.seed), {}, Counter(), 0
    names = [name for name in COMMANDS for _ in range(1 + (name == "explore --cluster"))]
    for number in range(options.trials):
        name = names[number % len(names)]
        if name not in known:
            with tempfile.TemporaryDirectory() as place:
                folder, began = prepared(Path(place) / "work"), time.monotonic()
                words = tuple(word for word in COMMANDS[name] if word not in {"--cluster", "{address}"})
                start(folder, words).communicate()
                known[name] = time.monotonic() - began, files(folder)
        try:
            count, ways = trial(name, *known[name], chance)
            ended.update(filter(None, ways))
            sys.stdout.write(
                f"{number + 1:3} {name:20} ended {count} times: {', '.join(filter(None, ways)) or 'never'}\n"
            )
        except AssertionError as error:
            failed += 1
            sys.stdout.write(f"{number + 1:3} {name:20} FAILED: {error}\n")
        sys.stdout.flush()
    shown = ", ".join(f"{count} by {way}" for way, count in ended.most_common())
    sys.stdout.write(f"{options.trials} trials, {ended.total()} ends ({shown}), {failed} failed\n")
    sys.exit(bool(failed))


if __name__ == "__main__":
    main()
