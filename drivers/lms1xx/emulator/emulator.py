"""An emulated LMS 111: the scanner's side of the connection, at the scanner's pace.

Shares the codec with the driver. Answers in the dialect it is set to and hears no other; writes
need a login. Source: SICK "Telegram Listing" 8014631, and recordings of an LMS 111 by its maker
(`SICKAG/sick_scan_xd`); where they say nothing, ours.
"""

from __future__ import annotations

from bisect import insort
from collections.abc import Callable

import numpy as np
from numpy.typing import NDArray

from drivers.emulation.timed_bytes import TimedBytes
from drivers.lms1xx import measurement as values
from drivers.lms1xx import telegrams
from drivers.lms1xx.emulator.answers import EVENTS, answer
from drivers.lms1xx.emulator.mirror import EmulatedMirror, ScanSource, Turn
from drivers.lms1xx.fields import FieldError, FieldWriter, fields_of
from drivers.lms1xx.framing import ETHERNET, Dialect, Telegram, TelegramFramer, encode_telegram
from drivers.lms1xx.health import LaserHealth, status_of
from drivers.lms1xx.measurement import Channel, Measurement, encode_measurement
from drivers.lms1xx.telegrams import Contamination, Fault, OutputRange, ScanContent, Scanning

REPLY_TIME = 0.0013  # s from command to reply, as recorded
SENDING_TIME = 0.0031  # s from the end of the sweep until its telegram leaves, as recorded
RUN_UP = 2.0  # s until the motor has another speed; ours
SERIAL = 18090362  # of the recorded one
REMISSION = 200  # of everything; ours

_BITS_PER_BYTE = 10
_SECTOR = (-450000, 2250000)
_PAIRS = ((2500, 2500), (2500, 5000), (5000, 5000))  # frequency with resolution, as sent
_REFUSED = 5  # result of mLMPsetscancfg: some other error
_FARTHEST_COUNT = 0xFFFF
_CLOCK = 1 << 32


