"""What befalls a command from outside: interrupts, readers that leave, disks that fill, and two of it at once."""

import ast
import json
import os
import subprocess
import sys
import time
from pathlib import Path

import pytest

import coast_cli
from tests.from_a_shell import popen

ROOT = Path(__file__).parents[2]
RECORDING = ROOT / "examples" / "diagnose" / "recording.csv"
EXPLORED = ROOT / "examples" / "explore.toml"
# Ctrl-C after a tenth of a second of work, however busy the machine is: the clock is the process's own.
INTERRUPTED = """
import os, signal, sys
import coast_cli.diagnosis.joint, coast_cli.design.tolerance, coast_cli.design.exploration
from coast_cli.__main__ import main
signal.signal(signal.SIGVTALRM, lambda *_: os.kill(os.getpid(), signal.SIGINT))
signal.setitimer(signal.ITIMER_VIRTUAL, float(sys.argv[1]))
sys.exit(main(sys.argv[2:]))
"""


def program(*words, **options):
    command = [sys.executable, *map(str, words)]
    path = os.pathsep.join([str(ROOT), *filter(None, [os.environ.get("PYTHONPATH")])])
    environment = {**os.environ, "PYTHONPATH": path}
    return popen(command, env=environment, stderr=subprocess.PIPE, **options)


@pytest.mark.parametrize(
    "words",
    [
        (
            "diagnose",
            "{config}",
            RECORDING,
            "-o",
            "{out}/a.json",
            "--save-model",
            "{out}/a.toml",
            "--report",
            "{out}/a.html",
        ),
        ("tolerance", "{config}", "--samples", "2000000", "-o", "{out}/a.json"),
        ("explore", "{explored}", "-o", "{out}/a.json"),
    ],
    ids=lambda words: words[0],
)
def test_an_interrupt_is_said_and_leaves_no_half_file(tmp_path, reference, words):
    out = tmp_path / "out"
    out.mkdir()
    filled = [str(word).format(config=reference, out=out, explored=EXPLORED) for word in words]
    ran = program("-c", INTERRUPTED, "0.1", *filled, stdout=subprocess.PIPE, cwd=tmp_path)
    stdout, stderr = ran.communicate()
    assert (ran.returncode, stdout) == (130, "")
    assert stderr.endswith("coast: interrupted.\n")
    assert all(line.startswith("coast: interrupted") for line in stderr.splitlines())
    assert list(out.iterdir()) == []


@pytest.mark.parametrize(
    "words",
    [
        ("rank-pairs", "{config}"),
        ("rank-pairs", "{config}", "-f", "json"),
        ("init", "-"),
        ("schema",),
        ("--help",),
        ("stroke", "--help"),
        ("--version",),
    ],
)
def test_a_full_disk_behind_stdout_is_said_in_a_sentence(reference, words):
    filled = [word.format(config=reference) for word in words]
    with Path("/dev/full").open("w") as full:
        ran = program("-m", "coast_cli", *filled, stdout=full)
        stderr = ran.communicate()[1]
    assert ran.returncode == 2
    assert stderr.splitlines()[-1] == "coast: stdout cannot be written (No space left on device)."


@pytest.mark.parametrize(("words", "code"), [(("rank-pairs", "{config}"), 0), (("rank-pairs", "nowhere.toml"), 3)])
def test_words_that_cannot_be_written_change_no_exit_code(reference, words, code):
    filled = [word.format(config=reference) for word in words]
    path = os.pathsep.join([str(ROOT), *filter(None, [os.environ.get("PYTHONPATH")])])
    with Path("/dev/full").open("w") as full:
        command = [sys.executable, "-m", "coast_cli", *filled]
        environment = {**os.environ, "PYTHONPATH": path}
        ran = subprocess.run(command, env=environment, stdout=subprocess.PIPE, stderr=full, check=False)
    assert ran.returncode == code
    assert bool(ran.stdout) == (code == 0)


def test_help_to_a_reader_that_left_is_no_error():
    ran = program("-m", "coast_cli", "--help", stdout=subprocess.PIPE)
    ran.stdout.close()
    assert ran.stderr.read() == ""
    assert ran.wait() == 0
    ran.stderr.close()


