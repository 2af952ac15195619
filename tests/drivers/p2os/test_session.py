from __future__ import annotations

import itertools
import math
from collections.abc import Callable, Iterator
from dataclasses import replace
from typing import TYPE_CHECKING

import pytest

from drivers.p2os.base_state import ChargeState
from drivers.p2os.command_numbers import CommandNumber
from drivers.p2os.commands import CLOSE, OPEN, PULSE, STOP, Command, decode_command
from drivers.p2os.config_packet import ConfigPacket
from drivers.p2os.emulator.firmware import Firmware
from drivers.p2os.emulator.make import PIONEER_2DX
from drivers.p2os.framing import PacketFramer, encode_packet
from drivers.p2os.model import load_model, model_names
from drivers.p2os.motor_watch import MotorState
from drivers.p2os.robot_identity import RobotIdentity
from drivers.p2os.session import P2osSession, SessionState
from drivers.p2os.settings import BaseSettings
from drivers.requests import SetBaud, Write

if TYPE_CHECKING:
    from conftest import Bench

N = CommandNumber
MakeBench = Callable[..., "Bench"]
IDLE_SIP = bytes.fromhex(
    "FAFB1B3200000000000000000000800000000000000000050000FF00387F".replace(" ", "")
)


def written(session: P2osSession) -> list[Command]:
    framer = PacketFramer()
    writes = (r.data for r in session.pop_requests() if isinstance(r, Write))
    return [decode_command(packet) for data in writes for packet in framer.feed(data)]


def motion(bench: Bench) -> list[tuple[float, Command]]:
    return [(t, c) for t, c in bench.heard if c.number in (N.VEL, N.RVEL, N.STOP, N.ENABLE)]


def sip(flags: int = 0x0003, left: int = 0, right: int = 0) -> bytes:
    data = bytearray(IDLE_SIP[3:-2])
    data[7:11] = left.to_bytes(2, "little", signed=True) + right.to_bytes(2, "little", signed=True)
    data[16:18] = flags.to_bytes(2, "little")
    return encode_packet(bytes(data))


def opened(subclass: str = "p2dx", **settings: object) -> P2osSession:
    """Return a session after the robot's reply to SYNC2 at t = 0."""
    session = P2osSession(BaseSettings(**settings))  # type: ignore[arg-type]
    session.link_up(0.0)
    for data in (b"\x00", b"\x01", RobotIdentity("R", "Pioneer", subclass).encode()):
        session.feed(encode_packet(data), 0.0)
    assert session.state is SessionState.OPENING
    return session


LIMITS_OF_DEFAULT_SETTINGS = ConfigPacket(
    speed_max=500,
    turn_rate_max=100,
    acceleration=300,
    deceleration=600,
    turn_acceleration=100,
    turn_deceleration=100,
    watchdog_ms=2000,
)


def ready(
    flags: int = 0x0003, config: ConfigPacket = LIMITS_OF_DEFAULT_SETTINGS, **settings: object
) -> P2osSession:
    """Return a READY session at t = 1.0 whose robot answers CONFIG and has reported ``flags``."""
    session = opened(**settings)
    for tick in range(1, 21):
        t = 0.05 * tick
        if any(c.number == N.CONFIG for c in written(session)):
            session.feed(encode_packet(config.encode()), t)
        session.feed(sip(flags), t)
        session.tick(t)
    assert session.state is SessionState.READY
    session.pop_requests()
    return session


def keep_reporting(
    session: P2osSession, start: float, end: float, report: bytes
) -> Iterator[float]:
    """Feed SIPs and ticks at 20 Hz."""
    for step in range(1, round((end - start) * 20) + 1):
        t = start + 0.05 * step
        session.feed(report, t)
        session.tick(t)
        yield t


