from __future__ import annotations

import os
import termios
import threading
from pathlib import Path

import pytest

from tools.teleop.terminal_keys import KeysError, drive_of, terminal_keys


@pytest.mark.parametrize(
    ("typed", "drive"),
    [
        (b"w", (1, 0)),
        (b"\x1b[D", (0, 1)),
        (b"www\x1b[C", (0, -1)),
        (b"w ", (0, 0)),
        (b"\x1b", (0, 0)),
        (b"s", (0, 0)),
        (b"z", (1, 1)),
        (b"c", (1, -1)),
        (b"x", (0, 0)),
    ],
)
def test_last_key_is_used(typed: bytes, drive: tuple[int, int]) -> None:
    assert drive_of(typed) == drive


def test_keys_are_reported_and_the_terminal_is_restored() -> None:
    master, slave = os.openpty()
    before = termios.tcgetattr(slave)
    heard: list[tuple[int, int]] = []
    pressed, ended = threading.Event(), threading.Event()

    def press(ahead: int, left: int) -> None:
        heard.append((ahead, left))
        pressed.set()

    with terminal_keys(press, ended.set, slave):
        os.write(master, b"w")
        assert pressed.wait(10.0)
        os.write(master, b"q")
        assert ended.wait(10.0)
    assert heard == [(1, 0)]
    assert termios.tcgetattr(slave) == before
    os.close(master)
    os.close(slave)


def test_file_instead_of_terminal_is_refused(tmp_path: Path) -> None:
    with (
        (tmp_path / "keys").open("wb") as file,
        pytest.raises(KeysError, match="ssh -t"),
        terminal_keys(lambda _a, _l: None, lambda: None, file.fileno()),
    ):
        pass
