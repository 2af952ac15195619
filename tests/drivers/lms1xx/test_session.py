from __future__ import annotations

import math

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

from drivers.lms1xx import telegrams
from drivers.lms1xx.emulator.emulator import Lms1xxEmulator
from drivers.lms1xx.framing import Dialect
from drivers.lms1xx.session import Lms1xxSession, SessionState
from drivers.lms1xx.settings import LaserSettings
from drivers.lms1xx.telegrams import Contamination, OutputRange, ScanContent, Scanning
from drivers.scan import Special
from tests.drivers.lms1xx.conftest import MakeNetwork, ramp

STREAMING = SessionState.STREAMING


@pytest.mark.parametrize("dialect", Dialect)
def test_it_finds_the_dialect_and_streams_at_the_full_rate(
    network: MakeNetwork, dialect: Dialect
) -> None:
    net = network(dialect=dialect)
    net.connect()
    net.run_until(STREAMING, 2.0)
    net.run(2.0)
    assert net.session.dialect is dialect
    assert net.session.identity == "LMS111_FieldEval V1.80.2"
    assert net.session.trouble is None
    assert len(net.scans) == pytest.approx(100, abs=2)
    scan = net.scans[-1]
    assert scan.ranges == pytest.approx(np.linspace(1.0, 5.0, 541), abs=0.0006)
    assert math.degrees(scan.angle_min) == pytest.approx(-135.0)
    assert math.degrees(scan.angle_increment) == pytest.approx(0.5)
    assert scan.turn_time == pytest.approx(0.02)


def test_a_scan_is_dated_at_the_middle_of_its_sweep(network: MakeNetwork) -> None:
    asked: list[float] = []

    def source(t: float, n: int, increment: float) -> np.ndarray:
        asked.append(t)
        return ramp(t, n, increment)

    net = network(emulator=Lms1xxEmulator(scan_source=source))
    net.connect()
    net.run(1.0)
    times = [scan.t for scan in net.scans]
    assert times == pytest.approx(asked[: len(times)], abs=0.0005)


def test_what_is_as_set_is_not_written(network: MakeNetwork) -> None:
    net = network()
    net.connect()
    net.run_until(STREAMING, 2.0)
    assert net.emulator.configuration_writes == 0
    assert net.session.counters.configuration_writes == 0
    assert net.commands == [
        telegrams.STREAM,
        telegrams.LOGIN,
        telegrams.READ_IDENTITY,
        telegrams.READ_CONTAMINATION,
        telegrams.READ_SCANNING,
        telegrams.READ_RANGE,
        telegrams.READ_CONTENT,
        telegrams.START_MEASURING,
        telegrams.LOGOUT,
        telegrams.STREAM,
    ]


def test_other_settings_are_written_and_read_back(network: MakeNetwork) -> None:
    wanted = LaserSettings(frequency=25.0, resolution_deg=0.25, field_of_view_deg=180.0)
    net = network(wanted, dialect=Dialect.B)
    net.emulator.content = ScanContent(echoes=3, remission=True, time=True, every=5)
    net.connect()
    net.run_until(STREAMING, 2.0)
    net.run(4.0)
    assert net.emulator.scanning == Scanning(2500, 2500, -450000, 2250000)
    assert net.emulator.output_range == OutputRange(2500, 0, 1800000)
    assert net.emulator.content == ScanContent(time=True), "only what matters is changed"
    assert net.commands.count(telegrams.READ_SCANNING) == 2
    assert net.session.trouble is None
    assert net.scans[-1].ranges.size == 721
    assert math.degrees(net.scans[-1].angle_min) == pytest.approx(-90.0)
    assert net.scans[-1].ranges[360] == pytest.approx(3.0, abs=0.001)
    assert net.scans[-1].t - net.scans[-2].t == pytest.approx(0.04, abs=0.001)


