from __future__ import annotations

import itertools
import math

import pytest

from drivers.p2os.command_numbers import CommandNumber
from drivers.p2os.commands import Command, command, host_baud
from drivers.p2os.config_packet import ConfigPacket, decode_config
from drivers.p2os.emulator.emulator import P2osEmulator
from drivers.p2os.emulator.firmware import Firmware
from drivers.p2os.emulator.make import PIONEER_2DX
from drivers.p2os.framing import PacketFramer, encode_packet
from drivers.p2os.robot_identity import decode_sync_reply
from drivers.p2os.sip import Sip, decode_sip

N = CommandNumber


class Robot:
    """An emulated robot in an ideal world, stepped every 10 ms."""

    def __init__(
        self,
        *,
        baud: int = 9600,
        sip_period: float | None = 0.1,
        firmware: Firmware = Firmware.P2OS,
        clock: float = 1.0,
    ) -> None:
        self.emulator = P2osEmulator(
            PIONEER_2DX, baud=baud, sip_period=sip_period, firmware=firmware, clock=clock
        )
        self.t = 0.0
        self.distance = self.rotation = 0.0
        self.packets: list[tuple[float, bytes]] = []
        self._framer = PacketFramer()

    def send(self, *commands: Command) -> None:
        for one in commands:
            self.emulator.feed(one.encode(), self.t)

    def run(self, seconds: float, refresh: Command | None = None) -> None:
        for step in range(round(seconds / 0.01)):
            self.t = round(self.t + 0.01, 6)
            distance, rotation = self.emulator.advance(self.t)
            self.emulator.turn_odometer(distance, rotation)
            self.distance += distance
            self.rotation += rotation
            if refresh is not None and step % 50 == 0:
                self.send(refresh)
            for sent in self.emulator.pop_output(self.t):
                self.packets += [(sent.t, packet) for packet in self._framer.feed(sent.data)]

    def open(self, *, motors: bool = True) -> Robot:
        self.send(Command(0), Command(1), Command(2), Command(1, 1))
        if motors:
            self.send(command(N.ENABLE, 1))
        self.run(0.3)
        return self

    @property
    def sips(self) -> list[Sip]:
        found = (decode_sip(packet) for _, packet in self.packets)
        return [sip for sip in found if sip is not None]


PULSE = Command(0)


def test_handshake_gets_its_replies() -> None:
    robot = Robot()
    robot.emulator.feed(b"WMS2\r", 0.0)
    robot.send(Command(0), Command(1), Command(2))
    robot.run(0.3)
    replies = [packet for _, packet in robot.packets]
    assert replies[:2] == [b"\x00", b"\x01"]
    identity = decode_sync_reply(replies[2])
    assert identity is not None
    assert (identity.name, identity.robot_class, identity.subclass) == (
        "Emulated",
        "Pioneer",
        "p2dx",
    )
    assert not robot.sips


@pytest.mark.parametrize("wrong", [[1], [2], [0, 2], [0, 1, 1], [0, 1, 2, 2], [0, 1, 2, 29]])
def test_sync_out_of_order_starts_over(wrong: list[int]) -> None:
    robot = Robot()
    robot.send(*map(Command, wrong))
    robot.run(0.2)
    replies = len(robot.packets)
    robot.send(Command(1))
    robot.run(0.2)
    assert len(robot.packets) == replies
    robot.open()
    assert robot.sips


@pytest.mark.parametrize("argument", [None, 1])
def test_open_and_close_are_accepted_with_or_without_argument(argument: int | None) -> None:
    robot = Robot()
    for session in (1, 2):
        robot.send(Command(0), Command(1), Command(2), Command(1, argument))
        robot.send(command(N.ENABLE, 1), command(N.VEL, 300))
        robot.run(1.0)
        assert robot.emulator.counters.sessions == session
        assert robot.emulator.velocity[0] > 0.2
        robot.send(Command(2, argument))
        robot.run(0.2)
        count = len(robot.packets)
        robot.run(0.5)
        assert len(robot.packets) == count
        assert not robot.emulator.motors_enabled
        assert not robot.emulator.sonar_on
        assert robot.emulator.velocity == (0.0, 0.0)


def test_sips_are_paced_at_the_rate_and_have_p2os_length() -> None:
    robot = Robot().open()
    robot.run(2.0, PULSE)
    times = [t for t, packet in robot.packets if decode_sip(packet)]
    gaps = [b - a for a, b in itertools.pairwise(times)]
    assert all(0.08 < gap < 0.12 for gap in gaps)
    for (t, packet), sip in zip(robot.packets[3:], robot.sips, strict=True):
        assert len(packet) + 5 == 30 + 3 * len(sip.sonar)
        wire_time = (len(packet) + 5) * 10 / 9600
        assert (t - wire_time) % 0.1 == pytest.approx(0.0, abs=1e-6) or (
            t - wire_time
        ) % 0.1 == pytest.approx(0.1, abs=1e-6)


