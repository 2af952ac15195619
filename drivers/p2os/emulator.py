"""A P2OS controller for benches and tests: what a real one answers, does and reports.

Where manuals and clients differ it satisfies both: OPEN, CLOSE and CONFIG with or without their
integer, SETO with a dangling argument type, strings with or without NUL, junk between packets.
"""

from __future__ import annotations

import math
from collections.abc import Callable, Sequence
from dataclasses import dataclass

from drivers.p2os.commands import HOST_BAUDS, Command, CommandNumber, decode_command
from drivers.p2os.emulated_config import STALL_PAUSE, WATCHDOG, emulated_config
from drivers.p2os.framing import CONTROLLER_MAX_COUNT, PacketFramer, encode_packet
from drivers.p2os.model import RobotModel
from drivers.p2os.motion_controller import MotionController
from drivers.p2os.odometer import RADIANS_PER_COUNT
from drivers.p2os.paced_output import PacedOutput
from drivers.p2os.packets import RobotIdentity, Sip, SipTail
from drivers.p2os.sip import COUNTS_PER_TURN, MOTORS_FLAG, POSITION_MASK, SIP_MOVING, SIP_STOPPED
from drivers.p2os.sonar_firing import SonarFiring
from drivers.timed_bytes import TimedBytes

MOTION_CYCLE = 0.010  # s
PACKET_GAP = 0.1  # s without a byte that ends an unfinished packet
SONAR_FLAG = 0x0002
P2OS_TAIL = SipTail(analog_port=5, gripper_state=0, analog=0, digital_in=0xFF, digital_out=0)
AWAITING_OPEN = 3  # behind SYNC0, SYNC1, SYNC2


@dataclass(slots=True)
class EmulatorCounters:
    """What clients sent besides commands obeyed."""

    sessions: int = 0
    commands: int = 0
    unknown_commands: int = 0
    motion_refused: int = 0  # motion commands while the motors were off


