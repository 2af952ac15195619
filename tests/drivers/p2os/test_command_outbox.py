from __future__ import annotations

import pytest

from drivers.p2os.command_numbers import CommandNumber
from drivers.p2os.command_outbox import BURST, DEFAULT_WATCHDOG, LATER_PERIOD, CommandOutbox
from drivers.p2os.commands import PULSE, STOP, Command
from drivers.requests import Request, Write

SPEEDS = [Command(CommandNumber.VEL, speed) for speed in range(1, 21)]


class Outlet:
    """An outbox with the time at which each command was sent."""

    def __init__(self) -> None:
        self.requests: list[Request] = []
        self.sent: list[tuple[float, Command]] = []
        self.outbox = CommandOutbox(self.requests, lambda what, t: self.sent.append((t, what)))
        self.outbox.restart(0.0)

    def flush(self, start: float, end: float, every: float) -> None:
        for step in range(1, round((end - start) / every) + 1):
            self.outbox.flush(start + every * step)


@pytest.mark.parametrize("every", [0.01, 0.05, 0.07])
def test_queue_is_sent_in_order_at_the_p2os_rate(every: float) -> None:
    outlet = Outlet()
    outlet.outbox.add(*SPEEDS)
    outlet.flush(0.0, 2.0, every)
    assert [what for _, what in outlet.sent] == SPEEDS
    assert outlet.requests == [Write(what.encode()) for what in SPEEDS]
    times = [t for t, _ in outlet.sent]
    for first in range(len(times)):
        for last in range(first, len(times)):
            elapsed = times[last] - times[first]
            assert last - first + 1 <= BURST + elapsed / 0.05 + 1e-6
    assert times[-1] < 1.0 + 3 * every
    assert outlet.outbox.empty


def test_later_firmware_gets_a_higher_rate() -> None:
    outlet = Outlet()
    outlet.outbox.period = LATER_PERIOD
    outlet.outbox.add(*SPEEDS)
    outlet.flush(0.0, 0.2, 0.01)
    assert len(outlet.sent) == len(SPEEDS)


def test_urgent_commands_are_sent_before_the_queue() -> None:
    outlet = Outlet()
    outlet.outbox.add(*SPEEDS[:2])
    for _ in range(4):
        outlet.outbox.send(STOP, 0.01)
    assert len(outlet.sent) == 4
    outlet.outbox.flush(0.05)
    assert len(outlet.sent) == 4
    outlet.flush(0.05, 0.3, 0.05)
    assert [what for _, what in outlet.sent[4:]] == SPEEDS[:2]


def test_stop_is_sent_first_after_the_watchdog_expired() -> None:
    outlet = Outlet()
    outlet.outbox.send(PULSE, DEFAULT_WATCHDOG - 0.01)
    outlet.outbox.send(SPEEDS[0], 2 * DEFAULT_WATCHDOG)
    outlet.outbox.send(STOP, 4 * DEFAULT_WATCHDOG)
    assert [what for _, what in outlet.sent] == [PULSE, STOP, SPEEDS[0], STOP]
    outlet.outbox.watchdog = 0.5
    outlet.outbox.send(PULSE, 4 * DEFAULT_WATCHDOG + 0.5)
    assert [what for _, what in outlet.sent[-2:]] == [STOP, PULSE]


def test_restart_resets_queue_rate_and_watchdog() -> None:
    outlet = Outlet()
    outlet.outbox.add(*SPEEDS)
    outlet.outbox.period, outlet.outbox.watchdog = LATER_PERIOD, 0.5
    outlet.outbox.restart(10.0)
    assert outlet.outbox.empty
    assert (outlet.outbox.period, outlet.outbox.watchdog) == (0.05, DEFAULT_WATCHDOG)
    outlet.outbox.send(PULSE, 10.1)
    assert [what for _, what in outlet.sent] == [PULSE]


def test_queue_can_be_cleared() -> None:
    outlet = Outlet()
    outlet.outbox.add(*SPEEDS)
    outlet.outbox.drop_queued()
    outlet.flush(0.0, 1.0, 0.05)
    assert outlet.sent == []
