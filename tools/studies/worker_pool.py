"""Worker processes for long studies, started anew and never forked.

A fork copies a process whose other threads (OpenCV's, Zenoh's) may hold locks; the copy of such a
lock is never released, and the child waits for ever.
"""

from __future__ import annotations

import multiprocessing
from concurrent.futures import ProcessPoolExecutor  # noqa: TID251 - the one place

START = multiprocessing.get_context("spawn")
"""How every process of ours starts that is not a program of its own."""


def worker_pool(processes: int) -> ProcessPoolExecutor:
    """Return a pool of that many processes, each begun with a fresh interpreter."""
    return ProcessPoolExecutor(processes, mp_context=START)
