"""The host's session against the emulated laser: from any state to a stream of dated scans."""

from __future__ import annotations

import math
from typing import Any

import msgspec
import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st
from numpy.typing import NDArray

from drivers.lms200.emulator.emulator import Lms200Emulator
from drivers.lms200.errors import ErrorEntry, Severity
from drivers.lms200.framing import encode_telegram
from drivers.lms200.session import Lms200Session, SessionState
from drivers.lms200.settings import LaserSettings
from drivers.lms200.telegrams import Configuration, Mode, Variant, VariantReply
from drivers.requests import SetBaud, Write
from drivers.scan import Special

STREAMING = SessionState.STREAMING


class Corner:
    """A wall 1.5 m to the right, one 4 m ahead, nothing to the left of 135 degrees."""

    def __init__(self) -> None:
        self.asked: list[float] = []

    def __call__(self, t: float, n: int, increment: float) -> NDArray[np.float64]:
        self.asked.append(t)
        return corner_ranges(-(n - 1) / 2 * increment + increment * np.arange(n))


def corner_ranges(angles: NDArray[np.float64]) -> NDArray[np.float64]:
    with np.errstate(divide="ignore"):
        right = np.where(angles < 0, -1.5 / np.sin(angles), np.inf)
        ahead = np.where(np.abs(angles) < 1.5, 4.0 / np.cos(angles), np.inf)
    ranges = np.minimum(right, ahead)
    return np.where(angles > math.radians(45), np.inf, ranges)


def laser(**settings: object) -> Lms200Session:
    return Lms200Session(msgspec.convert(settings, LaserSettings))


def sent_codes(line: Any) -> list[str]:
    return [frame[4:6].hex() if frame[4] == 0x20 else frame[4:5].hex() for frame in line.to_laser]


def test_fresh_laser_is_found_at_9600_and_set_up_in_order(line: Any) -> None:
    emulator = Lms200Emulator(scan_source=Corner())
    wire = line(laser(), emulator)
    wire.connect()
    assert wire.run_until(STREAMING, limit=6.0) < 4.0
    at_38400, at_9600 = ["2025"], ["2025", "2040"]
    set_up = ["3a", "31", "32", "3b", "74", "2000", "77", "2024"]
    assert sent_codes(wire) == [*at_38400, *at_9600, *set_up]
    assert wire.host_baud == emulator.baud == 38400
    assert emulator.state.variant == Variant(180, 100)
    assert (emulator.state.configuration.measuring_mode, emulator.state.configuration.units) == (
        5,
        1,
    )
    assert wire.session.identity == "LMS200;301061;V02.10"
    assert wire.session.trouble is None


def test_laser_set_up_before_is_not_written_again(line: Any) -> None:
    emulator = Lms200Emulator(scan_source=Corner())
    first = line(laser(), emulator)
    first.connect()
    first.run_until(STREAMING, limit=6.0)
    assert (emulator.state.variant_writes, emulator.state.configuration_writes) == (1, 1)

    emulator.power_on(first.t)
    second = line(laser(), emulator)
    second.t = first.t
    second.connect()
    second.run_until(STREAMING, limit=6.0)
    assert (emulator.state.variant_writes, emulator.state.configuration_writes) == (1, 1)
    assert not {"3b", "77", "2000"} & set(sent_codes(second))


@pytest.mark.parametrize("left_at", [9600, 19200, 38400, 500000])
def test_laser_left_streaming_is_stopped_first(line: Any, left_at: int) -> None:
    emulator = Lms200Emulator(scan_source=Corner())
    crashed = line(laser(baud=left_at), emulator)
    crashed.connect()
    crashed.run_until(STREAMING, limit=12.0)
    crashed.run(1.0)

    wire = line(laser(), emulator)
    wire.t = crashed.t
    wire.connect()
    taken = wire.run_until(STREAMING, limit=12.0)
    wire.run(1.0)
    assert emulator.baud == 38400
    assert len(wire.scans) >= 8
    if left_at == 38400:
        assert taken < 1.0
        assert sent_codes(wire) == ["2025", "3a", "31", "32", "74", "2024"]