def test_a_pair_that_the_scanner_refuses_is_told_and_it_streams_as_it_is(
    network: MakeNetwork,
) -> None:
    net = network(LaserSettings(frequency=50.0, resolution_deg=0.25))
    net.connect()
    net.run_until(STREAMING, 2.0)
    net.run(0.5)
    assert net.session.trouble == "laser refused 50 Hz in steps of 0.25 degrees"
    assert net.scans[-1].ranges.size == 541


def test_a_setting_that_is_not_kept_is_written_twice_and_told(network: MakeNetwork) -> None:
    net = network(LaserSettings(field_of_view_deg=100.0))

    class Forgetful(Lms1xxEmulator):
        def advance(self, t: float) -> None:
            self.output_range = OutputRange(5000, -450000, 2250000)
            super().advance(t)

    net.emulator = Forgetful(scan_source=ramp)
    net.connect()
    net.run_until(STREAMING, 2.0)
    net.run(0.2)
    assert net.session.trouble == "laser does not keep its field of view"
    assert net.emulator.configuration_writes == 2
    assert net.scans


def test_a_scanner_with_another_password_streams_unless_it_must_be_changed(
    network: MakeNetwork,
) -> None:
    net = network(emulator=Lms1xxEmulator(scan_source=ramp, password=0x6FD62C05))
    net.connect()
    net.run_until(STREAMING, 2.0)
    net.run(0.2)
    assert net.session.trouble == "laser refused the login: was its password changed?"
    assert net.scans


def test_a_scanner_that_stood_is_started(network: MakeNetwork) -> None:
    net = network()
    for payload in (
        telegrams.login(Dialect.A),
        telegrams.bare(telegrams.STOP_MEASURING, Dialect.A),
    ):
        net.emulator.feed(b"\x02" + payload + b"\x03", 0.0)
    net.connect()
    net.run_until(STREAMING, 2.0)
    net.run(2.5)
    assert net.scans
    assert net.session.counters.searches == 1


def test_a_stream_left_running_in_either_dialect_is_taken_over(network: MakeNetwork) -> None:
    first = network(dialect=Dialect.B)
    first.connect()
    first.run_until(STREAMING, 2.0)
    second = network(emulator=first.emulator)
    second.t = first.t
    second.connect()
    second.run_until(STREAMING, 2.0)
    second.run(0.5)
    assert len(second.scans) == pytest.approx(25, abs=2)


def test_scans_come_by_request_at_most_once_a_tick(network: MakeNetwork) -> None:
    net = network(LaserSettings(by_request=True, field_of_view_deg=190.0))
    net.connect()
    net.run_until(STREAMING, 2.0)
    net.run(2.0)
    assert telegrams.READ_SCAN in net.commands
    assert net.commands.count(telegrams.STREAM) == 1, "only to stop what was left running"
    assert 35 <= len(net.scans) <= 41
    times = [scan.t for scan in net.scans]
    assert times == sorted(set(times))
    assert net.scans[0].ranges.size == 381


def test_a_lost_reply_to_a_request_is_asked_for_again(network: MakeNetwork) -> None:
    net = network(LaserSettings(by_request=True))
    net.connect()
    net.run_until(STREAMING, 2.0)
    net.spoil = lambda data: b""
    net.run(0.3)
    net.spoil = lambda data: data
    before = len(net.scans)
    net.run(1.0)
    assert len(net.scans) > before + 5


def test_it_comes_back_after_the_connection_was_lost(network: MakeNetwork) -> None:
    net = network(dialect=Dialect.B)
    net.connect()
    net.run_until(STREAMING, 2.0)
    net.disconnect()
    net.run(1.0)
    assert net.session.state is SessionState.DOWN
    before = len(net.scans)
    net.connect()
    assert net.run_until(STREAMING, 2.0) < 0.2, "in the dialect found before"
    net.run(0.5)
    assert len(net.scans) > before + 20


