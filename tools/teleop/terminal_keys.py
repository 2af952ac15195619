"""The keys of the terminal a command was started from, as wishes of where to drive."""

from __future__ import annotations

import os
import select
import sys
import termios
import threading
import tty
from collections.abc import Callable
from types import TracebackType
from typing import Self

HELP = "hold an arrow key (or w a d) to drive, q and e for arcs; any other key stops; x ends"
POLL_S = 0.1

_DRIVES: dict[bytes, tuple[int, int]] = {
    b"w": (1, 0),
    b"a": (0, 1),
    b"d": (0, -1),
    b"q": (1, 1),
    b"e": (1, -1),
    b"\x1b[A": (1, 0),
    b"\x1b[D": (0, 1),
    b"\x1b[C": (0, -1),
    b"\x1bOA": (1, 0),
    b"\x1bOD": (0, 1),
    b"\x1bOC": (0, -1),
}
"""Key: ahead, left. There is no key for backwards: the laser does not see there."""
_END = b"x"


class KeysError(ValueError):
    """There are no keys to drive by; the message says what to do."""


def drive_of(typed: bytes) -> tuple[int, int]:
    """Return (ahead, left) of the last key among what was typed; (0, 0) for any that stops."""
    if typed[-3:] in _DRIVES:
        return _DRIVES[typed[-3:]]
    return _DRIVES.get(typed[-1:], (0, 0))


class TerminalKeys:
    """Reads keys on a thread of its own while the context lasts; the terminal is put back after.

    ``press`` hears (ahead, left) of every key, ``end`` that x was typed or the terminal has gone.
    """

    def __init__(
        self,
        press: Callable[[int, int], None],
        end: Callable[[], None],
        terminal: int | None = None,
    ) -> None:
        """Read the terminal of that file descriptor, standard input's where none is given.

        Raises KeysError where it is no terminal: keys come from a person at one, not from a file.
        """
        self._press, self._end = press, end
        self._terminal = sys.stdin.fileno() if terminal is None else terminal
        if not os.isatty(self._terminal):
            raise KeysError("--teleop needs a terminal with a keyboard: use `ssh -t`")
        self._before = termios.tcgetattr(self._terminal)
        self._ending = threading.Event()
        self._thread = threading.Thread(target=self._read, name="keys", daemon=True)

    def __enter__(self) -> Self:
        tty.setcbreak(self._terminal)
        self._thread.start()
        return self

    def __exit__(
        self,
        kind: type[BaseException] | None,
        error: BaseException | None,
        traceback: TracebackType | None,
    ) -> None:
        self._ending.set()
        self._thread.join()
        termios.tcsetattr(self._terminal, termios.TCSADRAIN, self._before)

    def _read(self) -> None:
        while not self._ending.is_set():
            if not select.select([self._terminal], [], [], POLL_S)[0]:
                continue
            try:
                typed = os.read(self._terminal, 64)
            except OSError:
                typed = b""
            if not typed or _END in typed:
                self._end()
                return
            self._press(*drive_of(typed))
