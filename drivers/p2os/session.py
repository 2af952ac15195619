"""A client's session with a P2OS robot base: connect, set up, drive, notice silence, recover.

Sans-I/O: told bytes and times, it leaves what must be written in ``take_requests``.
"""

from __future__ import annotations

import math
from collections import deque
from dataclasses import dataclass
from enum import StrEnum

from drivers.p2os.base_state import BaseState, base_state
from drivers.p2os.commands import (
    CLOSE,
    OPEN,
    PULSE,
    REQUEST_CONFIG,
    STAND_STILL,
    STOP,
    Command,
    CommandNumber,
    command,
)
from drivers.p2os.drive_wish import DriveWish
from drivers.p2os.framing import OVERHEAD, PacketFramer
from drivers.p2os.handshake import Handshake
from drivers.p2os.model import RobotModel, UnknownModelError, load_model
from drivers.p2os.odometer import Odometer
from drivers.p2os.packets import (
    CONFIG_TYPE,
    ConfigPacket,
    RobotIdentity,
    Sip,
    decode_config,
    decode_sip,
    is_sip,
)
from drivers.p2os.set_up import set_up_commands
from drivers.p2os.settings import BaseSettings
from drivers.requests import Request, Write

SILENCE_TIMEOUT = 1.0  # s without a SIP
KEEP_ALIVE_PERIOD = 0.4  # s
WATCHDOG = 2.0  # s without a packet after which the controller halts
CONFIG_TIMEOUT = 1.0  # s
CONFIG_RETRY = 0.33  # s
CONFIG_TRIES = 3
ENABLE_RETRY = 0.5  # s
PACKET_GAP = 0.1  # s without a byte that ends an unfinished packet
COMMANDS_PER_TICK = 2


class SessionState(StrEnum):
    """Where a session stands."""

    DOWN = "down"  # no link, or shut down
    SYNCING = "syncing"  # looking for the robot
    OPENING = "opening"  # servers open, setting limits
    READY = "ready"  # may be driven
    SILENT = "silent"  # was open, went silent; looking for the robot again


@dataclass(slots=True)
class SessionCounters:
    """What a session met, besides the framer's counters."""

    sips: int = 0
    other_packets: int = 0
    cut_packets: int = 0  # good checksum, but too short for what they say they are
    silences: int = 0
    stale_wishes: int = 0
    commands: int = 0


