"""A P2OS controller for benches and tests: replies, motion and reports.

Where manuals and clients differ it accepts both: OPEN, CLOSE and CONFIG with or without their
integer, SETO with an argument type but no argument, strings with or without NUL, noise between
packets.
"""

from __future__ import annotations

import math
from collections.abc import Sequence
from dataclasses import dataclass

from drivers.emulation.timed_bytes import TimedBytes
from drivers.p2os.command_numbers import CommandNumber
from drivers.p2os.commands import HOST_BAUDS, Command, decode_command
from drivers.p2os.emulator.base import FACTORY_WATCHDOG, EmulatedBase
from drivers.p2os.emulator.battery import EmulatedBattery
from drivers.p2os.emulator.board import EmulatedBoard
from drivers.p2os.emulator.command_server import CommandServer
from drivers.p2os.emulator.config_report import emulated_config
from drivers.p2os.emulator.firmware import Firmware
from drivers.p2os.emulator.make import BaseMake
from drivers.p2os.emulator.paced_output import PacedOutput
from drivers.p2os.emulator.reports import sip_report
from drivers.p2os.emulator.requested_packets import RequestedPackets
from drivers.p2os.extended_packets import NOTIFICATION_TYPES, Notification
from drivers.p2os.framing import CONTROLLER_MAX_COUNT, PacketFramer, encode_packet
from drivers.p2os.robot_identity import RobotIdentity

PACKET_GAP = 0.1  # s without a byte that ends an unfinished packet
START_UP_TIME = 1.0  # s after a reset without reception
FACTORY_CYCLE = 0.1  # s from SIP to SIP
MOST_BEHIND = 2
"""Cycles by which the line may be behind for a SIP to be sent still; ours."""
AWAITING_OPEN = 3  # behind SYNC0, SYNC1, SYNC2


@dataclass(slots=True)
class EmulatorCounters:
    """Counts of what clients sent besides executed commands."""

    sessions: int = 0
    commands: int = 0
    unknown_commands: int = 0
    resets: int = 0


