"""Reads recordings: header, configuration, map, events and effects in order.

The file is read sequentially, chunk by chunk. A truncated or damaged recording is readable up to
that place, which is then given by ``Recording.truncated``. The layout is described in
``robot_agent.recording.recording_writer``.
"""

from __future__ import annotations

import os
import struct
import zlib
from collections.abc import Callable, Collection, Iterator
from io import BytesIO
from pathlib import Path
from typing import BinaryIO

import msgspec
import zstandard
from mcap.data_stream import ReadDataStream
from mcap.exceptions import McapError
from mcap.opcode import Opcode
from mcap.records import Attachment, Channel, Chunk, Metadata
from mcap.writer import MCAP0_MAGIC

from maps.input_limits import BAD_DATA, MAX_RECORD_BYTES, MAX_RECORDING_S
from maps.pose import Pose
from robot_agent.messages.effects import ChangeBaud, Effect, Publish, Remember, Send, TakePicture
from robot_agent.messages.events import BytesReceived, Event, LinkName
from robot_agent.messages.streams import PROCESS_STREAMS
from robot_agent.recording.event_codec import CODECS
from robot_agent.recording.recording_writer import (
    CONFIGURATION_ATTACHMENT,
    MAP_ATTACHMENT_PREFIX,
    OCTET_STREAM,
    RUN_METADATA,
    SEQUENCE_MODULUS,
    BaudMessage,
    Gap,
    GapMessage,
    Note,
    Reference,
    ReferenceMessage,
)
from robot_agent.recording.run_header import SCHEMA_VERSION, RunHeader
from tools.logs.chunk_data import chunk_data
from tools.logs.recording_upgrades import upgraded

RECORD_HEAD = struct.Struct("<BQ")  # opcode, length of what follows
MESSAGE_HEAD = struct.Struct("<BQHIQQ")  # record head, channel, sequence, log and publish time
DATA_OPCODES = frozenset(
    {Opcode.HEADER, Opcode.METADATA, Opcode.ATTACHMENT, Opcode.CHUNK, Opcode.MESSAGE_INDEX}
)
CHUNK_END = struct.Struct("<8xQ")  # of a chunk: time of its first message, of its last
PRIVATE_OPCODE = 0x80  # opcodes of private records start here


class RecordingError(ValueError):
    """The file is no readable recording; the message names file, reason and remedy."""


class DamageError(ValueError):
    """A record is truncated or its content is invalid."""


Item = Event | Effect | Gap | Reference | Note
Interpreter = Callable[[float, bytes], Item]


class Recording:
    """One recording; make it with ``read_recording``."""

    def __init__(
        self, path: Path, header: RunHeader, truncated: str | None, upgrades: list[str]
    ) -> None:
        self.path = path
        self.layout = SCHEMA_VERSION - len(upgrades)
        """The layout the file was written in."""
        self.header = header
        self.upgrades = upgrades
        """The steps that brought its header from an earlier layout to the present one."""
        self.truncated = truncated
        """None, or one line that says at which byte the readable part ends; final after ``items``
        or ``messages`` is exhausted."""

    def items(self) -> Iterator[Item]:
        """Yield events, effects and references in order; every call reads the file again.

        An effect has no time of its own: it belongs to the event before it.
        """
        interpreters: dict[int, Interpreter] = {}
        for channel, t, data in self._raw():
            try:
                interpret = interpreters.get(channel.id)
                if interpret is None:
                    interpret = interpreters[channel.id] = _interpreter(channel)
                item = interpret(t, data)
            except BAD_DATA as error:
                self.truncated = f"{self.path}: readable up to {t:.6f} s: {channel.topic}: {error}"
                return
            yield item

    def messages(self, topics: Collection[str] | None) -> Iterator[tuple[str, float, bytes]]:
        """Yield topic, agent time (s) and content of the messages of some topics, in order.

        None means all topics.
        """
        return (
            (channel.topic, t, data)
            for channel, t, data in self._raw()
            if topics is None or channel.topic in topics
        )

    def end(self) -> float:
        """Return the agent time of the last complete chunk's end, s; reads little of the file."""
        last = 0.0
        with self.path.open("rb") as file:
            records = _Records(file, shallow=True)
            try:
                for opcode, body in records:
                    if opcode == Opcode.CHUNK:
                        (end_ns,) = CHUNK_END.unpack_from(body)
                        last = max(last, (end_ns - self.header.start_wall_ns) / 1e9)
            except _DAMAGE:
                pass
        return last

    def _raw(self) -> Iterator[tuple[Channel, float, bytes]]:
        self.truncated = None
        messages = _Messages(self.header.start_wall_ns)
        with self.path.open("rb") as file:
            records = _Records(file)
            try:
                for opcode, body in records:
                    if opcode == Opcode.CHUNK:
                        yield from messages.of_chunk(chunk_data(Chunk.read(_stream(body))))
                    elif opcode == Opcode.ATTACHMENT:
                        _attachment(body)  # a damaged attachment ends the readable part too
            except _DAMAGE as error:
                self.truncated = _describe_damage(self.path, records.offset, error)