def test_closed_streams_are_no_fault(reference):
    for stream in (1, 2):
        command = [
            sys.executable,
            "-c",
            "import os,sys; os.close(int(sys.argv[1])); os.execv(sys.executable, sys.argv[2:])",
        ]
        words = [str(stream), sys.executable, "-m", "coast_cli", "rank-pairs", str(reference)]
        assert subprocess.run([*command, *words], cwd=ROOT, capture_output=True, check=False).returncode == 0


def test_a_folder_that_may_not_be_written_is_named(coast, reference, tmp_path):
    folder = tmp_path / "locked"
    folder.mkdir()
    folder.chmod(0o500)
    if os.access(folder, os.W_OK):  # the superuser may write everywhere but here
        folder = Path("/sys")
    ran = coast("rank-pairs", reference, "-o", folder / "ranking.json")
    assert (ran.code, ran.out) == (2, "")
    assert str(folder / "ranking.json") in ran.err
    assert ran.err.count("\n") == 1


def test_of_two_that_write_one_file_it_is_one_whole_answer(tmp_path, reference):
    path = tmp_path / "answer.json"
    lengths = ("5", "10,20", "5,10,15,20,25,30")
    running = [
        program(
            "-m",
            "coast_cli",
            "stroke",
            reference,
            "--kappa",
            "0:60:0.1",
            "--x2",
            x2,
            "-o",
            path,
            stdout=subprocess.DEVNULL,
        )
        for x2 in lengths
    ]
    while any(ran.poll() is None for ran in running):
        if path.exists():
            assert len(json.loads(path.read_text(encoding="utf-8"))["rows"]) in {601, 1202, 3606}
        time.sleep(0.01)
    assert [ran.wait() for ran in running] == [0, 0, 0]
    assert len(json.loads(path.read_text(encoding="utf-8"))["rows"]) in {601, 1202, 3606}
    assert [item.name for item in tmp_path.iterdir()] == ["answer.json"]
    for ran in running:
        ran.stderr.close()


def test_a_stream_that_another_run_writes_is_left_to_it(coast, tmp_path):
    from coast_cli.output.stream import CsvStream

    stream = CsvStream(tmp_path / "pairs.csv", "one", overwrite=False)
    ran = coast("explore", EXPLORED, "--all", tmp_path / "pairs.csv")
    assert ran.code == 2
    assert "another run is writing this file" in ran.err
    stream.close()


def nodes():
    for path in sorted(Path(coast_cli.__file__).parent.rglob("*.py")):
        for node in ast.walk(ast.parse(path.read_text(encoding="utf-8"))):
            yield path.name, node


def test_nothing_is_unpickled_evaluated_or_fetched():
    barred = {
        "pickle",
        "marshal",
        "shelve",
        "dill",
        "cloudpickle",
        "joblib",
        "yaml",
        "socket",
        "http",
        "urllib",
        "requests",
        "ftplib",
        "smtplib",
        "ssl",
        "asyncio",
        "webbrowser",
        "ctypes",
        "code",
        "codeop",
        "runpy",
    }
    called = {
        "eval",
        "exec",
        "exec_module",
        "compile",
        "__import__",
        "system",
        "popen",
        "fromregex",
        "loadtxt",
        "genfromtxt",
        "memmap",
    }
    found = []
    for file, node in nodes():
        if isinstance(node, ast.Import):
            found += [(file, alias.name) for alias in node.names if alias.name.partition(".")[0] in barred]
        elif isinstance(node, ast.ImportFrom):
            found += [(file, node.module)] if (node.module or "").partition(".")[0] in barred else []
        elif isinstance(node, ast.Call):
            name = getattr(node.func, "id", getattr(node.func, "attr", ""))
            owner = getattr(getattr(node.func, "value", None), "id", "")
            options = {keyword.arg: keyword.value for keyword in node.keywords}
            pickled = (
                owner in {"np", "numpy"} and name == "load" and getattr(options.get("allow_pickle"), "value", True)
            )
            shell = getattr(options.get("shell"), "value", False)
            if (name in called and owner != "re") or pickled or shell:
                found.append((file, ast.unparse(node)[:80]))
    assert found == [("own.py", "spec.loader.exec_module(module)")]  # the file that --effects names, which is said
