"""Layout of a recording, and its writer to an MCAP file.

Layout 4 of a recording (``run_header.SCHEMA_VERSION``):

- metadata record ``run``: the fields of ``RunHeader`` as text;
- attachments: ``configuration`` (the effective configuration) and ``map/<file>`` (the map folder);
- one message per event, effect, gap and reference pose, in the order in which they happened, with
  ``sequence`` a running counter and ``log_time`` the run's wall-clock start plus the agent time.
  Agent times are whole microseconds, so that a reader recovers the identical float.

============================ ================== ==============================================
topic                        encoding           one message is
============================ ================== ==============================================
``base/rx``, ``laser/rx``    octet stream       bytes that arrived on a link
``base/tx``, ``laser/tx``    octet stream       bytes the agent sent
``link``                     json               a link that went up or down
``baud``                     json               a change of a link's rate
``tick``, ``shutdown``       json, empty object those events; further kinds: ``event_codec``
``key``                      json               a key of the robot's own terminal
``take_picture``             json, empty object the agent requested a picture
``memory``                   json               the pose to store for the next start
``gap``                      json               number of records lost at this place
``reference``                json               reference pose (ground truth), if a log has it
a stream's name              json               one telemetry payload, as published
``process``, ``process_log`` json               payloads of the process, not of the agent
============================ ================== ==============================================
"""

from __future__ import annotations

from dataclasses import dataclass
from typing import IO

import msgspec
from mcap.well_known import MessageEncoding, SchemaEncoding
from mcap.writer import Writer

from maps.pose import Pose
from robot_agent.messages.effects import ChangeBaud, Effect, Publish, Remember, Send, TakePicture
from robot_agent.messages.events import Event, LinkName
from robot_agent.messages.streams import STREAMS
from robot_agent.messages.viewer_schema import viewer_schema
from robot_agent.pose.pose_memory import RememberedPose
from robot_agent.recording.event_codec import CODECS, LINKS, encode_event
from robot_agent.recording.run_header import RunHeader

RUN_METADATA = "run"
CONFIGURATION_ATTACHMENT = "configuration"
MAP_ATTACHMENT_PREFIX = "map/"
OCTET_STREAM = "application/octet-stream"
CHUNK_BYTES = 256 * 1024
SEQUENCE_MODULUS = 2**32


@dataclass(frozen=True, slots=True)
class Gap:
    """A place where records were dropped: a replay cannot go past it."""

    t: float  # of the next record, or of the last one lost
    lost: int  # events and effects that are missing


@dataclass(frozen=True, slots=True)
class Note:
    """A payload of the process at t, not of the agent."""

    t: float
    stream: str
    payload: bytes


@dataclass(frozen=True, slots=True)
class Reference:
    """Reference pose (ground truth) at t, from the source of a converted log."""

    t: float
    pose: Pose  # map_from_base


class BaudMessage(msgspec.Struct, frozen=True):
    """A change of a link's local rate."""

    link: LinkName
    baud: int


class GapMessage(msgspec.Struct, frozen=True):
    """How many records were lost at this place."""

    lost: int


class ReferenceMessage(msgspec.Struct, frozen=True):
    """A reference pose, ``map_from_base`` (m, rad)."""

    x: float
    y: float
    theta: float


class EmptyMessage(msgspec.Struct, frozen=True):
    """A message whose topic and time say all."""


MESSAGES: dict[str, tuple[type[msgspec.Struct], str]] = {
    "baud": (BaudMessage, "patrol.Baud"),
    "take_picture": (EmptyMessage, "patrol.TakePicture"),
    "gap": (GapMessage, "patrol.Gap"),
    "reference": (ReferenceMessage, "patrol.Reference"),
    "memory": (RememberedPose, "patrol.RememberedPose"),
    **{codec.topic: (codec.message, codec.schema_name) for codec in CODECS},
}
"""Structs and schema names of the JSON topics besides the telemetry streams."""

_encode = msgspec.json.Encoder().encode