def read_recording(path: Path) -> Recording:
    """Open a recording and read its header, configuration and map files.

    Raises:
        RecordingError: the file cannot be read, is not MCAP, is not of a run, was cut before its
            header was complete, or is of a newer version.
    """
    try:
        with path.open("rb") as file:
            return _read_head(path, file)
    except OSError as error:
        raise RecordingError(
            f"{path}: cannot be read ({error.strerror}); give the path of a recording (.mcap)"
        ) from error


def _read_head(path: Path, file: BinaryIO) -> Recording:
    if file.read(len(MCAP0_MAGIC)) != MCAP0_MAGIC:
        raise RecordingError(
            f"{path}: is not an MCAP file; CARMEN logs and captures need `patrol convert` first"
        )
    file.seek(0)
    records = _Records(file)
    fields: dict[str, str] | None = None
    attachments: dict[str, bytes] = {}
    truncated = None
    try:
        for opcode, body in records:
            if opcode == Opcode.METADATA:
                metadata = Metadata.read(_stream(body))
                if metadata.name == RUN_METADATA:
                    fields = metadata.metadata
            elif opcode == Opcode.ATTACHMENT:
                attachment = _attachment(body)
                attachments[attachment.name] = attachment.data
            elif opcode == Opcode.CHUNK:
                break
    except _DAMAGE as error:
        truncated = _describe_damage(path, records.offset, error)
    header, upgrades = _header(path, fields, attachments, truncated)
    return Recording(path, header, truncated, upgrades)


def _header(
    path: Path,
    fields: dict[str, str] | None,
    attachments: dict[str, bytes],
    truncated: str | None,
) -> tuple[RunHeader, list[str]]:
    """Return the run header and the upgrades applied; raise RecordingError if there is none."""
    if fields is None:
        reason = truncated or f"{path}: has no `{RUN_METADATA}` record"
        raise RecordingError(f"{reason}; nothing to read: record again with `patrol agent`")
    version = fields.get("schema_version", "")
    if version.isdecimal() and int(version) > SCHEMA_VERSION:
        raise RecordingError(
            f"{path}: is of layout {version}, this program reads up to {SCHEMA_VERSION}; "
            "use the program that recorded it or a newer one"
        )
    map_files = {
        name.removeprefix(MAP_ATTACHMENT_PREFIX): data
        for name, data in attachments.items()
        if name.startswith(MAP_ATTACHMENT_PREFIX)
    }
    configuration = attachments.get(CONFIGURATION_ATTACHMENT, b"")
    try:
        fields, upgrades = upgraded(fields, map_files)
        header = msgspec.convert(
            {**fields, "configuration": configuration, "map_files": map_files},
            RunHeader,
            strict=False,
            builtin_types=(bytes,),
        )
    except (msgspec.ValidationError, ValueError, KeyError) as error:
        raise RecordingError(
            f"{path}: its `{RUN_METADATA}` record does not fit ({error}); record again"
        ) from error
    return header, upgrades


class _Messages:
    """Extracts the messages of successive chunks."""

    def __init__(self, start_wall_ns: int) -> None:
        self._start_ns = start_wall_ns
        self._channels: dict[int, Channel] = {}
        self._sequence = 0

    def of_chunk(self, data: bytes) -> Iterator[tuple[Channel, float, bytes]]:
        """Yield a chunk's messages with their times; DamageError where some are missing."""
        offset = 0
        while offset < len(data):
            opcode, length = RECORD_HEAD.unpack_from(data, offset)
            end = offset + RECORD_HEAD.size + length
            if opcode == Opcode.MESSAGE:
                _, _, number, sequence, log_time, _ = MESSAGE_HEAD.unpack_from(data, offset)
                channel = self._channels.get(number)
                if sequence != self._sequence or channel is None:
                    raise DamageError(f"message {self._sequence} is missing there")
                self._sequence = (sequence + 1) % SEQUENCE_MODULUS
                t = (log_time - self._start_ns) // 1000 / 1e6
                if abs(t) > MAX_RECORDING_S:
                    raise DamageError(f"the clock jumps to {t:.0f} s there")
                yield channel, t, data[offset + MESSAGE_HEAD.size : end]
            elif opcode == Opcode.CHANNEL:
                found = Channel.read(_stream(data[offset + RECORD_HEAD.size : end]))
                self._channels[found.id] = found
            offset = end


