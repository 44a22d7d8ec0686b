"""The same function over many jobs: here, in processes of this machine, or on the workers of a dask cluster."""

from __future__ import annotations

from collections.abc import Callable, Iterator, Sequence
from concurrent.futures import ProcessPoolExecutor
from typing import Any, TypeVar

Job = TypeVar("Job")
Result = TypeVar("Result")


def spread(
    function: Callable[[Job], Result], jobs: Sequence[Job], workers: int, cluster: str | None = None
) -> Iterator[Result]:
    """Yield the results in the order of the jobs; `cluster` is the address of a dask scheduler (tcp://host:port).

    Workers of a cluster run in this checkout on a file system that all see, and give the same bytes.
    """
    if cluster is not None:
        yield from _on_cluster(function, jobs, cluster)
    elif workers <= 1 or len(jobs) <= 1:
        yield from map(function, jobs)
    else:
        with ProcessPoolExecutor(workers) as pool:
            yield from pool.map(function, jobs)


def _on_cluster(function: Callable[..., Any], jobs: Sequence[Any], address: str) -> Iterator[Any]:
    from distributed import Client

    with Client(address, set_as_default=False) as client:
        for future in client.map(function, jobs, pure=False):
            yield future.result()