def test_it_comes_back_after_the_scanner_was_switched_off_and_on(network: MakeNetwork) -> None:
    emulator = Lms1xxEmulator(scan_source=ramp, boot_time=5.0)
    net = network(emulator=emulator)
    net.run(6.0)
    net.connect()
    net.run_until(STREAMING, 10.0)
    net.run(0.5)
    emulator.power_off(net.t)
    net.run(3.0)
    assert net.session.trouble is not None
    assert net.session.state is not STREAMING
    emulator.power_on(net.t)
    net.run(10.0)
    assert net.session.state is STREAMING
    assert net.session.trouble is None


def test_nothing_there_is_told_with_both_dialects(network: MakeNetwork) -> None:
    net = network()
    net.emulator.power_off(0.0)
    net.connect()
    net.run_until(SessionState.PAUSING, 3.0)
    assert net.session.trouble == "no answer in CoLa A or B: is this a SICK scanner's port?"


def test_silence_of_the_stream_starts_a_search(network: MakeNetwork) -> None:
    net = network(LaserSettings(silence=0.5))
    net.connect()
    net.run_until(STREAMING, 2.0)
    net.run(0.2)
    net.spoil = lambda data: b""
    net.run(0.7)
    assert net.session.trouble == "no scan comes"
    net.spoil = lambda data: data
    net.run_until(STREAMING, 3.0)
    assert net.session.trouble is None


@pytest.mark.parametrize("dialect", Dialect)
def test_a_dirty_window_is_asked_about_and_told(network: MakeNetwork, dialect: Dialect) -> None:
    net = network(dialect=dialect)
    net.connect()
    net.run_until(STREAMING, 2.0)
    net.run(0.1)
    assert net.session.health is not None
    assert net.session.health.ok
    net.emulator.contamination = Contamination.WARNING
    net.run(0.2)
    assert net.session.health.text == ("front window polluted (warning): wipe it with a soft cloth")
    assert net.commands.count(telegrams.READ_CONTAMINATION) == 2
    net.emulator.contamination = Contamination.NONE
    net.run(6.0)
    assert net.session.health.ok
    assert net.session.counters.searches == 1


def test_a_device_error_is_told(network: MakeNetwork) -> None:
    net = network()
    net.connect()
    net.run_until(STREAMING, 2.0)
    net.emulator.failing = True
    net.run(0.2)
    assert net.session.health is not None
    assert "reports an error" in net.session.health.text
    net.emulator.power_off(net.t)
    net.run(2.5)
    assert net.session.trouble is not None
    assert "reports an error" in net.session.trouble


def test_mounting_turns_and_blinds_the_scan(network: MakeNetwork) -> None:
    net = network(LaserSettings(upside_down=True, ignore=((-45.0, 0.0),)))
    net.connect()
    net.run_until(STREAMING, 2.0)
    net.run(0.2)
    scan = net.scans[-1]
    assert scan.clockwise
    assert scan.ranges[0] == pytest.approx(5.0, abs=0.001)
    assert (scan.specials[-91:] == Special.IGNORED).all()
    assert not (scan.specials[:-91] == Special.IGNORED).any()


def test_it_stops_the_stream_at_its_end(network: MakeNetwork) -> None:
    net = network()
    net.connect()
    net.run_until(STREAMING, 2.0)
    net.session.shut_down(net.t)
    net.run(0.1)
    assert net.session.state is SessionState.DOWN
    assert net.commands[-1] == telegrams.STREAM
    assert net.emulator.pop_output(net.t + 1.0) == []


@given(
    data=st.lists(st.binary(max_size=40), max_size=10),
    states=st.integers(0, 12),
)
def test_any_bytes_in_never_an_exception_out(data: list[bytes], states: int) -> None:
    session = Lms1xxSession(LaserSettings())
    emulator = Lms1xxEmulator(scan_source=ramp)
    session.link_up(0.0)
    t = 0.0
    for _ in range(states):
        for request in session.pop_requests():
            emulator.feed(request.data, t)
        t += 0.01
        for item in emulator.pop_output(t):
            session.feed(item.data, item.t)
    for piece in data:
        t += 0.3
        session.feed(piece, t)
        session.tick(t)
        session.pop_requests()