def test_other_configuration_is_changed_only_where_it_must(line: Any) -> None:
    emulator = Lms200Emulator(scan_source=Corner(), variant=Variant(100, 25))
    odd = bytes.fromhex("0500 70 01 06 03 00 00 00 05 02 07 01") + bytes(range(21))
    emulator.state.configuration = Configuration(odd)
    wire = line(laser(resolution_deg=0.5), emulator)
    wire.connect()
    wire.run_until(STREAMING, limit=6.0)
    assert emulator.state.configuration.block == odd[:5] + b"\x05\x01" + odd[7:]
    assert emulator.state.variant == Variant(180, 50)
    wire.run(1.0)  # it sends scan and telegram index, as its configuration says
    assert {scan.ranges.size for scan in wire.scans} == {361}
    assert wire.session.counters.unusable == 0


@pytest.mark.parametrize(
    ("baud", "resolution_deg", "per_second"),
    [(38400, 1.0, 9.38), (38400, 0.5, 4.69), (19200, 1.0, 5.0), (9600, 0.5, 1.29), (500000, 1, 75)],
)
def test_scans_have_rate_and_times_of_the_mirror(
    line: Any, baud: int, resolution_deg: float, per_second: float
) -> None:
    scene = Corner()
    wire = line(laser(baud=baud, resolution_deg=resolution_deg), Lms200Emulator(scan_source=scene))
    wire.connect()
    wire.run_until(STREAMING, limit=12.0)
    wire.run(6.0)
    times = [scan.t for scan in wire.scans]
    assert np.diff(times).mean() == pytest.approx(1 / per_second, rel=0.02)
    turns = round(1 / resolution_deg)
    measured = np.reshape(scene.asked[: turns * len(times)], (-1, turns)).mean(axis=1)
    np.testing.assert_allclose(times, measured, atol=1e-4)


@pytest.mark.parametrize("resolution_deg", [1.0, 0.5])
def test_asymmetric_scene_keeps_left_and_right(line: Any, resolution_deg: float) -> None:
    wire = line(laser(resolution_deg=resolution_deg), Lms200Emulator(scan_source=Corner()))
    wire.connect()
    wire.run_until(STREAMING, limit=6.0)
    wire.run(1.0)
    scan = wire.scans[-1]
    assert scan.angles[0] == pytest.approx(-math.pi / 2)
    assert scan.angles[-1] == pytest.approx(math.pi / 2)
    np.testing.assert_allclose(scan.ranges, corner_ranges(scan.angles), atol=0.00051)
    assert scan.ranges[0] == pytest.approx(1.5, abs=1e-3)
    assert np.isinf(scan.ranges[-1])


def test_laser_streams_again_after_a_power_cut(line: Any) -> None:
    emulator = Lms200Emulator(scan_source=Corner(), boot_time=5.0)
    wire = line(laser(), emulator)
    wire.connect()
    wire.run_until(STREAMING, limit=6.0)
    wire.run(1.0)
    emulator.power_off(wire.t)
    wire.run(3.0)
    assert wire.session.state is SessionState.SEARCHING
    assert wire.session.trouble == "no scan for 2 s"
    emulator.power_on(wire.t)
    scans_before = len(wire.scans)
    assert wire.run_until(STREAMING, limit=16.0) < 15.0
    wire.run(1.0)
    assert len(wire.scans) > scans_before + 8
    assert wire.session.counters.configuration_writes == 1


def test_power_on_telegram_starts_over_at_its_rate(line: Any) -> None:
    emulator = Lms200Emulator(scan_source=Corner())
    wire = line(laser(baud=9600), emulator)
    wire.connect()
    wire.run_until(STREAMING, limit=6.0)
    wire.run(1.0)
    emulator.power_on(wire.t)
    wire.run(0.1)
    assert wire.session.state is not STREAMING
    assert wire.run_until(STREAMING, limit=1.0) < 1.0
    assert wire.session.counters.timeouts == 0


