"""Worker processes for long studies, spawned and never forked.

A fork copies locks held by other threads (OpenCV's, Zenoh's); such a copy is never released, and
the child deadlocks.
"""

from __future__ import annotations

import multiprocessing
import os
import signal
from concurrent.futures import ProcessPoolExecutor  # noqa: TID251 - the one place

START = multiprocessing.get_context("spawn")
"""Start method of every child process that runs a function."""


def worker_pool(processes: int) -> ProcessPoolExecutor:
    """Return a pool of that many processes, each with a fresh interpreter."""
    return ProcessPoolExecutor(processes, mp_context=START, initializer=_end_silently_by_ctrl_c)


def _end_silently_by_ctrl_c() -> None:
    """End this process at once by a Ctrl-C, which its parent gets too and tells."""
    if signal.getsignal(signal.SIGINT) is signal.default_int_handler:  # not: started with nohup
        signal.signal(signal.SIGINT, lambda *_: os._exit(130))
