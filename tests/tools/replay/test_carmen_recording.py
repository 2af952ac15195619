"""Conversions between recordings, logs, captures and tables."""

from __future__ import annotations

import csv
import json
import math
from pathlib import Path

import numpy as np
import pytest

from robot_agent.messages.events import Event
from tools.cli import main
from tools.logs.capture import CaptureError, capture_to_recording, read_capture
from tools.logs.carmen import read_carmen
from tools.logs.recorded_config import recorded_config
from tools.logs.recorded_scans import ScanDecoder
from tools.logs.recording import read_recording
from tools.replay.recorded_devices import recorded_devices

KEPT = Path(__file__).parents[1] / "logs" / "recordings" / "layout_1.mcap"
CAPTURES = ("client-sim-tcp", "client-sim-serial", "client-laser", "client-laser-halfdegree")


@pytest.mark.parametrize("name", CAPTURES)
def test_capture_survives_conversion_to_a_recording_and_back(
    data_folder: Path, tmp_path: Path, name: str
) -> None:
    source = data_folder / "captures" / f"{name}.jsonl"
    recording, back = tmp_path / "capture.mcap", tmp_path / "back.jsonl"
    assert main(["convert", str(source), "-o", str(recording)]) == 0
    assert main(["convert", str(recording), "-o", str(back)]) == 0
    before, after = read_capture(source), read_capture(back)
    traffic = [(line.t, line.dir, line.hex) for line in before if line.hex and not line.abridged]
    assert [(line.t, line.dir, line.hex) for line in after if line.hex] == traffic
    rates = [line.baud for line in before if line.hex and line.baud and not line.abridged]
    assert not rates or [line.baud for line in after if line.hex] == rates


def test_capture_can_be_served(data_folder: Path, tmp_path: Path) -> None:
    path = tmp_path / "capture.mcap"
    summary = capture_to_recording(data_folder / "captures/client-sim-tcp.jsonl", path)
    base = recorded_devices(read_recording(path))["base"]
    base.feed(b"\xfa\xfb", 10.0)
    played = b"".join(out.data for out in base.pop_output(100.0))
    assert len(played) == summary.received
    assert played.startswith(b"\xfa\xfb\x03\x00")


@pytest.mark.parametrize(
    ("content", "complaint"),
    [
        ('{"t": 1, "dir": "host->robot", "hex": "fafb"}\n{"t": "x"}\n', "line 2"),
        ('{"t": 1, "dir": "host->robot", "hex": "fa0"}\n', "line 1"),
        ('{"t": 1, "dir": "event", "baud": 9600}\n', "no traffic"),
        ("ODOM 1 2 3\n", "line 1"),
    ],
)
def test_invalid_captures_are_refused(tmp_path: Path, content: str, complaint: str) -> None:
    path = tmp_path / "odd.jsonl"
    path.write_text(content)
    with pytest.raises(CaptureError, match=complaint):
        read_capture(path)


def test_recording_to_carmen_keeps_scans_and_odometry(tmp_path: Path) -> None:
    path = tmp_path / "run.log"
    assert main(["convert", str(KEPT), "-o", str(path)]) == 0
    log = read_carmen(path)
    recording = read_recording(KEPT)
    decoder = ScanDecoder(recorded_config(recording)[0])
    decoded = [
        found
        for item in recording.items()
        if isinstance(item, Event)
        for found in decoder.scans(item)
    ]
    assert len(log.scans) == len(decoded) > 10
    for scan, (original, odometry) in zip(log.scans, decoded, strict=True):
        assert scan.t == pytest.approx(original.t, abs=1e-6)
        assert scan.ranges.size == original.ranges.size
        both = np.isfinite(original.ranges)
        assert np.array_equal(np.isfinite(scan.ranges), both)
        assert scan.ranges[both] == pytest.approx(original.ranges[both], abs=0.001)
        laser = odometry.compose(decoder.mount)  # a log's odometry is the laser's
        assert math.dist(scan.odometry[:2], laser[:2]) < 1e-5


def test_stream_is_written_as_table(tmp_path: Path) -> None:
    path = tmp_path / "decisions.csv"
    assert main(["convert", str(KEPT), "-o", str(path), "--stream", "decision"]) == 0
    with path.open() as file:
        rows = list(csv.DictReader(file))
    recording = read_recording(KEPT)
    payloads = [json.loads(data) for _topic, _t, data in recording.messages(("decision",))]
    assert len(rows) == len(payloads)
    assert float(rows[3]["command.v"]) == payloads[3]["command"]["v"]
    assert rows[3]["action"] == payloads[3]["action"]
    assert next(iter(rows[0])) == "t"


def test_bytes_are_written_as_table(tmp_path: Path) -> None:
    path = tmp_path / "rx.csv"
    assert main(["convert", str(KEPT), "-o", str(path), "--stream", "base/rx"]) == 0
    rows = path.read_text().splitlines()
    assert rows[0] == "t,hex"
    assert "fafb" in rows[1]


@pytest.mark.parametrize(
    ("arguments", "complaint"),
    [
        (["-o", "x.csv"], "--stream"),
        (["-o", "x.csv", "--stream", "nothing"], "topics with messages are base/rx"),
        (["-o", "x.mcap"], "a .log, .ros2 or .jsonl"),
    ],
)
def test_unknown_conversions_name_the_known_ones(
    arguments: list[str],
    complaint: str,
    capsys: pytest.CaptureFixture[str],
    tmp_path: Path,
    monkeypatch: pytest.MonkeyPatch,
) -> None:
    monkeypatch.chdir(tmp_path)
    assert main(["convert", str(KEPT), *arguments]) == 1
    assert complaint in capsys.readouterr().err
