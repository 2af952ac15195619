"""The emulated laser against commands built from the listing alone."""

from __future__ import annotations

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st
from numpy.typing import NDArray

from drivers.emulation.timed_bytes import TimedBytes
from drivers.lms200.emulator.emulator import Lms200Emulator
from drivers.lms200.framing import Ack, Nak, Telegram, TelegramFramer, encode_telegram
from drivers.lms200.measurement import MEASURING_MODES, TURN, decode_measurement
from drivers.lms200.telegrams import DeviceStatus, Variant

INSTALL = b"\x20\x00SICK_LMS"
CONFIGURATION = "00 00 46 00 00 05 01 00 00 02 02"


def flat(t: float, n: int, increment: float) -> NDArray[np.float64]:
    return np.full(n, 2.0)


def ask(emulator: Lms200Emulator, payload: bytes, t: float = 0.0) -> list[str]:
    """Return ACK, NAK and reply payloads as hex."""
    emulator.feed(encode_telegram(payload), t)
    output = b"".join(item.data for item in emulator.pop_output(t + 1.0))
    found = TelegramFramer().feed(output)
    return [i.payload.hex() if isinstance(i, Telegram) else type(i).__name__ for i in found]


def stream(emulator: Lms200Emulator, until: float) -> list[TimedBytes]:
    emulator.feed(encode_telegram(b"\x20\x24"), 0.0)
    output = emulator.pop_output(until)
    return [item for item in output if len(item.data) > 100]


def test_acknowledgement_comes_before_the_reply_at_the_wire_rate() -> None:
    emulator = Lms200Emulator()
    emulator.feed(encode_telegram(b"\x20\x25"), 5.0)
    assert emulator.pop_output(5.001) == []
    ack, reply = emulator.pop_output(6.0)
    assert (ack.t, ack.data) == (pytest.approx(5.0 + 10 / 9600), b"\x06")
    assert reply.t == pytest.approx(5.0 + 100 / 9600)
    assert reply.data == bytes.fromhex("02 80 03 00 A0 00 10 16 0A")


def test_bad_crc_is_answered_with_nak() -> None:
    emulator = Lms200Emulator()
    emulator.feed(bytes.fromhex("02 00 01 00 31 15 13"), 0.0)
    assert [item.data for item in emulator.pop_output(1.0)] == [b"\x15"]


def test_incomplete_telegram_is_discarded_after_a_gap() -> None:
    emulator = Lms200Emulator()
    emulator.feed(bytes.fromhex("02 00 80 00 31"), 0.0)
    assert ask(emulator, b"\x32", 1.0) == ["Ack", "b210"]


def test_other_addresses_are_not_answered() -> None:
    emulator = Lms200Emulator()
    emulator.feed(encode_telegram(b"\x31", address=3), 0.0)
    assert emulator.pop_output(1.0) == []


@pytest.mark.parametrize("unknown", [b"\x99", b"\x20\x2c", b"\x20", b"\x66\x03", b"\x3b\xb4"])
def test_unknown_commands_are_refused(unknown: bytes) -> None:
    assert ask(Lms200Emulator(), unknown) == ["Ack", "9210"]


def test_type_status_errors_and_configuration_are_answered() -> None:
    emulator = Lms200Emulator()
    assert ask(emulator, b"\x3a") == ["Ack", "ba" + b"LMS200;301061;V02.10 ".hex() + "10"]
    assert ask(emulator, b"\x32", 2.0) == ["Ack", "b210"]
    _ack, reply = ask(emulator, b"\x31", 4.0)
    status = DeviceStatus.decode(Telegram(0x80, bytes.fromhex(reply)))
    assert status is not None
    assert (status.variant, status.baud, status.units) == (Variant(180, 50), 9600, 1)
    _ack, reply = ask(emulator, b"\x74", 6.0)
    assert reply == "f4" + emulator.state.configuration.block.hex() + "10"


def test_configuration_is_taken_in_installation_mode_only() -> None:
    emulator = Lms200Emulator()
    block = bytes.fromhex(CONFIGURATION)
    assert ask(emulator, b"\x77" + block) == ["Ack", "9210"]
    assert ask(emulator, b"\x20\x00SICK_XXX", 2.0) == ["Ack", "a00110"]
    assert ask(emulator, b"\x77" + block, 4.0) == ["Ack", "9210"]
    assert ask(emulator, INSTALL, 6.0) == ["Ack", "a00010"]
    assert ask(emulator, b"\x77" + block, 8.0) == ["Ack", "f701" + block.hex() + "10"]
    assert emulator.state.configuration.measuring_mode == 5
    assert ask(emulator, b"\x20\x24", 10.0) == ["Ack", "a00010"]
    assert ask(emulator, b"\x77" + block, 12.0) == ["Ack", "9210"]


