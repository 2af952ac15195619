"""The writer beside the control loop: what hangs is the disk or the pipe, never the caller."""

from __future__ import annotations

import os
import threading
import time
from collections.abc import Callable
from pathlib import Path

import msgspec
import pytest

from maps.map_folder import load_map_folder
from robot_agent.config import find_map
from robot_agent.messages.foxglove import Log, timestamp_at
from robot_agent.messages.log_level import LogLevel
from robot_agent.messages.streams import encode
from robot_agent.pose.pose_memory import RememberedPose
from robot_agent.process import side_writer
from robot_agent.process.journal import Journal
from robot_agent.process.pose_file import PoseFile
from robot_agent.process.side_writer import SideWriter

LINE = encode(
    Log(timestamp=timestamp_at(1.0, 0), level=LogLevel.WARNING, message="x" * 900, name="gate")
)


def test_payloads_are_written_in_order_and_the_last_ones_at_the_end() -> None:
    written: list[bytes] = []
    writer = SideWriter("test", written.append, 100)
    payloads = [bytes([number]) for number in range(50)]
    for payload in payloads:
        writer.put(payload)
    assert writer.close()
    assert written == payloads
    assert writer.lost == 0


def test_a_pose_file_on_a_disk_that_hangs_holds_nobody_up(tmp_path: Path) -> None:
    os.mkfifo(tmp_path / "pose.json.new")  # a write to it waits for a reader that never comes
    folder = load_map_folder(find_map("paper_lab", Path()), "border")
    file = PoseFile(tmp_path / "pose.json", "r1", folder)
    writer = SideWriter("pose file", file.keep, 1)
    pose = RememberedPose(x=1.0, y=2.0, theta=0.0, odometer_x=1, odometer_y=2, odometer_heading=3)
    for _ in range(20):
        writer.put(msgspec.json.encode(pose))
    assert writer.lost >= 18
    assert not writer.close(0.05)


def test_a_write_that_takes_too_long_hangs_until_it_is_done(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.setattr(side_writer, "HANG_S", 0.05)
    os.mkfifo(tmp_path / "file")
    written = threading.Event()

    def write(payload: bytes) -> None:
        (tmp_path / "file").write_bytes(payload)
        written.set()

    writer = SideWriter("test", write, 1)
    assert not writer.hangs
    writer.put(b"pose")
    assert until(lambda: writer.hangs)
    assert (tmp_path / "file").read_bytes() == b"pose"
    assert written.wait(5.0)
    assert until(lambda: not writer.hangs)
    assert writer.close()


def until(true: Callable[[], bool]) -> bool:
    """Wait for a condition for 5 s at most; return whether it came."""
    give_up = time.monotonic() + 5.0
    while not true() and time.monotonic() < give_up:
        time.sleep(0.005)
    return true()


def test_a_stalled_journal_loses_its_oldest_lines_and_holds_nobody_up() -> None:
    reader, pipe = os.pipe()  # 64 kB until it blocks
    with os.fdopen(pipe, "w") as out:
        writer = SideWriter("journal", Journal(out, {}).write, 100)
        for _ in range(400):
            writer.put(LINE)
        assert writer.lost > 100
        drain = threading.Thread(target=lambda: _read_all(reader), daemon=True)
        drain.start()
        assert writer.close(5.0)
    drain.join(5.0)
    os.close(reader)


def _read_all(reader: int) -> None:
    while os.read(reader, 65536):
        pass
