from __future__ import annotations

import io
import struct
from pathlib import Path

import pytest
from mcap.writer import Writer

from robot_agent.messages.effects import Publish, Send
from robot_agent.messages.events import BytesReceived, LinkUp, Tick
from robot_agent.recording.recording_writer import RecordingWriter
from robot_agent.recording.run_header import SCHEMA_VERSION, RunHeader
from tests.tools.monitor.agent_recordings import header_of
from tools.logs.recording import Item, RecordingError, read_recording

HEADER = RunHeader(
    robot="anna",
    team="north",
    seed=7,
    software_version="0.1.0",
    start_wall_ns=1_700_000_000_000_000_000,
    configuration=b"seed = 7\n",
    map_files={"map.pgm": b"P5 2 1 255 " + bytes(2)},
)
ITEMS: list[Item] = [
    LinkUp(0.0, "base"),
    Send("base", b"\xfa\xfb\x03"),
    BytesReceived(0.1, "base", b"\xfa\xfb\x03\x00"),
    Publish("pose", b'{"pose":1}'),
    Tick(0.15),
    Tick(0.2),
]
CHUNK_ITEMS = 2


def small_recording() -> bytes:
    """Write a recording of three chunks of two items each."""
    file = io.BytesIO()
    writer = RecordingWriter(file, HEADER)
    for index, item in enumerate(ITEMS):
        if isinstance(item, Send | Publish):
            writer.write_effect(0.1, item)
        else:
            assert isinstance(item, LinkUp | BytesReceived | Tick)
            writer.write_event(item)
        if index % CHUNK_ITEMS == CHUNK_ITEMS - 1:
            writer.flush()
    writer.finish()
    return file.getvalue()


def chunk_places(whole: bytes) -> list[int]:
    """Return the byte offsets of the chunk records."""
    places, place = [], 8
    while whole[place] != 0x0F:  # the record that ends the data
        if whole[place] == 0x06:
            places.append(place)
        place += 9 + struct.unpack_from("<Q", whole, place + 1)[0]
    return places


def test_truncation_anywhere_gives_a_complete_prefix(tmp_path: Path) -> None:
    whole = small_recording()
    path = tmp_path / "cut.mcap"
    counts = []
    for size in range(0, len(whole), 11):
        path.write_bytes(whole[:size])
        try:
            recording = read_recording(path)
        except RecordingError:
            counts.append(-1)
            continue
        assert recording.header.robot == "anna"
        found = list(recording.items())
        assert found == ITEMS[: len(found)]
        if len(found) < len(ITEMS):
            assert recording.truncated is not None
            assert f"{path}: readable up to byte " in recording.truncated
        counts.append(len(found))
    assert counts == sorted(counts)
    assert set(counts) == {-1, 0, 2, 4, 6}


def test_truncation_is_reported_with_the_end_of_the_readable_part(tmp_path: Path) -> None:
    whole = small_recording()
    path = tmp_path / "cut.mcap"
    second = chunk_places(whole)[1]
    path.write_bytes(whole[: second + 20])
    recording = read_recording(path)
    assert list(recording.items()) == ITEMS[:CHUNK_ITEMS]
    assert recording.truncated is not None
    assert recording.truncated.startswith(f"{path}: readable up to byte {second}: ")


def test_any_flipped_byte_gives_a_prefix_or_an_error(tmp_path: Path) -> None:
    whole = small_recording()
    path = tmp_path / "damaged.mcap"
    shortened = 0
    data_end = whole.rindex(b"\x0f" + struct.pack("<Q", 4))
    for place in range(0, data_end, 5):
        damaged = bytearray(whole)
        damaged[place] ^= 0x55
        path.write_bytes(damaged)
        try:
            recording = read_recording(path)
            found = list(recording.items())
        except RecordingError:
            continue
        if recording.header.start_wall_ns == HEADER.start_wall_ns:
            assert found == ITEMS[: len(found)]
        assert recording.truncated is not None or len(found) == len(ITEMS)
        shortened += recording.truncated is not None
    assert shortened > 10