@pytest.mark.parametrize("length", [7, 32, 34])
def test_configurations_of_every_client_are_taken(length: int) -> None:
    emulator = Lms200Emulator()
    ask(emulator, INSTALL)
    block = bytes.fromhex(CONFIGURATION).ljust(length, b"\0")[:length]
    assert ask(emulator, b"\x77" + block, 2.0) == ["Ack", "f701" + block.hex() + "10"]
    assert len(emulator.state.configuration.block) == 34
    assert emulator.state.configuration.measuring_mode == 5


@pytest.mark.parametrize("block", ["00", "0000460000 07 01", "0000460000 05 02"])
def test_unusable_configurations_are_refused(block: str) -> None:
    emulator = Lms200Emulator()
    before = emulator.state.configuration
    ask(emulator, INSTALL)
    sent = bytes.fromhex(block)
    assert ask(emulator, b"\x77" + sent, 2.0) == ["Ack", "f700" + sent.hex() + "10"]
    assert emulator.state.configuration == before


@pytest.mark.parametrize(
    ("wanted", "reply"),
    [
        ("B4 00 64 00", "bb01b400640010"),
        ("64 00 19 00", "bb016400190010"),
        ("B4 00 19 00", "bb00b400320010"),
        ("B4 00 00 00", "bb01b400640010"),  # resolution 0 is 1 degree
    ],
)
def test_variants_are_set_or_refused(wanted: str, reply: str) -> None:
    assert ask(Lms200Emulator(), b"\x3b" + bytes.fromhex(wanted)) == ["Ack", reply]


def test_rate_changes_once_the_reply_has_left_at_the_old_rate() -> None:
    emulator = Lms200Emulator()
    emulator.feed(encode_telegram(b"\x20\x40"), 0.0)
    emulator.pop_output(0.010)
    assert emulator.baud == 9600
    (reply,) = emulator.pop_output(0.011)
    assert reply.data[4:6] == b"\xa0\x00"
    assert reply.t == pytest.approx(100 / 9600)
    assert emulator.baud == 38400
    emulator.feed(encode_telegram(b"\x32"), 1.0)
    ack, _reply = emulator.pop_output(2.0)
    assert ack.t == pytest.approx(1.0 + 10 / 38400)


def test_one_call_returns_bytes_of_one_rate() -> None:
    emulator = Lms200Emulator()
    emulator.feed(encode_telegram(b"\x20\x40") + encode_telegram(b"\x32"), 0.0)
    assert b"".join(item.data for item in emulator.pop_output(1.0))[-2:] == b"\x16\x0a"
    assert b"".join(item.data for item in emulator.pop_output(1.0))[-2:] == b"\x3f\x13"


def test_reset_confirms_then_starts_at_9600() -> None:
    emulator = Lms200Emulator(baud=38400, boot_time=2.0)
    emulator.feed(encode_telegram(b"\x10"), 0.0)
    output = emulator.pop_output(1.0)
    assert [item.data for item in output] == [b"\x06", bytes.fromhex("02 80 02 00 91 10 79 30")]
    assert emulator.baud == 9600
    emulator.feed(encode_telegram(b"\x31"), 1.5)  # still booting: ignored
    (power_on,) = emulator.pop_output(3.0)
    assert power_on.data[4] == 0x90
    assert power_on.t == pytest.approx(2.0 + (9 * 10) / 38400 + len(power_on.data) * 10 / 9600)


@pytest.mark.parametrize(
    ("baud", "variant", "turns"),
    [
        (9600, Variant(180, 100), 30),
        (19200, Variant(180, 100), 15),
        (38400, Variant(180, 100), 8),
        (38400, Variant(180, 50), 16),
        (38400, Variant(100, 25), 16),
        (500000, Variant(180, 100), 1),
        (500000, Variant(180, 50), 2),
    ],
)
def test_stream_is_paced_by_wire_and_whole_mirror_scans(
    baud: int, variant: Variant, turns: int
) -> None:
    emulator = Lms200Emulator(baud=baud, scan_source=flat, variant=variant)
    times = [item.t for item in stream(emulator, until=5.0)]
    np.testing.assert_allclose(np.diff(times), turns * TURN, atol=1e-9)
    wire_time = (variant.count * 2 + 10) * 10 / baud
    assert (times[0] - wire_time) / TURN == pytest.approx(round((times[0] - wire_time) / TURN))


def test_source_is_called_at_the_middle_of_each_turn() -> None:
    asked: list[tuple[float, int, float]] = []

    def source(t: float, n: int, increment: float) -> NDArray[np.float64]:
        asked.append((t, n, increment))
        return np.full(n, 2.0)

    emulator = Lms200Emulator(baud=38400, scan_source=source, variant=Variant(180, 50))
    sent = stream(emulator, until=1.0)
    wire_time = 732 * 10 / 38400
    ends = np.array([item.t - wire_time for item in sent])
    expected = np.column_stack((ends - 1.5 * TURN, ends - 0.5 * TURN)).ravel()
    np.testing.assert_allclose([t for t, _n, _increment in asked[: len(expected)]], expected)
    assert asked[0][1:] == (361, pytest.approx(np.radians(0.5)))


