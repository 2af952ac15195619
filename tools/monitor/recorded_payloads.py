"""Reads telemetry from an agent's or a monitor's recording, from any time on, in order of time.

A file is indexed once without decompressing it; payloads are then read chunk by chunk. A truncated
file yields everything before the cut.
"""

from __future__ import annotations

import os
import struct
import zlib
from collections.abc import Iterator
from dataclasses import dataclass, field
from io import BytesIO
from pathlib import Path
from typing import BinaryIO

import zstandard
from mcap.data_stream import ReadDataStream
from mcap.exceptions import McapError
from mcap.opcode import Opcode
from mcap.records import Attachment, Channel, Chunk, Metadata
from mcap.writer import MCAP0_MAGIC

from maps.input_limits import BAD_DATA, MAX_RECORD_BYTES
from robot_agent.messages.streams import STREAMS, key_of
from robot_agent.recording.recording_writer import MAP_ATTACHMENT_PREFIX, RUN_METADATA
from tools.logs.chunk_data import chunk_data
from tools.logs.recording import MESSAGE_HEAD, RECORD_HEAD, RecordingError
from tools.monitor.team_recorder import TEAM_METADATA

_CHUNK_TIMES = struct.Struct("<QQ")
_CHANNEL_ID = struct.Struct("<H")
_DAMAGE = (*BAD_DATA, McapError, struct.error, zstandard.ZstdError, RuntimeError, MemoryError)
_STREAM_OF_TOPIC = {name: name for name in STREAMS} | {"process_log": "event"}
"""Telemetry stream by topic of an agent's recording."""


@dataclass(frozen=True, slots=True)
class RecordedPayload:
    """One payload: its telemetry key, bytes, and time, s since 1970."""

    t: float
    key: str
    data: bytes


@dataclass(slots=True)
class _Index:
    """Index of a file: metadata, attachments, chunks, channels."""

    metadata: dict[str, dict[str, str]] = field(default_factory=dict)
    attachments: dict[str, bytes] = field(default_factory=dict)
    chunks: list[tuple[int, float, float]] = field(default_factory=list)  # offset, first, last (s)
    channels: dict[int, str] = field(default_factory=dict)  # -> topic
    searched: int = -1  # offset of the last chunk whose channels are known


class RecordedPayloads:
    """The telemetry of one recording."""

    def __init__(self, path: Path) -> None:
        """Index a recording.

        Raises:
            RecordingError: the file cannot be read, is no recording, or holds no telemetry.
        """
        self.path = path
        try:
            with path.open("rb") as file:
                self._index = _index_file(path, file)
        except OSError as error:
            raise RecordingError(
                f"{path}: cannot be read ({error.strerror}); give the path of a recording (.mcap)"
            ) from error
        self._keys = self._telemetry_keys()
        if not self._index.chunks or not self._keys:
            raise RecordingError(
                f"{path}: holds no telemetry; give a recording of `patrol agent` or of "
                "`patrol monitor --record`"
            )
        self.start = min(first for _, first, _ in self._index.chunks)
        self.end = max(last for _, _, last in self._index.chunks)

    @property
    def metadata(self) -> dict[str, dict[str, str]]:
        """Its metadata records by name."""
        return self._index.metadata

    @property
    def attachments(self) -> dict[str, bytes]:
        """Its attachments by name."""
        return self._index.attachments

    @property
    def map_files(self) -> dict[str, bytes]:
        """The map folder's files by name."""
        return {
            name.removeprefix(MAP_ATTACHMENT_PREFIX): data
            for name, data in self.attachments.items()
            if name.startswith(MAP_ATTACHMENT_PREFIX)
        }

    def payloads(self, since: float) -> Iterator[RecordedPayload]:
        """Yield the payloads from ``since``, s since 1970, on, in order of time.

        Damaged chunks are skipped. Raises OSError if the file cannot be opened any more.
        """
        with self.path.open("rb") as file:
            for offset, _, last in self._index.chunks:
                if last < since:
                    continue
                try:
                    found = sorted(self._of_chunk(file, offset), key=lambda payload: payload.t)
                except _DAMAGE:
                    continue  # the other chunks may be intact
                yield from (payload for payload in found if payload.t >= since)

    def _of_chunk(self, file: BinaryIO, offset: int) -> Iterator[RecordedPayload]:
        for opcode, body in _records(_chunk_data(file, offset)):
            if opcode != Opcode.MESSAGE:
                continue
            channel, _, log_time, _ = _MESSAGE.unpack_from(body)
            key = self._keys.get(channel)
            if key is not None:
                yield RecordedPayload(log_time / 1e9, key, body[_MESSAGE.size :])

    def _telemetry_keys(self) -> dict[int, str]:
        """Return the telemetry key by channel id, of telemetry channels only."""
        run = self.metadata.get(RUN_METADATA)
        if run is None:
            return dict(self._index.channels) if TEAM_METADATA in self.metadata else {}
        robot, team = run.get("robot", "robot"), run.get("team", "team")
        return {
            channel: key_of(team, robot, _STREAM_OF_TOPIC[topic])
            for channel, topic in self._index.channels.items()
            if topic in _STREAM_OF_TOPIC
        }


