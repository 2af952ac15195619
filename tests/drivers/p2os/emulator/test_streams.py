from __future__ import annotations

import pytest

from drivers.p2os.command_numbers import CommandNumber
from drivers.p2os.commands import Command
from drivers.p2os.emulator.streams import EmulatedStreams

N = CommandNumber


@pytest.mark.parametrize(
    ("argument", "due"), [(0, [False] * 3), (1, [True, False, False]), (2, [True] * 3)]
)
def test_argument_selects_none_one_or_a_stream(argument: int, due: list[bool]) -> None:
    streams = EmulatedStreams()
    streams.request(Command(N.ENCODER, argument))
    assert [streams.pop_due(N.ENCODER) for _ in range(3)] == due
    assert not streams.pop_due(N.IOREQUEST)


def test_streams_end_on_request_and_on_stop() -> None:
    streams = EmulatedStreams()
    for number in (N.ENCODER, N.IOREQUEST):
        streams.request(Command(number, 2))
    streams.request(Command(N.ENCODER, 0))
    assert not streams.pop_due(N.ENCODER)
    assert streams.pop_due(N.IOREQUEST)
    streams.stop()
    assert not streams.pop_due(N.IOREQUEST)