def test_connects_and_sets_up_before_ready(bench: MakeBench) -> None:
    wire = bench(max_speed=0.4, bump_stall="both")
    wire.connect()
    assert wire.t < 1.5
    assert wire.session.identity == RobotIdentity("Emulated", "Pioneer", "p2dx")
    assert wire.session.config is not None
    assert wire.session.config.subclass == "p2dx"
    wire.run(0.1)
    sent = [(c.number, c.argument) for _, c in wire.heard]
    assert sent == [
        (N.SYNC0, None),
        (N.SYNC1, None),
        (N.SYNC2, None),
        (N.OPEN, 1),
        (N.CONFIG, 1),
        (N.SETV, 400),
        (N.SETRV, 100),
        (N.SETA, 300),
        (N.SETA, -600),
        (N.SETRA, 100),
        (N.SETRA, -100),
        (N.BUMP_STALL, 3),
        (N.SONAR, 1),
        (N.STOP, None),
        (N.VEL, 0),
        (N.RVEL, 0),
        (N.CONFIG, 1),
    ]
    assert wire.session.trouble is None
    assert wire.session.config.speed_max == 400
    assert not wire.emulator.motors_enabled
    assert wire.states[-1].sonar_on


@pytest.mark.parametrize("firmware", list(Firmware))
@pytest.mark.parametrize("name", model_names())
def test_robot_of_each_model_connects_and_all_its_sonars_are_heard(
    bench: MakeBench, name: str, firmware: Firmware
) -> None:
    ring = len(load_model(name).sonar)
    make = replace(PIONEER_2DX, subclass=name, transducers=ring)
    wire = bench(robot_baud=38400, baud=38400, make=make, firmware=firmware)
    wire.connect()
    wire.run(2.0)
    assert wire.session.trouble is None
    assert wire.session.model is load_model(name)
    heard = {number for state in wire.states for number, _ in state.sonar}
    assert heard == set(range(ring))
    assert wire.session.counters.unknown_sonars == 0


def test_setup_is_rate_limited(bench: MakeBench) -> None:
    wire = bench(baud=115200, robot_baud=115200)
    wire.connect()
    times = [t for t, c in wire.heard if c.number in (N.SETV, N.SETA, N.SETRA, N.SONAR)]
    for window in range(round(wire.t / 0.05)):
        start = 0.05 * window
        assert sum(start <= t < start + 0.05 for t in times) <= 2


def test_session_opens_without_config_after_three_requests() -> None:
    session = opened()
    asked = [0.0]
    for t in keep_reporting(session, 0.0, 0.95, sip()):
        asked += [t for c in written(session) if c.number == N.CONFIG and t > 0.1]
    assert len(asked) == 3
    assert asked[1:] == pytest.approx([0.35, 0.70], abs=0.051)
    assert session.state is SessionState.OPENING
    for _ in keep_reporting(session, 0.95, 2.0, sip()):
        pass
    assert session.state is SessionState.READY
    assert session.config is None


@pytest.mark.parametrize(("reported", "used"), [("P3DX", "p3dx"), ("p2de", "p2de")])
def test_model_follows_the_reported_subclass(reported: str, used: str) -> None:
    session = opened(subclass=reported)
    assert session.model.subclass == used
    assert session.identity is not None
    assert session.identity.subclass == reported


@pytest.mark.parametrize(("reported", "model"), [("p9zz", None), ("p3dx", "p2dx")])
def test_robot_without_a_model_of_its_own_is_never_ready(reported: str, model: str | None) -> None:
    session = opened(subclass=reported, model=model)
    for t in keep_reporting(session, 0.0, 4.0, sip()):
        session.drive(t, 0.3, 0.0)
        session.enable_motors(t)
        assert not [c for c in written(session) if c.number == N.ENABLE]
    assert session.state is SessionState.OPENING
    assert session.trouble == session.model_trouble
    assert reported in (session.trouble or "")


def test_old_session_is_stopped_then_closed_then_connected(bench: MakeBench) -> None:
    wire = bench()
    wire.connect()
    wire.enable()
    wire.run(1.5, lambda t: wire.session.drive(t, 0.3, 0.0))
    assert wire.emulator.velocity[0] == pytest.approx(0.3)
    # The agent dies while the robot drives; the watchdog halts it; another agent takes over.
    wire.session = P2osSession(BaseSettings())
    wire.run(5.0)
    assert wire.emulator.watchdog_expired
    assert wire.emulator.velocity == (0.0, 0.0)
    assert wire.emulator.session_open
    path = wire.path
    wire.heard.clear()
    wire.connect()
    numbers = [c.number for _, c in wire.heard]
    assert numbers[:3] == [N.STOP, N.CLOSE, N.SYNC0]
    assert wire.path == path
    assert wire.session.handshake.old_sessions == 1
    assert wire.emulator.counters.sessions == 2


