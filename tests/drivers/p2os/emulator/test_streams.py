from __future__ import annotations

import pytest

from drivers.p2os.command_numbers import CommandNumber
from drivers.p2os.commands import Command
from drivers.p2os.emulator.streams import EmulatedStreams

N = CommandNumber


@pytest.mark.parametrize(
    ("argument", "due"), [(0, [0, 0, 0]), (1, [1, 0, 0]), (2, [1, 1, 1]), (9, [1, 1, 1])]
)
def test_argument_selects_none_one_or_a_stream(argument: int, due: list[int]) -> None:
    streams = EmulatedStreams()
    streams.request(Command(N.ENCODER, argument))
    sent = []
    for cycle in range(3):
        numbers = streams.due(cycle)
        sent.append(len(numbers))
        for number in numbers:
            assert number is N.ENCODER
            streams.on_sent(number)
    assert sent == due


def test_request_that_was_not_fulfilled_stays() -> None:
    streams = EmulatedStreams()
    streams.request(Command(N.IOREQUEST, 1))
    assert streams.due(0) == streams.due(1) == [N.IOREQUEST]


def test_each_stream_is_first_in_turn() -> None:
    streams = EmulatedStreams()
    for number in (N.ENCODER, N.IOREQUEST, N.JOYINFO):
        streams.request(Command(number, 2))
    assert [streams.due(cycle)[0] for cycle in range(4)] == [
        *(N.ENCODER, N.IOREQUEST, N.JOYINFO, N.ENCODER)
    ]
    assert all(len(streams.due(cycle)) == 3 for cycle in range(3))


def test_streams_end_on_request_and_on_stop() -> None:
    streams = EmulatedStreams()
    for number in (N.ENCODER, N.IOREQUEST):
        streams.request(Command(number, 2))
    streams.request(Command(N.ENCODER, 0))
    assert streams.due(0) == [N.IOREQUEST]
    streams.stop()
    assert streams.due(0) == []
