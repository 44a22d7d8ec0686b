"""``coast explore --all`` that waits after its first block: what befalls it then comes at the same moment on any machine."""

import os
import subprocess
import sys
import time
from contextlib import contextmanager
from pathlib import Path

from tests.from_a_shell import popen

ROOT = Path(__file__).parents[1]
_SCRIPT = """
import sys, time
from pathlib import Path
from coast_cli.__main__ import main
from coast_cli.design import work
from coast_cli.output.stream import CsvStream
reached, go = Path(sys.argv.pop(1)), Path(sys.argv.pop(1))
write, work._CONNECT_SECONDS = CsvStream.write, 600  # the workers of a busy machine come late
def waits(stream, *block):
    write(stream, *block)
    if stream.blocks == 1:
        reached.touch()
        while not go.exists():
            time.sleep(0.01)
CsvStream.write = waits
sys.exit(main())
"""


@contextmanager
def held(folder, *words):
    """Yield the process once its first block is written; after the ``with`` it goes on.

    Args:
        folder: where two marks are put. words: the command line.
    """
    reached, go = folder / "reached", folder / "go"
    path = os.pathsep.join([str(ROOT), *filter(None, [os.environ.get("PYTHONPATH")])])
    command = [sys.executable, "-c", _SCRIPT, str(reached), str(go), *map(str, words)]
    pipes = {"stdout": subprocess.PIPE, "stderr": subprocess.PIPE}
    running = popen(command, env={**os.environ, "PYTHONPATH": path}, **pipes)
    while not reached.exists():
        assert running.poll() is None, running.communicate()
        time.sleep(0.02)
    yield running
    go.touch()