@pytest.mark.parametrize("robot_baud", [19200, 38400, 57600, 115200])
def test_session_finds_the_robots_rate(bench: MakeBench, robot_baud: int) -> None:
    wire = bench(robot_baud=robot_baud)
    wire.connect()
    assert wire.session.baud == wire.baud == robot_baud
    assert wire.t < 7.0


def test_old_session_at_another_rate_falls_back_to_the_start_rate(bench: MakeBench) -> None:
    wire = bench()
    wire.connect()
    wire.emulator.feed(Command(N.HOSTBAUD, 2).encode(), wire.t)
    assert wire.emulator.baud == 38400
    wire.session = P2osSession(BaseSettings())
    wire.run(0.5)
    wire.connect()
    assert wire.session.baud == 9600
    assert wire.emulator.counters.sessions == 2


def test_rates_are_tried_in_order_and_again() -> None:
    session = P2osSession(BaseSettings(baud=38400))
    session.link_up(0.0)
    rates: list[int] = []
    for tick in range(260):
        session.tick(0.05 * tick)
        rates += [r.baud for r in session.pop_requests() if isinstance(r, SetBaud)]
    assert rates[:6] == [38400, 9600, 19200, 115200, 57600, 38400]
    assert rates[6:11] == [9600, 38400, 19200, 38400, 115200]


@pytest.mark.parametrize("reply", [b"\xff", b"\x01", b"\x02"])
def test_handshake_restarts_after_a_pause_on_failure(reply: bytes) -> None:
    session = P2osSession(BaseSettings())
    session.link_up(0.0)
    session.feed(encode_packet(reply), 0.1)
    session.feed(encode_packet(b"\x00"), 0.2)
    session.tick(0.25)
    assert written(session) == []
    session.tick(0.4)
    assert written(session) == [Command(0)]


def test_first_packet_on_a_silent_line_is_sync0_and_comes_after_listening() -> None:
    """Some servers take any other first packet for the end of the handshake."""
    session = P2osSession(BaseSettings())
    session.link_up(0.0)
    session.tick(0.2)
    assert written(session) == []
    session.tick(0.25)
    assert written(session) == [Command(0)]


def test_robot_that_reports_is_stopped_before_anything_else(bench: MakeBench) -> None:
    """The old session's motion, halted by the watchdog, must not resume even briefly."""
    wire = bench()
    wire.connect()
    wire.enable()
    wire.run(1.5, lambda t: wire.session.drive(t, 0.3, 0.0))
    wire.session = P2osSession(BaseSettings())
    wire.run(4.0)
    assert wire.emulator.watchdog_expired
    path = wire.path
    wire.heard.clear()
    wire.connect()
    assert wire.heard[0][1] == STOP
    assert wire.path == path


def test_half_finished_handshake_is_completed(bench: MakeBench) -> None:
    wire = bench()
    for number in range(3):
        wire.emulator.feed(Command(number).encode(), 0.0)
    wire.emulator.pop_output(1.0)
    session = wire.session
    session.link_up(0.0)
    session.pop_requests()
    session.tick(0.3)
    assert written(session) == [Command(0)]
    session.tick(0.8)
    assert written(session) == [OPEN, Command(0)]
    wire.connect()


def test_session_connects_despite_noise(bench: MakeBench) -> None:
    wire = bench()
    wire.session.feed(b"\xfa\xfb\xff", 0.0)
    wire.session.link_up(0.0)
    wire.session.feed(b"WMS2\r\xfa\xfb\xfe\x00", 0.0)
    wire.emulator.feed(b"\xfa\xfb\xc8\x01", 0.0)
    wire.run_until(lambda: wire.session.state is SessionState.READY, 5.0)


def test_motors_stay_off_until_enabled_and_first_motion_is_zero(bench: MakeBench) -> None:
    wire = bench()
    wire.connect()
    wire.heard.clear()
    wire.run(1.0, lambda t: wire.session.drive(t, 0.3, 0.5))
    assert all(c.integer == 0 for _, c in motion(wire))
    assert not wire.emulator.motors_enabled
    wire.heard.clear()
    wire.session.enable_motors(wire.t)
    wire.session.enable_motors(wire.t)
    wire.run(0.15)
    assert [(c.number, c.integer) for _, c in motion(wire)][:3] == [
        (N.VEL, 0),
        (N.RVEL, 0),
        (N.ENABLE, 1),
    ]
    wire.run_until(lambda: wire.states[-1].motors_enabled, 1.0)
    wire.session.enable_motors(wire.t)
    wire.run(1.0)
    assert [c.number for _, c in wire.heard].count(N.ENABLE) == 1


