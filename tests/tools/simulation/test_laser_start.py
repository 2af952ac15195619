"""How an emulated laser is found, and that a session brings it to a stream from there."""

from __future__ import annotations

import numpy as np
import pytest

from drivers.lms200.errors import ErrorEntry, Severity
from drivers.lms200.framing import encode_telegram
from drivers.lms200.telegrams import Mode, Variant
from tools.simulation.laser_start import LaserStart, LaserStartError, parse_laser_start

READ_ERRORS = encode_telegram(b"\x32")


def found(spec: str, t: float = 100.0):  # type: ignore[no-untyped-def]
    return parse_laser_start(spec).make(lambda _t, n, _i: np.full(n, 2.0), lambda: None, t)


def test_every_state_is_parsed() -> None:
    spec = "baud=500000, variant=100:0.25,streaming,address=1,polluted,error=fatal:57,no-ack,slow"
    assert parse_laser_start(spec) == LaserStart(
        baud=500000,
        variant=Variant(100, 25),
        streaming=True,
        address=1,
        polluted=True,
        errors=(ErrorEntry(Severity.FATAL, 57, present=True),),
        acknowledges=False,
        slow=True,
    )
    assert parse_laser_start("") == LaserStart()


def test_address_may_be_written_as_its_replies_have_it() -> None:
    assert parse_laser_start("address=0x81") == parse_laser_start("address=1")


@pytest.mark.parametrize(
    ("spec", "words"),
    [
        ("baud=57600", "9600, 19200, 38400, 500000"),
        ("baud", "no such state"),
        ("variant=180:0.25", "180:1, 180:0.5, 100:1"),
        ("address=0", "1 to 127"),
        ("address=0x80", "1 to 127"),
        ("address=081", "1 to 127"),
        ("address=300", "1 to 127"),
        ("error=17", "SEVERITY:NUMBER"),
        ("error=bad:17", "info, warning, error, fatal"),
        ("slow=3", "no such state"),
        ("melting", "use e.g."),
    ],
)
def test_what_no_laser_is_is_refused(spec: str, words: str) -> None:
    with pytest.raises(LaserStartError, match=words):
        parse_laser_start(spec)


def test_laser_left_streaming_sends_scans_at_its_rate_from_its_address() -> None:
    laser = found("baud=38400,streaming,address=1,variant=100:1")
    assert (laser.mode, laser.baud) == (Mode.CONTINUOUS, 38400)
    scan = laser.pop_output(101.0)[-1]
    assert scan.data[:5] == b"\x02\x81\xce\x00\xb0"


def test_power_cut_returns_to_the_rate_it_is_switched_on_at() -> None:
    laser = found("baud=500000")
    laser.power_on(101.0)
    assert laser.baud == 500000


def test_condition_is_in_every_status_byte() -> None:
    laser = found("polluted,error=error:20")
    laser.feed(READ_ERRORS, 101.0)
    _ack, reply = laser.pop_output(102.0)
    assert reply.data[4:-2] == b"\xb2\x03\x14\x93"


def test_laser_without_acknowledgements_replies_all_the_same() -> None:
    laser = found("no-ack")
    laser.feed(READ_ERRORS, 101.0)
    (reply,) = laser.pop_output(102.0)
    assert reply.data[4:-2] == b"\xb2\x10"


@pytest.mark.parametrize(
    ("command", "takes"),
    [(b"\x20\x25", 2.8), (b"\x77" + bytes(7), 6.0), (b"\x3b\xb4\x00\x64\x00", 6.0), (b"\x74", 0.0)],
)
def test_slow_laser_acknowledges_at_once_and_replies_by_the_book(
    command: bytes, takes: float
) -> None:
    laser = found("slow,baud=38400")
    laser.feed(encode_telegram(b"\x20\x00SICK_LMS"), 190.0)
    laser.pop_output(199.0)
    laser.feed(encode_telegram(command), 200.0)
    laser.feed(READ_ERRORS, 200.1 if takes else 201.0)  # overlooked while it is busy
    ack, reply = laser.pop_output(210.0)[:2]
    assert ack.t < 200.01
    assert reply.t == pytest.approx(200.0 + takes, abs=0.02)
    assert len(laser.pop_output(220.0)) == 0


def test_line_without_a_rate_has_the_mirrors_pace_until_one_is_ordered() -> None:
    start = LaserStart(variant=Variant(180, 100), paced=False)
    laser = start.make(lambda _t, n, _i: np.full(n, 2.0), lambda: None, 0.0)
    laser.feed(encode_telegram(b"\x20\x24"), 0.0)
    assert len(laser.pop_output(1.0)) == pytest.approx(75 + 2, abs=2)
    laser.feed(encode_telegram(b"\x20\x40"), 1.0)
    laser.pop_output(1.9)
    laser.pop_output(2.0)
    laser.feed(encode_telegram(b"\x20\x24"), 2.0)
    assert len(laser.pop_output(3.0)) == pytest.approx(9 + 2, abs=2)