def test_output_never_overlaps_on_the_wire() -> None:
    robot = Robot().open()
    robot.send(*[command(N.CONFIG, 1)] * 4)
    robot.run(1.0, PULSE)
    times = [(t, (len(packet) + 5) * 10 / 9600) for t, packet in robot.packets]
    for (before, _), (after, wire) in itertools.pairwise(times):
        assert after - before >= wire - 1e-9


def test_line_that_is_too_slow_for_all_streams_leaves_packets_out_in_turn() -> None:
    robot = Robot(firmware=Firmware.ARCOS).open()
    for number in (N.ENCODER, N.IOREQUEST, N.JOYINFO, N.GRIPREQUEST, N.BATTERYINFO, N.GYRO):
        robot.send(Command(number, 2))
    robot.run(2.0, PULSE)
    robot.packets.clear()
    robot.run(10.0, PULSE)
    kinds = [packet[0] for _, packet in robot.packets]
    assert sum(kind in (0x32, 0x33) for kind in kinds) == pytest.approx(100, abs=2)
    for kind in (0x90, 0xF0, 0xF8, 0xE0, 0xFA, 0x98):
        assert 10 < kinds.count(kind) < 100, kind
    last = max(t for t, _ in robot.packets)
    assert last <= robot.t
    robot.send(Command(2))
    robot.packets.clear()
    robot.run(1.0)
    assert len(robot.packets) < 8, "nothing had piled up"


def test_sonar_fires_one_transducer_per_ring_every_40_ms() -> None:
    robot = Robot().open()
    robot.emulator.set_sonar([0.1 * (n + 1) for n in range(15)] + [math.inf])
    robot.packets.clear()
    robot.run(3.2, PULSE)
    numbers = [number for sip in robot.sips for number, _ in sip.sonar]
    front = [n for n in numbers if n < 8]
    assert len(front) == pytest.approx(3.2 / 0.04, abs=3)
    assert all((b - a) % 8 == 1 for a, b in itertools.pairwise(front))
    assert [n + 8 for n in front] == [n for n in numbers if n >= 8]
    assert {len(sip.sonar) for sip in robot.sips} == {4, 6}
    ranges = dict(reading for sip in robot.sips for reading in sip.sonar)
    assert ranges[4] == round(0.5 / 0.000268)
    assert ranges[15] == 18657
    robot.send(command(N.SONAR, 0))
    robot.run(0.2)
    robot.packets.clear()
    robot.run(0.5, PULSE)
    assert all(not sip.sonar and not sip.sonar_on for sip in robot.sips)


@pytest.mark.parametrize("nul", [b"", b"\0"])
def test_polling_sets_the_firing_order(nul: bytes) -> None:
    robot = Robot().open()
    robot.send(Command(N.POLLING, bytes((1, 3)), nul))
    robot.packets.clear()
    robot.run(1.0, PULSE)
    numbers = [number for sip in robot.sips[1:] for number, _ in sip.sonar]
    assert set(numbers) == {0, 2}


def test_motion_is_ignored_with_motors_off() -> None:
    robot = Robot().open(motors=False)
    robot.send(command(N.VEL, 300), command(N.RVEL, 20))
    robot.run(0.5)
    robot.send(command(N.ENABLE, 1))
    robot.run(0.5)
    assert (robot.distance, robot.rotation) == (0.0, 0.0)
    assert robot.emulator.motion_refused == 2
    assert robot.sips[0].motors_enabled is False
    assert robot.sips[-1].motors_enabled is True


def test_trapezoid_follows_the_limits() -> None:
    robot = Robot().open()
    robot.send(command(N.SETA, 200), command(N.SETA, -400), command(N.VEL, 300))
    robot.run(1.0)
    assert robot.emulator.velocity[0] == pytest.approx(0.2)
    assert robot.distance == pytest.approx(0.1)
    robot.run(1.0)
    assert robot.emulator.velocity[0] == 0.3
    robot.send(command(N.VEL, -100))
    robot.run(0.75)
    assert robot.emulator.velocity[0] == pytest.approx(0.0, abs=1e-9)
    robot.run(0.5)
    assert robot.emulator.velocity[0] == pytest.approx(-0.1)
    robot.send(command(N.SETRA, 50), command(N.SETRA, -200), command(N.RVEL, -20))
    robot.run(0.2)
    assert robot.emulator.velocity[1] == pytest.approx(math.radians(-10))
    robot.run(0.3)
    robot.send(command(N.RVEL, 0))
    robot.run(0.1)
    assert robot.emulator.velocity[1] == 0.0