def test_enable_is_sent_again_until_the_sip_shows_it() -> None:
    session = ready(flags=0x0002)
    session.enable_motors(1.0)
    enables = []
    for t in keep_reporting(session, 1.0, 2.2, sip(flags=0x0002)):
        commands = written(session)
        enables += [t for c in commands if c.number == N.ENABLE]
    assert len(enables) == 3
    assert min(b - a for a, b in itertools.pairwise(enables)) >= 0.4
    for _ in keep_reporting(session, 2.2, 3.5, sip(flags=0x0003)):
        assert all(c.number != N.ENABLE for c in written(session))


def test_drive_sends_changes_at_once_and_refreshes() -> None:
    session = ready()
    session.drive(1.0, 0.25, math.radians(-10.0))
    assert written(session) == [Command(N.VEL, 250), Command(N.RVEL, -10)]
    session.drive(1.1, 0.25, math.radians(-10.0))
    assert written(session) == []
    session.drive(1.2, 0.25, math.radians(12.0))
    assert written(session) == [Command(N.RVEL, 12)]
    session.drive(1.25, 0.25, math.radians(12.0))
    assert written(session) == [Command(N.VEL, 250)]
    session.drive(1.3, 9.0, -9.0)
    assert written(session) == [Command(N.RVEL, -100), Command(N.VEL, 500)]


def test_stale_request_becomes_standstill_before_pulses() -> None:
    session = ready()
    session.drive(1.0, 0.3, 0.2)
    session.pop_requests()
    moving = sip(left=300, right=300)
    sent = [(t, c) for t in keep_reporting(session, 1.0, 3.0, moving) for c in written(session)]
    first = [(round(t, 2), c.number, c.integer) for t, c in sent[:2]]
    assert first in ([(1.35, N.VEL, 0), (1.35, N.RVEL, 0)], [(1.3, N.VEL, 0), (1.3, N.RVEL, 0)])
    assert PULSE.number not in [c.number for _, c in sent]
    assert session.counters.stale_requests == 1
    sent = [(t, c) for t in keep_reporting(session, 3.0, 5.0, sip()) for c in written(session)]
    assert {c.number for _, c in sent} == {PULSE.number}
    gaps = [b - a for (a, _), (b, _) in itertools.pairwise(sent)]
    assert max(gaps) < 0.5


def test_idle_session_holds_off_the_watchdog(bench: MakeBench) -> None:
    wire = bench()
    wire.connect()
    wire.run(6.0)
    assert not wire.emulator.watchdog_expired
    assert wire.session.state is SessionState.READY


@pytest.mark.parametrize("wish", [(math.nan, 0.1), (0.1, math.inf), (-math.inf, math.nan)])
def test_request_of_nan_or_inf_is_standstill(wish: tuple[float, float]) -> None:
    session = ready()
    session.drive(1.0, 0.3, 0.1)
    session.pop_requests()
    session.drive(1.1, *wish)
    assert written(session) == [Command(N.VEL, 0), Command(N.RVEL, 0)]


def test_stop_is_sent_first_after_a_frozen_process() -> None:
    session = ready()
    session.drive(1.0, 0.3, 0.0)
    session.pop_requests()
    session.feed(sip(), 3.1)
    session.drive(3.1, 0.2, 0.0)
    assert written(session)[:2] == [STOP, Command(N.VEL, 200)]
    session.drive(3.2, 0.25, 0.0)
    assert written(session)[:1] == [Command(N.VEL, 250)]


def test_stop_sends_all_zeros_at_once() -> None:
    session = ready()
    session.drive(1.0, 0.3, 0.0)
    session.pop_requests()
    session.stop(1.01)
    assert written(session) == [STOP, Command(N.VEL, 0), Command(N.RVEL, 0)]
    session.stop(1.02)
    assert written(session) == []
    session.stop(1.27)
    assert written(session) == [Command(N.VEL, 0), Command(N.RVEL, 0)]


