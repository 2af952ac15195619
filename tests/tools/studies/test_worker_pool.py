"""Worker processes are spawned: no locks of the parent's threads are copied."""

from __future__ import annotations

import os
import threading

import cv2
import numpy as np

from tools.studies.worker_pool import START, worker_pool

HELD = threading.Lock()
"""Held by a thread of this process: a forked copy would deadlock on it."""


def use_lock_and_opencv(value: int) -> tuple[int, int]:
    """Use lock and OpenCV in a worker: a forked one would deadlock."""
    with HELD:
        cv2.setNumThreads(1)
        return os.getpid(), int(cv2.blur(np.full((64, 64), value, np.uint8), (5, 5)).max())


def test_worker_does_not_inherit_locks_of_the_parents_threads() -> None:
    cv2.setNumThreads(2)
    cv2.blur(np.zeros((512, 512), np.uint8), (5, 5))  # OpenCV's threads are alive
    with HELD, worker_pool(2) as pool:
        results = list(pool.map(use_lock_and_opencv, [3, 5]))
    assert [value for _pid, value in results] == [3, 5]
    assert os.getpid() not in {pid for pid, _value in results}


def test_start_method_is_spawn() -> None:
    assert START.get_start_method() == "spawn"