def test_setv_limits_later_commands() -> None:
    robot = Robot().open()
    robot.send(command(N.SETV, 150), command(N.SETRV, 10), command(N.VEL, 300))
    robot.send(command(N.RVEL, 50))
    robot.run(1.5)
    assert robot.emulator.velocity == pytest.approx((0.15, math.radians(10)))


def test_watchdog_stops_motion_and_a_pulse_resumes_it() -> None:
    robot = Robot().open()
    robot.send(command(N.VEL, 300))
    robot.run(1.99)
    assert robot.emulator.velocity[0] == 0.3
    assert robot.emulator.motion_permitted
    robot.run(0.02)
    assert robot.emulator.watchdog_expired
    assert not robot.emulator.motion_permitted
    robot.run(1.0)
    assert robot.emulator.velocity == (0.0, 0.0)
    robot.send(PULSE)
    robot.run(1.1)
    assert robot.emulator.velocity[0] == pytest.approx(0.3)


def test_stop_ramps_down_and_e_stop_stops_at_once() -> None:
    robot = Robot().open()
    robot.send(command(N.VEL, 300))
    robot.run(1.5)
    robot.send(Command(N.STOP))
    robot.run(0.5)
    assert robot.emulator.velocity[0] == pytest.approx(0.15)
    robot.send(command(N.VEL, 300))
    robot.run(1.5)
    robot.send(Command(N.E_STOP))
    assert robot.emulator.velocity == (0.0, 0.0)
    robot.run(0.5)
    assert robot.emulator.velocity == (0.0, 0.0)
    robot.send(command(N.VEL, 300))
    robot.run(0.5)
    assert robot.emulator.velocity[0] > 0.1


@pytest.mark.parametrize("distance", [500, -300])
def test_move_travels_its_distance(distance: int) -> None:
    robot = Robot().open()
    robot.send(command(N.SETV, 400), command(N.MOVE, distance))
    robot.run(6.0, PULSE)
    assert robot.distance == pytest.approx(distance / 1000, abs=0.003)
    assert robot.emulator.velocity[0] == pytest.approx(0.0, abs=1e-3)


def test_head_and_dhead_turn_the_shorter_way() -> None:
    robot = Robot().open()
    robot.send(command(N.HEAD, 270))
    robot.run(5.0, PULSE)
    assert math.degrees(robot.rotation) == pytest.approx(-90, abs=0.2)
    assert robot.sips[-1].heading_counts == pytest.approx(-1024, abs=2)
    assert robot.sips[-1].control_counts == -1024
    robot.send(command(N.DHEAD, 120))
    robot.run(5.0, PULSE)
    assert math.degrees(robot.rotation) == pytest.approx(30, abs=0.2)


def test_vel2_sets_wheels_until_the_next_command() -> None:
    robot = Robot().open()
    robot.send(Command(N.VEL2, -0x02FD))  # left -60, right +60 mm/s by sign and magnitude
    robot.run(1.0)
    sip = robot.sips[-1]
    assert (sip.left_speed_counts, sip.right_speed_counts) == (-60, 60)
    assert robot.emulator.velocity == pytest.approx((0.0, 0.06 * 5.6))
    robot.send(Command(N.VEL2, 0x0A05))
    robot.run(2.0, PULSE)
    sip = robot.sips[-1]
    assert (sip.left_speed_counts, sip.right_speed_counts) == (200, 100)
    robot.send(command(N.VEL, 100))
    robot.run(2.0, PULSE)
    assert robot.emulator.velocity == pytest.approx((0.1, 0.0))


def test_sip_type_depends_on_motion() -> None:
    robot = Robot().open()
    assert robot.sips[-1].packet_type == 0x32
    robot.send(command(N.VEL, 100))
    robot.run(1.0)
    assert robot.sips[-1].packet_type == 0x33


def test_position_wraps_at_15_bits_and_heading_at_4096() -> None:
    robot = Robot().open()
    robot.emulator.set_odometry(32768 * 0.00084, -0.00084, math.tau * 0.75)
    robot.run(0.3, PULSE)
    sip = robot.sips[-1]
    assert (sip.x_counts, sip.y_counts, sip.heading_counts) == (0, 32767, -1024)
    robot.emulator.set_odometry(0.0, 0.0, math.pi)
    robot.run(0.3)
    assert robot.sips[-1].heading_counts == -2048


@pytest.mark.parametrize("data", [b"\x07", b"\x07\x3b"])
def test_seto_is_accepted_with_or_without_argument_type(data: bytes) -> None:
    robot = Robot().open()
    robot.emulator.set_odometry(1.0, 2.0, 0.5)
    robot.emulator.feed(encode_packet(data), robot.t)
    robot.run(0.2)
    sip = robot.sips[-1]
    assert (sip.x_counts, sip.y_counts, sip.heading_counts) == (0, 0, 0)


