"""Runs of a study on a Dask cluster, given by its scheduler's address.

The workers need this product, and the map folder under the same path. Dask comes with the extra
``cluster``; studies on one machine do without it.
"""

from __future__ import annotations

from collections.abc import Callable, Iterator, Sequence
from typing import TypeVar

CONNECT_S = 10

_Run = TypeVar("_Run")
_Result = TypeVar("_Result")


class ClusterError(ValueError):
    """A cluster that cannot be used; the message says what to do."""


def run_on_cluster(
    runs: Sequence[_Run], run: Callable[[_Run], _Result], address: str
) -> Iterator[_Result]:
    """Yield the results of runs as they end; those not begun are cancelled when the caller stops.

    Raises ClusterError without Dask, or where no scheduler answers at the address.
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
