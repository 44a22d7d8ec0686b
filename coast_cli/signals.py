"""SIGINT, SIGTERM and SIGHUP end a command alike: once, as KeyboardInterrupt, so that it can keep what is done.

While something must not be cut in two, ``held`` puts them off. A third signal ends the process at once.
"""

from __future__ import annotations

import os
import signal
import sys
from collections.abc import Iterator
from contextlib import contextmanager
from typing import Any

_NAMES = ("SIGINT", "SIGTERM", "SIGHUP")
_AGAIN_SECONDS = 0.01


class _Stop:
    """What has arrived, and whether it is put off.

    Attributes:
        first: the first signal; 0 before. count: how many came. holds: how many blocks put them off now.
        due: whether the interrupt is still to be raised.
    """

    first = count = holds = 0
    due = False


_stop = _Stop()


@contextmanager
def stoppable() -> Iterator[None]:
    """Let the signals end what runs inside; those that were ignored from the start (nohup, a shell's background) stay so."""
    vars(_stop).clear()
    before, unraisable = {}, sys.unraisablehook
    try:
        for number in _numbers():
            if signal.getsignal(number) is not signal.SIG_IGN:
                before[number] = signal.signal(number, _arrived)
        sys.unraisablehook = lambda args: _raise_again() if args.exc_type is KeyboardInterrupt else unraisable(args)
        yield
    finally:
        sys.unraisablehook = unraisable
        for number, handler in before.items():
            signal.signal(number, handler)


@contextmanager
def held() -> Iterator[None]:
    """Put the signals off until the block ends."""
    _stop.holds += 1
    try:
        yield
    finally:
        _stop.holds -= 1
        _raise_due()


def ignore() -> None:
    """Let the signals do nothing any more: what is left of the process is its end."""
    for number in _numbers():
        signal.signal(number, signal.SIG_IGN)


def exit_code() -> int:
    """Return the code of a process that a signal ended, 128 and its number."""
    return 128 + (_stop.first or signal.SIGINT)


def stopped_by() -> str:
    """Return in words what ended the process."""
    return "interrupted" if _stop.first in {0, signal.SIGINT} else f"ended by {signal.Signals(_stop.first).name}"


def leave_to_the_parent() -> None:
    """Let a worker process be ended by its parent alone, which the terminal's signals reach as well."""
    signal.signal(signal.SIGINT, signal.SIG_IGN)
    signal.signal(signal.SIGTERM, signal.SIG_DFL)
    if hasattr(signal, "SIGHUP"):
        signal.signal(signal.SIGHUP, signal.SIG_IGN)
        signal.pthread_sigmask(signal.SIG_UNBLOCK, _numbers())


@contextmanager
def not_inherited() -> Iterator[None]:
    """Start processes that no signal reaches before they call ``leave_to_the_parent``."""
    if not hasattr(signal, "pthread_sigmask"):
        yield
        return
    before = signal.pthread_sigmask(signal.SIG_BLOCK, _numbers())
    try:
        yield
    finally:
        signal.pthread_sigmask(signal.SIG_SETMASK, before)


def _numbers() -> set[signal.Signals]:
    return {getattr(signal, name) for name in _NAMES if hasattr(signal, name)}


def _arrived(number: int, _frame: Any) -> None:  # noqa: ANN401
    _stop.count += 1
    if _stop.count == 1:
        _stop.first, _stop.due = number, True
    if _stop.count >= 3:
        os._exit(exit_code())
    _raise_due()


def _raise_due() -> None:
    if _stop.due and not _stop.holds:
        _stop.due = False
        raise KeyboardInterrupt


def _raise_again() -> None:
    """Raise an interrupt once more that came where Python cannot raise: in a destructor, or in a callback of an import."""
    _stop.due = True
    if not hasattr(signal, "setitimer"):
        os._exit(exit_code())
    signal.signal(signal.SIGALRM, lambda *_: _raise_due())
    signal.setitimer(signal.ITIMER_REAL, _AGAIN_SECONDS)
