"""Executes runs of a study on a Dask cluster.

The workers need this product, and the map folder under the same path. Dask is in the extra
``cluster``; studies on one machine do not need it.
"""

from __future__ import annotations

from collections.abc import Callable, Iterator, Sequence
from typing import TypeVar

CONNECT_S = 10

_Run = TypeVar("_Run")
_Result = TypeVar("_Result")


class ClusterError(ValueError):
    """A cluster cannot be used; the message names reason and remedy."""


def run_on_cluster(
    runs: Sequence[_Run], run: Callable[[_Run], _Result], address: str
) -> Iterator[_Result]:
    """Yield the results of runs as they end; pending ones are cancelled when the caller stops.

    address: of the Dask scheduler. Raises ClusterError without Dask, or if no scheduler answers.
    """
    try:
        from distributed import Client, as_completed
    except ImportError:
        raise ClusterError(
            "studies on a cluster need Dask: install border-patrol[cluster]"
        ) from None
    try:
        client = Client(address, timeout=CONNECT_S)
    except (OSError, ValueError) as error:
        raise ClusterError(
            f"no Dask scheduler at {address} ({error}); start one with dask scheduler, workers "
            "with dask worker, and give its address, such as tcp://host:8786"
        ) from None
    with client:
        futures = client.map(run, runs, pure=False)
        try:
            for future in as_completed(futures):
                yield future.result()
        finally:
            client.cancel(futures)
