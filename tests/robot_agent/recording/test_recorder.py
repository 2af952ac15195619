from __future__ import annotations

import io
import os
import resource
import signal
import subprocess
import sys
import time
from collections.abc import Callable
from pathlib import Path
from typing import get_args

import hypothesis.strategies as st
import pytest
from hypothesis import given, settings
from mcap.reader import make_reader

from maps.pose import Pose
from robot_agent.messages.effects import ChangeBaud, Publish, Remember, Send
from robot_agent.messages.events import (
    BytesReceived,
    Event,
    LinkDown,
    LinkName,
    LinkUp,
    Shutdown,
    Tick,
)
from robot_agent.messages.streams import PROCESS_STREAMS, STREAMS
from robot_agent.recording.recorder import Recorder
from robot_agent.recording.recording_writer import Gap, Note, RecordingWriter, Reference
from robot_agent.recording.run_files import OneFile
from robot_agent.recording.run_header import RunHeader
from tools.logs.recording import Item, read_recording

START_WALL_NS = 1_700_000_000_123_456_789
HEADER = RunHeader(
    robot="anna",
    team="north",
    seed=7,
    software_version="0.1.0",
    start_wall_ns=START_WALL_NS,
    start_monotonic_ns=12_345_678_901,
    source="bench",
    configuration=b'[robot]\nname = "anna"\n',
    map_files={"map.yaml": b"image: map.pgm\n", "map.pgm": bytes(range(256))},
)

LONGEST_RUN_US = 10**13  # four months
times = st.integers(0, LONGEST_RUN_US).map(lambda us: us / 1e6)
AGENT_STREAMS = sorted(STREAMS.keys() - PROCESS_STREAMS)
links = st.sampled_from(get_args(LinkName))
data = st.binary(max_size=80)
events = st.one_of(
    st.builds(BytesReceived, times, links, data),
    st.builds(LinkUp, times, links),
    st.builds(LinkDown, times, links, st.text(max_size=40)),
    st.builds(Tick, times),
    st.builds(Shutdown, times),
)
effects = st.one_of(
    st.builds(Send, links, data),
    st.builds(ChangeBaud, links, st.integers(0, 10**6)),
    st.builds(Remember, data),
    st.builds(Publish, st.sampled_from([*AGENT_STREAMS, "a stream of tomorrow"]), data),
)
numbers = st.floats(allow_nan=False, allow_infinity=False)
marks = st.one_of(
    st.builds(Gap, times, st.integers(1, 10**9)),
    st.builds(Reference, times, st.builds(Pose, numbers, numbers, numbers)),
    st.builds(Note, times, st.sampled_from(sorted(PROCESS_STREAMS)), data),
)
items = st.lists(st.one_of(events, effects, marks), max_size=30)


def write_items(writer: RecordingWriter, recorded: list[Item]) -> None:
    t = 0.0
    for item in recorded:
        t = getattr(item, "t", t)
        if isinstance(item, Gap):
            writer.write_gap(item)
        elif isinstance(item, Note):
            writer.write_note(item)
        elif isinstance(item, Reference):
            writer.write_reference(item.t, item.pose)
        elif isinstance(item, Event):
            writer.write_event(item)
        else:
            writer.write_effect(t, item)


def record(recorder: Recorder, recorded: list[Item]) -> None:
    t = 0.0
    for item in recorded:
        t = getattr(item, "t", t)
        if isinstance(item, Event):
            recorder.record_event(item)
        else:
            assert isinstance(item, Send | ChangeBaud | Publish | Remember)
            recorder.record_effect(t, item)


@settings(max_examples=40)
@given(recorded=items, start_wall_ns=st.integers(0, 2**61), flush_after=st.integers(0, 30))
def test_everything_written_is_read_back_exactly_and_in_order(
    tmp_path_factory: pytest.TempPathFactory,
    recorded: list[Item],
    start_wall_ns: int,
    flush_after: int,
) -> None:
    header = RunHeader(
        robot="r", team="t", seed=1, software_version="", start_wall_ns=start_wall_ns
    )
    path = tmp_path_factory.mktemp("round_trip") / "run.mcap"
    with path.open("wb") as file:
        writer = RecordingWriter(file, header)
        write_items(writer, recorded[:flush_after])
        writer.flush()
        write_items(writer, recorded[flush_after:])
        writer.finish()
    recording = read_recording(path)
    assert list(recording.items()) == recorded
    assert recording.truncated is None
    assert recording.header == header