def test_shut_down_leaves_a_closed_robot_standing(bench: MakeBench) -> None:
    wire = bench()
    wire.connect()
    wire.enable()
    wire.run(1.0, lambda t: wire.session.drive(t, 0.3, 0.0))
    wire.session.shut_down(wire.t)
    assert wire.session.state is SessionState.DOWN
    wire.run(0.3)
    assert [c for _, c in wire.heard][-3:] == [STOP, Command(N.ENABLE, 0), CLOSE]
    assert not wire.emulator.session_open
    assert not wire.emulator.motors_enabled
    assert wire.emulator.velocity == (0.0, 0.0)
    wire.session.drive(wire.t, 0.3, 0.0)
    wire.session.shut_down(wire.t)
    assert wire.session.pop_requests() == []


def test_session_that_was_shut_down_is_not_opened_again(bench: MakeBench) -> None:
    wire = bench()
    wire.connect()
    wire.session.shut_down(wire.t)
    assert wire.session.ended
    wire.session.link_down(wire.t)
    wire.session.link_up(wire.t)
    wire.session.pop_requests()
    wire.run(2.0)
    assert wire.session.state is SessionState.DOWN
    assert wire.emulator.counters.sessions == 1
    never_up = P2osSession(BaseSettings())
    never_up.shut_down(0.0)
    never_up.link_up(1.0)
    assert never_up.pop_requests() == []


@pytest.mark.parametrize("phase", [0.04 * step for step in range(13)])
def test_silent_robot_is_found_again_and_stopped_first(bench: MakeBench, phase: float) -> None:
    wire = bench()
    wire.connect()
    wire.enable()
    wire.run(2.0, lambda t: wire.session.drive(t, 0.3, 0.0))
    x = wire.states[-1].x
    wire.cut = True
    wire.run(3.0 + phase, lambda t: wire.session.drive(t, 0.3, 0.0))
    assert wire.session.state is SessionState.SILENT
    assert wire.session.counters.silences == 1
    assert wire.emulator.velocity[0] == pytest.approx(0.0, abs=0.3)
    wire.run_until(lambda: wire.emulator.velocity == (0.0, 0.0), 2.0)
    path = wire.path
    wire.cut = False
    wire.heard.clear()
    back_at = wire.t
    wire.run_until(lambda: wire.session.state is SessionState.READY, 1.0)
    # Should the cable return in the midst of a STOP, only the SYNC0 behind it is whole: the robot
    # takes that for PULSE, and the STOP that answers its next report ends what it resumes.
    stopped_at, _ = next(pair for pair in wire.heard if pair[1] == STOP)
    assert [c for t, c in wire.heard if t < stopped_at] in ([], [Command(0)])
    assert stopped_at - back_at < 0.55
    assert wire.path - path < 0.005
    assert wire.emulator.velocity == (0.0, 0.0)
    assert wire.emulator.counters.sessions == 1
    assert wire.session.counters.resumptions == 1
    assert wire.session.motors is MotorState.ON
    wire.run(1.0)
    assert wire.emulator.velocity == (0.0, 0.0)
    # The distance driven unobserved, until its watchdog, is in its counters.
    assert wire.states[-1].x == pytest.approx(wire.pose.x, abs=0.005)
    assert wire.states[-1].x > x + 0.3


def test_session_recovers_after_link_loss(bench: MakeBench) -> None:
    wire = bench()
    wire.connect()
    wire.enable()
    wire.run(1.0, lambda t: wire.session.drive(t, 0.3, 0.0))
    wire.session.link_down(wire.t)
    assert wire.session.state is SessionState.DOWN
    assert wire.session.pop_requests() == []
    wire.run(0.5, lambda t: wire.session.drive(t, 0.3, 0.0))
    wire.heard.clear()
    wire.connect()
    assert wire.heard[0][1] == STOP


def test_time_measured_is_when_the_sip_left_the_controller() -> None:
    session = ready()
    report = sip()
    (state,) = session.feed(report, 2.0)
    assert state.t == pytest.approx(2.0 - len(report) * 10 / 9600)
    first, second = session.feed(report + report + b"\xfa", 3.0)
    assert second.t == pytest.approx(3.0 - (len(report) + 1) * 10 / 9600)
    assert first.t == pytest.approx(3.0 - (2 * len(report) + 1) * 10 / 9600)


def test_unknown_and_cut_packets_are_counted() -> None:
    session = ready()
    assert session.feed(encode_packet(b"\x77\x01") + encode_packet(b"\x32\x01"), 1.1) == []
    assert session.counters.other_packets == 1
    assert session.counters.cut_packets == 1


