"""An emulated LMS 200: the laser's side of the line, at the laser's pace.

Shares the codec with the driver. Replies leave at the rate in force, one byte after another; scans
are measured over whole mirror turns and sent when the wire is free. Source: SICK telegram listing
8007954/Q501; where it says nothing, what known clients expect.
"""

from __future__ import annotations

from dataclasses import replace

import numpy as np
from numpy.typing import NDArray

from drivers.emulation.timed_bytes import TimedBytes
from drivers.lms200 import telegrams
from drivers.lms200.emulator.answer import Answer
from drivers.lms200.emulator.commands import answer_to
from drivers.lms200.emulator.laser_state import POWER_ON_BAUD, LaserState
from drivers.lms200.emulator.measured_output import MeasuredOutput, is_stream
from drivers.lms200.emulator.mirror import (
    TURN,
    EmulatedMirror,
    ReflectorSource,
    ScanSource,
    Sweep,
    Turn,
)
from drivers.lms200.emulator.value_telegrams import degrees_of, encode_output, mean_of
from drivers.lms200.emulator.wire import LaserWire
from drivers.lms200.errors import ErrorEntry, Severity
from drivers.lms200.framing import (
    ACK,
    HOST_ADDRESSES,
    NAK,
    REPLY_BIT,
    Telegram,
    TelegramFramer,
    encode_telegram,
)
from drivers.lms200.health import LaserHealth, status_byte
from drivers.lms200.telegrams import STATUS_OK, Mode, Variant

RESET_TIME = 0.01  # s from the confirmation of a reset to the power-on telegram
BYTE_GAP = 0.1  # s; the laser allows 6 ms, a pty and a scheduler add to that

_REFUSED = Answer(bytes((telegrams.BAD_COMMAND,)))