class RecordingWriter:
    """Writes one recording to a binary file, on the caller's thread.

    Raises whatever the file raises (OSError on a full disk); the writer is unusable after that.
    """

    def __init__(self, file: IO[bytes], header: RunHeader) -> None:
        """Write the header and register all channels with their schemas."""
        self._header = header
        self._sequence = 0
        self._writer = Writer(file, chunk_size=CHUNK_BYTES)
        self._writer.start(profile="", library=f"border-patrol {header.software_version}")
        self._write_header()
        self._channels = self._register_channels()

    def _write_header(self) -> None:
        header = self._header
        fields = {
            name: str(getattr(header, name))
            for name in RunHeader.__dataclass_fields__
            if name not in ("configuration", "map_files")
        }
        self._writer.add_metadata(RUN_METADATA, fields)
        self._attach(CONFIGURATION_ATTACHMENT, header.configuration)
        for name, data in header.map_files.items():
            self._attach(MAP_ATTACHMENT_PREFIX + name, data)

    def _attach(self, name: str, data: bytes) -> None:
        start = self._header.start_wall_ns
        self._writer.add_attachment(start, start, name, OCTET_STREAM, data)

    def _register_channels(self) -> dict[str, int]:
        """Register every topic, so that the first chunk describes them all."""
        raw = [f"{link}/{way}" for link in LINKS for way in ("rx", "tx")]
        channels = {topic: self._writer.register_channel(topic, OCTET_STREAM, 0) for topic in raw}
        for topic, (message, name) in MESSAGES.items():
            schema = msgspec.json.encode(viewer_schema(message, name))
            channels[topic] = self._register_json(topic, name, schema)
        for stream in STREAMS.values():
            schema = msgspec.json.encode(stream.json_schema())
            channels[stream.name] = self._register_json(stream.name, stream.schema_name, schema)
        return channels

    def _register_json(self, topic: str, schema_name: str, schema: bytes) -> int:
        schema_id = self._writer.register_schema(schema_name, SchemaEncoding.JSONSchema, schema)
        return self._writer.register_channel(topic, MessageEncoding.JSON, schema_id)

    def write_event(self, event: Event) -> None:
        """Write one event at its own time."""
        topic, data = encode_event(event)
        self._write(event.t, topic, data)

    def write_effect(self, t: float, effect: Effect) -> None:
        """Write one effect at the time t of the event that caused it."""
        match effect:
            case Send(link, data):
                self._write(t, f"{link}/tx", data)
            case Publish(stream, payload):
                self._write(t, stream, payload)
            case TakePicture():
                self._write(t, "take_picture", _encode(EmptyMessage()))
            case Remember(payload):
                self._write(t, "memory", payload)
            case ChangeBaud(link, baud):
                self._write(t, "baud", _encode(BaudMessage(link, baud)))

    def write_note(self, note: Note) -> None:
        """Write a payload of the process."""
        self._write(note.t, note.stream, note.payload)

    def write_reference(self, t: float, pose: Pose) -> None:
        """Write the reference pose at t (``map_from_base``) of a converted log."""
        self._write(t, "reference", _encode(ReferenceMessage(*pose)))

    def write_gap(self, gap: Gap) -> None:
        """Write a gap mark."""
        self._write(gap.t, "gap", _encode(GapMessage(gap.lost)))

    def _write(self, t: float, topic: str, data: bytes) -> None:
        log_time = self._header.start_wall_ns + round(t * 1e6) * 1000
        self._writer.add_message(
            self._channel(topic), log_time, data, log_time, self._sequence % SEQUENCE_MODULUS
        )
        self._sequence += 1

    def _channel(self, topic: str) -> int:
        """Return a topic's channel; a stream outside the table is registered without a schema."""
        channel = self._channels.get(topic)
        if channel is None:
            channel = self._writer.register_channel(topic, MessageEncoding.JSON, 0)
            self._channels[topic] = channel
        return channel

    def flush(self) -> None:
        """Finish the chunk in progress and write everything so far to the file."""
        self._writer.flush()  # type: ignore[no-untyped-call]

    def finish(self) -> None:
        """Write the index and the closing records; the file itself stays open."""
        self._writer.finish()  # type: ignore[no-untyped-call]