def test_laser_that_misses_its_first_look_is_found_in_the_next_sweep(line: Any) -> None:
    emulator = Lms200Emulator(scan_source=Corner())
    wire = line(laser(), emulator)
    missed: list[bytes] = []

    def miss_the_first_at_9600(data: bytes) -> bytes:
        if wire.host_baud == 9600 and not missed:
            missed.append(data)
            return b""
        return data

    wire.spoil = miss_the_first_at_9600
    wire.connect()
    assert wire.run_until(STREAMING, limit=6.0) < 5.0
    assert wire.session.counters.searches == 1


def test_streaming_laser_that_misses_a_look_is_asked_again_at_its_rate(line: Any) -> None:
    emulator = Lms200Emulator(scan_source=Corner(), baud=38400)
    first = line(laser(), emulator)
    first.connect()
    first.run_until(STREAMING, limit=3.0)
    wire = line(laser(), emulator)
    rates: list[int] = []

    def miss_the_first(data: bytes) -> bytes:
        rates.append(wire.host_baud)
        return data if len(rates) > 1 else b""

    wire.spoil = miss_the_first
    wire.connect()
    wire.run_until(STREAMING, limit=3.0)
    assert set(rates) == {38400}


def test_absent_laser_is_searched_for_until_it_answers(line: Any) -> None:
    emulator = Lms200Emulator(scan_source=Corner())
    emulator.power_off(0.0)
    wire = line(laser(), emulator)
    wire.connect()
    wire.run(12.0)
    assert wire.session.trouble is not None
    assert "38400, 9600, 19200, 500000" in wire.session.trouble
    emulator.power_on(wire.t)
    assert wire.run_until(STREAMING, limit=10.0) < 10.0
    assert wire.session.trouble is None


def test_corrupted_command_is_repeated_after_nak(line: Any) -> None:
    emulator = Lms200Emulator(scan_source=Corner(), baud=38400)
    wire = line(laser(), emulator)
    spoilt: list[bytes] = []

    def spoil_first_status_request(data: bytes) -> bytes:
        if data[4:5] == b"\x31" and not spoilt:
            spoilt.append(data)
            return data[:-1] + b"\xff"
        return data

    wire.spoil = spoil_first_status_request
    wire.connect()
    wire.run_until(STREAMING, limit=3.0)
    assert b"\x15" in wire.from_laser
    assert wire.session.counters.naks == 1
    assert sent_codes(wire).count("31") == 2
    assert wire.session.counters.searches == 1


def test_unanswered_command_is_repeated(line: Any) -> None:
    emulator = Lms200Emulator(scan_source=Corner(), baud=38400)
    wire = line(laser(), emulator)
    dropped: list[bytes] = []

    def drop_first_two_type_requests(data: bytes) -> bytes:
        if data[4:5] == b"\x3a" and len(dropped) < 2:
            dropped.append(data)
            return b""
        return data

    wire.spoil = drop_first_two_type_requests
    wire.connect()
    wire.run_until(STREAMING, limit=3.0)
    assert len(dropped) == 2
    assert wire.session.counters.timeouts == 2
    assert wire.session.counters.searches == 1


def test_scans_that_stop_coming_restart_the_search(line: Any) -> None:
    emulator = Lms200Emulator(scan_source=Corner(), baud=38400)
    wire = line(laser(), emulator)
    wire.connect()
    wire.run_until(STREAMING, limit=3.0)
    emulator.feed(encode_telegram(b"\x20\x25"), wire.t)
    wire.run(1.5)
    assert wire.session.state is STREAMING
    wire.run(1.2)
    assert wire.session.counters.searches == 2
    wire.run_until(STREAMING, limit=2.0)


class Forgetful(Lms200Emulator):
    """A laser that acknowledges a configuration and does not keep it."""

    def feed(self, data: bytes, t: float) -> None:
        before = self.state.configuration
        super().feed(data, t)
        self.state.configuration = before


