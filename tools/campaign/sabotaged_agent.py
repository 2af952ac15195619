"""The shipped agent with fault injection: at SIGUSR1 one of its threads dies, or the clock jumps.

Started as ``python -m tools.campaign.sabotaged_agent WHAT agent ROBOT.toml ...``; WHAT is the end
of a thread's name, or ``clock``. The agent's code is unchanged.
"""

from __future__ import annotations

import ctypes
import runpy
import signal
import sys
import threading
import time
from types import FrameType

JUMP_S = 300_000_000
"""Nine years, s: a clock without a battery jumps back by years."""


def kill_thread(ending: str) -> None:
    """Raise SystemExit in the thread whose name ends with ``ending``."""
    for thread in threading.enumerate():
        if thread.name.endswith(ending) and thread.ident is not None:
            ctypes.pythonapi.PyThreadState_SetAsyncExc(
                ctypes.c_ulong(thread.ident), ctypes.py_object(SystemExit)
            )


def set_clock_back() -> None:
    """Make every later reading of the wall clock JUMP_S too small."""
    true_time, true_time_ns = time.time, time.time_ns
    time.time = lambda: true_time() - JUMP_S
    time.time_ns = lambda: true_time_ns() - JUMP_S * 1_000_000_000


def install(what: str) -> None:
    """Install a handler of SIGUSR1 that injects the fault."""

    def handler(_number: int, _frame: FrameType | None) -> None:
        if what == "clock":
            set_clock_back()
        else:
            kill_thread(what)

    signal.signal(signal.SIGUSR1, handler)


if __name__ == "__main__":
    install(sys.argv.pop(1))
    runpy.run_module("tools.cli", run_name="__main__", alter_sys=True)
