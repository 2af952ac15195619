from __future__ import annotations

import pytest

from drivers.lms200.emulator.wire import LaserWire


def test_bytes_leave_one_after_another_at_the_rate() -> None:
    wire = LaserWire(9600)
    wire.send(b"abc", 1.0)
    wire.send(b"de", 1.0)
    assert wire.pop(1.0 + 29 / 9600) == []
    first, second = wire.pop(2.0)
    assert (first.t, second.t) == pytest.approx((1.0 + 30 / 9600, 1.0 + 50 / 9600))


def test_only_measured_values_are_broken_off() -> None:
    wire = LaserWire(9600)
    wire.send(bytes(100), 0.0)
    wire.break_off(0.01)
    assert len(wire.pop(1.0)[0].data) == 100
    wire.send(bytes(100), 1.0, measured=True)
    wire.break_off(1.0101)
    wire.send(b"\x06", 1.0101)
    cut, ack = wire.pop(1.0125)
    assert len(cut.data) == 10
    assert ack.t == pytest.approx(cut.t + 10 / 9600)


def test_what_has_left_is_not_broken_off() -> None:
    wire = LaserWire(9600)
    wire.send(bytes(10), 0.0, measured=True)
    wire.break_off(1.0)
    assert len(wire.pop(1.0)[0].data) == 10


def test_line_without_a_rate_takes_no_time_until_one_is_ordered() -> None:
    wire = LaserWire(9600, paced=False)
    wire.send(bytes(1000), 1.0, measured=True)
    wire.break_off(1.0)
    assert wire.pop(1.0)[0].t == 1.0
    wire.send(b"ok", 1.0, baud_after=38400)
    assert wire.pop(1.0)[0].t == 1.0
    wire.send(bytes(384), 2.0)
    assert wire.pop(3.0)[0].t == pytest.approx(2.1)
    assert wire.baud == 38400


@pytest.mark.parametrize("paced", [True, False])
def test_measured_values_that_are_still_to_begin_are_dropped(*, paced: bool) -> None:
    wire = LaserWire(9600, paced=paced)
    wire.send(bytes(100), 1.005, measured=True)
    wire.break_off(1.0)
    wire.send(b"\x06", 1.0)
    (ack,) = wire.pop(2.0)
    assert ack.t <= 1.0 + 10 / 9600
