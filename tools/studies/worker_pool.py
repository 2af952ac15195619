"""Worker processes for long studies, spawned and never forked.

A fork copies locks held by other threads (OpenCV's, Zenoh's); such a copy is never released, and
the child deadlocks.
"""

from __future__ import annotations

import multiprocessing
import os
import signal
from collections.abc import Iterator
from concurrent.futures import ProcessPoolExecutor  # noqa: TID251 - the one place
from contextlib import contextmanager

START = multiprocessing.get_context("spawn")
"""Start method of every child process that runs a function."""


@contextmanager
def worker_pool(processes: int) -> Iterator[ProcessPoolExecutor]:
    """Yield a pool of that many processes, each with a fresh interpreter.

    An exception in the block ends them at once, whatever they are doing and still had to do.
    """
    before = set(multiprocessing.active_children())
    pool = ProcessPoolExecutor(processes, mp_context=START, initializer=_end_silently_by_ctrl_c)
    try:
        yield pool
    except BaseException:
        pool.shutdown(wait=False, cancel_futures=True)
        for worker in set(multiprocessing.active_children()) - before:
            worker.kill()
        raise
    pool.shutdown()


def _end_silently_by_ctrl_c() -> None:
    """End this process at once by a Ctrl-C, which its parent gets too and tells."""
    if signal.getsignal(signal.SIGINT) is signal.default_int_handler:  # not: started with nohup
        signal.signal(signal.SIGINT, lambda *_: os._exit(130))
