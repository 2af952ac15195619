"""An emulated LMS 200: the laser's side of the line, paced like one.

Shares the codec with the driver. Replies leave at the rate in force, one byte after another; scans
are measured over whole mirror turns and sent when the wire is free. Source: SICK telegram listing
8007954/Q501; where it is silent, what known clients wait for.
"""

from __future__ import annotations

import math
from collections import deque
from collections.abc import Callable
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from drivers.lms200 import telegrams
from drivers.lms200.framing import (
    ACK,
    HOST_ADDRESSES,
    NAK,
    REPLY_BIT,
    Telegram,
    TelegramFramer,
    encode_telegram,
)
from drivers.lms200.measurement import (
    MEASURING_MODES,
    TURN,
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
from drivers.timed_bytes import TimedBytes

ScanSource = Callable[[float, int, float], NDArray[np.float64]]

POWER_ON_BAUD = 9600
RESET_TIME = 0.01  # s from the confirmation of a reset to the power-on telegram
BYTE_GAP = 0.1  # s; the laser allows 6 ms, a pty and a scheduler add to that

_BITS_PER_BYTE = 10
_BAUD_BY_MODE = {mode: baud for baud, mode in BAUD_MODES.items()}


@dataclass(frozen=True, slots=True)
class _Outgoing:
    """Bytes on the wire; ``baud_after`` is the rate in force once they have left."""

    t: float
    data: bytes
    baud_after: int | None = None


class Lms200Emulator:
    """An LMS 200 that is switched on at time 0 with the factory's settings.

    scan_source(t, n, increment) -> ranges (n,) m, rightmost beam first, inf for no return, is asked
    once per scan with the middle of its sweep (s) and the angle between beams (rad), times rising;
    None leaves scans to ``send_scan``. Variant and configuration outlive ``power_off``.
    """

    def __init__(
        self,
        *,
        baud: int = POWER_ON_BAUD,
        scan_source: ScanSource | None = None,
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
        self._scan_source = scan_source
        self._boot_time = boot_time
        self._type_text = type_text
        self._framer = TelegramFramer(HOST_ADDRESSES)
        self._powered = True
        self._boots_at: float | None = None
        self._last_fed = 0.0
        self._sent: deque[_Outgoing] = deque()
        self._line_baud = baud
        self._wire_free = 0.0
        self._sweep_begin: float | None = None
        self._one_scan_wanted = False
        self._scan_index = 0

    # The line

    def feed(self, data: bytes, t: float) -> None:
        """Take bytes from the host, the last of which arrived at ``t``."""
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
        """Let time pass to ``t``: finish booting, measure the scans that are due."""
        if self._boots_at is not None and t >= self._boots_at:
            at, self._boots_at = self._boots_at, None
            self._reply(telegrams.encode_text(telegrams.POWER_ON, self._type_text), at)
        if self._scan_source is None:
            return
        while (sweep_end := self._next_sweep_end()) is not None:
            measured = sweep_end - self._sweep_time / 2
            if measured > t:
                return
            increment = math.radians(self.variant.resolution_cdeg / 100)
            ranges = self._scan_source(measured, self.variant.count, increment)
            self._send_values(ranges, sweep_end)

    def take_output(self, t: float) -> list[TimedBytes]:
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
        """Cut the power: what has not been taken is lost."""
        self.advance(t)
        self._powered = False
        self._boots_at = None
        self._sent.clear()
        self._stop_scanning()

    def power_on(self, t: float) -> None:
        """Switch on, or off and on: after the boot time the power-on telegram leaves at 9600."""
        self.power_off(t)
        self._powered = True
        self.baud = self._line_baud = POWER_ON_BAUD
        self._boot(t + self._boot_time)

    def send_scan(self, ranges: NDArray[np.float64], t_measured: float) -> bool:
        """Play back a scan, ranges (n,) m, whose sweep's middle was at ``t_measured`` (s).

        Returns False where a laser would have lost it: not streaming, or the wire busy. A scan one
        beam short of the variant lacks the leftmost. Raises ValueError for any other length.
        """
        missing = self.variant.count - ranges.size
        if missing not in (0, 1):
            raise ValueError(f"laser is set to {self.variant.count} beams, not {ranges.size}")
        sweep_end = t_measured + self._sweep_time / 2
        if not self._scanning or sweep_end < self._wire_free:
            return False
        self._send_values(np.append(ranges, [np.inf] * missing), sweep_end)
        return True

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
        self._send(encode_telegram(payload, REPLY_BIT), t, baud_after)

    # Scanning

    @property
    def _scanning(self) -> bool:
        return self.mode is Mode.CONTINUOUS or self._one_scan_wanted

    @property
    def _sweep_time(self) -> float:
        return self.variant.mirror_turns * TURN

    def _next_sweep_end(self) -> float | None:
        """Return the end of the first whole sweep after which the wire is free; None: no sweep."""
        if self._sweep_begin is None:
            return None
        first = _next_multiple(self._sweep_begin, self._sweep_time) + self._sweep_time
        return max(first, _next_multiple(self._wire_free, self._sweep_time))

    def _send_values(self, ranges: NDArray[np.float64], sweep_end: float) -> None:
        configuration = self.configuration
        indices = b""
        if configuration.sends_indices:
            self._scan_index = (self._scan_index + 1) & 0xFF
            indices = bytes((self._scan_index, self._scan_index))
        mode = MEASURING_MODES[configuration.measuring_mode]
        payload = encode_measurement(ranges, mode, configuration.units, indices=indices)
        self._reply(payload, sweep_end)
        self._one_scan_wanted = False
        self._sweep_begin = sweep_end if self._scanning else None

    def _stop_scanning(self) -> None:
        self._one_scan_wanted = False
        self._sweep_begin = None

    # Commands

    def _obey(self, payload: bytes, t: float) -> None:
        code, data = payload[0], payload[1:]
        self._send(bytes((ACK,)), t)
        if code == Command.RESET and not data:
            self._reply(bytes((telegrams.RESET_CONFIRMED, STATUS_OK)), t, POWER_ON_BAUD)
            self._boot(self._wire_free + max(RESET_TIME, self._boot_time))
        elif code == Command.MODE and data:
            self._select_mode(data, t)
        elif code == Command.REQUEST and data == b"\x01":
            self._one_scan_wanted = True
            self._sweep_begin = self._wire_free
        elif code == Command.STATUS and not data:
            self._reply(self._status().encode(), t)
        elif code == Command.ERRORS and not data:
            self._reply(bytes((Command.ERRORS.reply, STATUS_OK)), t)
        elif code == Command.TYPE and not data:
            self._reply(telegrams.encode_text(Command.TYPE.reply, self._type_text), t)
        elif code == Command.VARIANT and len(data) == 4:
            self._set_variant(data, t)
        elif code == Command.READ_CONFIGURATION and not data:
            block = self.configuration.block
            self._reply(bytes((Command.READ_CONFIGURATION.reply, *block, STATUS_OK)), t)
        elif code == Command.WRITE_CONFIGURATION and self.mode is Mode.INSTALLATION:
            self._write_configuration(data, t)
        else:
            self._reply(bytes((telegrams.BAD_COMMAND, STATUS_OK)), t)

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
        elif code in (Mode.DIAGNOSTIC, Mode.CONTINUOUS, Mode.ON_REQUEST) and not password:
            self._reply(_mode_reply(telegrams.MODE_SELECTED), t)
            self._enter(Mode(code))
        else:
            self._reply(bytes((telegrams.BAD_COMMAND, STATUS_OK)), t)

    def _enter(self, mode: Mode) -> None:
        self.mode = mode
        self._stop_scanning()
        if mode is Mode.CONTINUOUS:
            self._sweep_begin = self._wire_free

    def _set_variant(self, data: bytes, t: float) -> None:
        """Take a variant; resolution 0, which one client sends by mistake, keeps the present."""
        angle = int.from_bytes(data[:2], "little")
        resolution = int.from_bytes(data[2:], "little") or self.variant.resolution_cdeg
        wanted = Variant(angle, resolution)
        accepted = wanted in telegrams.VARIANTS
        if accepted:
            self.variant = wanted
            self.variant_writes += 1
        if self.mode is Mode.CONTINUOUS:
            self._enter(Mode.ON_REQUEST)
        self._reply(VariantReply(accepted, self.variant).encode(), t)

    def _write_configuration(self, block: bytes, t: float) -> None:
        """Take a block of any length up to the present one's; shorter ones change its beginning."""
        fits = Configuration.SHORTEST <= len(block) <= len(self.configuration.block)
        wanted = self.configuration.overlaid(block) if fits else self.configuration
        usable = wanted.measuring_mode in MEASURING_MODES and wanted.units in (UNIT_CM, UNIT_MM)
        accepted = fits and usable
        if accepted:
            self.configuration = wanted
            self.configuration_writes += 1
        head = bytes((Command.WRITE_CONFIGURATION.reply, int(accepted)))
        self._reply(head + block + bytes((STATUS_OK,)), t)

    def _status(self) -> DeviceStatus:
        return DeviceStatus(
            software=self._type_text.rsplit(";", 1)[-1],
            mode=self.mode,
            defective=False,
            measuring_mode=self.configuration.measuring_mode,
            variant=self.variant,
            baud=self._line_baud,
            units=self.configuration.units,
        )


def _mode_reply(result: int) -> bytes:
    return bytes((Command.MODE.reply, result, STATUS_OK))


def _next_multiple(t: float, period: float) -> float:
    """Return the first multiple of ``period`` that is not before ``t``, but for rounding."""
    return math.ceil(t / period - 1e-6) * period
