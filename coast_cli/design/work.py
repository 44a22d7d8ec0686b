"""Blocks of work done in order: in this process, on several, or on a dask cluster; the answer is the same bytes.

The engines are the standard library's process pool and dask.distributed, both behind ``concurrent.futures.Executor``. Dask
repeats what a lost worker was doing.
"""

from __future__ import annotations

from collections import deque
from collections.abc import Callable, Iterable, Iterator
from concurrent.futures import CancelledError, Executor, Future
from contextlib import contextmanager
from typing import Any, TypeVar

from coast_cli.errors import CoastError, NotConverged, UsageError
from coast_cli.signals import leave_to_the_parent, not_inherited

Task = TypeVar("Task")
Result = TypeVar("Result")
_AHEAD = 4  # blocks a worker may be ahead of what is written, which bounds the memory
_CONNECT_SECONDS = 10
_LOOK_SECONDS = 5  # after which a scheduler that is gone is noticed


class WorkerLost(NotConverged):
    """A worker process is gone before its block was done."""


@contextmanager
def workers(jobs: int, cluster: str | None) -> Iterator[tuple[Executor | None, int]]:
    """Yield an executor and how many blocks it may hold; None is this process.

    Raises:
        UsageError: the cluster does not answer, or dask.distributed is not installed.
    """
    if cluster is not None:
        with _dask(cluster) as found:
            yield found
    elif jobs > 1:
        from concurrent.futures import ProcessPoolExecutor
        from multiprocessing import get_context

        pool = ProcessPoolExecutor(jobs, mp_context=get_context("spawn"), initializer=leave_to_the_parent)
        try:
            yield pool, _AHEAD * jobs
        finally:
            pool.shutdown(wait=True, cancel_futures=True)
    else:
        yield None, 1


def results_in_order(
    executor: Executor | None, window: int, function: Callable[[Task], Result], tasks: Iterable[Task]
) -> Iterator[Result]:
    """Yield the results of the tasks in their order, with at most ``window`` of them under way.

    Raises:
        WorkerLost: a worker is gone.
    """
    if executor is None:
        yield from map(function, tasks)
        return
    from concurrent.futures.process import BrokenProcessPool

    under_way: deque[Future[Result]] = deque()
    try:
        for task in tasks:
            with not_inherited():  # a process pool starts a worker here
                under_way.append(executor.submit(function, task))
            if len(under_way) >= window:
                yield under_way.popleft().result()
        while under_way:
            yield under_way.popleft().result()
    except BrokenProcessPool:
        raise WorkerLost(
            "a worker process ended before its block was done: give fewer processes, or run again."
        ) from None


@contextmanager
def _dask(address: str) -> Iterator[tuple[Executor, int]]:
    try:
        from distributed import Client, KilledWorker
        from distributed.comm.core import CommClosedError
    except ImportError:
        raise UsageError("a cluster needs dask.distributed: pip install 'coast-cli[cluster]'.") from None
    try:
        client: Any = Client(address, timeout=_CONNECT_SECONDS, set_as_default=False)
    except (OSError, ValueError, TimeoutError):
        raise UsageError(f"{address}: no dask scheduler answers there.") from None
    with _silent_logs(), client:
        try:
            client.wait_for_workers(1, timeout=_CONNECT_SECONDS)
        except TimeoutError:
            raise UsageError(f"{address}: the scheduler has no workers.") from None
        window = _AHEAD * max(sum(client.nthreads().values()), 1)
        try:
            yield _Cluster(client), window
        except CoastError:
            raise
        except Exception as error:
            lost = isinstance(error, CancelledError | KilledWorker | CommClosedError)
            if client.status == "running" and not lost:
                raise
            reason = "gave up a block whose workers ended" if isinstance(error, KilledWorker) else "is gone"
            raise WorkerLost(f"the dask scheduler at {address} {reason}: see to it, and run again.") from None


class _Cluster(Executor):
    """A dask client as an executor."""

    def __init__(self, client: Any) -> None:  # noqa: ANN401
        self._client = client

    def submit(self, function: Callable[..., Any], /, *args: Any, **kwargs: Any) -> Future[Any]:  # noqa: ANN401
        return _Watched(self._client, self._client.submit(function, *args, pure=False, **kwargs))


class _Watched(Future[Any]):
    """A result on a cluster that is not waited for once the client has lost its scheduler, as dask's own may be."""

    def __init__(self, client: Any, awaited: Any) -> None:  # noqa: ANN401
        super().__init__()
        self._client, self._awaited = client, awaited

    def result(self, timeout: float | None = None) -> Any:  # noqa: ANN401
        while True:
            try:
                return self._awaited.result(timeout=timeout or _LOOK_SECONDS)
            except TimeoutError:
                if self._awaited.done() or timeout is not None:
                    raise
                if self._client.status != "running":
                    raise CancelledError from None


@contextmanager
def _silent_logs() -> Iterator[None]:
    """Keep dask from writing tracebacks to stderr; what matters of them is said in a sentence."""
    import logging

    before = logging.root.manager.disable
    logging.disable(logging.CRITICAL)
    try:
        yield
    finally:
        logging.disable(before)
