from __future__ import annotations

from dataclasses import dataclass
from typing import get_args

import pytest

from robot_agent.messages.events import BytesReceived, Event
from robot_agent.recording.event_codec import CODECS, EventCodec, encode_event, plain_event


@dataclass(frozen=True, slots=True)
class Spot:
    hue: str
    area: int


@dataclass(frozen=True, slots=True)
class SpotsSeen:
    t: float
    measured: float
    spots: tuple[Spot, ...]
    note: str = ""


def test_every_kind_of_event_has_a_codec() -> None:
    kinds = {kind for codec in CODECS for kind in codec.events}
    assert kinds | {BytesReceived} == set(get_args(Event))


def test_new_kind_of_event_needs_one_codec() -> None:
    codec = plain_event("spots", SpotsSeen, "patrol.Spots")
    event = SpotsSeen(1.25, 1.125, (Spot("red", 40), Spot("green", 7)))
    message = codec.encode(event)
    assert b'"t"' not in message
    assert b"note" not in message, "what is at its default is left out, never null"
    assert codec.decode(1.25, message) == event


def test_bytes_are_stored_unchanged() -> None:
    assert encode_event(BytesReceived(1.0, "laser", b"\x02\x80")) == ("laser/rx", b"\x02\x80")


@pytest.mark.parametrize("codec", CODECS, ids=lambda codec: codec.topic)
def test_invalid_message_raises_value_error(codec: EventCodec) -> None:
    with pytest.raises(ValueError, match=r"JSON|Expected|truncated"):
        codec.decode(0.0, b"[")