def test_writes_are_limited_if_the_laser_keeps_no_setting(line: Any) -> None:
    emulator = Forgetful(scan_source=Corner(), baud=38400)
    wire = line(laser(), emulator)
    wire.connect()
    for _ in range(5):
        wire.run_until(STREAMING, limit=5.0)
        emulator.power_on(wire.t)
        wire.run(3.0)
    wire.run_until(STREAMING, limit=5.0)
    assert emulator.state.configuration_writes == 2
    assert wire.session.trouble == "laser does not keep its measuring mode and units"


def test_changed_password_is_reported_and_scans_resume(line: Any) -> None:
    emulator = Lms200Emulator(scan_source=Corner(), baud=38400)
    wire = line(laser(), emulator)
    wire.spoil = lambda data: (
        encode_telegram(b"\x20\x00OTHERPAS") if data[4:6] == b"\x20\x00" else data
    )
    wire.connect()
    wire.run(0.5)
    assert wire.session.trouble is not None
    assert "password" in wire.session.trouble
    wire.run_until(STREAMING, limit=5.0)
    wire.run(1.0)
    np.testing.assert_allclose(wire.scans[-1].ranges[0], 1.5, atol=0.001)


def test_laser_that_keeps_sending_reflectivity_gives_no_ranges(line: Any) -> None:
    emulator = Lms200Emulator(scan_source=Corner(), baud=38400)
    emulator.state.password = b"OTHERPAS"
    emulator.state.configuration = emulator.state.configuration.changed(0x3F, 1)
    wire = line(laser(), emulator)
    wire.connect()
    wire.run(3.0)
    assert wire.session.trouble == "laser keeps mode 3F: no ranges"
    assert wire.scans == []


def test_shut_down_stops_the_stream(line: Any) -> None:
    emulator = Lms200Emulator(scan_source=Corner(), baud=38400)
    wire = line(laser(), emulator)
    wire.connect()
    wire.run_until(STREAMING, limit=3.0)
    wire.session.shut_down(wire.t)
    assert wire.session.pop_requests() == [Write(encode_telegram(b"\x20\x25"))]
    assert wire.session.state is SessionState.DOWN
    emulator.feed(encode_telegram(b"\x20\x25"), wire.t)
    assert emulator.mode is Mode.ON_REQUEST
    assert wire.session.feed(encode_telegram(b"\x90\x10", 0x80), wire.t) == []
    wire.session.tick(wire.t + 100)
    assert wire.session.pop_requests() == []


def test_link_down_ends_and_link_up_starts_again(line: Any) -> None:
    wire = line(laser(), Lms200Emulator(scan_source=Corner(), baud=38400))
    wire.connect()
    wire.run_until(STREAMING, limit=3.0)
    wire.session.link_down(wire.t)
    assert wire.session.state is SessionState.DOWN
    wire.connect()
    wire.run_until(STREAMING, limit=3.0)


def test_bytes_behind_a_telegram_correct_its_time() -> None:
    session = laser()
    session.link_up(0.0)
    t = 0.0
    for reply in [
        b"\xa0\x00\x10",
        b"\xbaLMS200\x10",
        b"\xb1\x10",
        b"\xb2\x10",
        VariantReply(accepted=True, variant=Variant(180, 100)).encode(),
        bytes((0xF4,)) + bytes.fromhex("000046000005010000020200000000000000") + b"\x10",
        b"\xa0\x00\x10",
    ]:
        session.feed(encode_telegram(reply, 0x80), t)
    assert session.state is STREAMING
    frame = encode_telegram(b"\xb0\xb5\x40" + b"\xe8\x03" * 181 + b"\x10", 0x80)
    (alone,) = session.feed(frame, 1.0)
    first, second = session.feed(frame + frame, 2.0)
    wire_time = len(frame) * 10 / 38400
    assert alone.t == pytest.approx(1.0 - wire_time - 0.00666)
    assert second.t == pytest.approx(2.0 - wire_time - 0.00666)
    assert first.t == pytest.approx(2.0 - 2 * wire_time - 0.00666)


