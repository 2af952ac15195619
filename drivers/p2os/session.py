"""A client's session with a P2OS robot base: connect, set up, drive, notice silence, recover.

Sans-I/O: takes bytes and times; ``pop_requests`` returns what the link must do.
"""

from __future__ import annotations

import math
from dataclasses import dataclass
from enum import StrEnum

from drivers.p2os.base_state import BaseState, base_state
from drivers.p2os.command_numbers import RESERVED, CommandNumber
from drivers.p2os.command_outbox import CommandOutbox
from drivers.p2os.commands import CLOSE, OPEN, PULSE, STAND_STILL, STOP, Command, command
from drivers.p2os.config_packet import ConfigPacket
from drivers.p2os.drive_request import DriveRequest
from drivers.p2os.extended_packets import NOTIFICATION_TYPES, Notification
from drivers.p2os.fitted_bumpers import FittedBumpers
from drivers.p2os.framing import OVERHEAD, PacketFramer
from drivers.p2os.handshake import Handshake
from drivers.p2os.latest_packets import LatestPackets
from drivers.p2os.model import RobotModel
from drivers.p2os.model_choice import choose_model, expected_model
from drivers.p2os.motor_watch import MotorState, MotorWatch
from drivers.p2os.odometer import Odometer, in_finest_counts
from drivers.p2os.packets import decode_packet, is_known
from drivers.p2os.robot_identity import RobotIdentity
from drivers.p2os.set_up import SetUp
from drivers.p2os.settings import BaseSettings
from drivers.p2os.sip import Sip, decode_sip
from drivers.p2os.trouble import Trouble, TroubleKind
from drivers.p2os.wheel_correction import WheelCorrection
from drivers.requests import Request

SILENCE_TIMEOUT = 1.0  # s without a SIP
KEEP_ALIVE_PERIOD = 0.4  # s
WATCHDOG_SHARE = 0.25  # keep-alive period as a share of a short watchdog
PACKET_GAP = 0.1  # s without a byte that ends an unfinished packet


class SessionState(StrEnum):
    """State of a session."""

    DOWN = "down"  # no link, or shut down
    SYNCING = "syncing"  # searching for the robot
    OPENING = "opening"  # servers open, setting limits
    READY = "ready"  # takes velocities
    SILENT = "silent"  # was open, no reports; searching for the robot again


SEARCHING = (SessionState.SYNCING, SessionState.SILENT)


@dataclass(slots=True)
class SessionCounters:
    """Counts of a session, besides the framer's counters."""

    sips: int = 0
    other_packets: int = 0  # of an unknown type
    cut_packets: int = 0  # good checksum, but too short for their type
    unknown_sonars: int = 0  # readings of transducers that the model lacks
    old_sessions: int = 0  # packets of another client's session, to which CLOSE was sent
    rate_searches: int = 0  # of every rate, that found no robot
    silences: int = 0
    resumptions: int = 0  # sessions found still open
    controller_resets: int = 0
    unknown_models: int = 0  # robots that reported what no model is known of, or another one
    refused_limits: int = 0  # times the robot kept other limits than those asked for
    stale_requests: int = 0
    commands: int = 0