def test_header_configuration_and_map_come_back(tmp_path: Path) -> None:
    recorder = Recorder(OneFile(tmp_path / "run.mcap"), HEADER)
    recorder.close()
    assert read_recording(recorder.files.path).header == HEADER


def test_recorder_keeps_the_order_of_events_and_effects(tmp_path: Path) -> None:
    recorded: list[Item] = [
        LinkUp(0.0, "base"),
        Send("base", b"\xfa\xfb\x03\x00\x00\x00"),
        ChangeBaud("base", 38400),
        BytesReceived(0.1, "base", b"\xfa\xfb"),
        BytesReceived(0.1, "laser", b"\x02"),
        Publish("status", b"{}"),
        LinkDown(0.3, "laser", "no such device"),
        Tick(0.35),
        Shutdown(1.0),
    ]
    recorder = Recorder(OneFile(tmp_path / "run.mcap"), HEADER)
    record(recorder, recorded)
    recorder.close()
    recorder.close()
    assert (recorder.failed, recorder.lost) == ("", 0)
    assert list(read_recording(recorder.files.path).items()) == recorded


def test_full_queue_is_counted_and_leaves_a_gap(tmp_path: Path) -> None:
    recorder = Recorder(OneFile(tmp_path / "run.mcap"), HEADER, capacity=4, drain_period=3600.0)
    ticks: list[Item] = [Tick(index / 10) for index in range(10)]
    record(recorder, ticks)
    recorder.close()
    assert recorder.lost == 6
    assert list(read_recording(recorder.files.path).items()) == [*ticks[:4], Gap(0.9, 6)]


def test_every_discontinuity_is_marked_when_the_disk_cannot_keep_up(tmp_path: Path) -> None:
    recorder = Recorder(OneFile(tmp_path / "run.mcap"), HEADER, capacity=3, drain_period=0.001)
    count = 20_000
    record(recorder, [Tick(index / 1e6) for index in range(count)])
    recorder.close()
    seen = 0
    for item in read_recording(recorder.files.path).items():
        if isinstance(item, Gap):
            seen += item.lost
        else:
            assert item == Tick(seen / 1e6)
            seen += 1
    assert seen == count
    assert 0 < recorder.lost < count


def test_full_disk_sets_failed_without_raising() -> None:
    recorder = Recorder(OneFile(Path("/dev/full")), HEADER)
    recorder.record_event(Tick(0.0))
    recorder.close()
    assert recorder.failed == "/dev/full: recording stopped: No space left on device"
    before = recorder.lost  # 1 where the disk failed before the first event came
    recorder.record_event(Tick(1.0))
    assert recorder.lost == before + 1


def test_file_that_cannot_be_created_sets_failed(tmp_path: Path) -> None:
    (tmp_path / "in_the_way").touch()
    recorder = Recorder(OneFile(tmp_path / "in_the_way" / "run.mcap"), HEADER)
    recorder.close()
    assert "run.mcap: recording stopped: " in recorder.failed


def test_hanging_disk_sets_failed_and_does_not_block(tmp_path: Path) -> None:
    path = tmp_path / "run.mcap"
    os.mkfifo(path)  # opening it waits for a reader, as a hanging disk makes one wait
    recorder = Recorder(OneFile(path), HEADER, capacity=100, close_wait=0.05)
    record(recorder, [Tick(index / 10) for index in range(150)])
    assert recorder.lost == 50
    recorder.close()
    assert "the disk hangs" in recorder.failed
    reader = os.open(path, os.O_RDONLY | os.O_NONBLOCK)  # lets the thread go
    recorder.close()
    os.close(reader)


class DiskFullLater(io.BytesIO):
    """A file on a disk with room for some bytes only."""

    def __init__(self, room: int) -> None:
        super().__init__()
        self.room = room

    def write(self, part: object) -> int:
        assert isinstance(part, bytes)
        if self.tell() + len(part) > self.room:
            raise OSError(28, "No space left on device")
        return super().write(part)


def test_writer_reports_a_disk_that_fills_up_and_keeps_what_was_flushed(tmp_path: Path) -> None:
    file = DiskFullLater(room=20_000)
    writer = RecordingWriter(file, HEADER)
    flushed = 0

    def write_until_full() -> None:
        nonlocal flushed
        for index in range(10_000):
            writer.write_event(Tick(index / 100))
            writer.flush()
            flushed = index + 1

    with pytest.raises(OSError, match="No space left"):
        write_until_full()
    path = tmp_path / "run.mcap"
    path.write_bytes(file.getvalue())
    assert flushed > 0
    assert list(read_recording(path).items())[:flushed] == [Tick(i / 100) for i in range(flushed)]