def test_damaged_attachment_ends_the_readable_part(tmp_path: Path) -> None:
    damaged = bytearray(small_recording())
    damaged[damaged.index(b"seed = 7")] ^= 1
    path = tmp_path / "damaged.mcap"
    path.write_bytes(damaged)
    recording = read_recording(path)
    assert recording.header.configuration == b""
    first_reading = recording.truncated
    assert first_reading is not None
    assert first_reading.endswith("an attachment there fails its checksum")
    assert list(recording.items()) == []
    assert recording.truncated == first_reading


def test_lost_chunk_ends_the_readable_part(tmp_path: Path) -> None:
    whole = small_recording()
    path = tmp_path / "hole.mcap"
    first, second, _ = chunk_places(whole)
    path.write_bytes(whole[:first] + whole[second:])
    recording = read_recording(path)
    assert list(recording.items()) == []
    assert recording.truncated == f"{path}: readable up to byte {first}: message 0 is missing there"


def test_recording_can_be_read_twice(tmp_path: Path) -> None:
    path = tmp_path / "run.mcap"
    path.write_bytes(small_recording())
    recording = read_recording(path)
    assert list(recording.items()) == list(recording.items()) == ITEMS
    assert recording.truncated is None


def test_long_recording_has_many_chunks(tmp_path: Path) -> None:
    path = tmp_path / "long.mcap"
    count = 20_000
    with path.open("wb") as file:
        writer = RecordingWriter(file, HEADER)
        for index in range(count):
            writer.write_event(BytesReceived(index / 1e6, "laser", bytes(30)))
        writer.finish()
    numbers = (item.t for item in read_recording(path).items() if isinstance(item, BytesReceived))
    assert list(numbers) == [index / 1e6 for index in range(count)]


@pytest.mark.parametrize(
    ("content", "reason", "remedy"),
    [
        (b"", "not an MCAP file", "patrol convert"),
        (b"# CARMEN Logfile\nFLASER 180 1.0\n", "not an MCAP file", "patrol convert"),
    ],
)
def test_other_files_are_refused(tmp_path: Path, content: bytes, reason: str, remedy: str) -> None:
    path = tmp_path / "odd.log"
    path.write_bytes(content)
    with pytest.raises(RecordingError) as raised:
        read_recording(path)
    message = str(raised.value)
    assert message.startswith(f"{path}: ")
    assert reason in message
    assert remedy in message
    assert "\n" not in message


def test_missing_file_is_refused(tmp_path: Path) -> None:
    with pytest.raises(RecordingError, match=r"none\.mcap: cannot be read \(No such file"):
        read_recording(tmp_path / "none.mcap")


def write_foreign(path: Path, metadata: dict[str, str] | None) -> None:
    with path.open("wb") as file:
        writer = Writer(file)
        writer.start()
        if metadata is not None:
            writer.add_metadata("run", metadata)
        writer.finish()  # type: ignore[no-untyped-call]


@pytest.mark.parametrize(
    ("metadata", "reason"),
    [
        (None, "has no `run` record"),
        ({"schema_version": "99"}, f"is of layout 99, this program reads up to {SCHEMA_VERSION}"),
        ({"schema_version": "one"}, "its `run` record does not fit"),
        ({"robot": "r"}, "its `run` record does not fit"),
    ],
)
def test_other_mcap_files_are_refused(
    tmp_path: Path, metadata: dict[str, str] | None, reason: str
) -> None:
    path = tmp_path / "foreign.mcap"
    write_foreign(path, metadata)
    with pytest.raises(RecordingError) as raised:
        read_recording(path)
    assert reason in str(raised.value)


@pytest.mark.parametrize("jump", [1e8, 8e9])
def test_clock_that_jumps_ends_the_readable_part(tmp_path: Path, jump: float) -> None:
    path = tmp_path / "jump.mcap"
    with path.open("wb") as file:
        writer = RecordingWriter(file, header_of("robot", 1_700_000_000.0))
        for t in (0.0, 1.0, 1.0 + jump):
            writer.write_event(Tick(t))
        writer.finish()
    recording = read_recording(path)
    assert [event.t for event in recording.items() if isinstance(event, Tick)] == [0.0, 1.0]
    assert recording.truncated is not None
    assert f"the clock jumps to {1.0 + jump:.0f} s there" in recording.truncated