class _Records:
    """Iterates over the (opcode, body) records of an MCAP file's data section."""

    def __init__(self, file: BinaryIO, *, shallow: bool = False) -> None:
        """``shallow`` reads only the head of each body."""
        self._file = file
        self._shallow = shallow
        self._size = os.fstat(file.fileno()).st_size
        self.offset = len(MCAP0_MAGIC)
        """Byte offset of the current record."""

    def __iter__(self) -> Iterator[tuple[int, bytes]]:
        """Yield complete records to the end of the data; raise DamageError at a truncated one."""
        self._file.seek(self.offset)
        while True:
            head = self._file.read(RECORD_HEAD.size)
            if len(head) < RECORD_HEAD.size:
                raise DamageError("the file ends there without its closing records")
            opcode, length = RECORD_HEAD.unpack(head)
            if opcode == Opcode.DATA_END:
                return
            if opcode not in DATA_OPCODES and opcode < PRIVATE_OPCODE:
                raise DamageError(f"a record there is of unknown kind {opcode}")
            end = self.offset + RECORD_HEAD.size + length
            if end > self._size:
                raise DamageError(f"a record there would end at byte {end}, the file does before")
            wanted = min(length, CHUNK_END.size) if self._shallow else length
            if wanted > MAX_RECORD_BYTES:
                raise DamageError(f"a record there has {length} bytes, too many")
            body = self._file.read(wanted)
            if len(body) < wanted:
                raise DamageError("the file ends inside a record there")
            yield opcode, body
            self.offset = end
            if self._shallow:
                self._file.seek(end)


_DAMAGE = (*BAD_DATA, McapError, struct.error, zstandard.ZstdError, RuntimeError, MemoryError)
"""Exceptions of reading a damaged record; RuntimeError is lz4's."""


def _describe_damage(path: Path, offset: int, error: BaseException) -> str:
    return f"{path}: readable up to byte {offset}: {error or type(error).__name__}"


def _stream(data: bytes) -> ReadDataStream:
    return ReadDataStream(BytesIO(data))


def _attachment(body: bytes) -> Attachment:
    (expected,) = struct.unpack("<I", body[-4:])
    if zlib.crc32(body[:-4]) != expected:
        raise DamageError("an attachment there fails its checksum")
    attachment: Attachment = Attachment.read(_stream(body))
    return attachment


_decode_baud = msgspec.json.Decoder(BaudMessage).decode
_decode_gap = msgspec.json.Decoder(GapMessage).decode
_decode_reference = msgspec.json.Decoder(ReferenceMessage).decode


def _baud_effect(_t: float, data: bytes) -> Effect:
    message = _decode_baud(data)
    return ChangeBaud(message.link, message.baud)


def _reference(t: float, data: bytes) -> Reference:
    message = _decode_reference(data)
    return Reference(t, Pose(message.x, message.y, message.theta))


_INTERPRETERS: dict[str, Interpreter] = {
    "baud": _baud_effect,
    "take_picture": lambda _t, _data: TakePicture(),
    "gap": lambda t, data: Gap(t, _decode_gap(data).lost),
    "reference": _reference,
    "memory": lambda _t, data: Remember(data),
    **{codec.topic: codec.decode for codec in CODECS},
}


def _interpreter(channel: Channel) -> Interpreter:
    """Return the function that converts a channel's messages to items."""
    topic: str = channel.topic
    if topic in PROCESS_STREAMS:
        return lambda t, data: Note(t, topic, data)
    if channel.message_encoding != OCTET_STREAM:
        return _INTERPRETERS.get(topic) or (lambda _t, data: Publish(topic, data))
    name, _, way = topic.partition("/")
    link = msgspec.convert(name, LinkName)
    if way == "rx":
        return lambda t, data: BytesReceived(t, link, data)
    return lambda _t, data: Send(link, data)
