"""Keys typed while the terminal shows the team."""

from __future__ import annotations

import os
import select
import termios
import time
import tty
from collections.abc import Callable, Iterator
from contextlib import contextmanager


@contextmanager
def view_keys(terminal: int) -> Iterator[Callable[[float], bytes]]:
    """Yield a function that waits up to a time, s, for keys and returns those typed.

    terminal: file descriptor of the keyboard. Without one, or in the background, the function waits
    and returns nothing. The terminal's mode is restored on every way out.
    """
    if not _is_ours(terminal):
        yield _wait
        return
    before = termios.tcgetattr(terminal)
    tty.setcbreak(terminal, termios.TCSANOW)
    closed = False

    def typed(seconds: float) -> bytes:
        nonlocal closed
        if closed:
            return _wait(seconds)
        if not select.select([terminal], [], [], seconds)[0]:
            return b""
        try:
            keys = os.read(terminal, 64)
        except OSError:
            keys = b""
        closed = not keys
        return keys

    try:
        yield typed
    finally:
        termios.tcsetattr(terminal, termios.TCSANOW, before)


def _is_ours(terminal: int) -> bool:
    """Return whether it is a terminal whose keys this process gets."""
    try:
        return os.isatty(terminal) and os.tcgetpgrp(terminal) == os.getpgrp()
    except OSError:
        return False


def _wait(seconds: float) -> bytes:
    time.sleep(seconds)
    return b""