@pytest.mark.parametrize("argument", [None, 1])
def test_config_contains_the_limits_in_force(argument: int | None) -> None:
    robot = Robot().open()
    robot.send(command(N.SETV, 400), command(N.SETA, -500), Command(N.CONFIG, argument))
    robot.run(0.5)
    (config,) = [c for _, p in robot.packets if (c := decode_config(p)) is not None]
    assert isinstance(config, ConfigPacket)
    assert (config.robot_class, config.subclass, config.watchdog_ms) == ("Pioneer", "p2dx", 2000)
    assert (config.speed_max, config.acceleration, config.deceleration) == (400, 300, 500)
    assert config.autobaud == 2


def test_host_baud_holds_until_close() -> None:
    robot = Robot().open()
    robot.send(host_baud(38400))
    assert robot.emulator.baud == 38400
    robot.packets.clear()
    robot.run(1.0)
    (t, packet) = robot.packets[-1]
    assert (round(t - (len(packet) + 5) * 10 / 38400, 6) * 10) % 1 == pytest.approx(0.0, abs=1e-4)
    robot.send(Command(2, 1))
    assert robot.emulator.baud == 9600


def test_battery_is_reported() -> None:
    robot = Robot().open()
    robot.emulator.battery.volts = 11.7
    robot.run(0.3)
    assert robot.sips[-1].battery_decivolts == 117


def test_battest_pretends_a_voltage_and_0_gives_back_the_real_battery() -> None:
    robot = Robot().open()
    robot.send(command(N.BATTEST, 105))
    robot.run(0.3)
    assert robot.sips[-1].battery_decivolts == 105
    robot.send(command(N.BATTEST, 0))
    robot.run(0.3)
    assert robot.sips[-1].battery_decivolts == 130


def test_stall_cuts_the_power_temporarily() -> None:
    robot = Robot().open()
    robot.send(command(N.VEL, 300))
    robot.run(1.0)
    robot.emulator.set_contact(stalled=True, front_bumpers=0, rear_bumpers=0)
    assert robot.emulator.velocity == (0.0, 0.0)
    robot.emulator.set_contact(stalled=False, front_bumpers=0b10001, rear_bumpers=0b100)
    robot.run(0.09)
    assert robot.emulator.velocity == (0.0, 0.0)
    robot.run(0.2)
    assert robot.emulator.velocity[0] > 0.0
    stalled = [s for s in robot.sips if s.left_stall_byte & 1]
    assert 1 <= len(stalled) <= 2
    assert stalled[0].right_stall_byte & 1
    assert robot.sips[-1].left_stall_byte == 0b100 << 1
    assert robot.sips[-1].right_stall_byte == 0b10001 << 1


def test_bumpers_block_only_their_direction_when_configured() -> None:
    robot = Robot().open()
    robot.send(command(N.BUMP_STALL, 3), command(N.VEL, 200))
    robot.run(0.5)
    robot.emulator.set_contact(stalled=False, front_bumpers=1, rear_bumpers=0)
    robot.run(0.5)
    assert robot.emulator.velocity[0] == 0.0
    assert robot.sips[-1].left_stall_byte & robot.sips[-1].right_stall_byte & 1
    robot.send(command(N.VEL, -200))
    robot.run(0.5)
    assert robot.emulator.velocity[0] < -0.1


def test_unknown_commands_are_counted_and_ignored() -> None:
    robot = Robot().open()
    robot.send(Command(62, 1), Command(20, 1), Command(255))
    assert robot.emulator.counters.unknown_commands == 3
    robot.run(0.3)
    assert robot.emulator.session_open


def test_playback_sends_sips_on_demand() -> None:
    robot = Robot(sip_period=None).open()
    robot.run(0.5, PULSE)
    assert not robot.sips
    robot.emulator.set_odometry(0.84, 0.0, 0.0)
    robot.emulator.emit_sip(robot.t)
    robot.run(0.1)
    assert [sip.x_counts for sip in robot.sips] == [1000]


def test_controller_with_a_fast_clock_reports_oftener_and_drives_faster_than_it_says() -> None:
    robot = Robot(clock=1.1).open()
    robot.send(command(N.VEL, 200))
    robot.run(2.0, PULSE)
    before, reports = robot.distance, len(robot.packets)
    robot.run(5.0, PULSE)
    assert robot.distance - before == pytest.approx(1.1 * 5.0 * 0.2, abs=0.01)
    assert len(robot.packets) - reports == pytest.approx(55, abs=1)
    assert robot.sips[-1].left_speed_counts == pytest.approx(200, abs=2)
    assert all(0.0 < sent <= robot.t for sent, _ in robot.packets)


def test_closed_robot_sends_no_sip() -> None:
    robot = Robot()
    robot.emulator.emit_sip(0.0)
    robot.run(0.5)
    assert robot.packets == []
