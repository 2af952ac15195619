"""The shipped agent with a traitor inside: at SIGUSR1 one of its threads dies, or the clock jumps.

Started as ``python -m tools.campaign.sabotaged_agent WHAT agent ROBOT.toml ...``; WHAT is how a
thread's name ends, or ``clock``. Nothing of the agent is changed.
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
"""Back by nine years, as a clock without a battery does, or forth when it hears of the time."""


def kill_thread(ending: str) -> None:
    """Let the thread whose name ends so die of an exception that nobody expects."""
    for thread in threading.enumerate():
        if thread.name.endswith(ending) and thread.ident is not None:
            ctypes.pythonapi.PyThreadState_SetAsyncExc(
                ctypes.c_ulong(thread.ident), ctypes.py_object(SystemExit)
            )


def turn_clock_back() -> None:
    """Let every later reading of the wall clock be wrong."""
    true_time, true_time_ns = time.time, time.time_ns
    time.time = lambda: true_time() - JUMP_S
    time.time_ns = lambda: true_time_ns() - JUMP_S * 1_000_000_000


def betray(what: str) -> None:
    """Wait for SIGUSR1, then do it."""

    def handler(_number: int, _frame: FrameType | None) -> None:
        if what == "clock":
            turn_clock_back()
        else:
            kill_thread(what)

    signal.signal(signal.SIGUSR1, handler)


if __name__ == "__main__":
    betray(sys.argv.pop(1))
    runpy.run_module("tools.cli", run_name="__main__", alter_sys=True)