class Lms200Emulator:
    """An LMS 200 that is switched on at time 0 with the factory's settings.

    scan_source(t, n, increment) -> ranges (n,) m, rightmost beam first, inf for no return, is
    called once per mirror turn used, with the middle of the turn (s), the number of beams and the
    angle between them (rad), times rising; None leaves scans to ``send_scan``. reflector_source()
    -> (n,) beams of that turn that ended on a reflector, None for none, is called next. Settings
    survive ``power_off``. ``polluted``: dirty front window. ``slow``: takes as long as the listing
    allows. ``acknowledges``: sends an ACK before each reply. ``paced``: whether the line has a rate
    before one is ordered; TCP has none.
    """

    def __init__(
        self,
        *,
        baud: int = POWER_ON_BAUD,
        scan_source: ScanSource | None = None,
        reflector_source: ReflectorSource | None = None,
        variant: Variant = telegrams.VARIANTS[1],
        boot_time: float = 0.0,
        type_text: str | None = None,
        paced: bool = True,
    ) -> None:
        self.state = LaserState(variant=variant, baud=baud, type_text=type_text)
        self.polluted = False
        self.slow = False
        self.acknowledges = True
        self._errors: tuple[ErrorEntry, ...] = ()
        self._blind_until = -np.inf
        self._mirror = (
            None if scan_source is None else EmulatedMirror(scan_source, reflector_source)
        )
        self._boot_time = boot_time
        self._framer = TelegramFramer(HOST_ADDRESSES)
        self._powered = True
        self._boots_at: float | None = None
        self._busy_until = -np.inf
        self._last_fed = 0.0
        self._wire = LaserWire(baud, paced=paced)
        self._output: MeasuredOutput | None = None
        self._once = False
        self._sweeps: list[Sweep] = []  # of the mean in progress
        self._telegram_index = 0

    @property
    def baud(self) -> int:
        """The rate of the bytes taken so far."""
        return self._wire.baud

    @property
    def mode(self) -> Mode:
        """The operating mode."""
        return self.state.mode

    # Line

    def feed(self, data: bytes, t: float) -> None:
        """Take bytes from the host whose last one arrived at ``t``."""
        self.advance(t)
        if not self._powered or self._boots_at is not None:
            return
        if t - self._last_fed > BYTE_GAP:
            self._framer.reset()
        self._last_fed = t
        bad_before = self._framer.counters.bad_checksum
        received = self._framer.feed(data)
        if t < self._busy_until:
            return
        if self._framer.counters.bad_checksum > bad_before:
            self._wire.break_off(t)
            self._wire.send(bytes((NAK,)), t)
        for item in received:
            if isinstance(item, Telegram) and item.address in (0, self.state.address):
                self._obey(item.payload, t)

    def advance(self, t: float) -> None:
        """Advance to ``t``: finish booting, measure the scans that are due."""
        if self._boots_at is not None and t >= self._boots_at:
            at, self._boots_at = self._boots_at, None
            self._reply(telegrams.encode_text(telegrams.POWER_ON, self.state.type)[:-1], at)
        if self._mirror is None:
            return
        while sweep := self._mirror.measure(self.state.variant, self._wire.free, t):
            self._take_sweep(sweep)

    def turn_due(self, t: float) -> Turn | None:
        """Return the mirror turn for which ``advance(t)`` will call the scan source next, or None.

        A source that measures for many lasers at once prepares for it.
        """
        if self._mirror is None:
            return None
        return self._mirror.due(self.state.variant, self._wire.free, t)

    def pop_output(self, t: float) -> list[TimedBytes]:
        """Return what has wholly left the wire by ``t``, in order.

        One call returns bytes of one rate: what was sent after a rate change comes with the next.
        """
        self.advance(t)
        return self._wire.pop(t)

    def power_off(self, t: float) -> None:
        """Cut the power; output not yet taken is lost."""
        self.advance(t)
        self._powered = False
        self._boots_at = None
        self._wire.clear()
        self._stop_measuring()

    def power_on(self, t: float) -> None:
        """Switch on, or off and on: after the boot time the power-on telegram leaves at 9600."""
        self.power_off(t)
        self._powered = True
        self.state.baud = self.state.permanent_baud
        self._wire.restart(self.state.baud)
        self._boot(t + self._boot_time)

    def send_scan(self, ranges: NDArray[np.float64], t_measured: float) -> bool:
        """Play back a scan, ranges (n,) m, whose sweep's middle was at ``t_measured`` (s).

        Returns False where a laser would have lost it: not streaming, or the wire busy. A scan one
        beam short of the variant lacks the leftmost. Raises ValueError for any other length.
        """
        variant = self.state.variant
        missing = variant.count - ranges.size
        if missing not in (0, 1):
            raise ValueError(f"laser is set to {variant.count} beams, not {ranges.size}")
        sweep_end = t_measured + variant.mirror_turns * TURN / 2
        if self._output is None or self._output.turns or sweep_end < self._wire.free:
            return False
        self._take_sweep(Sweep(np.append(ranges, [np.inf] * missing), sweep_end, None))
        return True

    # Condition

    def set_errors(self, errors: tuple[ErrorEntry, ...], t: float) -> None:
        """Set the error list from ``t`` on; a fatal error present ends measuring."""
        self.advance(t)
        self._errors = errors
        if self._condition(t).defective:
            self._enter(Mode.ON_REQUEST)

    def blind(self, until: float) -> None:
        """Mark every beam dazzled in the scans that end before ``until`` (s)."""
        self._blind_until = until

    def _condition(self, t: float) -> LaserHealth:
        level = Severity.WARNING if self.polluted else Severity.OK
        level = max([level, *(Severity(e.severity) for e in self._errors if e.present)])
        return LaserHealth(
            level,
            pollution=self.polluted,
            implausible=t < self._blind_until,
            defective=level is Severity.FATAL,
            errors=self._errors,
        )

    def _boot(self, ready: float) -> None:
        self._enter(Mode.ON_REQUEST)
        self._wire.free = ready
        self._boots_at = ready
        self._framer.reset()

    # Commands

    def _obey(self, payload: bytes, t: float) -> None:
        """Acknowledge a command, breaking off measured values, and carry it out."""
        if t < self._busy_until:
            return
        state = self.state
        state.health = self._condition(t)
        self._wire.break_off(t)
        if self.acknowledges:
            self._wire.send(bytes((ACK,)), t)
        answer = answer_to(payload, state) or _REFUSED
        ready = t
        if self.slow and answer.takes:
            ready = self._busy_until = t + answer.takes
        if answer.reply:
            self._reply(answer.reply, ready, answer.baud_after)
        if answer.baud_after is not None:
            state.baud = answer.baud_after
        if answer.restarts:
            self._wire.drop_order(state.baud)
            self._boot(self._wire.free + max(RESET_TIME, self._boot_time))
        elif answer.enter is not None:
            self._enter(answer.enter, answer.output)
        elif answer.output is not None:
            self._measure(answer.output, once=True)

    def _reply(self, payload: bytes, t: float, baud_after: int | None = None) -> None:
        """Send a reply; its last byte is the present status byte."""
        self._wire.send(self._framed(payload, t), t, baud_after=baud_after)

    def _framed(self, payload: bytes, t: float) -> bytes:
        status = status_byte(self._condition(t), STATUS_OK)
        return encode_telegram(payload + bytes((status,)), REPLY_BIT | self.state.address)

    # Measuring

    def _enter(self, mode: Mode, output: MeasuredOutput | None = None) -> None:
        self.state.mode = mode
        self._stop_measuring()
        if output is not None:
            self._measure(output, once=not is_stream(mode))

    def _measure(self, output: MeasuredOutput, *, once: bool) -> None:
        self._output, self._once = output, once
        self._sweeps.clear()
        if self._mirror is not None:
            self._mirror.start(self._wire.free, partial=output.turns)

    def _stop_measuring(self) -> None:
        self._output = None
        if self._mirror is not None:
            self._mirror.stop()

    def _take_sweep(self, sweep: Sweep) -> None:
        """Send a sweep's values, or add it to the mean in progress."""
        output, state = self._output, self.state
        if output is None:
            return
        blind = sweep.end < self._blind_until
        if blind:
            sweep = replace(sweep, ranges=np.full_like(sweep.ranges, np.inf))
        if state.fields.stored:
            units = state.configuration.units
            state.fields.evaluate(sweep.ranges, degrees_of(sweep, state), units)
        self._sweeps.append(sweep)
        if len(self._sweeps) < output.scans:
            return
        sweep = mean_of(self._sweeps)
        self._sweeps.clear()
        if self._once:
            self._stop_measuring()
        if output.if_infringed and not any(state.fields.infringed(state.configuration.evaluations)):
            return
        payload = encode_output(output, sweep, state, self._indices(sweep), dazzled=blind)
        self._wire.send(self._framed(payload, sweep.end), sweep.end, measured=True)

    def _indices(self, sweep: Sweep) -> bytes:
        """Return the mirror turn and the number of telegrams so far, where they are sent."""
        if not self.state.configuration.sends_indices:
            return b""
        self._telegram_index = (self._telegram_index + 1) & 0xFF
        return bytes((sweep.turn & 0xFF, self._telegram_index))