class P2osEmulator:
    """One robot base. The simulated world converts its wheel motion to odometry and contacts.

    Each step of the world: ``advance(t)``, move the body, ``turn_odometer``, ``set_contact`` and
    ``set_sonar``, then ``pop_output(t)``; ``feed`` takes bytes from the client at any time.
    ``sip_period`` (s) None leaves the reports to ``emit_sip``. ``firmware`` says how its SIPs and
    its CONFIG look. ``board`` has its auxiliary ports, joystick and pins.
    """

    def __init__(
        self,
        model: BaseMake,
        *,
        baud: int = 9600,
        name: str = "Emulated",
        sip_period: float | None = FACTORY_CYCLE,
        firmware: Firmware = Firmware.P2OS,
        watchdog: float = FACTORY_WATCHDOG,
        clock: float = 1.0,
    ) -> None:
        self.model = model
        self._clock = clock
        self.baud = baud
        self.identity = RobotIdentity(name, "Pioneer", model.subclass)
        self.counters = EmulatorCounters()
        self.framer = PacketFramer(CONTROLLER_MAX_COUNT)
        self.firmware = firmware
        self.base = EmulatedBase(model, watchdog)
        self.base.e_stall = firmware.reports_stop_button
        self.board = EmulatedBoard(model, firmware)
        self._start_baud = baud
        self._sip_period = sip_period
        self._next_sip = math.inf
        self._requested = RequestedPackets(self.base)
        self._starting_until: float | None = None
        self._notifies = False
        self._output = PacedOutput()
        self._server = CommandServer(self.base, self.board)
        self._ranges: Sequence[float] = [model.sonar_far] * model.transducers
        self._awaited_sync = 0
        self._last_byte = -math.inf

    # State of the robot

    @property
    def velocity(self) -> tuple[float, float]:
        """Present speed of the wheels as (v m/s, w rad/s)."""
        return self.base.velocity

    @property
    def watchdog_expired(self) -> bool:
        """Whether motion is halted because the client sent no packet in time."""
        return self.base.watchdog_expired

    @property
    def motion_permitted(self) -> bool:
        """Whether setpoints can move the wheels now."""
        return self.base.motion_permitted

    @property
    def motors_enabled(self) -> bool:
        """Whether the motors have power."""
        return self.base.motors_enabled

    @property
    def session_open(self) -> bool:
        """Whether a client has opened the servers."""
        return self.base.session_open

    @property
    def sonar_on(self) -> bool:
        """Whether the transducers fire."""
        return self.board.sonar.is_on

    @property
    def motion_refused(self) -> int:
        """Number of motion commands that came while the motors were off."""
        return self._server.motion_refused

    @property
    def battery(self) -> EmulatedBattery:
        """The battery, whose voltage may be set."""
        return self.base.battery

    # Called by the world

    def advance(self, t: float) -> tuple[float, float]:
        """Run the controller to ``t``; return the wheels' motion since the last call as
        (distance m, rotation rad)."""
        self.base.run_to(self._clock * t)
        return self.base.pop_motion()

    def turn_odometer(self, distance: float, rotation: float) -> None:
        """Add encoder motion to the odometer: ``distance`` m along an arc of ``rotation`` rad."""
        self.base.turn_odometer(distance, rotation)

    def set_odometry(self, x: float, y: float, theta: float) -> None:
        """Set the odometer (m, m, rad), as when a log is played back."""
        self.base.set_odometry(x, y, theta)

    def set_contact(self, *, stalled: bool, front_bumpers: int, rear_bumpers: int) -> None:
        """Set whether the wheels are blocked and which bumper segments are pressed (bit 0 =
        first)."""
        self.base.set_contact(
            stalled=stalled, front_bumpers=front_bumpers, rear_bumpers=rear_bumpers
        )

    def set_sonar(self, ranges: Sequence[float]) -> None:
        """Set the range each transducer measures now, m; inf for no echo."""
        self._ranges = ranges

    def press_stop_button(self) -> None:
        """Cut the motors' power; ENABLE has no effect until ``release_stop_button``."""
        self.base.press_stop_button()

    def release_stop_button(self) -> None:
        """Allow ENABLE again; the motors stay off."""
        self.base.stop_button_pressed = False

    def press_motors_button(self) -> None:
        """Switch the motors on or off by hand; no effect while no session is open."""
        self.base.enable_motors(on=not self.base.motors_enabled)

    def reset(self, t: float, *, notify: bool = True) -> None:
        """Reset the controller as its RESET button does: the session is lost, motors and sonar
        are off, bytes are ignored for START_UP_TIME. With ``notify`` a notification follows, which
        P2OS does not send."""
        self.counters.resets += 1
        self._close()
        self.board = EmulatedBoard(self.model, self.firmware, self.board.aux)
        self._server.use(self.board)
        self.framer.reset()
        self._output = PacedOutput()
        self._starting_until = self._clock * t + START_UP_TIME
        self._notifies = notify

    # Line

    def feed(self, data: bytes, t: float) -> None:
        """Take bytes that arrived from the client by ``t``."""
        t *= self._clock
        self._run_to(t)
        if self._starting_until is not None:
            return
        packets = self.framer.abandon_packet() if t - self._last_byte > PACKET_GAP else []
        packets += self.framer.feed(data)
        self._last_byte = t
        for packet in packets:
            self.base.heard_at = t
            command = decode_command(packet)
            if self.session_open:
                self._obey(command, t)
            else:
                self._on_handshake(command, t)

    def pop_output(self, t: float) -> list[TimedBytes]:
        """Send reports if a cycle has ended; return everything that has left the wire by ``t``."""
        t *= self._clock
        self._run_to(t)
        if self._sip_period is not None and t >= self._next_sip - 1e-9:
            self._report(t)
            self._next_sip += self._sip_period
            if self._next_sip <= t:
                self._next_sip = t + self._sip_period
        self._send_aux(t)
        sent = self._output.pop(t)
        if self._clock == 1.0:
            return sent
        return [TimedBytes(each.t / self._clock, each.data) for each in sent]

    def emit_sip(self, t: float) -> None:
        """Send a SIP and the requested packets now; no effect while no session is open."""
        self._report(self._clock * t)

    def _report(self, t: float) -> None:
        """Send a SIP and the requested packets at ``t`` of the controller's clock.

        What the line cannot send before the next SIP is left out: at a low rate requested packets
        come seldom, a SIP not at all while others are still being sent.
        """
        if not self.session_open:
            return
        cycle = self._sip_period or FACTORY_CYCLE
        fired = [(n, self._ranges[n]) for n in self.board.sonar.pop_fired(t)]
        sip = encode_packet(sip_report(self.base, self.board, fired).encode())
        if not self._output.has_room(0, t, self.baud, t + MOST_BEHIND * cycle):
            return

        def fits(size: int) -> bool:
            return self._output.has_room(len(sip) + size, t, self.baud, t + cycle)

        before, behind = self._requested.packets(self.board, t, fits)
        for packet in (*before, sip, *behind):
            self._output.send(packet, t, self.baud)

    def _send_aux(self, t: float) -> None:
        """Send the bytes of auxiliary ports that the client has asked for and that are there."""
        for port in self.board.aux.values():
            answer = port.pop_answer()
            if answer is not None:
                self._send(answer.encode(), t)

    def _send(self, data: bytes, t: float) -> None:
        self._output.send(encode_packet(data), t, self.baud)

    def _run_to(self, t: float) -> None:
        self.base.run_to(t)
        if self._starting_until is not None and t >= self._starting_until:
            self._starting_until = None
            if self._notifies:
                self._send(Notification(NOTIFICATION_TYPES[-1]).encode(), t)

    # Session

    def _on_handshake(self, command: Command, t: float) -> None:
        """Answer SYNC0, SYNC1, SYNC2 in order, then OPEN; anything else starts over."""
        if command.number == CommandNumber.SYNC0:
            self._send(bytes((CommandNumber.SYNC0,)), t)
            self._awaited_sync = 1
        elif self._awaited_sync == AWAITING_OPEN and command.number == CommandNumber.OPEN:
            self._open(t)
        elif self._awaited_sync == command.number == CommandNumber.SYNC1:
            self._send(bytes((CommandNumber.SYNC1,)), t)
            self._awaited_sync = 2
        elif self._awaited_sync == command.number == CommandNumber.SYNC2:
            self._send(self.identity.encode(), t)
            self._awaited_sync = AWAITING_OPEN
        else:
            self._awaited_sync = 0

    def _open(self, t: float) -> None:
        self.counters.sessions += 1
        self.base.open_session()
        self.board.sonar.start(t)
        self._next_sip = t + (self._sip_period or 0.0)

    def _close(self) -> None:
        self.base.close_session()
        self.board.end_session()
        self._next_sip = math.inf
        self._awaited_sync = 0
        self.baud = self._start_baud

    # Commands

    def _obey(self, command: Command, t: float) -> None:
        self.counters.commands += 1
        if command.number == CommandNumber.CLOSE:
            self._close()
        elif command.number == CommandNumber.CONFIG:
            self._send_config(t)
        elif command.number == CommandNumber.HOSTBAUD:
            self._change_baud(command)
        elif command.number == CommandNumber.RESET:
            self.reset(t)
        elif not self._server.obey(command, t):
            self.counters.unknown_commands += 1

    def _change_baud(self, command: Command) -> None:
        if 0 <= command.integer < len(HOST_BAUDS):
            self.baud = HOST_BAUDS[command.integer]

    def _send_config(self, t: float) -> None:
        config = emulated_config(self.identity, self.base, self.board, baud=self._start_baud)
        self._send(config.encode(), t)