class P2osEmulator:
    """One robot base. The world turns its wheels' motion into odometry and contacts.

    Each step of a world: ``advance(t)``, move the body, ``turn_odometer``, ``set_contact`` and
    ``set_sonar``, then ``take_output(t)``; bytes from the client go in through ``feed`` at any
    time between. ``sip_period`` None leaves the reports to ``emit_sip``.
    """

    def __init__(
        self,
        model: RobotModel,
        *,
        baud: int = 9600,
        name: str = "Emulated",
        sip_period: float | None = 0.1,
    ) -> None:
        self.model = model
        self.baud = baud
        self.identity = RobotIdentity(name, "Pioneer", model.subclass)
        self.battery_decivolts = 130
        self.counters = EmulatorCounters()
        self.framer = PacketFramer(CONTROLLER_MAX_COUNT)
        self.motors_enabled = False
        self.session_open = False
        self._start_baud = baud
        self._sip_period = sip_period
        self._next_sip = math.inf
        self._output = PacedOutput()
        self._controller = MotionController(model)
        self._sonar = SonarFiring(len(model.sonar))
        self._ranges: Sequence[float] = [model.sonar_far] * len(model.sonar)
        self._handlers = self._handler_table()
        self._awaited_sync = 0
        self._x = self._y = self._theta = 0.0  # odometer: m, m, rad
        self._moved = (0.0, 0.0)  # wheel motion not yet fetched: m, rad
        self._t: float | None = None
        self._last_packet = self._last_byte = self._power_back = -math.inf
        self._stalled = False
        self._front_bumpers = self._rear_bumpers = 0
        self._bump_stall = 0

    @property
    def velocity(self) -> tuple[float, float]:
        """Present speed of the wheels as (v m/s, w rad/s)."""
        return self._controller.v, self._controller.w

    @property
    def watchdog_expired(self) -> bool:
        """Whether motion is halted because the client fell silent."""
        return self._t is not None and self._t - self._last_packet >= WATCHDOG - 1e-9

    @property
    def motion_permitted(self) -> bool:
        """Whether setpoints move the wheels now."""
        return self.session_open and self.motors_enabled and not self.watchdog_expired

    @property
    def sonar_on(self) -> bool:
        """Whether the transducers fire."""
        return self._sonar.is_on

    def feed(self, data: bytes, t: float) -> None:
        """Take bytes that arrived from the client by ``t``."""
        self._run_to(t)
        packets = self.framer.abandon_packet() if t - self._last_byte > PACKET_GAP else []
        packets += self.framer.feed(data)
        self._last_byte = t
        for packet in packets:
            self._last_packet = t
            command = decode_command(packet)
            if self.session_open:
                self._obey(command, t)
            else:
                self._shake_hands(command, t)

    def advance(self, t: float) -> tuple[float, float]:
        """Run the controller to ``t``; return the wheels' motion since the last call as
        (distance m, rotation rad)."""
        self._run_to(t)
        moved, self._moved = self._moved, (0.0, 0.0)
        return moved

    def turn_odometer(self, distance: float, rotation: float) -> None:
        """Count what the encoders saw: ``distance`` m along an arc of ``rotation`` rad."""
        middle = self._theta + 0.5 * rotation
        self._x += distance * math.cos(middle)
        self._y += distance * math.sin(middle)
        self._theta += rotation

    def set_odometry(self, x: float, y: float, theta: float) -> None:
        """Impose the odometer (m, m, rad), as when a log is played back."""
        self._x, self._y, self._theta = x, y, theta

    def set_contact(self, *, stalled: bool, front_bumpers: int, rear_bumpers: int) -> None:
        """Say whether the wheels are blocked and which bumper segments are pressed (bit 0 =
        first). A stall cuts the motors' power for STALL_PAUSE."""
        self._stalled = stalled
        self._front_bumpers, self._rear_bumpers = front_bumpers, rear_bumpers
        v = self._controller.v
        bumped = (v > 0.0 and self._front_blocked) or (v < 0.0 and self._rear_blocked)
        if (stalled or bumped) and self._t is not None and self._t >= self._power_back:
            self._power_back = self._t + STALL_PAUSE
            self._controller.halt()

    def set_sonar(self, ranges: Sequence[float]) -> None:
        """Say what each transducer would measure now, m; inf where nothing is heard."""
        self._ranges = ranges

    def take_output(self, t: float) -> list[TimedBytes]:
        """Report if a SIP is due; return everything that has left the wire by ``t``."""
        self._run_to(t)
        if self._sip_period is not None and t >= self._next_sip - 1e-9:
            self.emit_sip(t)
            self._next_sip += self._sip_period
            if self._next_sip <= t:
                self._next_sip = t + self._sip_period
        return self._output.take(t)

    def emit_sip(self, t: float) -> None:
        """Send a SIP now; nothing happens while no session is open."""
        if self.session_open:
            self._send(self._sip(t).encode(), t)

    def _send(self, data: bytes, t: float) -> None:
        self._output.send(encode_packet(data), t, self.baud)

    def _shake_hands(self, command: Command, t: float) -> None:
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
        self.session_open = True
        self.set_odometry(0.0, 0.0, 0.0)
        self._controller = MotionController(self.model)
        self._sonar.start(t)
        self._next_sip = t + (self._sip_period or 0.0)

    def _handler_table(self) -> dict[int, Callable[[Command, float], None]]:
        motion = ("MOVE", "VEL", "RVEL", "HEAD", "DHEAD", "VEL2", "STOP", "E_STOP")
        limits = ("SETV", "SETRV", "SETA", "SETRA")
        return {
            **{CommandNumber[name]: self._obey_motion for name in motion},
            **{CommandNumber[name]: self._set_limit for name in limits},
            CommandNumber.PULSE: self._do_nothing,
            CommandNumber.OPEN: self._do_nothing,
            CommandNumber.CLOSE: self._close,
            CommandNumber.POLLING: self._set_polling,
            CommandNumber.ENABLE: self._enable_motors,
            CommandNumber.SETO: self._zero_odometer,
            CommandNumber.CONFIG: self._send_config,
            CommandNumber.SONAR: self._switch_sonar,
            CommandNumber.BUMP_STALL: self._set_bump_stall,
            CommandNumber.HOSTBAUD: self._change_baud,
        }

    def _obey(self, command: Command, t: float) -> None:
        self.counters.commands += 1
        handler = self._handlers.get(command.number)
        if handler is None:
            self.counters.unknown_commands += 1
        else:
            handler(command, t)

    def _do_nothing(self, command: Command, t: float) -> None:
        """PULSE, and OPEN in an open session: only the watchdog hears them."""

    def _obey_motion(self, command: Command, _t: float) -> None:
        if self.motors_enabled:
            self._controller.obey(command, self._heading())
        else:
            self.counters.motion_refused += 1

    def _set_limit(self, command: Command, _t: float) -> None:
        self._controller.set_limit(command)

    def _enable_motors(self, command: Command, _t: float) -> None:
        self.motors_enabled = command.integer != 0
        if not self.motors_enabled:
            self._controller.drop_setpoints()
            self._controller.halt()

    def _zero_odometer(self, _command: Command, _t: float) -> None:
        self.set_odometry(0.0, 0.0, 0.0)

    def _set_polling(self, command: Command, _t: float) -> None:
        if isinstance(command.argument, bytes):
            self._sonar.set_order([one_based - 1 for one_based in command.argument])

    def _switch_sonar(self, command: Command, t: float) -> None:
        if command.integer & 1:
            self._sonar.start(t)
        else:
            self._sonar.stop()

    def _set_bump_stall(self, command: Command, _t: float) -> None:
        self._bump_stall = command.integer & 3

    def _change_baud(self, command: Command, _t: float) -> None:
        if 0 <= command.integer < len(HOST_BAUDS):
            self.baud = HOST_BAUDS[command.integer]

    def _send_config(self, _command: Command, t: float) -> None:
        config = emulated_config(
            self.identity, self.model, self._controller.limits, baud=self._start_baud
        )
        self._send(config.encode(), t)

    def _close(self, _command: Command, _t: float) -> None:
        self.session_open = False
        self.motors_enabled = False
        self._controller = MotionController(self.model)
        self._sonar.stop()
        self._next_sip = math.inf
        self._awaited_sync = 0
        self._bump_stall = 0
        self.baud = self._start_baud

    def _run_to(self, t: float) -> None:
        if self._t is None:
            self._t = t
        while self._t < t - 1e-9:
            if self._controller.at_rest or not self.motors_enabled:
                self._t = t
                return
            dt = min(MOTION_CYCLE, t - self._t)
            self._run_cycle(self._t, dt)
            self._t += dt

    def _run_cycle(self, t: float, dt: float) -> None:
        if t < self._power_back - 1e-9:
            self._controller.halt()
            return
        distance, rotation = self._controller.run(
            dt,
            self._heading(),
            halted=self.watchdog_expired,
            forward=not self._front_blocked,
            backward=not self._rear_blocked,
        )
        self._moved = (self._moved[0] + distance, self._moved[1] + rotation)

    @property
    def _front_blocked(self) -> bool:
        return bool(self._bump_stall & 1 and self._front_bumpers)

    @property
    def _rear_blocked(self) -> bool:
        return bool(self._bump_stall & 2 and self._rear_bumpers)

    def _heading(self) -> float:
        """Heading as the encoders have it now, rad: the odometer and what is not yet fetched."""
        return self._theta + self._moved[1]

    def _sip(self, t: float) -> Sip:
        conversion = self.model.conversion
        v, w = self.velocity
        wheel_difference = w / conversion.turn
        powerless = self._t is not None and self._t < self._power_back
        stall = self._stalled or powerless or self._front_blocked or self._rear_blocked
        heading = self._heading()
        return Sip(
            packet_type=SIP_MOVING if abs(v) > 1e-3 or abs(w) > 1e-3 else SIP_STOPPED,
            x_counts=round(self._x / conversion.distance) & POSITION_MASK,
            y_counts=round(self._y / conversion.distance) & POSITION_MASK,
            heading_counts=_heading_counts(self._theta),
            left_speed_counts=round((v - wheel_difference) / conversion.speed),
            right_speed_counts=round((v + wheel_difference) / conversion.speed),
            battery_decivolts=self.battery_decivolts,
            left_stall_byte=stall | (self._rear_bumpers & 0x7F) << 1,
            right_stall_byte=stall | (self._front_bumpers & 0x7F) << 1,
            control_counts=_heading_counts(self._controller.heading_setpoint(heading)),
            flags=MOTORS_FLAG * self.motors_enabled | SONAR_FLAG * self.sonar_on,
            compass_2deg=0,
            sonar=self._fresh_sonar(t),
            tail=P2OS_TAIL,
        )

    def _fresh_sonar(self, t: float) -> tuple[tuple[int, int], ...]:
        far, metres_per_count = self.model.sonar_far, self.model.conversion.range
        return tuple(
            (number, round(min(self._ranges[number], far) / metres_per_count))
            for number in self._sonar.take_fired(t)
        )


def _heading_counts(heading: float) -> int:
    """Return a heading in rad as counts from -2048 to 2047."""
    counts = round(math.remainder(heading, math.tau) / RADIANS_PER_COUNT)
    half = COUNTS_PER_TURN // 2
    return (counts + half) % COUNTS_PER_TURN - half