class P2osSession:
    """One robot base behind one link. Call ``take_requests`` after every other call."""

    def __init__(self, settings: BaseSettings) -> None:
        self.state = SessionState.DOWN
        self.state_since = -math.inf
        self.identity: RobotIdentity | None = None
        self.config: ConfigPacket | None = None
        self.model: RobotModel = load_model(settings.model)
        self.counters = SessionCounters()
        self.framer = PacketFramer()
        self._settings = settings
        self._requests: list[Request] = []
        self.handshake = Handshake(settings.baud, self._requests)
        self._odometer = Odometer()
        self._wish = DriveWish(settings)
        self._queue: deque[Command] = deque()
        self._base: BaseState | None = None
        self._last_byte = self._last_sip = self._last_sent = -math.inf
        self._opened_at = self._config_asked_at = -math.inf
        self._config_tries = 0
        self._set_up_queued = False
        self._enabling_since: float | None = None

    @property
    def baud(self) -> int:
        """Rate at which the robot is spoken to."""
        return self.handshake.baud

    def link_up(self, t: float) -> None:
        """The port is open: look for the robot."""
        self._requests.clear()
        self.framer.reset()
        self._enter(SessionState.SYNCING, t)
        self._forget_motion()
        self.handshake.start(t, at_configured_rate=True)

    def link_down(self, t: float) -> None:
        """The port is gone: nothing can be sent or asked any more."""
        self._requests.clear()
        self._enter(SessionState.DOWN, t)
        self._forget_motion()

    def take_requests(self) -> list[Request]:
        """Return what the link must do, in order, and forget it."""
        requests = self._requests.copy()
        self._requests.clear()
        return requests

    def feed(self, data: bytes, t: float) -> list[BaseState]:
        """Take bytes whose last one arrived at ``t``; return a state for each SIP of an open
        session, at the time it was measured."""
        if self.state is SessionState.DOWN or not data:
            return []
        packets = self.framer.abandon_packet() if t - self._last_byte > PACKET_GAP else []
        packets += self.framer.feed(data)
        self._last_byte = t
        states = []
        behind = self.framer.pending + sum(len(packet) + OVERHEAD for packet in packets)
        for packet in packets:
            # The measurement was taken when the packet's first byte was sent.
            state = self._take_packet(packet, t, t - behind * 10.0 / self.baud)
            behind -= len(packet) + OVERHEAD
            if state is not None:
                states.append(state)
        return states

    def tick(self, t: float) -> None:
        """Notice what is overdue: replies, reports, wishes, keep-alives. Call 20 times a second."""
        if self.state in (SessionState.SYNCING, SessionState.SILENT):
            self.handshake.tick(t)
        elif self.state is not SessionState.DOWN and t - self._last_sip > SILENCE_TIMEOUT:
            self._go_silent(t)
        elif self.state is SessionState.OPENING:
            self._advance_opening(t)
        elif self.state is SessionState.READY:
            self._keep_ready(t)

    def enable_motors(self, t: float) -> None:
        """Switch the motors on, from standstill; ignored unless READY or when they are on.

        VEL 0, RVEL 0 and ENABLE 1 are sent again until a SIP shows the motors on.
        """
        if self.state is not SessionState.READY or self._enabling_since is not None:
            return
        if not self._motors_on:
            self._queue_enable(t)

    def drive(self, t: float, v: float, w: float) -> None:
        """Ask for ``v`` m/s and ``w`` rad/s, clamped to the settings; call at least every 0.3 s.

        Ignored unless READY. While the motors are off the wish is held at zero, so that nothing
        moves at the moment they come on.
        """
        if self.state is not SessionState.READY:
            return
        if not self._motors_on or self._enabling_since is not None:
            v = w = 0.0
        for wanted in self._wish.commands(t, v, w):
            self._send(wanted, t)

    def stop(self, t: float) -> None:
        """Stop the robot: STOP, VEL 0, RVEL 0 at once; calls at rest only refresh them."""
        if self.state is not SessionState.READY:
            return
        if self._wish.moving:
            self._send(STOP, t)
        for wanted in self._wish.commands(t, 0.0, 0.0):
            self._send(wanted, t)

    def shut_down(self, t: float) -> None:
        """Leave the robot standing, motors off, session closed; the state is DOWN after it."""
        if self.state is SessionState.DOWN:
            return
        for last in (STOP, command(CommandNumber.ENABLE, 0), CLOSE):
            self._send(last, t)
        self._enter(SessionState.DOWN, t)
        self._forget_motion()

    def _enter(self, state: SessionState, t: float) -> None:
        self.state = state
        self.state_since = t

    @property
    def _motors_on(self) -> bool:
        return self._base is not None and self._base.motors_enabled

    def _take_packet(self, packet: bytes, t: float, t_measured: float) -> BaseState | None:
        if self.state in (SessionState.SYNCING, SessionState.SILENT):
            identity = self.handshake.feed(packet, t)
            if identity is not None:
                self._open(identity, t)
            return None
        if packet[0] == CONFIG_TYPE:
            self.config = decode_config(packet)
            return None
        sip = decode_sip(packet)
        if sip is not None:
            return self._take_sip(sip, t, t_measured)
        if is_sip(packet):
            self.counters.cut_packets += 1
        else:
            self.counters.other_packets += 1
        return None

    def _take_sip(self, sip: Sip, t: float, t_measured: float) -> BaseState:
        self.counters.sips += 1
        self._last_sip = t
        self._odometer.update(
            sip.x_counts, sip.y_counts, sip.heading_counts, self.model.conversion.distance
        )
        self._base = base_state(t_measured, sip, self._odometer, self.model)
        if sip.motors_enabled and not self._queue:
            self._enabling_since = None
        return self._base

    def _open(self, identity: RobotIdentity, t: float) -> None:
        """Start the servers and take the model of the robot that answered."""
        self.identity = identity
        try:
            self.model = load_model(identity.subclass)
        except UnknownModelError:
            self.model = load_model(self._settings.model)
        self._enter(SessionState.OPENING, t)
        self.config = None
        self._forget_motion()
        self._odometer.forget_reference()
        self._set_up_queued = False
        self._config_tries = 0
        self._opened_at = self._last_sip = t
        self._send(OPEN, t)
        self._ask_config(t)

    def _advance_opening(self, t: float) -> None:
        """CONFIG if it comes, then the limits, then zero motion; READY once all that is out."""
        if not self._set_up_queued:
            if self.config is not None or t - self._opened_at >= CONFIG_TIMEOUT:
                self._queue.extend(set_up_commands(self._settings))
                self._set_up_queued = True
            elif self._config_tries < CONFIG_TRIES and t - self._config_asked_at >= CONFIG_RETRY:
                self._ask_config(t)
        self._send_queued(t)
        if self._set_up_queued and not self._queue and self._base is not None:
            self._enter(SessionState.READY, t)

    def _ask_config(self, t: float) -> None:
        self._config_tries += 1
        self._config_asked_at = t
        self._send(REQUEST_CONFIG, t)

    def _keep_ready(self, t: float) -> None:
        if self._wish.is_stale(t):
            self.counters.stale_wishes += 1
            self._stand_still(t)
        if self._enabling_since is not None and t - self._enabling_since >= ENABLE_RETRY:
            self._queue_enable(t)
        self._send_queued(t)
        if t - self._last_sent >= KEEP_ALIVE_PERIOD:
            self._keep_alive(t)

    def _keep_alive(self, t: float) -> None:
        """Hold off the watchdog; a robot that moves against its orders is told to stand still."""
        if self._base is not None and self._base.standing and not self._wish.moving:
            self._send(PULSE, t)
        else:
            self._stand_still(t)

    def _stand_still(self, t: float) -> None:
        for zero in STAND_STILL:
            self._send(zero, t)

    def _queue_enable(self, t: float) -> None:
        self._enabling_since = t
        self._queue.extend((*STAND_STILL, command(CommandNumber.ENABLE, 1)))

    def _go_silent(self, t: float) -> None:
        self.counters.silences += 1
        self._enter(SessionState.SILENT, t)
        self._forget_motion()
        self.handshake.start(t, at_configured_rate=False)

    def _forget_motion(self) -> None:
        self._queue.clear()
        self._base = None
        self._enabling_since = None
        self._wish = DriveWish(self._settings)

    def _send_queued(self, t: float) -> None:
        for _ in range(min(COMMANDS_PER_TICK, len(self._queue))):
            self._send(self._queue.popleft(), t)

    def _send(self, what: Command, t: float) -> None:
        if self.state is SessionState.READY and t - self._last_sent >= WATCHDOG:
            # The controller has halted and any packet makes it resume the old motion.
            self._last_sent = t
            self._send(STOP, t)
        self.counters.commands += 1
        self._last_sent = t
        self._wish.note_sent(what, t)
        self._requests.append(Write(what.encode()))