class Lms1xxEmulator:
    """An LMS 111 that is switched on at time 0 and measures.

    scan_source(t, n, increment) -> ranges (n,) m, rightmost beam first, inf for no return, is
    called once per mirror turn used, with the middle of the turn (s), the number of beams and the
    angle between them (rad), times rising. Settings survive ``power_off``. ``contamination``: of
    the front window. ``failing``: it reports a device error.
    """

    def __init__(
        self,
        *,
        scan_source: ScanSource,
        dialect: Dialect = Dialect.A,
        boot_time: float = 0.0,
        password: int = telegrams.CLIENT_PASSWORD,
    ) -> None:
        self.dialect = dialect
        self.scanning = Scanning(5000, 5000, *_SECTOR)
        self.output_range = OutputRange(5000, *_SECTOR)
        self.content = ScanContent()
        self.contamination = Contamination.NONE
        self.failing = False
        self.configuration_writes = 0
        self._source = scan_source
        self._boot_time = boot_time
        self._password = password
        self._framer = TelegramFramer()
        self._mirror = EmulatedMirror(50.0, 0.5)
        self._mirror.start(0.0)
        self._booted_at = 0.0
        self._powered = True
        self._logged_in = False
        self._streaming = False
        self._asked = 0  # scans still to be sent on request
        self._telegrams = 0
        self._sent: list[TimedBytes] = []  # in order of time
        self._commands: dict[str, Callable[[Telegram, float], bytes]] = {
            telegrams.LOGIN: self._log_in,
            telegrams.LOGOUT: self._log_out,
            telegrams.SET_SCANNING: self._set_scanning,
            telegrams.SET_RANGE: self._set_range,
            telegrams.SET_CONTENT: self._set_content,
            telegrams.START_MEASURING: self._start_measuring,
            telegrams.STOP_MEASURING: self._stop_measuring,
            telegrams.SET_DIALECT: self._set_dialect,
        }

    # Line

    @property
    def baud(self) -> int:
        """Rate of its line, bit/s."""
        return ETHERNET

    @property
    def turn_time(self) -> float:
        """Time of one mirror turn, s."""
        return self._mirror.turn_time

    def feed(self, data: bytes, t: float) -> None:
        """Take bytes from the host whose last one arrived at ``t``."""
        self.advance(t)
        if not self._powered or t < self._booted_at:
            return
        for telegram in self._framer.feed(data):
            if telegram.dialect is self.dialect:
                self._obey(telegram, t)

    def advance(self, t: float) -> None:
        """Advance to ``t``: measure the scans that are due."""
        while (turn := self.turn_due(t)) is not None:
            ranges = self._source(turn.middle, turn.beams, turn.increment)
            number = self._mirror.number
            self._mirror.take()
            if self._asked:
                self._asked -= 1
                self._send_scan(ranges, turn, number, telegrams.SCAN_READ)
            if self._streaming and number % self.content.every == 0:
                self._send_scan(ranges, turn, number, telegrams.SCAN_SENT)

    def turn_due(self, t: float) -> Turn | None:
        """Return the mirror turn for which ``advance(t)`` will call the scan source next, or None.

        A source that measures for many lasers at once prepares for it.
        """
        if not self._powered or not (self._streaming or self._asked):
            return None
        turn = self._mirror.next_turn()
        return None if turn is None or turn.middle > t else turn

    def pop_output(self, t: float) -> list[TimedBytes]:
        """Return what has wholly left the wire by ``t``, in order."""
        self.advance(t)
        output: list[TimedBytes] = []
        while self._sent and self._sent[0].t <= t:
            output.append(self._sent.pop(0))
        return output

    def power_off(self, t: float) -> None:
        """Cut the power; output not yet taken is lost."""
        self.advance(t)
        self._powered = self._logged_in = self._streaming = False
        self._asked = 0
        self._sent.clear()
        self._framer.reset()

    def power_on(self, t: float) -> None:
        """Switch on, or off and on: after the boot time it measures and answers."""
        self.power_off(t)
        self._powered = True
        self._booted_at = t + self._boot_time
        self._mirror.start(self._booted_at)

    def _send(self, payload: bytes, t: float) -> None:
        frame = encode_telegram(payload, self.dialect)
        item = TimedBytes(t + len(frame) * _BITS_PER_BYTE / ETHERNET, frame)
        insort(self._sent, item, key=_time)  # a reply leaves before a scan still being measured

    # Scans

    def _send_scan(
        self, ranges: NDArray[np.float64], turn: Turn, number: int, command: str
    ) -> None:
        self._telegrams += 1
        sent = turn.sweep_end + SENDING_TIME
        content = self.content
        counts = self._counts(ranges)
        wide = [self._channel("DIST1", counts)]
        if content.echoes & ScanContent.SECOND_ECHO:
            wide.append(self._channel("DIST2", np.zeros_like(counts)))
        narrow: list[Channel] = []
        if content.remission:
            light = np.where(counts >= values.SMALLEST_RANGE, REMISSION, 0)
            kind = np.uint16 if content.wide else np.uint8
            (wide if content.wide else narrow).append(self._channel("RSSI1", light.astype(kind)))
        measurement = Measurement(
            serial=SERIAL,
            status=status_of(LaserHealth(self.failing, self.contamination)),
            telegrams=self._telegrams & 0xFFFF,
            scans=number & 0xFFFF,
            counted=round(turn.sweep_end * 1e6) % _CLOCK,
            sent=round(sent * 1e6) % _CLOCK,
            frequency=self.scanning.frequency,
            wide=tuple(wide),
            narrow=tuple(narrow),
        )
        self._send(encode_measurement(measurement, command, self.dialect), sent)

    def _counts(self, ranges: NDArray[np.float64]) -> NDArray[np.uint16]:
        """Return millimetres (n,) of the beams sent; 0 for no return or one too near."""
        step, output = self.scanning.resolution, self.output_range
        first, last = (round((end - _SECTOR[0]) / step) for end in (output.first, output.last))
        part = ranges[first : last + 1]
        counts = np.zeros(part.shape, dtype=np.uint16)
        seen = np.isfinite(part)
        counts[seen] = np.clip(np.rint(part[seen] * 1000.0), 0, _FARTHEST_COUNT)
        counts[counts < values.SMALLEST_RANGE] = values.NO_RETURN
        return counts

    def _channel(self, content: str, counts: NDArray[np.integer]) -> Channel:
        first = round((self.output_range.first - _SECTOR[0]) / self.scanning.resolution)
        at = _SECTOR[0] + first * self.scanning.resolution
        return Channel(content, 1.0, 0.0, at, self.scanning.resolution, counts)

    # Commands

    def _obey(self, telegram: Telegram, t: float) -> None:
        reply = self._reply_to(telegram, t)
        if reply:
            self._send(reply, t + REPLY_TIME)

    def _reply_to(self, telegram: Telegram, t: float) -> bytes:
        """Return the payload of the reply; empty where that comes later."""
        command = telegram.command
        if command == telegrams.READ_SCAN:
            self._await_scan(t)
            return b""
        if command in self._commands:
            return self._commands[command](telegram, t)
        kind, _, name = command.partition(" ")
        if kind == "sRN":
            return self._read(telegram, name)
        if kind == "sEN" and name in EVENTS:
            return self._subscribe(telegram, name, t)
        known = {"sMN": Fault.UNKNOWN_METHOD, "sWN": Fault.UNKNOWN_VARIABLE}
        return self._fault(known.get(kind, Fault.UNKNOWN_COMMAND))

    def _read(self, telegram: Telegram, name: str) -> bytes:
        writer = self._done(telegram)
        settings: dict[str, Scanning | OutputRange | ScanContent] = {
            telegrams.READ_SCANNING: self.scanning,
            telegrams.READ_RANGE: self.output_range,
            telegrams.READ_CONTENT: self.content,
        }
        if telegram.command in settings:
            settings[telegram.command].write(writer)
        elif telegram.command == telegrams.READ_CONTAMINATION:
            writer.unsigned(self.contamination, 1)
        elif telegram.command == telegrams.READ_DIALECT:
            writer.unsigned(int(self.dialect is Dialect.B), 1)
        elif not answer(name, writer):
            return self._fault(Fault.UNKNOWN_VARIABLE)
        return writer.payload

    def _subscribe(self, telegram: Telegram, name: str, t: float) -> bytes:
        wanted = telegrams.decode_byte(telegram)
        if wanted not in (0, 1):
            return self._fault(Fault.INVALID_DATA)
        if name == "LMDscandata":
            self._mirror.skip_to(t)
            self._streaming = bool(wanted)
        return self._done(telegram).unsigned(wanted, 1).payload

    def _await_scan(self, t: float) -> None:
        """Send the next scan to be measured once more, in reply."""
        if not self._streaming:
            self._mirror.skip_to(t)
        self._asked = 1

    def _log_in(self, telegram: Telegram, _t: float) -> bytes:
        fields = fields_of(telegram)
        try:
            level, password = fields.unsigned(1), fields.unsigned(4)
        except FieldError:
            return self._fault(Fault.INVALID_DATA)
        self._logged_in = level >= telegrams.CLIENT_LEVEL and password == self._password
        return self._done(telegram).unsigned(int(self._logged_in), 1).payload

    def _log_out(self, telegram: Telegram, _t: float) -> bytes:
        self._logged_in = False
        return self._done(telegram).unsigned(telegrams.LOGGED_IN, 1).payload

    def _set_scanning(self, telegram: Telegram, t: float) -> bytes:
        wanted = Scanning.decode(telegram)
        if not self._logged_in or wanted is None:
            return self._fault(Fault.INVALID_DATA if self._logged_in else Fault.ACCESS_DENIED)
        accepted = (wanted.frequency, wanted.resolution) in _PAIRS
        if accepted:
            self.configuration_writes += 1
            self.scanning = Scanning(wanted.frequency, wanted.resolution, *_SECTOR)
            frequency = wanted.frequency / telegrams.PER_HERTZ
            self._mirror = EmulatedMirror(frequency, wanted.resolution / telegrams.PER_DEGREE)
            self._mirror.start(t + RUN_UP)
        result = telegrams.DONE if accepted else _REFUSED
        return self.scanning.write(self._done(telegram).unsigned(result, 1)).payload

    def _set_range(self, telegram: Telegram, _t: float) -> bytes:
        wanted = OutputRange.decode(telegram)
        if wanted is None or not _SECTOR[0] <= wanted.first < wanted.last <= _SECTOR[1]:
            return self._fault(Fault.INVALID_DATA)
        if not self._logged_in:
            return self._fault(Fault.WRITE_DENIED)
        self.output_range = wanted
        return self._written(telegram)

    def _set_content(self, telegram: Telegram, _t: float) -> bytes:
        wanted = ScanContent.decode(telegram)
        if wanted is None or wanted.every < 1:
            return self._fault(Fault.INVALID_DATA)
        if not self._logged_in:
            return self._fault(Fault.WRITE_DENIED)
        self.content = wanted
        return self._written(telegram)

    def _set_dialect(self, telegram: Telegram, t: float) -> bytes:
        """Answer in the present dialect, then take the other one."""
        wanted = telegrams.decode_byte(telegram)
        if wanted not in (0, 1):
            return self._fault(Fault.INVALID_DATA)
        if not self._logged_in:
            return self._fault(Fault.WRITE_DENIED)
        self._send(self._written(telegram), t + REPLY_TIME)
        self.dialect = Dialect.B if wanted else Dialect.A
        return b""

    def _written(self, telegram: Telegram) -> bytes:
        self.configuration_writes += 1
        return self._done(telegram).payload

    def _start_measuring(self, telegram: Telegram, t: float) -> bytes:
        if not self._logged_in:
            return self._fault(Fault.ACCESS_DENIED)
        if self._mirror.next_turn() is None:
            self._mirror.start(t + RUN_UP)
        return self._done(telegram).unsigned(telegrams.DONE, 1).payload

    def _stop_measuring(self, telegram: Telegram, _t: float) -> bytes:
        if not self._logged_in:
            return self._fault(Fault.ACCESS_DENIED)
        self._mirror.stop()
        return self._done(telegram).unsigned(telegrams.DONE, 1).payload

    def _done(self, telegram: Telegram) -> FieldWriter:
        """Begin the reply to a command."""
        return FieldWriter(telegrams.reply_to(telegram.command), self.dialect)

    def _fault(self, fault: Fault) -> bytes:
        return telegrams.encode_fault(fault, self.dialect)


def _time(item: TimedBytes) -> float:
    return item.t
