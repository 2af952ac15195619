"""An emulated LMS 200: the laser's side of the line, at the laser's pace.

Shares the codec with the driver. Replies leave at the rate in force, one byte after another; scans
are measured over whole mirror turns and sent when the wire is free. Source: SICK telegram listing
8007954/Q501; where it says nothing, what known clients expect.
"""

from __future__ import annotations

from collections import deque
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from drivers.emulation.timed_bytes import TimedBytes
from drivers.lms200 import telegrams
from drivers.lms200.emulator.mirror import (
    TURN,
    EmulatedMirror,
    ReflectorSource,
    ScanSource,
    Sweep,
    Turn,
)
from drivers.lms200.errors import ErrorEntry, Severity, encode_errors
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
from drivers.lms200.measurement import (
    MEASURING_MODES,
    UNIT_CM,
    UNIT_MM,
    encode_measurement,
)
from drivers.lms200.telegrams import (
    BAUD_MODES,
    STATUS_OK,
    Command,
    Configuration,
    DeviceStatus,
    Mode,
    Variant,
    VariantReply,
)
from drivers.scan import Special

POWER_ON_BAUD = 9600
RESET_TIME = 0.01  # s from the confirmation of a reset to the power-on telegram
BYTE_GAP = 0.1  # s; the laser allows 6 ms, a pty and a scheduler add to that

_BITS_PER_BYTE = 10
_BAUD_BY_MODE = {mode: baud for baud, mode in BAUD_MODES.items()}
_STREAMS = (Mode.CONTINUOUS, Mode.CONTINUOUS_TURNS)


@dataclass(frozen=True, slots=True)
class _Outgoing:
    """Bytes on the wire; ``baud_after`` is the rate from then on, None for no change."""

    t: float
    data: bytes
    baud_after: int | None = None