_MESSAGE = struct.Struct("<HIQQ")  # channel, sequence, log time, publish time
assert _MESSAGE.size == MESSAGE_HEAD.size - RECORD_HEAD.size


def _index_file(path: Path, file: BinaryIO) -> _Index:
    if file.read(len(MCAP0_MAGIC)) != MCAP0_MAGIC:
        raise RecordingError(f"{path}: is not an MCAP file; give a recording (.mcap)")
    index = _Index()
    size = os.fstat(file.fileno()).st_size
    offset = len(MCAP0_MAGIC)
    try:
        while len(head := file.read(RECORD_HEAD.size)) == RECORD_HEAD.size:
            opcode, length = RECORD_HEAD.unpack(head)
            end = offset + RECORD_HEAD.size + length
            if end > size or opcode == Opcode.DATA_END:
                break
            _index_record(index, file, opcode, offset, length)
            offset = end
            file.seek(offset)
    except _DAMAGE:
        pass  # the index holds what precedes the damage
    return index


def _index_record(index: _Index, file: BinaryIO, opcode: int, offset: int, length: int) -> None:
    """Add one record, whose head has just been read, to the index."""
    if opcode == Opcode.CHUNK:
        first, last = _CHUNK_TIMES.unpack(file.read(_CHUNK_TIMES.size))
        if last:
            index.chunks.append((offset, first / 1e9, last / 1e9))
    elif opcode == Opcode.MESSAGE_INDEX:
        (channel,) = _CHANNEL_ID.unpack(file.read(_CHANNEL_ID.size))
        if channel not in index.channels:  # it is defined in the chunk before this index
            _index_channels(index, file)
    elif opcode == Opcode.METADATA:
        metadata = Metadata.read(ReadDataStream(BytesIO(_body(file, length))))
        index.metadata[metadata.name] = metadata.metadata
    elif opcode == Opcode.ATTACHMENT:
        body = _body(file, length)
        if zlib.crc32(body[:-4]) == struct.unpack("<I", body[-4:])[0]:
            attachment = Attachment.read(ReadDataStream(BytesIO(body)))
            index.attachments[attachment.name] = attachment.data


def _index_channels(index: _Index, file: BinaryIO) -> None:
    offset, _, _ = index.chunks[-1]
    if offset == index.searched:
        return  # it does not define that channel
    index.searched = offset
    for opcode, body in _records(_chunk_data(file, offset)):
        if opcode == Opcode.CHANNEL:
            channel = Channel.read(ReadDataStream(BytesIO(body)))
            index.channels[channel.id] = channel.topic


def _chunk_data(file: BinaryIO, offset: int) -> bytes:
    """Return the decompressed records of the chunk at an offset.

    Raises one of _DAMAGE for damage and impossible sizes.
    """
    file.seek(offset)
    _, length = RECORD_HEAD.unpack(file.read(RECORD_HEAD.size))
    return chunk_data(Chunk.read(ReadDataStream(BytesIO(_body(file, length)))))


def _body(file: BinaryIO, length: int) -> bytes:
    if length > MAX_RECORD_BYTES:
        raise ValueError("a record there is too large")
    return file.read(length)


def _records(data: bytes) -> Iterator[tuple[int, bytes]]:
    offset = 0
    while offset + RECORD_HEAD.size <= len(data):
        opcode, length = RECORD_HEAD.unpack_from(data, offset)
        begin = offset + RECORD_HEAD.size
        offset = begin + length
        yield opcode, data[begin:offset]