def test_stock_reader_finds_topics_schemas_and_times(tmp_path: Path) -> None:
    path = tmp_path / "run.mcap"
    with path.open("wb") as file:
        writer = RecordingWriter(file, HEADER)
        writer.write_event(BytesReceived(1.5, "laser", b"\x02\x80"))
        writer.write_effect(1.5, Publish("scan", b'{"ranges":[]}'))
        writer.finish()
    with path.open("rb") as file:
        reader = make_reader(file, validate_crcs=True)
        summary = reader.get_summary()
        found = list(reader.iter_messages())
    assert summary is not None
    assert summary.statistics is not None
    assert summary.statistics.message_count == 2
    schema_names = {
        channel.topic: summary.schemas[channel.schema_id].name
        for channel in summary.channels.values()
        if channel.schema_id
    }
    assert {name: stream.schema_name for name, stream in STREAMS.items()}.items() <= (
        schema_names.items()
    )
    (raw_schema, raw_channel, raw), (scan_schema, scan_channel, scan) = found
    assert (raw_schema, raw_channel.topic, raw.data) == (None, "laser/rx", b"\x02\x80")
    assert raw_channel.message_encoding == "application/octet-stream"
    assert scan_schema is not None
    assert (scan_schema.name, scan_schema.encoding) == ("foxglove.LaserScan", "jsonschema")
    assert (scan_channel.topic, scan_channel.message_encoding) == ("scan", "json")
    assert (raw.sequence, scan.sequence) == (0, 1)
    assert raw.log_time == START_WALL_NS + 1_500_000_000


ENDLESS_RUN = """
import itertools, sys, time
from pathlib import Path
from robot_agent.messages.events import Tick
from robot_agent.recording.recorder import Recorder
from robot_agent.recording.run_files import OneFile
from robot_agent.recording.run_header import RunHeader
header = RunHeader(robot="r", team="t", seed=1, software_version="", start_wall_ns=0)
recorder = Recorder(OneFile(Path(sys.argv[1])), header, drain_period=0.02, flush_period=0.2)
start = time.monotonic()
for index in itertools.count():
    recorder.record_event(Tick(index / 100))
    print(index, flush=True)
    time.sleep(max(0.0, start + index / 200 - time.monotonic()))
"""


def test_killed_process_leaves_a_readable_prefix(tmp_path: Path) -> None:
    path = tmp_path / "run.mcap"
    repository = Path(__file__).resolve().parents[3]
    with subprocess.Popen(
        [sys.executable, "-c", ENDLESS_RUN, str(path)],
        cwd=repository,
        stdout=subprocess.PIPE,
        text=True,
    ) as process:
        assert process.stdout is not None
        for line in process.stdout:
            if int(line) == 140:
                break
        process.send_signal(signal.SIGKILL)
    recording = read_recording(path)
    ticks = list(recording.items())
    assert recording.truncated is not None
    assert "closing records" in recording.truncated or "byte" in recording.truncated
    assert ticks == [Tick(index / 100) for index in range(len(ticks))]
    assert len(ticks) > 50  # flushed each 0.2 s of 0.7 s


def test_run_goes_on_in_a_new_file_after_an_error_of_the_disk(tmp_path: Path) -> None:
    files = OneFile(tmp_path / "run.mcap")
    limit = resource.getrlimit(resource.RLIMIT_FSIZE)
    recorder = Recorder(files, HEADER, drain_period=0.001, flush_period=0.01, retry_after=0.01)
    wait_for((tmp_path / "run.mcap").exists)
    wait_for(lambda: (tmp_path / "run.mcap").stat().st_size > 0)
    try:
        resource.setrlimit(resource.RLIMIT_FSIZE, (1000, limit[1]))  # as a full disk
        recorder.record_event(Tick(1.0))
        wait_for(lambda: bool(recorder.failed))
        recorder.record_event(Tick(2.0))
    finally:
        resource.setrlimit(resource.RLIMIT_FSIZE, limit)
    wait_for(lambda: not recorder.failed)
    recorder.record_event(Tick(3.0))
    recorder.close()
    assert "run.2" in files.path.name or "run.3" in files.path.name
    assert list(read_recording(files.path).items()) == [Gap(1.0, 1), Gap(3.0, 1), Tick(3.0)]
    assert recorder.lost == 2


def wait_for(condition: Callable[[], bool]) -> None:
    """Wait for the recorder's thread."""
    end = time.monotonic() + 20.0
    while not condition():
        assert time.monotonic() < end
        time.sleep(0.001)
