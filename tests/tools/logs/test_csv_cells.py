from __future__ import annotations

import csv
import io
from pathlib import Path

import pytest

from robot_agent.messages.effects import Publish
from robot_agent.messages.events import Tick
from robot_agent.recording.recording_writer import RecordingWriter
from tests.tools.monitor.agent_recordings import START, header_of
from tools.cli import main
from tools.logs.csv_cells import csv_cell


@pytest.mark.parametrize("start", ["=", "+", "-", "@", "\t=", "\r="])
def test_text_that_starts_as_a_formula_is_neutralised(start: str) -> None:
    cell = csv_cell(f"{start}cmd|' /C calc'!A0")
    assert cell.startswith("'")


@pytest.mark.parametrize("value", [-1.5, 7, None, True, "keep_going", "a - b", "größer", ""])
def test_numbers_and_plain_texts_stay(value: object) -> None:
    assert csv_cell(value) == value


def test_control_characters_are_escaped() -> None:
    assert csv_cell("\x1b[2J\u202eabc\n\0") == "\\x1b[2J\\u202eabc\\n\\x00"


def test_converted_stream_holds_neither_formula_nor_control_character(tmp_path: Path) -> None:
    path, target = tmp_path / "robot.mcap", tmp_path / "table.csv"
    with path.open("wb") as file:
        writer = RecordingWriter(file, header_of("robot", START))
        writer.write_event(Tick(0.0))
        writer.write_effect(0.0, Publish("event", b'{"message":"=1+1","@x":"\\u001b[2J","n":-1}'))
        writer.finish()
    assert main(["convert", str(path), "-o", str(target), "--stream", "event"]) == 0
    rows = list(csv.reader(io.StringIO(target.read_text())))
    assert rows == [["t", "message", "'@x", "n"], ["0.0", "'=1+1", "\\x1b[2J", "-1"]]
