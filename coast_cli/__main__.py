"""The program's entry, and the one place where an error becomes text on stderr and an exit code.

0 fine, 1 checked and the answer is no, 2 usage, 3 bad input, 4 not converged (or a fault of the program itself), 128 and
its number where a signal ended it: 130 interrupted. Everything else is imported once signals are looked after.
"""

from __future__ import annotations

import sys

TYPE_CHECKING = False
if TYPE_CHECKING:
    from collections.abc import Sequence

INTERNAL = 4
_HELP = "Try `coast --help`, or --help after a command"


def main(arguments: Sequence[str] | None = None) -> int:
    """Run one command line and return its exit code; ``arguments`` stand for ``sys.argv[1:]``."""
    try:
        from coast_cli.signals import stoppable

        with stoppable():
            code = _run(arguments)
    except KeyboardInterrupt:
        code = _interrupted()
        if (
            arguments is None and "multiprocessing.util" not in sys.modules
        ):  # which gives back its semaphores at the end
            import os

            os._exit(code)  # Python itself would end by SIGINT where the signal came in a text that it executed
    if arguments is None:
        from coast_cli.signals import ignore

        ignore()
    return code


def _run(arguments: Sequence[str] | None) -> int:
    import gc
    import os
    import warnings

    from coast_cli.errors import printable
    from coast_cli.output.standard_streams import prepare, to_stderr

    prepare()
    # Imports make many objects that live to the end; looking for garbage among them is a twentieth of the start.
    gc.set_threshold(50_000, 20, 20)
    # Matrices here are small: threads of the linear algebra cost more than they give, five times on a busy machine.
    os.environ.setdefault("OPENBLAS_NUM_THREADS", "1")
    if arguments is None:
        if not sys.warnoptions:
            # An overflow is refused by its result, in a sentence; numpy's own words would stand before it.
            warnings.simplefilter("ignore", RuntimeWarning)
        arguments = sys.argv[1:]
    try:
        from coast_cli.cli.app import run

        return run(list(arguments))
    except Exception as error:  # noqa: BLE001  # the one place that catches everything
        text, code = _explain(error)
        to_stderr(f"coast: {printable(text)}")
        return code


def _interrupted() -> int:
    from coast_cli.output.standard_streams import to_stderr
    from coast_cli.signals import exit_code, stopped_by

    to_stderr(f"coast: {stopped_by()}.")
    return exit_code()


def _explain(error: Exception) -> tuple[str, int]:
    from coast_cli.cli.app import refusal
    from coast_cli.errors import CoastError, UsageError

    if isinstance(error, CoastError):
        return str(error), error.exit_code
    if isinstance(error, refusal()):
        text = error.format_message()  # type: ignore[attr-defined]
        advice = "`coast init` writes one to start from" if "'CONFIG" in text else _HELP
        return f"{text.rstrip('.')}. {advice}.", UsageError.exit_code
    if isinstance(error, MemoryError):
        return "there is not enough memory for this; ask for less at once.", INTERNAL
    kind, place = type(error).__name__, _last_line(error)
    return f"internal error, please report it: {kind} at {place}: {error}", INTERNAL


def _last_line(error: Exception) -> str:
    """Return the module and line that raised, which a report needs and a traceback would bury."""
    from pathlib import Path
    from traceback import extract_tb

    frames = [frame for frame in extract_tb(error.__traceback__) if "coast_cli" in frame.filename]
    return f"{Path(frames[-1].filename).name}:{frames[-1].lineno}" if frames else "unknown place"


if __name__ == "__main__":
    sys.exit(main())
