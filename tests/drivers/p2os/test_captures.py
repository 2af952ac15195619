"""Traffic of an independent client and an independent simulator against session and emulator."""

from __future__ import annotations

import itertools
import math
from collections.abc import Callable
from random import Random
from typing import TYPE_CHECKING

import pytest
from hypothesis import HealthCheck, given, settings
from hypothesis import strategies as st

from drivers.p2os.base_state import BaseState
from drivers.p2os.commands import decode_command
from drivers.p2os.config_packet import decode_config
from drivers.p2os.emulator.emulator import P2osEmulator
from drivers.p2os.emulator.make import PIONEER_2DX
from drivers.p2os.framing import PacketFramer, encode_packet
from drivers.p2os.robot_identity import decode_sync_reply
from drivers.p2os.session import P2osSession, SessionState
from drivers.p2os.settings import BaseSettings
from drivers.p2os.sip import decode_sip

if TYPE_CHECKING:
    from conftest import Capture

HOST, ROBOT = "host->robot", "robot->host"


def kinds(packets: list[bytes]) -> list[str]:
    """Names of a robot's packets, with SIPs in a row counted once."""
    names: list[str] = []
    for packet in packets:
        name = "SIP" if decode_sip(packet) is not None else f"{packet[0]:02x}"
        if name != "SIP" or names[-1:] != ["SIP"]:
            names.append(name)
    return names


def test_every_byte_decodes_and_re_encodes(capture: Capture) -> None:
    for direction, junk in ((HOST, b"WMS2\r"), (ROBOT, b"")):
        framer = PacketFramer()
        stream = b"".join(data for _, data in capture.side(direction))
        packets = framer.feed(stream)
        assert framer.counters.bad_checksum == framer.pending == 0
        assert framer.counters.discarded_bytes == len(junk) * stream.startswith(junk)
        for packet in packets:
            assert re_encoded(direction, packet) == encode_packet(packet)


def test_every_byte_of_a_rate_searching_client_decodes_and_re_encodes(
    read_capture: Callable[[str], Capture],
) -> None:
    stream = b"".join(data for _, data in read_capture("client-silent-robot").side(HOST))
    framer = PacketFramer()
    packets = framer.feed(stream)
    assert b"WMS2\r" + b"".join(re_encoded(HOST, packet) for packet in packets) == stream


def re_encoded(direction: str, packet: bytes) -> bytes:
    if direction == HOST:
        return decode_command(packet).encode()
    if packet in (b"\x00", b"\x01"):
        return encode_packet(packet)
    decoded = decode_sip(packet) or decode_config(packet) or decode_sync_reply(packet)
    assert decoded is not None
    return encode_packet(decoded.encode())


def replay_robot(capture: Capture) -> tuple[P2osSession, list[BaseState]]:
    session = P2osSession(BaseSettings())
    session.link_up(0.0)
    states: list[BaseState] = []
    ticks = 0
    for t, data in capture.side(ROBOT):
        while ticks * 0.05 < t:
            session.tick(ticks * 0.05)
            ticks += 1
        states += session.feed(data, t)
        session.pop_requests()
    return session, states


def test_session_decodes_the_simulators_packets(capture: Capture) -> None:
    session, states = replay_robot(capture)
    assert session.state is SessionState.READY
    assert session.identity is not None
    assert (session.identity.name, session.identity.subclass) == ("AMRISim", "p2dx")
    assert session.config is not None
    assert (session.config.speed_max, session.config.autobaud) == (3000, 2)
    assert session.config.surplus == b""
    assert states[-1].battery == pytest.approx(13.0)
    assert all(b.t > a.t for a, b in itertools.pairwise(states))


def test_session_reaches_the_recorded_pose(capture: Capture) -> None:
    _, states = replay_robot(capture)
    final = states[-1]
    if len(states) < 300:
        expected = (0x0476 * 0.00084, 0x0002 * 0.00084, math.tau * 0x0293 / 4096)
        assert (final.x, final.y, final.theta) == pytest.approx(expected, abs=1e-9)
    else:
        assert len(states) == 378
        assert (final.x, final.y) == pytest.approx((1.672, -0.555), abs=0.001)
        # The client that printed -92.7 uses 0.00153 rad per count, 0.3 % less than 2 pi / 4096.
        assert math.degrees(final.theta) == pytest.approx(-92.7, abs=0.35)
        assert math.degrees(final.theta) * 0.00153 * 4096 / math.tau == pytest.approx(
            -92.7, abs=0.1
        )