def test_drive_and_odometry_agree(bench: MakeBench) -> None:
    wire = bench()
    wire.connect()
    wire.enable()
    wire.run(6.0, lambda t: wire.session.drive(t, 0.3, 0.35))
    assert wire.states[-1].v == pytest.approx(0.3, abs=0.002)
    assert wire.states[-1].w == pytest.approx(math.radians(20.0), abs=0.01)
    wire.run(4.0, lambda t: wire.session.stop(t))
    final = wire.states[-1]
    assert final.standing
    assert (final.x, final.y) == pytest.approx((wire.pose.x, wire.pose.y), abs=0.001)
    assert math.remainder(final.theta - wire.pose.theta, math.tau) == pytest.approx(0.0, abs=0.002)
    assert final.theta == pytest.approx(2.0, abs=0.3)


def test_odometry_is_continuous_over_the_wrap_of_the_counters(bench: MakeBench) -> None:
    wire = bench()
    wire.connect()
    wire.enable()
    wire.run_until(
        lambda: (wire.session.drive(wire.t, 0.5, 0.0), wire.states[-1].x > 30.0)[1], 70.0
    )
    steps = [b.x - a.x for a, b in zip(wire.states, wire.states[1:], strict=False)]
    assert max(steps) < 0.06
    assert min(steps) > -0.001
    assert wire.path > 32768 * 0.00084
    assert wire.states[-1].x == pytest.approx(wire.path, abs=0.05)


def test_odometry_is_continuous_over_a_new_session(bench: MakeBench) -> None:
    wire = bench()
    wire.connect()
    wire.enable()
    wire.run(3.0, lambda t: wire.session.drive(t, 0.3, 0.3))
    wire.run(2.0, lambda t: wire.session.stop(t))
    before = wire.states[-1]
    wire.session.link_down(wire.t)
    wire.connect()
    after = wire.states[-1]
    assert (after.x, after.y, after.theta) == pytest.approx((before.x, before.y, before.theta))
    wire.enable()
    wire.run(2.0, lambda t: wire.session.drive(t, 0.3, 0.0))
    wire.run(2.0, lambda t: wire.session.stop(t))
    final = wire.states[-1]
    assert (final.x, final.y) == pytest.approx((wire.pose.x, wire.pose.y), abs=0.003)


def test_replugged_adapter_finds_the_robot_in_session_and_stops_it_first(bench: MakeBench) -> None:
    wire = bench()
    wire.connect()
    wire.enable()
    wire.run(2.0, lambda t: wire.session.drive(t, 0.3, 0.0))
    wire.session.link_down(wire.t)
    wire.run(1.0)
    assert wire.session.state is SessionState.DOWN
    wire.heard.clear()
    back_at = wire.t
    wire.connect()
    assert wire.heard[0][1] == STOP
    assert wire.heard[0][0] - back_at < 0.2
    assert wire.t - back_at < 1.0
    assert [c.number for _, c in wire.heard].count(N.OPEN) == 0
    assert wire.emulator.counters.sessions == 1
    wire.run(1.0, lambda t: wire.session.stop(t))
    assert wire.emulator.velocity == (0.0, 0.0)
    assert wire.states[-1].x == pytest.approx(wire.pose.x, abs=0.005)


@pytest.mark.parametrize("notify", [True, False])
def test_session_reopens_after_a_controller_reset(bench: MakeBench, notify: bool) -> None:
    wire = bench()
    wire.connect()
    wire.enable()
    wire.run(1.5, lambda t: wire.session.drive(t, 0.3, 0.0))
    x = wire.states[-1].x
    wire.emulator.reset(wire.t, notify=notify)
    wire.heard.clear()
    wire.run_until(lambda: wire.session.state is not SessionState.READY, 2.0)
    wire.run_until(lambda: wire.session.state is SessionState.READY, 5.0)
    assert wire.emulator.counters.sessions == 2
    assert not wire.emulator.motors_enabled
    assert wire.session.motors is MotorState.OFF
    assert wire.states[-1].x == pytest.approx(x, abs=0.05)
    assert all(c.integer == 0 for _, c in motion(wire) if c.number != N.ENABLE)