class P2osSession:
    """The session with one robot base on one link. Call ``pop_requests`` after every other call.

    If after a silence or a new link the robot is still in the session that this object set up, it
    is resumed: STOP and the limits are sent, the servers are not opened again.
    """

    def __init__(self, settings: BaseSettings) -> None:
        self.state = SessionState.DOWN
        self.state_since = -math.inf
        self.ended = False
        """Whether the session was shut down; it is not opened again."""
        self.identity: RobotIdentity | None = None
        self.model: RobotModel = expected_model(settings)
        self.model_trouble: str | None = None
        """Why the model is not known to be the robot's; the session is then never READY."""
        self.latest = LatestPackets()
        self.counters = SessionCounters()
        self.framer = PacketFramer()
        self._settings = settings
        self._requests: list[Request] = []
        self.handshake = Handshake(settings.baud, self._requests)
        self._odometer = Odometer()
        self._wheels = WheelCorrection(settings)
        self._requested = DriveRequest(settings)
        self._outbox = CommandOutbox(self._requests, self._on_sent)
        self._set_up = SetUp(settings, self._outbox)
        self._bumpers = FittedBumpers(self.model.bumper_segments)
        self._motors = MotorWatch()
        self._base: BaseState | None = None
        self._last_byte = self._last_sip = self._t = -math.inf
        self._ours = False
        self._left_open: Sip | None = None  # latest SIP of a session another client left open
        self._search_reason: Trouble | None = None

    @property
    def baud(self) -> int:
        """Present rate of the line."""
        return self.handshake.baud

    @property
    def manner(self) -> str:
        """How it is spoken to, for people."""
        return f"at {self.baud} baud"

    @property
    def config(self) -> ConfigPacket | None:
        """The controller's latest CONFIG of this session; None if it has sent none."""
        return self._set_up.config

    @property
    def odometer_counters(self) -> tuple[int, int, int] | None:
        """The base's x, y and heading counters in the latest SIP; None before the first."""
        return self._odometer.counters

    @property
    def odometer_found(self) -> tuple[int, int, int] | None:
        """The base's counters when it was found, None before; a new session may reset them.

        From the session that another client left open, if there was one, else from the latest SIP.
        """
        left_open = self._left_open
        return self._odometer.counters if left_open is None else self._counters_of(left_open)

    @property
    def watchdog(self) -> float:
        """Time without a packet, s, after which the controller halts the robot."""
        return self._set_up.watchdog

    @property
    def missing_bumpers(self) -> str | None:
        """A line for people with the bumper rings that the robot lacks; None if it lacks none."""
        return None if self._base is None else self._bumpers.missing

    @property
    def motors(self) -> MotorState:
        """State of the motors' power."""
        return self._motors.state

    @property
    def trouble(self) -> str | None:
        """A line for people with the worst trouble and the remedy; None if there is none."""
        return next((trouble.words for trouble in self.troubles), None)

    @property
    def troubles(self) -> list[Trouble]:
        """Everything that is wrong now, the worst first."""
        if self.state is SessionState.DOWN:
            return []
        reasons = [self.handshake.trouble, self._search_reason]
        if self.state not in SEARCHING:
            reasons = [self._model_trouble, self._motors.trouble(self._t), self._set_up.trouble]
        return [reason for reason in reasons if reason is not None]

    @property
    def _model_trouble(self) -> Trouble | None:
        words = self.model_trouble
        return None if words is None else Trouble(TroubleKind.MODEL, words)

    def link_up(self, t: float) -> None:
        """Start the search for the robot: the port is open. No effect after ``shut_down``."""
        if self.ended:
            return
        self._requests.clear()
        self.framer.reset()
        self._search(SessionState.SYNCING, None, t)

    def link_down(self, t: float) -> None:
        """Drop requests and the pending motion: the port is closed."""
        self._requests.clear()
        self._enter(SessionState.DOWN, t)
        self._forget_motion()

    def pop_requests(self) -> list[Request]:
        """Return and clear the requests to the link, in order."""
        requests = self._requests.copy()
        self._requests.clear()
        return requests

    def feed(self, data: bytes, t: float) -> list[BaseState]:
        """Take bytes whose last one arrived at ``t``; return the states of an open session's SIPs,
        each with the time of its measurement."""
        if self.state is SessionState.DOWN or not data:
            return []
        self._t = t
        if self.state in SEARCHING:
            self.handshake.on_bytes(data)
        packets = self.framer.abandon_packet() if t - self._last_byte > PACKET_GAP else []
        packets += self.framer.feed(data)
        self._last_byte = t
        states = []
        behind = self.framer.pending + sum(len(packet) + OVERHEAD for packet in packets)
        for packet in packets:
            # The measurement was taken when the packet's first byte was sent.
            state = self._on_packet(packet, t, t - behind * 10.0 / self.baud)
            behind -= len(packet) + OVERHEAD
            if state is not None:
                states.append(state)
        return states

    def tick(self, t: float) -> None:
        """Handle overdue replies, reports, requests and keep-alives; call 20 times a second."""
        self._t = t
        if self.state in SEARCHING:
            self.handshake.tick(t)
            self.counters.rate_searches = self.handshake.sweeps
        elif self.state is not SessionState.DOWN and t - self._last_sip > SILENCE_TIMEOUT:
            self._go_silent(t)
        elif self.state is SessionState.OPENING:
            self._advance_opening(t)
        elif self.state is SessionState.READY:
            self._keep_ready(t)

    def enable_motors(self, t: float) -> None:
        """Switch the motors on, from standstill; ignored unless READY or when they are on.

        VEL 0, RVEL 0 and ENABLE 1 are repeated until a SIP shows the motors on. Motors that a
        person has switched off stay off.
        """
        if self.state is SessionState.READY and self._motors.may_enable:
            self._queue_enable(t)

    def drive(self, t: float, v: float, w: float) -> None:
        """Request ``v`` m/s and ``w`` rad/s, clamped to the settings; call at least every 0.3 s.

        Ignored unless READY. While the motors are off the request is held at zero, so that the
        robot stands when they come on. Zeros are sent at once, other values as soon as the
        controller can take them.
        """
        if self.state is not SessionState.READY:
            return
        if self.motors is not MotorState.ON:
            v = w = 0.0
        self._requested.set(t, v, w)
        self._send_requested(self._requested.due(t), t)

    def stop(self, t: float) -> None:
        """Send STOP, VEL 0, RVEL 0 at once; at standstill only refresh the zeros."""
        if self.state is not SessionState.READY:
            return
        if self._requested.moving:
            self._outbox.send(STOP, t)
        self._requested.set(t, 0.0, 0.0)
        for zero in self._requested.due(t):
            self._outbox.send(zero, t)

    def request(self, what: Command) -> None:
        """Queue a command that neither moves the robot nor touches its session: ENCODER, IOREQUEST,
        SAY and the like. A new session does not restore streams.

        Raises ValueError for any other; ignored unless READY.
        """
        if what.number in RESERVED:
            raise ValueError(f"command {what.number} belongs to the session: use its methods")
        if self.state is SessionState.READY:
            self._outbox.add(what)

    def shut_down(self, t: float) -> None:
        """Stop the robot, switch its motors off, close the session for good; the state becomes
        DOWN. That the robot closes the connection then is no fault."""
        self.ended = True
        if self.state is SessionState.DOWN:
            return
        for last in (STOP, command(CommandNumber.ENABLE, 0), CLOSE):
            self._outbox.send(last, t)
        self._ours = False
        self._enter(SessionState.DOWN, t)
        self._forget_motion()

    # Packets

    def _on_packet(self, data: bytes, t: float, t_measured: float) -> BaseState | None:
        if self.state is SessionState.SILENT and self._ours and data[0] in NOTIFICATION_TYPES:
            self._restart(t)
            return None
        if self.state in SEARCHING:
            sip = decode_sip(data)
            if not self._ours or sip is None:
                if sip is not None:
                    self._left_open = sip
                self._on_handshake(data, t)
                return None
            self._resume(t)
        packet = decode_packet(data)
        match packet:
            case Sip():
                return self._on_sip(packet, t, t_measured)
            case ConfigPacket():
                self._set_up.on_config(packet)
                self._bumpers.on_config(packet)
            case Notification():
                self._restart(t)
            case None if is_known(data):
                self.counters.cut_packets += 1
            case None:
                self.counters.other_packets += 1
            case _:
                self.latest.update(packet, t)
        return None

    def _on_sip(self, sip: Sip, t: float, t_measured: float) -> BaseState:
        self.counters.sips += 1
        self._last_sip = t
        self._odometer.update(*self._counters_of(sip), self.model.conversion.distance)
        counted = base_state(t_measured, sip, self._odometer, self.model, self._bumpers)
        base = self._wheels.corrected(counted, self.model.conversion.turn)
        self.counters.unknown_sonars += base.unknown_sonars
        self._motors.update(base, commands_pending=not self._outbox.empty)
        self._base = base
        return base

    def _counters_of(self, sip: Sip) -> tuple[int, int, int]:
        """Return the x, y and heading counters of a SIP, the heading in the finest counts."""
        per_turn = self.model.conversion.heading_counts
        return sip.x_counts, sip.y_counts, in_finest_counts(sip.heading_counts, per_turn)

    # Finding the robot

    def _enter(self, state: SessionState, t: float) -> None:
        self.state = state
        self.state_since = t

    def _search(self, state: SessionState, reason: Trouble | None, t: float) -> None:
        self._enter(state, t)
        self._search_reason = reason
        self._forget_motion()
        in_session = self._ours and state is SessionState.SILENT
        self.handshake.start(t, in_session=in_session)

    def _on_handshake(self, data: bytes, t: float) -> None:
        identity = self.handshake.feed(data, t)
        self.counters.old_sessions = self.handshake.old_sessions
        if identity is not None:
            self._open(identity, t)

    def _open(self, identity: RobotIdentity, t: float) -> None:
        """Start the servers and load the model of the robot that answered."""
        self.identity = identity
        self.model, self.model_trouble = choose_model(self._settings, identity.subclass)
        self.latest = LatestPackets()
        self._odometer.forget_reference()
        self._bumpers = FittedBumpers(self.model.bumper_segments)
        self._ours = False
        self.counters.unknown_models += self.model_trouble is not None
        self._begin_opening(OPEN, t)
        self._set_up.limit_to(self.model)
        self._set_up.begin(t, resumed=False)
        self._outbox.flush(t)

    def _resume(self, t: float) -> None:
        """Resume the session in which the robot was found."""
        self.counters.resumptions += 1
        self._begin_opening(STOP, t)
        self._set_up.begin(t, resumed=True)

    def _begin_opening(self, first: Command, t: float) -> None:
        self._enter(SessionState.OPENING, t)
        self._forget_motion()
        self._outbox.restart(t)
        self._last_sip = t
        self._outbox.send(first, t)

    def _go_silent(self, t: float) -> None:
        self.counters.silences += 1
        symptom = "fell silent" if self._base is not None else "answered, but sends no reports"
        name = self.identity.name if self.identity is not None else ""
        words = f"robot {name} {symptom} at {self.baud} baud: robot switched off? cable?"
        self._search(SessionState.SILENT, Trouble(TroubleKind.SILENT, words), t)

    def _restart(self, t: float) -> None:
        """Search again: the controller reports that its session is lost."""
        self.counters.controller_resets += 1
        self._ours = False
        words = "the robot's controller has reset itself: opens a new session"
        self._search(SessionState.SYNCING, Trouble(TroubleKind.RESET, words), t)

    # Setting it up

    def _advance_opening(self, t: float) -> None:
        """Go on with CONFIG, limits, zero motion, limits read back; then READY."""
        prepared = self._set_up.advance(t)
        self._outbox.flush(t)
        self.counters.refused_limits = self._set_up.refusals
        if prepared and self._base is not None and self.model_trouble is None:
            self._ours = True
            self._enter(SessionState.READY, t)

    # Keeping it

    def _keep_ready(self, t: float) -> None:
        if self._requested.is_stale(t):
            self.counters.stale_requests += 1
            self._requested.zero()
            self._stand_still(t)
        if self._motors.is_overdue(t):
            self._queue_enable(t)
        self._send_requested(self._requested.changed(), t)
        self._outbox.flush(t)
        period = min(KEEP_ALIVE_PERIOD, WATCHDOG_SHARE * self.watchdog)
        if t - self._outbox.last_sent >= period:
            self._keep_alive(t)

    def _keep_alive(self, t: float) -> None:
        """Send PULSE before the watchdog fires; zeros instead if the robot is not at rest."""
        if self._base is not None and self._base.standing and not self._requested.moving:
            self._outbox.send(PULSE, t)
        else:
            self._stand_still(t)

    def _send_requested(self, due: list[Command], t: float) -> None:
        for wanted in due:
            if wanted.integer == 0 or self._outbox.has_room(t):
                self._outbox.send(wanted, t)

    def _stand_still(self, t: float) -> None:
        for zero in STAND_STILL:
            self._outbox.send(zero, t)

    def _queue_enable(self, t: float) -> None:
        self._motors.on_enable(t)
        self._outbox.add(*STAND_STILL, command(CommandNumber.ENABLE, 1))

    def _forget_motion(self) -> None:
        self._outbox.drop_queued()
        self._requested.reset()
        self._base = None
        self._motors = MotorWatch()

    def _on_sent(self, what: Command, t: float) -> None:
        self.counters.commands += 1
        self._requested.on_sent(what, t)
