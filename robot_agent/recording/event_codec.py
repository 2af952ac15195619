"""Encoding of each kind of event in a recording: one codec per kind, for writing and reading.

Bytes of a link are stored unchanged, each link under its own topic. Every other event is a small
JSON object; its time is the message's. A new kind of event is one more ``plain_event``.
"""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import MISSING, dataclass, fields
from typing import Any, get_args, get_type_hints

import msgspec

from robot_agent.messages.events import (
    BlobsSeen,
    BytesReceived,
    DeviceName,
    Event,
    LinkDown,
    LinkName,
    LinkUp,
    OperatorKey,
    PictureTaken,
    Shutdown,
    Tick,
)
from robot_agent.messages.foxglove import CompressedImage, timestamp_at

LINKS: tuple[LinkName, ...] = get_args(LinkName)


@dataclass(frozen=True, slots=True)
class EventCodec:
    """Codec of the events of one topic."""

    topic: str
    schema_name: str
    message: type[msgspec.Struct]
    """Struct of its JSON."""
    events: tuple[type, ...]
    encode: Callable[[Any], bytes]
    decode: Callable[[float, bytes], Event]
    """Raises msgspec.ValidationError for a message that does not fit."""


def plain_event(topic: str, event_type: type, schema_name: str) -> EventCodec:
    """Return the codec of a kind of event whose message is its fields, without the time ``t``."""
    hints = get_type_hints(event_type)
    kept = [field for field in fields(event_type) if field.name != "t"]
    message = msgspec.defstruct(
        f"{event_type.__name__}Message",
        [
            (field.name, hints[field.name])
            if field.default is MISSING
            else (field.name, hints[field.name], field.default)
            for field in kept
        ],
        frozen=True,
        omit_defaults=True,
    )
    encoder, decoder = msgspec.json.Encoder(), msgspec.json.Decoder(message)
    names = [field.name for field in kept]

    def encode(event: Any) -> bytes:
        return encoder.encode(message(**{name: getattr(event, name) for name in names}))

    def decode(t: float, data: bytes) -> Event:
        found = decoder.decode(data)
        event: Event = event_type(t, **{name: getattr(found, name) for name in names})
        return event

    return EventCodec(topic, schema_name, message, (event_type,), encode, decode)


class LinkMessage(msgspec.Struct, frozen=True):
    """A link that went up or down, and why."""

    link: DeviceName
    up: bool
    reason: str = ""


def _encode_link(event: LinkUp | LinkDown) -> bytes:
    if isinstance(event, LinkUp):
        return msgspec.json.encode(LinkMessage(event.link, True))
    return msgspec.json.encode(LinkMessage(event.link, False, event.reason))


def _decode_link(t: float, data: bytes) -> Event:
    message = msgspec.json.decode(data, type=LinkMessage)
    return LinkUp(t, message.link) if message.up else LinkDown(t, message.link, message.reason)


def _encode_picture(event: PictureTaken) -> bytes:
    image = CompressedImage(
        timestamp=timestamp_at(event.taken), frame_id="camera", data=event.jpeg, format="jpeg"
    )
    return msgspec.json.encode(image)


def _decode_picture(t: float, data: bytes) -> Event:
    image = msgspec.json.decode(data, type=CompressedImage)
    taken = round(image.timestamp.sec + 1e-9 * image.timestamp.nsec, 6)
    return PictureTaken(t, taken, image.data)


CODECS: tuple[EventCodec, ...] = (
    plain_event("tick", Tick, "patrol.Tick"),
    plain_event("shutdown", Shutdown, "patrol.Shutdown"),
    plain_event("key", OperatorKey, "patrol.OperatorKey"),
    plain_event("blobs", BlobsSeen, "patrol.Blobs"),
    EventCodec(
        "picture",
        "foxglove.CompressedImage",
        CompressedImage,
        (PictureTaken,),
        _encode_picture,
        _decode_picture,
    ),
    EventCodec("link", "patrol.Link", LinkMessage, (LinkUp, LinkDown), _encode_link, _decode_link),
)

_BY_TYPE = {event: codec for codec in CODECS for event in codec.events}


def encode_event(event: Event) -> tuple[str, bytes]:
    """Return an event's topic and message."""
    if isinstance(event, BytesReceived):
        return f"{event.link}/rx", event.data
    codec = _BY_TYPE[type(event)]
    return codec.topic, codec.encode(event)