def test_stop_button_is_reported_and_stays_latched(bench: MakeBench) -> None:
    wire = bench()
    wire.connect()
    wire.enable()
    wire.run(1.0, lambda t: wire.session.drive(t, 0.3, 0.0))
    wire.emulator.press_stop_button()
    wire.heard.clear()

    def insist(t: float) -> None:
        wire.session.enable_motors(t)
        wire.session.drive(t, 0.3, 0.0)

    wire.run(2.0, insist)
    assert wire.session.motors is MotorState.STOP_BUTTON
    assert "press MOTORS" in (wire.session.trouble or "")
    assert N.ENABLE not in [c.number for _, c in wire.heard]
    wire.emulator.release_stop_button()
    wire.emulator.press_motors_button()
    wire.run_until(lambda: wire.session.motors is MotorState.ON, 1.0)
    assert wire.session.trouble is None
    assert wire.emulator.velocity == (0.0, 0.0)


def test_stop_button_of_later_firmware_is_its_own_flag(bench: MakeBench) -> None:
    wire = bench(firmware=Firmware.ARCOS)
    wire.connect()
    wire.enable()
    wire.emulator.press_stop_button()
    wire.run(0.3)
    seen = wire.states[-1]
    assert (seen.stop_button, seen.stall_left, seen.stall_right) == (True, False, False)
    assert wire.session.motors is MotorState.STOP_BUTTON


def test_real_voltage_charge_turn_rate_and_faults_are_decoded(bench: MakeBench) -> None:
    wire = bench(firmware=Firmware.ARCOS, make=replace(PIONEER_2DX, subclass="p3dx-sh"))
    wire.connect()
    wire.enable()
    wire.emulator.battery.charge_state = ChargeState.FLOAT
    wire.emulator.base.fault_flags = 0x2
    wire.run(1.5, lambda t: wire.session.drive(t, 0.0, 0.5))
    seen = wire.states[-1]
    assert seen.battery == pytest.approx(13.0)
    assert (seen.charge_state, seen.charger_power) == (ChargeState.FLOAT, True)
    assert seen.fault_flags == 0x2
    assert seen.turn_rate == pytest.approx(0.5, abs=0.02)


def test_requested_packets_are_streamed_and_kept(bench: MakeBench) -> None:
    wire = bench(baud=38400, robot_baud=38400, firmware=Firmware.ARCOS)
    wire.connect()
    for number in (N.ENCODER, N.IOREQUEST, N.JOYINFO, N.GRIPREQUEST, N.BATTERYINFO, N.GYRO):
        wire.session.request(Command(number, 2))
    wire.emulator.board.aux[2].receive(b"hello")
    wire.session.request(Command(N.GETAUX2, 5))
    wire.enable()
    wire.run(2.0, lambda t: wire.session.drive(t, 0.2, 0.0))
    latest = wire.session.latest
    assert latest.encoder is not None
    assert latest.encoder.left_ticks > 0
    for streamed in (latest.io, latest.joystick, latest.gripper, latest.battery, latest.gyro):
        assert streamed is not None
        assert latest.received_at[type(streamed)] > wire.t - 0.2
    assert latest.aux[2].data == b"hello"
    for reserved in (N.VEL, N.ENABLE, N.HOSTBAUD, N.RESET, N.SETA, N.CLOSE):
        with pytest.raises(ValueError, match="belongs to the session"):
            wire.session.request(Command(reserved, 1))


def test_echoing_port_is_reported() -> None:
    session = P2osSession(BaseSettings())
    session.link_up(0.0)
    for step in range(200):
        t = 0.05 * step
        session.tick(t)
        for request in session.pop_requests():
            if isinstance(request, Write):
                session.feed(request.data, t + 0.01)
    assert session.state is SessionState.SYNCING
    assert "echoes what is sent" in (session.trouble or "")


def test_trouble_without_a_robot_contains_rates_and_last_bytes() -> None:
    session = P2osSession(BaseSettings())
    session.link_up(0.0)
    for step in range(200):
        session.tick(0.05 * step)
    assert "no reply at 9600, 38400, 19200, 115200, 57600 baud" in (session.trouble or "")
    session.link_up(20.0)
    for step in range(200):
        session.feed(b"\x55\xaa", 20.0 + 0.05 * step)
        session.tick(20.0 + 0.05 * step)
    assert "only noise" in (session.trouble or "")
    assert "55 aa" in (session.trouble or "")
