"""Worker processes are spawned: no locks of the parent's threads are copied."""

from __future__ import annotations

import multiprocessing
import os
import signal
import threading
import time
from concurrent.futures.process import BrokenProcessPool
from pathlib import Path

import cv2
import numpy as np
import pytest

from tools.cli import EndedBySignal
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


def interrupt_and_wait(started: str) -> None:
    Path(started).touch()
    signal.raise_signal(signal.SIGINT)


def test_ctrl_c_ends_a_worker_without_a_traceback(
    tmp_path: Path, capfd: pytest.CaptureFixture[str]
) -> None:
    started = tmp_path / "started"
    with worker_pool(1) as pool, pytest.raises(BrokenProcessPool):
        pool.submit(interrupt_and_wait, str(started)).result()
    assert started.exists()
    assert capfd.readouterr().err == ""


def sleep_long(started: str) -> None:
    Path(started).touch()
    time.sleep(600.0)


def test_an_exception_ends_workers_amid_their_work_and_what_waits_for_it(tmp_path: Path) -> None:
    names = [str(tmp_path / name) for name in "abcdefgh"]
    began = time.monotonic()
    with pytest.raises(EndedBySignal), worker_pool(1) as pool:  # noqa: PT012
        for name in names:
            pool.submit(sleep_long, name)
        while not Path(names[0]).exists():
            time.sleep(0.01)
        (worker,) = multiprocessing.active_children()
        raise EndedBySignal(signal.SIGTERM)
    # Not by one join: the pool's own thread joins as well, and the slower of both sees it alive.
    while worker.is_alive():
        assert time.monotonic() - began < 60.0
        time.sleep(0.01)
    assert not Path(names[1]).exists()


def test_start_method_is_spawn() -> None:
    assert START.get_start_method() == "spawn"