def test_acks_within_noise_do_not_delay_the_search() -> None:
    session = laser()
    session.link_up(0.0)
    tried: set[int] = set()
    for step in range(600):
        session.feed(b"\xff\x06\x15\x06\x33", step * 0.02)
        session.tick(step * 0.02)
        tried |= {r.baud for r in session.pop_requests() if isinstance(r, SetBaud)}
    assert tried == {38400, 9600, 19200, 500000}


@given(
    st.lists(
        st.one_of(
            st.binary(max_size=40),
            st.sampled_from(
                [
                    encode_telegram(payload, 0x80)
                    for payload in (
                        b"\xa0\x00\x10",
                        b"\xba\x10",
                        b"\xb1\x10",
                        b"\xbb\x00\x10",
                        b"\xf4\x10",
                        b"\xf7\x10",
                        b"\xf7\x01\x10",
                        b"\x92\x10",
                        b"\x90\x10",
                        b"\xb0\xb5\x40\x10",
                    )
                ]
            ),
        ),
        max_size=30,
    )
)
def test_arbitrary_bytes_do_not_raise(chunks: list[bytes]) -> None:
    session = laser()
    session.link_up(0.0)
    for step, chunk in enumerate(chunks):
        session.feed(chunk, step * 0.1)
        session.tick(step * 0.1)
        session.pop_requests()


@pytest.mark.parametrize(
    ("given_settings", "named"),
    [({"baud": 57600}, "baud"), ({"resolution_deg": 0.25}, "resolution_deg"), ({"bad": 1}, "bad")],
)
def test_invalid_settings_are_refused(given_settings: dict[str, object], named: str) -> None:
    with pytest.raises(msgspec.ValidationError, match=named):
        msgspec.convert(given_settings, LaserSettings)


def streaming(line: Any, emulator: Lms200Emulator, **settings: object) -> Any:
    wire = line(laser(**settings), emulator)
    wire.connect()
    wire.run_until(STREAMING, limit=12.0)
    return wire


def test_healthy_laser_is_queried_once(line: Any) -> None:
    wire = streaming(line, Lms200Emulator(scan_source=Corner()))
    asked = len(wire.to_laser)
    wire.run(20.0)
    assert wire.session.health is not None
    assert wire.session.health.ok
    assert len(wire.to_laser) == asked


def test_pollution_and_errors_appear_while_streaming(line: Any) -> None:
    emulator = Lms200Emulator(scan_source=Corner())
    wire = streaming(line, emulator)
    wire.run(1.0)
    emulator.polluted = True
    emulator.set_errors((ErrorEntry(Severity.WARNING, 18, present=True),), wire.t)
    wire.run(3.0)
    health = wire.session.health
    assert health.pollution
    assert health.level is Severity.WARNING
    assert "warning 18: front window polluted" in health.text
    scans = len(wire.scans)
    wire.run(3.0)
    assert len(wire.scans) - scans == pytest.approx(28, abs=2)
    emulator.polluted = False
    emulator.set_errors((ErrorEntry(Severity.WARNING, 18, present=False),), wire.t)
    wire.run(8.0)
    assert wire.session.health.ok


def test_fatal_error_is_in_the_trouble_when_scans_stop(line: Any) -> None:
    emulator = Lms200Emulator(scan_source=Corner())
    wire = streaming(line, emulator)
    wire.run(1.0)
    emulator.set_errors((ErrorEntry(Severity.FATAL, 57, present=True),), wire.t)
    wire.run(8.0)
    assert wire.session.state is not STREAMING
    assert "fatal 57: no zero index" in wire.session.trouble
    emulator.set_errors((), wire.t)
    wire.run_until(STREAMING, limit=6.0)
    wire.run(1.0)
    assert wire.session.health.ok
    assert wire.session.trouble is None