class Lms200Emulator:
    """An LMS 200 that is switched on at time 0 with the factory's settings.

    scan_source(t, n, increment) -> ranges (n,) m, rightmost beam first, inf for no return, is
    called once per mirror turn used, with the middle of the turn (s), the number of beams and the
    angle between them (rad), times rising; None leaves scans to ``send_scan``. reflector_source()
    -> (n,) beams of that turn that ended on a reflector, None for none, is called next. Variant,
    configuration and ``permanent_baud`` survive ``power_off``. ``polluted``: dirty front window.
    """

    def __init__(
        self,
        *,
        baud: int = POWER_ON_BAUD,
        scan_source: ScanSource | None = None,
        reflector_source: ReflectorSource | None = None,
        variant: Variant = telegrams.VARIANTS[1],
        boot_time: float = 0.0,
        type_text: str = "LMS200;30106;V02.10",
    ) -> None:
        self.baud = baud
        self.mode = Mode.ON_REQUEST
        self.variant = variant
        self.configuration = telegrams.STANDARD_CONFIGURATION
        self.variant_writes = 0
        self.configuration_writes = 0
        self.permanent_baud = POWER_ON_BAUD
        self.polluted = False
        self._errors: tuple[ErrorEntry, ...] = ()
        self._blind_until = -np.inf
        self._mirror = (
            None if scan_source is None else EmulatedMirror(scan_source, reflector_source)
        )
        self._boot_time = boot_time
        self._type_text = type_text
        self._framer = TelegramFramer(HOST_ADDRESSES)
        self._powered = True
        self._boots_at: float | None = None
        self._last_fed = 0.0
        self._sent: deque[_Outgoing] = deque()
        self._line_baud = baud
        self._wire_free = 0.0
        self._one_scan_wanted = False
        self._scan_index = 0

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
        if self._framer.counters.bad_checksum > bad_before:
            self._send(bytes((NAK,)), t)
        for item in received:
            if isinstance(item, Telegram) and item.address == 0:
                self._obey(item.payload, t)

    def advance(self, t: float) -> None:
        """Advance to ``t``: finish booting, measure the scans that are due."""
        if self._boots_at is not None and t >= self._boots_at:
            at, self._boots_at = self._boots_at, None
            self._reply(telegrams.encode_text(telegrams.POWER_ON, self._type_text), at)
        if self._mirror is None:
            return
        while sweep := self._mirror.measure(self.variant, self._wire_free, t):
            self._send_values(sweep)
            if self._one_scan_wanted:
                self._stop_scanning()

    def turn_due(self, t: float) -> Turn | None:
        """Return the mirror turn for which ``advance(t)`` will call the scan source next, or None.

        A source that measures for many lasers at once prepares for it.
        """
        if self._mirror is None:
            return None
        return self._mirror.due(self.variant, self._wire_free, t)

    def pop_output(self, t: float) -> list[TimedBytes]:
        """Return what has wholly left the wire by ``t``, in order.

        One call returns bytes of one rate: what was sent after a rate change comes with the next.
        """
        self.advance(t)
        output: list[TimedBytes] = []
        while self._sent and self._sent[0].t <= t:
            outgoing = self._sent.popleft()
            output.append(TimedBytes(outgoing.t, outgoing.data))
            if outgoing.baud_after is not None:
                self.baud = outgoing.baud_after
                break
        return output

    def power_off(self, t: float) -> None:
        """Cut the power; output not yet taken is lost."""
        self.advance(t)
        self._powered = False
        self._boots_at = None
        self._sent.clear()
        self._stop_scanning()

    def power_on(self, t: float) -> None:
        """Switch on, or off and on: after the boot time the power-on telegram leaves at 9600."""
        self.power_off(t)
        self._powered = True
        self.baud = self._line_baud = self.permanent_baud
        self._boot(t + self._boot_time)

    def send_scan(self, ranges: NDArray[np.float64], t_measured: float) -> bool:
        """Play back a scan, ranges (n,) m, whose sweep's middle was at ``t_measured`` (s).

        Returns False where a laser would have lost it: not streaming, or the wire busy. A scan one
        beam short of the variant lacks the leftmost. Raises ValueError for any other length.
        """
        missing = self.variant.count - ranges.size
        if missing not in (0, 1):
            raise ValueError(f"laser is set to {self.variant.count} beams, not {ranges.size}")
        sweep_end = t_measured + self.variant.mirror_turns * TURN / 2
        scanning = self.mode is Mode.CONTINUOUS or self._one_scan_wanted
        if not scanning or sweep_end < self._wire_free:
            return False
        self._send_values(Sweep(np.append(ranges, [np.inf] * missing), sweep_end, None))
        self._one_scan_wanted = False
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
        self._wire_free = ready
        self._boots_at = ready
        self._framer.reset()

    def _send(self, data: bytes, t: float, baud_after: int | None = None) -> None:
        begin = max(t, self._wire_free)
        self._wire_free = begin + len(data) * _BITS_PER_BYTE / self._line_baud
        self._sent.append(_Outgoing(self._wire_free, data, baud_after))
        if baud_after is not None:
            self._line_baud = baud_after

    def _reply(self, payload: bytes, t: float, baud_after: int | None = None) -> None:
        """Send a reply; its last byte becomes the present status byte."""
        status = status_byte(self._condition(t), STATUS_OK)
        self._send(encode_telegram(payload[:-1] + bytes((status,)), REPLY_BIT), t, baud_after)

    # Scanning

    def _send_values(self, sweep: Sweep) -> None:
        configuration = self.configuration
        indices = b""
        if configuration.sends_indices:
            self._scan_index = (self._scan_index + 1) & 0xFF
            indices = bytes((self._scan_index, self._scan_index))
        blind = sweep.end < self._blind_until
        payload = encode_measurement(
            np.full_like(sweep.ranges, np.inf) if blind else sweep.ranges,
            MEASURING_MODES[configuration.measuring_mode],
            configuration.units,
            reflectors=sweep.reflectors,
            quarter=sweep.quarter,
            inf_means=Special.DAZZLED if blind else Special.NO_RETURN,
            indices=indices,
        )
        self._reply(payload, sweep.end)

    def _start_scanning(self) -> None:
        if self._mirror is not None:
            partial = self.mode is Mode.CONTINUOUS_TURNS and not self._one_scan_wanted
            self._mirror.start(self._wire_free, partial=partial)

    def _stop_scanning(self) -> None:
        self._one_scan_wanted = False
        if self._mirror is not None:
            self._mirror.stop()

    # Commands

    def _obey(self, payload: bytes, t: float) -> None:
        code, data = payload[0], payload[1:]
        self._send(bytes((ACK,)), t)
        reading = None if data else self._read(code, t)
        if reading is not None:
            self._reply(reading, t)
        elif code == Command.RESET and not data:
            self._reply(bytes((telegrams.RESET_CONFIRMED, STATUS_OK)), t, self.permanent_baud)
            self._boot(self._wire_free + max(RESET_TIME, self._boot_time))
        elif code == Command.MODE and data:
            self._select_mode(data, t)
        elif code == Command.REQUEST and data == b"\x01":
            self._measure_once()
        elif code == Command.VARIANT and len(data) == 4:
            self._set_variant(data, t)
        elif code == Command.PERMANENT_BAUD and data in (b"\x00", b"\x01"):
            self._set_permanent_baud(keep=data == b"\x01", t=t)
        elif code == Command.WRITE_CONFIGURATION and self.mode is Mode.INSTALLATION:
            self._write_configuration(data, t)
        else:
            self._reply(bytes((telegrams.BAD_COMMAND, STATUS_OK)), t)

    def _read(self, code: int, t: float) -> bytes | None:
        """Return the reply to a command that only reads."""
        match code:
            case Command.STATUS:
                return self._status(t).encode()
            case Command.ERRORS:
                return encode_errors(self._errors)
            case Command.TYPE:
                return telegrams.encode_text(Command.TYPE.reply, self._type_text)
            case Command.READ_CONFIGURATION:
                return bytes((Command.READ_CONFIGURATION.reply, *self.configuration.block, 0))
        return None

    def _measure_once(self) -> None:
        self._enter(Mode.ON_REQUEST)
        self._one_scan_wanted = True
        self._start_scanning()

    def _set_permanent_baud(self, *, keep: bool, t: float) -> None:
        """Power on at the present rate from now on, or at 9600; the reply is like that to 77."""
        self.permanent_baud = self._line_baud if keep else POWER_ON_BAUD
        reply = (Command.PERMANENT_BAUD.reply, telegrams.ACCEPTED, STATUS_OK)
        self._reply(bytes(reply), t)

    def _select_mode(self, data: bytes, t: float) -> None:
        code, password = data[0], data[1:]
        if code in _BAUD_BY_MODE and not password:
            self._reply(_mode_reply(telegrams.MODE_SELECTED), t, _BAUD_BY_MODE[code])
        elif code in (Mode.INSTALLATION, Mode.TEST_PASSWORD):
            right = password == telegrams.PASSWORD
            if right and code == Mode.INSTALLATION:
                self._enter(Mode.INSTALLATION)
            result = telegrams.MODE_SELECTED if right else telegrams.WRONG_PASSWORD
            self._reply(_mode_reply(result), t)
        elif code in _STREAMS and not password and self._condition(t).defective:
            self._reply(_mode_reply(telegrams.MODE_FAULT), t)
        elif code in (*_STREAMS, Mode.DIAGNOSTIC, Mode.ON_REQUEST) and not password:
            self._reply(_mode_reply(telegrams.MODE_SELECTED), t)
            self._enter(Mode(code))
        else:
            self._reply(bytes((telegrams.BAD_COMMAND, STATUS_OK)), t)

    def _enter(self, mode: Mode) -> None:
        self.mode = mode
        self._stop_scanning()
        if mode in _STREAMS:
            self._start_scanning()

    def _set_variant(self, data: bytes, t: float) -> None:
        """Set the variant; resolution 0, sent by one client by mistake, keeps the present one."""
        angle = int.from_bytes(data[:2], "little")
        resolution = int.from_bytes(data[2:], "little") or self.variant.resolution_cdeg
        wanted = Variant(angle, resolution)
        accepted = wanted in telegrams.VARIANTS
        if accepted:
            self.variant = wanted
            self.variant_writes += 1
        if self.mode in _STREAMS:
            self._enter(Mode.ON_REQUEST)
        self._reply(VariantReply(accepted, self.variant).encode(), t)

    def _write_configuration(self, block: bytes, t: float) -> None:
        """Set the configuration; a block shorter than the present one replaces its beginning."""
        fits = Configuration.SHORTEST <= len(block) <= len(self.configuration.block)
        wanted = self.configuration.overlaid(block) if fits else self.configuration
        usable = wanted.measuring_mode in MEASURING_MODES and wanted.units in (UNIT_CM, UNIT_MM)
        accepted = fits and usable
        if accepted:
            self.configuration = wanted
            self.configuration_writes += 1
        head = bytes((Command.WRITE_CONFIGURATION.reply, int(accepted)))
        self._reply(head + block + bytes((STATUS_OK,)), t)

    def _status(self, t: float) -> DeviceStatus:
        return DeviceStatus(
            software=self._type_text.rsplit(";", 1)[-1],
            mode=self.mode,
            defective=self._condition(t).defective,
            measuring_mode=self.configuration.measuring_mode,
            variant=self.variant,
            baud=self._line_baud,
            units=self.configuration.units,
            permanent_baud=self.permanent_baud != POWER_ON_BAUD,
        )


def _mode_reply(result: int) -> bytes:
    return bytes((Command.MODE.reply, result, STATUS_OK))
