from __future__ import annotations

import io
import threading
from dataclasses import fields
from pathlib import Path
from typing import Any

import pytest

from drivers.p2os.base_state import BaseState
from robot_agent.process.journal import Journal
from tests.robot_agent.process.test_journal import EVENT
from tools.teleop.drive_line import Distance, LineBelow, drive_line, line_words, size_of


def state(t: float, x: float, y: float = 0.0) -> BaseState:
    numbers: dict[str, Any] = dict.fromkeys((field.name for field in fields(BaseState)), 0.0)
    return BaseState(**(numbers | {"t": t, "x": x, "y": y, "v": 0.25, "w": -0.5}))


def test_line_tells_speed_distance_and_size() -> None:
    distance = Distance()
    for t, x in enumerate((5.0, 5.5, 5.5, 5.1)):
        distance.take(state(t, x))
    words = line_words(state(4.0, 5.1), distance, 4_210_000)
    assert words == "0.25 m/s   -29 deg/s   driven 0.9 m   recorded 4.2 MB"
    assert line_words(None, distance, 0) == "no report of the base yet   recorded 0.0 MB"


def test_messages_stand_above_the_line() -> None:
    out = io.StringIO()
    below = LineBelow(out)
    below.show("0.25 m/s")
    below.show("0.25 m/s")
    Journal(below, {}).write(EVENT)
    below.show("0.26 m/s")
    below.show("")
    drawn = out.getvalue()
    assert drawn.count("0.25 m/s") == 1
    shown = [line.rpartition("\r\033[K")[2] for line in drawn.split("\n")]
    assert shown[0].startswith(("error: ", "warning: ", "info: "))
    assert shown[-1] == ""


def test_line_follows_base_and_recording_and_is_cleared(tmp_path: Path) -> None:
    out, asked = io.StringIO(), threading.Event()
    path = tmp_path / "drive.mcap"
    assert size_of(path) == 0
    path.write_bytes(b"0" * 300_000)

    def recorded() -> int:
        asked.set()
        return size_of(path)

    with drive_line(LineBelow(out), lambda: state(1.0, 2.0), recorded):
        assert asked.wait(10.0)
    assert "driven 0.0 m   recorded 0.3 MB" in out.getvalue()
    assert out.getvalue().endswith("\r\033[K")


def test_line_is_cleared_after_an_error() -> None:
    out = io.StringIO()
    with pytest.raises(RuntimeError), drive_line(LineBelow(out), lambda: None, lambda: 0):
        raise RuntimeError
    assert "\n" not in out.getvalue()