def test_source_is_called_once_the_turn_is_due() -> None:
    asked: list[float] = []

    def source(t: float, n: int, increment: float) -> NDArray[np.float64]:
        asked.append(t)
        return np.full(n, 2.0)

    emulator = Lms200Emulator(baud=38400, scan_source=source, variant=Variant(180, 100))
    emulator.feed(encode_telegram(b"\x20\x24"), 0.0)
    now = 0.0
    while now < 1.0:
        now += 0.001
        count = len(asked)
        emulator.advance(now)
        assert all(now - 0.001 - 1e-9 <= t <= now for t in asked[count:])
    assert len(asked) == 10


@pytest.mark.parametrize(
    ("command", "reply"), [("20 25", 9), ("3B B4 00 64 00", 13), ("32", 8), ("31", 160)]
)
def test_command_breaks_off_the_scan_being_sent(command: str, reply: int) -> None:
    emulator = Lms200Emulator(baud=9600, scan_source=flat)
    whole = stream(emulator, until=2.0)[-1]
    asked = whole.t + 0.3
    emulator.pop_output(asked)
    emulator.feed(encode_telegram(bytes.fromhex(command)), asked)
    cut, ack, answer = emulator.pop_output(asked + 0.25)
    assert cut.data == whole.data[: len(cut.data)]
    assert 200 < len(cut.data) < 300
    assert (ack.data, len(answer.data)) == (b"\x06", reply)
    assert asked < ack.t < asked + 0.06


def test_stream_goes_on_after_a_request_and_ends_with_a_mode_or_variant() -> None:
    for command, streams in (("32", True), ("20 25", False), ("3B B4 00 64 00", False)):
        emulator = Lms200Emulator(baud=38400, scan_source=flat)
        stream(emulator, until=1.0)
        emulator.feed(encode_telegram(bytes.fromhex(command)), 1.0)
        rest = [len(item.data) for item in emulator.pop_output(3.0)]
        assert (732 in rest) == streams


def test_request_gives_one_scan() -> None:
    emulator = Lms200Emulator(baud=38400, scan_source=flat, variant=Variant(180, 100))
    emulator.feed(encode_telegram(b"\x30\x01"), 0.0)
    assert [len(item.data) for item in emulator.pop_output(3.0)] == [1, 372]


def test_playback_keeps_the_time_of_a_scan() -> None:
    emulator = Lms200Emulator(baud=38400, variant=Variant(180, 100))
    ranges = np.linspace(1.0, 3.0, 181)
    assert not emulator.send_scan(ranges, 0.5)
    stream(emulator, until=0.9)
    assert emulator.send_scan(ranges, 1.0)
    assert not emulator.send_scan(ranges, 1.05)  # the wire is busy
    (item,) = emulator.pop_output(2.0)
    assert item.t == pytest.approx(1.0 + TURN / 2 + 372 * 10 / 38400)
    (found,) = TelegramFramer().feed(item.data)
    assert isinstance(found, Telegram)
    measurement = decode_measurement(found, MEASURING_MODES[0])
    assert measurement is not None
    np.testing.assert_allclose(measurement.ranges, ranges, atol=0.00051)


def test_playback_accepts_one_beam_less_and_refuses_other_counts() -> None:
    emulator = Lms200Emulator(baud=38400, variant=Variant(180, 100))
    stream(emulator, until=0.9)
    assert emulator.send_scan(np.full(180, 1.0), 1.0)
    (item,) = emulator.pop_output(2.0)
    assert item.data[-7:-3] == bytes.fromhex("E8 03 FF 1F")
    with pytest.raises(ValueError, match="181 beams, not 361"):
        emulator.send_scan(np.full(361, 1.0), 3.0)


def test_powered_off_laser_sends_nothing() -> None:
    emulator = Lms200Emulator(baud=38400, scan_source=flat)
    stream(emulator, until=1.0)
    emulator.power_off(1.0)
    emulator.feed(encode_telegram(b"\x31"), 1.5)
    assert emulator.pop_output(9.0) == []


@given(st.lists(st.binary(max_size=50), max_size=20))
def test_arbitrary_bytes_do_not_raise(chunks: list[bytes]) -> None:
    emulator = Lms200Emulator(scan_source=flat)
    for step, chunk in enumerate(chunks):
        emulator.feed(chunk, step * 0.01)
        emulator.pop_output(step * 0.01)


@given(st.binary(min_size=1, max_size=40))
def test_any_command_is_answered(payload: bytes) -> None:
    emulator = Lms200Emulator(scan_source=flat)
    emulator.feed(encode_telegram(payload), 0.0)
    found = TelegramFramer().feed(b"".join(item.data for item in emulator.pop_output(9.0)))
    assert found[0] == Ack()
    assert len(found) >= 2
    assert Nak() not in found