def test_dazzled_scans_have_specials_instead_of_ranges(line: Any) -> None:
    emulator = Lms200Emulator(scan_source=Corner())
    wire = streaming(line, emulator)
    emulator.blind(wire.t + 2.0)
    wire.run(1.5)
    scan = wire.scans[-1]
    assert np.isinf(scan.ranges).all()
    assert (scan.specials == Special.DAZZLED).all()
    assert wire.session.health.implausible
    wire.run(3.0)
    assert np.isfinite(wire.scans[-1].ranges).any()


def test_rate_in_the_status_is_ordered_where_the_line_has_none(line: Any) -> None:
    emulator = Lms200Emulator(scan_source=Corner(), paced=False)
    wire = line(laser(), emulator)
    wire.line_has_rate = False
    wire.connect()
    wire.run_until(STREAMING, limit=3.0)
    assert sent_codes(wire)[:5] == ["2025", "3a", "31", "2040", "3a"]
    assert emulator.state.baud == 38400
    wire.run(2.0)
    assert len(wire.scans) == pytest.approx(18.8, abs=2)


def test_rate_that_the_laser_does_not_keep_is_ordered_once(line: Any) -> None:
    class Stubborn(Lms200Emulator):
        def feed(self, data: bytes, t: float) -> None:
            super().feed(data, t)
            self.state.baud = 9600

    wire = line(laser(), Stubborn(scan_source=Corner(), paced=False))
    wire.line_has_rate = False
    wire.connect()
    wire.run_until(STREAMING, limit=3.0)
    assert sent_codes(wire).count("2040") == 1


@pytest.mark.parametrize("left", ["fresh", "streaming"])
def test_laser_slow_by_the_book_is_set_up_without_a_retry(line: Any, left: str) -> None:
    emulator = Lms200Emulator(scan_source=Corner(), baud=38400)
    if left == "streaming":
        emulator.feed(encode_telegram(b"\x20\x24"), 0.0)
        emulator.pop_output(1.05)
    emulator.slow = True
    wire = line(laser(), emulator)
    wire.t = 1.05  # a scan is on its way, if any
    wire.connect()
    taken = wire.run_until(STREAMING, limit=30.0)
    assert taken == pytest.approx(3 * 2.8 + 2 * 6.0, abs=0.6)
    assert wire.session.counters.timeouts == 0
    assert wire.session.counters.searches == 1
    assert wire.session.trouble is None


def test_laser_without_acknowledgements_is_set_up(line: Any) -> None:
    emulator = Lms200Emulator(scan_source=Corner())
    emulator.acknowledges = False
    wire = streaming(line, emulator)
    wire.run(1.0)
    assert wire.session.counters.timeouts == 0, "silence at 38400, where it is not, is none"
    assert len(wire.scans) >= 8


def test_laser_at_an_address_and_at_500000_baud_is_found_streaming(line: Any) -> None:
    emulator = Lms200Emulator(scan_source=Corner(), baud=500000)
    emulator.state.address = 1
    emulator.feed(encode_telegram(b"\x20\x24"), 0.0)
    wire = streaming(line, emulator)
    wire.run(1.0)
    assert len(wire.scans) >= 8


def test_partial_scans_have_offset_and_time_of_their_turn(line: Any) -> None:
    scene = Corner()
    wire = streaming(
        line, Lms200Emulator(scan_source=scene), baud=500000, resolution_deg=0.5, partial_scans=True
    )
    wire.run(2.0)
    scans = wire.scans[2:]
    assert len(scans) == pytest.approx(150, abs=4)
    firsts = {round(math.degrees(scan.angle_min), 3) for scan in scans}
    assert firsts == {-90.0, -89.5}
    for scan in scans:
        assert scan.angle_increment == pytest.approx(math.radians(1.0))
        assert scan.turns == 1
        np.testing.assert_allclose(scan.ranges, corner_ranges(scan.angles), atol=0.00051)
    times = np.array([scan.t for scan in scans])
    assert np.diff(times) == pytest.approx(13.32e-3, abs=1e-4)
    nearest = np.abs(np.subtract.outer(times, scene.asked)).min(axis=1)
    assert nearest.max() < 1e-4