def test_session_reaches_every_recorded_intermediate_pose(capture: Capture) -> None:
    """The simulator starts at the origin and counts in 16 bits, so its counters are the pose."""
    packets = PacketFramer().feed(b"".join(data for _, data in capture.side(ROBOT)))
    sips = [sip for packet in packets if (sip := decode_sip(packet)) is not None]
    _, states = replay_robot(capture)
    assert len(states) == len(sips)
    for sip, state in zip(sips, states, strict=True):
        x, y = ((count + 0x8000) % 0x10000 - 0x8000 for count in (sip.x_counts, sip.y_counts))
        assert (state.x, state.y) == pytest.approx((0.00084 * x, 0.00084 * y), abs=1e-9)
        turned = math.remainder(state.theta - math.tau * sip.heading_counts / 4096, math.tau)
        assert turned == pytest.approx(0.0, abs=1e-9)
        assert (state.v_left, state.v_right) == pytest.approx(
            (0.001 * sip.left_speed_counts, 0.001 * sip.right_speed_counts)
        )
        assert state.sonar == tuple((n, pytest.approx(0.000268 * c)) for n, c in sip.sonar)


def test_emulator_answers_the_client_like_the_simulator(capture: Capture) -> None:
    emulator = P2osEmulator(PIONEER_2DX, name="AMRISim")
    framer, packets = PacketFramer(), list[bytes]()
    now = 0.0
    for t, data in capture.side(HOST):
        while now < t:
            now = min(now + 0.01, t)
            emulator.turn_odometer(*emulator.advance(now))
            packets += [p for sent in emulator.pop_output(now) for p in framer.feed(sent.data)]
        emulator.feed(data, t)
    recorded = PacketFramer().feed(b"".join(data for _, data in capture.side(ROBOT)))
    assert kinds(packets) == kinds(recorded)
    assert kinds(packets)[:5] == ["00", "01", "02", "20", "SIP"]
    assert packets[2] == recorded[2]
    assert len(packets) == pytest.approx(len(recorded), abs=3)
    assert not emulator.session_open
    assert not emulator.motors_enabled
    assert emulator.baud == 9600
    assert emulator.framer.counters.bad_checksum == 0
    ours, theirs = decode_sip(packets[-1]), decode_sip(recorded[-1])
    assert ours is not None
    assert theirs is not None
    assert ours.left_speed_counts == ours.right_speed_counts == 0
    # Same commands, near the same path: the simulator adds odometry noise of its own.
    assert math.hypot(
        (ours.x_counts - theirs.x_counts + 0x4000) % 0x8000 - 0x4000,
        (ours.y_counts - theirs.y_counts + 0x4000) % 0x8000 - 0x4000,
    ) * 0.00084 == pytest.approx(0.0, abs=0.35)


@settings(
    max_examples=30,
    suppress_health_check=[HealthCheck.function_scoped_fixture, HealthCheck.too_slow],
)
@given(st.randoms(use_true_random=False))
def test_damaged_traffic_raises_nothing_at_either_end(
    read_capture: Callable[[str], Capture], dice: Random
) -> None:
    session, emulator = P2osSession(BaseSettings()), P2osEmulator(PIONEER_2DX)
    session.link_up(0.0)
    for line in read_capture("client-sim-serial").lines:
        t, data = line["t"], bytearray.fromhex(line["hex"])
        for _ in range(dice.choice((0, 0, 1, 3))):
            data[dice.randrange(len(data))] = dice.randrange(256)
        if dice.random() < 0.1:
            del data[dice.randrange(len(data))]
        if line["dir"] == HOST:
            emulator.feed(bytes(data), t)
            emulator.turn_odometer(*emulator.advance(t))
            emulator.pop_output(t)
        else:
            for state in session.feed(bytes(data), t):
                session.drive(t, state.x, state.theta)
        session.tick(t)
        session.enable_motors(t)
    session.shut_down(20.0)
    assert session.state is SessionState.DOWN
    assert emulator.framer.counters.bad_checksum + emulator.framer.counters.discarded_bytes > 0


@given(st.lists(st.binary(min_size=1, max_size=30), max_size=40), st.booleans())
def test_any_packets_raise_nothing_at_either_end(packets: list[bytes], opened: bool) -> None:
    session, emulator = P2osSession(BaseSettings()), P2osEmulator(PIONEER_2DX)
    session.link_up(0.0)
    if opened:
        for reply in (b"\x00", b"\x01", b"\x02a\0b\0c\0"):
            session.feed(encode_packet(reply), 0.0)
        for request in (b"\x00", b"\x01", b"\x02", b"\x01", b"\x04\x3b\x01\x00"):
            emulator.feed(encode_packet(request), 0.0)
    for number, packet in enumerate(packets):
        t = 0.05 * number
        session.feed(encode_packet(packet), t)
        session.tick(t)
        emulator.feed(encode_packet(packet), t)
        emulator.turn_odometer(*emulator.advance(t))
        emulator.pop_output(t)
    assert (session.identity is not None) >= opened
    assert (emulator.counters.sessions > 0) >= opened


def test_emulator_answers_a_rate_searching_client(
    read_capture: Callable[[str], Capture],
) -> None:
    emulator = P2osEmulator(PIONEER_2DX)
    for t, data in read_capture("client-silent-robot").side(HOST):
        emulator.feed(data, t)
    replies = PacketFramer().feed(b"".join(sent.data for sent in emulator.pop_output(10.0)))
    # To a controller that awaits SYNC1 the client's OPEN is one.
    assert set(replies) == {b"\x00", b"\x01"}
    assert not emulator.session_open
