"""Drive keys from the terminal in which a command was started."""

from __future__ import annotations

import os
import select
import sys
import termios
import threading
import tty
from collections.abc import Callable, Iterator
from contextlib import contextmanager

HELP = "hold an arrow key (or w a d) to drive, z and c for arcs; any other key stops; q ends"
POLL_S = 0.1

_DRIVES: dict[bytes, tuple[int, int]] = {
    b"w": (1, 0),
    b"a": (0, 1),
    b"d": (0, -1),
    b"z": (1, 1),
    b"c": (1, -1),
    b"\x1b[A": (1, 0),
    b"\x1b[D": (0, 1),
    b"\x1b[C": (0, -1),
    b"\x1bOA": (1, 0),
    b"\x1bOD": (0, 1),
    b"\x1bOC": (0, -1),
}
"""(ahead, left) by key. There is no key for backwards: the laser does not see there."""
_END = b"q"


class KeysError(ValueError):
    """There is no terminal to read keys from; the message contains the remedy."""


def drive_of(typed: bytes) -> tuple[int, int]:
    """Return (ahead, left) of the last key in ``typed``, ahead 0 or 1, left -1 to 1."""
    if typed[-3:] in _DRIVES:
        return _DRIVES[typed[-3:]]
    return _DRIVES.get(typed[-1:], (0, 0))


@contextmanager
def terminal_keys(
    press: Callable[[int, int], None], end: Callable[[], None], terminal: int | None = None
) -> Iterator[None]:
    """Read keys on a thread while the context lasts; restore the terminal's mode after it.

    press: called with (ahead, left) of every key. end: called when q was typed or the terminal is
    closed. terminal: its file descriptor, None for standard input. Raises KeysError if it is no
    terminal.
    """
    descriptor = sys.stdin.fileno() if terminal is None else terminal
    if not os.isatty(descriptor):
        raise KeysError("--teleop needs a terminal with a keyboard: use `ssh -t`")
    before = termios.tcgetattr(descriptor)
    ending = threading.Event()
    thread = threading.Thread(
        target=_read, args=(descriptor, press, end, ending), name="keys", daemon=True
    )
    tty.setcbreak(descriptor)
    try:
        thread.start()
        yield
    finally:
        ending.set()
        thread.join()
        termios.tcsetattr(descriptor, termios.TCSADRAIN, before)


def _read(
    terminal: int,
    press: Callable[[int, int], None],
    end: Callable[[], None],
    ending: threading.Event,
) -> None:
    while not ending.is_set():
        if not select.select([terminal], [], [], POLL_S)[0]:
            continue
        try:
            typed = os.read(terminal, 64)
        except OSError:
            typed = b""
        if not typed or _END in typed:
            end()
            return
        press(*drive_of(typed))
