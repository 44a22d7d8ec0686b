"""Start a command as a shell in the foreground does: one that runs in the background hands on interrupts ignored."""

import signal
import subprocess


def popen(command, *, prepare=None, **options):
    """Return a process that an interrupt reaches, however the tests themselves were started.

    Args:
        prepare: called in the process before the command, for instance to set limits.
    """

    def begin():
        signal.signal(signal.SIGINT, signal.default_int_handler)
        if prepare is not None:
            prepare()

    return subprocess.Popen(command, preexec_fn=begin, text=True, **options)  # noqa: PLW1509 -- one thread, no locks
