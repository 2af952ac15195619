"""The host's session with an LMS 200, from finding its rate to a stream of scans.

Sans-I/O: takes bytes and times, returns requests to the link. Order of steps: find the rate (a
laser left streaming is stopped by the same command), set the wanted rate, type, status (and the
rate, where it tells another), errors, variant, configuration, stream. Variant and configuration are
written only where the laser reports others: its EEPROM endures few writes. Source: SICK telegram
listing 8007954/Q501, timing and modes.
"""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass
from enum import StrEnum

from drivers.lms200 import telegrams
from drivers.lms200.exchange import Exchange
from drivers.lms200.framing import REPLY_BIT, Ack, Nak, Telegram, TelegramFramer
from drivers.lms200.framing import encode_telegram as encode
from drivers.lms200.health import LaserHealth
from drivers.lms200.health_watch import HealthWatch
from drivers.lms200.measured_parts import OUTPUT_CODES, decode_output, stream_command
from drivers.lms200.measurement import MEASURING_MODES
from drivers.lms200.rate_search import COMMON_RATES, RateSearch
from drivers.lms200.scan import scan_of
from drivers.lms200.settings import LaserSettings
from drivers.lms200.telegrams import Configuration, DeviceStatus, VariantReply
from drivers.mounting import Mounting, as_mounted
from drivers.requests import Request, SetBaud, Write
from drivers.scan import Scan

REPLY_LIMIT = 1.0  # s after the ACK
MODE_LIMIT = 3.0  # s, mode changes
CONFIGURATION_LIMIT = 15.0  # s, writing the EEPROM
SETTLING = 0.25  # s, both ends changing rate
INNER_SILENCE = 0.25  # s without a byte inside a telegram: its end is lost
RESTART_PAUSE = 0.5  # s
MAX_WRITES = 2  # of variant and of configuration, each; then the laser is used as it is

_BITS_PER_BYTE = 10


class SessionState(StrEnum):
    """State of the session."""

    DOWN = "down"
    PAUSING = "pausing"
    SEARCHING = "searching"
    CHANGING_RATE = "changing rate"
    SETTLING = "settling"
    IDENTIFYING = "identifying"
    READING_STATUS = "reading status"
    READING_ERRORS = "reading errors"
    SETTING_VARIANT = "setting variant"
    READING_CONFIGURATION = "reading configuration"
    UNLOCKING = "unlocking"
    WRITING_CONFIGURATION = "writing configuration"
    STARTING = "starting"
    STREAMING = "streaming"


@dataclass(slots=True)
class LaserCounters:
    """Counts since the session was made."""

    scans: int = 0
    unusable: int = 0  # telegrams of measured values that are no whole scan
    timeouts: int = 0
    naks: int = 0
    searches: int = 0
    variant_writes: int = 0
    configuration_writes: int = 0


class Lms200Session:
    """Brings a laser from any state to streaming, and keeps it streaming.

    After every call take ``pop_requests()`` and execute them in order. ``trouble`` is a line for
    people: why there are no scans, or which setting the laser refused; None when all is as set.
    """

    def __init__(self, settings: LaserSettings) -> None:
        self.state = SessionState.DOWN
        self.identity: str | None = None
        self.trouble: str | None = None
        self.counters = LaserCounters()
        self.framer = TelegramFramer()
        self._settings = settings
        self._mounting: Mounting = settings
        self._mode = MEASURING_MODES[settings.mode_code]
        self._exchange = Exchange(self.framer)
        self._watch = HealthWatch()
        self._requests: list[Request] = []
        self._rates = RateSearch(settings.baud)
        self._status: DeviceStatus | None = None
        self._variant = settings.variant  # of the laser: sub-ranges count its beams
        self._last_received = 0.0
        self._awaits_reply = False
        self._rate_ordered = False  # in this search: once, also if the laser keeps another
        self._configuration_attempts = 0
        self._wanted_configuration = telegrams.STANDARD_CONFIGURATION
        self._on_reply: dict[SessionState, Callable[[Telegram, float], None]] = {
            SessionState.SEARCHING: self._rate_found,
            SessionState.CHANGING_RATE: self._rate_changed,
            SessionState.IDENTIFYING: self._identified,
            SessionState.READING_STATUS: self._status_read,
            SessionState.READING_ERRORS: self._errors_read,
            SessionState.SETTING_VARIANT: self._variant_set,
            SessionState.READING_CONFIGURATION: self._configuration_read,
            SessionState.UNLOCKING: self._unlocked,
            SessionState.WRITING_CONFIGURATION: self._configuration_written,
            SessionState.STARTING: self._started,
        }

    @property
    def health(self) -> LaserHealth | None:
        """The laser's condition as it reports it; None until the first report."""
        return self._watch.health

    @property
    def baud(self) -> int:
        """The present rate of the line."""
        return self._rates.baud

    @property
    def manner(self) -> str:
        """How it is spoken to, for people."""
        return f"at {self.baud} baud"

    @property
    def answers(self) -> bool:
        """Whether the laser answers, if slowly: it is being set up, or sends scans."""
        if self.state is SessionState.SEARCHING:
            return self._exchange.is_acknowledged
        return self.state not in (SessionState.DOWN, SessionState.PAUSING)

    # Called by the owner of the link

    def link_up(self, t: float) -> None:
        """Start the search for the laser: the port is open."""
        self._search(self._settings.baud, t)

    def link_down(self, t: float) -> None:  # noqa: ARG002 - every session has this call
        """Drop requests and unfinished telegrams: the port is closed."""
        self.state = SessionState.DOWN
        self._requests.clear()
        self.framer.reset()

    def remount(self, mounting: Mounting) -> None:
        """Take another mounting."""
        self._mounting = mounting

    def shut_down(self, t: float) -> None:
        """Stop the stream and end; ``link_up`` starts again."""
        if self.state is SessionState.DOWN:
            return
        self.link_down(t)
        self._requests.append(Write(encode(telegrams.SELECT_ON_REQUEST)))

    def pop_requests(self) -> list[Request]:
        """Return and clear the requests to the link, in order."""
        requests, self._requests = self._requests, []
        return requests

    def feed(self, data: bytes, t: float) -> list[Scan]:
        """Take bytes the last of which arrived at ``t``; return the scans they complete."""
        if self.state is SessionState.DOWN:
            return []
        scans: list[Scan] = []
        if self.state in self._on_reply:
            self._exchange.on_bytes(t)
        if self.framer.pending and t - self._last_received >= INNER_SILENCE:
            for item in self.framer.flush():
                scans += self._on_item(item, self._last_received)
        for item in self.framer.feed(data):
            scans += self._on_item(item, t)
        if self._awaits_reply and self.framer.pending:
            for item in self.framer.break_off():
                scans += self._on_item(item, t)
        self._last_received = t
        self._query_health(t)
        return scans

    def tick(self, t: float) -> None:
        """Handle timeouts: repeat the request, try the next rate, start over."""
        if self._awaits_reply and t - self._last_received >= INNER_SILENCE:
            for item in self.framer.break_off(silent=True):
                self._on_item(item, self._last_received)
        if self.state is not SessionState.DOWN and t >= self._exchange.deadline:
            self._out_of_time(t)
        self._query_health(t)

    # Bytes in

    def _on_item(self, item: Telegram | Ack | Nak, t: float) -> list[Scan]:
        if isinstance(item, Telegram):
            return self._on_telegram(item, t)
        if self.state in self._on_reply and not self._exchange.amid_noise:
            if isinstance(item, Ack):
                self._exchange.acknowledged(t)
            else:
                self.counters.naks += 1
                self._exchange.refused(t)
        return []

    def _on_telegram(self, telegram: Telegram, t: float) -> list[Scan]:
        if telegram.code in OUTPUT_CODES:
            return self._on_measurement(telegram, t)
        self._awaits_reply = False
        self._watch.on_telegram(telegram)
        if telegram.code == telegrams.POWER_ON:
            self._search(self.baud, t)
        elif self.state in self._on_reply:
            command = self._exchange.command[0]
            if telegram.code == command | REPLY_BIT:
                self._on_reply[self.state](telegram, t)
            elif telegram.code == telegrams.BAD_COMMAND:
                self._start_over(f"laser refused command {command:02X}", t)
        return []

    def _on_measurement(self, telegram: Telegram, t: float) -> list[Scan]:
        if self.state not in (SessionState.STARTING, SessionState.STREAMING):
            return []  # from a stream about to be stopped, of unknown geometry
        measurement = decode_output(telegram, self._mode, self._variant)
        if measurement is None:
            self.counters.unusable += 1
            return []
        self._watch.on_scan_status(measurement.status)
        self.state = SessionState.STREAMING
        self._rates.on_scan()
        self.counters.scans += 1
        self._exchange.deadline = t + self._settings.silence
        byte_time = _BITS_PER_BYTE / self.baud
        arrival = t - telegram.bytes_after * byte_time
        scan = scan_of(measurement, arrival, telegram.wire_length * byte_time)
        return [as_mounted(scan, self._mounting)]

    # Time

    def _out_of_time(self, t: float) -> None:
        if self.state is SessionState.PAUSING:
            self._search(self._settings.baud, t)
        elif self.state is SessionState.SETTLING:
            self._request(SessionState.IDENTIFYING, telegrams.READ_TYPE, t)
        elif self.state is SessionState.STREAMING:
            silent = f"no scan for {self._settings.silence:g} s"
            self._start_over(self._with_health(silent), t)
        elif self.state is SessionState.SEARCHING and self._is_unlikely and not self._rates.ends:
            self._try_next_rate(t)
        elif self._exchange.tries_left:
            # While it is looked for, silence is what most rates and dialects answer with.
            self.counters.timeouts += self.state is not SessionState.SEARCHING
            self._send(t)
        elif self.state is SessionState.SEARCHING:
            self._try_next_rate(t)
        else:
            command = f"{self._exchange.command[0]:02X}"
            self._start_over(f"no answer to command {command} at {self.baud} baud", t)

    def _with_health(self, trouble: str) -> str:
        health = self.health
        if health is None or health.ok:
            return trouble
        return f"{trouble}; laser reports {health.text}"

    def _request(
        self, state: SessionState, command: bytes, t: float, limit: float = REPLY_LIMIT
    ) -> None:
        self.state = state
        self._exchange.begin(command, limit)
        self._send(t)

    def _send(self, t: float) -> None:
        self._awaits_reply = True
        self._requests.append(Write(self._exchange.send(t, self.baud)))

    def _query_health(self, t: float) -> None:
        """While streaming, query the laser's condition when its status byte has changed."""
        if self.state is SessionState.STREAMING:
            command = self._watch.next_command(t)
            if command is not None:
                if command == telegrams.SELECT_CONTINUOUS:
                    command = self._stream_command
                self._awaits_reply = True
                self._requests.append(Write(encode(command)))

    # Finding the laser

    def _start_over(self, trouble: str, t: float) -> None:
        self.trouble = trouble
        self.state = SessionState.PAUSING
        self._exchange.deadline = t + RESTART_PAUSE

    def _search(self, first_baud: int, t: float) -> None:
        self.counters.searches += 1
        self._rates.restart(first_baud)
        self._watch.restart()
        self._rate_ordered = False
        self._try_next_rate(t)

    def _try_next_rate(self, t: float) -> None:
        if self._rates.ends:
            rates = ", ".join(map(str, COMMON_RATES))
            self._start_over(f"no laser answers at {rates} baud: check its power and cable", t)
            return
        self._rates.advance()
        self._set_baud(self.baud)
        self._request(SessionState.SEARCHING, telegrams.SELECT_ON_REQUEST, t, MODE_LIMIT)

    @property
    def _is_unlikely(self) -> bool:
        """Whether a search leaves its rate before all tries: noise, or a quick look in silence."""
        if self._exchange.only_noise:
            return True
        return self._rates.glances and not self._exchange.heard

    def _set_baud(self, baud: int) -> None:
        self._rates.baud = baud
        self.framer.reset()
        self._requests.append(SetBaud(baud))

    def _rate_found(self, _reply: Telegram, t: float) -> None:
        self.trouble = None
        if self.baud == self._settings.baud:
            self._request(SessionState.IDENTIFYING, telegrams.READ_TYPE, t)
        else:
            self._order_rate(t)

    def _order_rate(self, t: float) -> None:
        self._rate_ordered = True
        command = telegrams.select_baud(self._settings.baud)
        self._request(SessionState.CHANGING_RATE, command, t, MODE_LIMIT)

    def _rate_changed(self, reply: Telegram, t: float) -> None:
        if telegrams.first_data_byte(reply) == telegrams.MODE_SELECTED:
            self._set_baud(self._settings.baud)
        else:
            self.trouble = f"laser refused {self._settings.baud} baud, stays at {self.baud}"
        self.state = SessionState.SETTLING
        self._exchange.deadline = t + SETTLING

    # Setting it up

    def _identified(self, reply: Telegram, t: float) -> None:
        self.identity = telegrams.decode_text(reply)
        self._request(SessionState.READING_STATUS, telegrams.READ_STATUS, t)

    def _status_read(self, reply: Telegram, t: float) -> None:
        self._status = DeviceStatus.decode(reply)
        told = None if self._status is None else self._status.baud
        if told not in (None, self._settings.baud) and not self._rate_ordered:
            self._order_rate(t)  # a line without a rate, as TCP: the laser has another all the same
        else:
            self._request(SessionState.READING_ERRORS, telegrams.READ_ERRORS, t)

    def _errors_read(self, _reply: Telegram, t: float) -> None:
        if self._status is not None and self._status.variant in telegrams.VARIANTS:
            self._variant = self._status.variant
        if self._status is not None and self._status.variant == self._settings.variant:
            self._read_configuration(t)
        elif self.counters.variant_writes >= MAX_WRITES:
            self.trouble = "laser does not keep its field of view and step"
            self._read_configuration(t)
        else:
            self.counters.variant_writes += 1
            command = telegrams.set_variant(self._settings.variant)
            self._request(SessionState.SETTING_VARIANT, command, t, CONFIGURATION_LIMIT)

    def _variant_set(self, reply: Telegram, t: float) -> None:
        answer = VariantReply.decode(reply)
        if answer is None or not answer.accepted:
            field, step = self._settings.field_of_view_deg, self._settings.resolution_deg
            self._start_over(f"laser refused a field of {field} degrees in steps of {step:g}", t)
        else:
            self._variant = self._settings.variant
            self._read_configuration(t)

    def _read_configuration(self, t: float) -> None:
        self._request(SessionState.READING_CONFIGURATION, telegrams.READ_CONFIGURATION, t)

    def _configuration_read(self, reply: Telegram, t: float) -> None:
        present = telegrams.decode_read_configuration(reply)
        if present is None:
            self._start_over("laser sent an unreadable configuration", t)
            return
        wanted = present.changed(self._settings.mode_code, self._settings.unit_code)
        if present == wanted:
            self._start(present, t)
        elif self._configuration_attempts >= MAX_WRITES:
            if present.measuring_mode not in MEASURING_MODES:
                self._start_over(f"laser keeps mode {present.measuring_mode:02X}: no ranges", t)
                return
            self.trouble = "laser does not keep its measuring mode and units"
            self._start(present, t)
        else:
            self._configuration_attempts += 1
            self._wanted_configuration = wanted
            self._request(SessionState.UNLOCKING, telegrams.SELECT_INSTALLATION, t, MODE_LIMIT)

    def _unlocked(self, reply: Telegram, t: float) -> None:
        if telegrams.first_data_byte(reply) != telegrams.MODE_SELECTED:
            self._start_over("laser refused installation mode: was its password changed?", t)
            return
        self.counters.configuration_writes += 1
        command = telegrams.write_configuration(self._wanted_configuration)
        self._request(SessionState.WRITING_CONFIGURATION, command, t, CONFIGURATION_LIMIT)

    def _configuration_written(self, reply: Telegram, t: float) -> None:
        if telegrams.first_data_byte(reply) != telegrams.ACCEPTED:
            self._start_over("laser refused its configuration", t)
            return
        self._start(self._wanted_configuration, t)

    def _start(self, configuration: Configuration, t: float) -> None:
        self._mode = MEASURING_MODES[configuration.measuring_mode]
        self._request(SessionState.STARTING, self._stream_command, t, MODE_LIMIT)

    @property
    def _stream_command(self) -> bytes:
        settings = self._settings
        return stream_command(
            mean_of=settings.mean_of,
            part=settings.part,
            remission=settings.remission,
            turns=settings.partial_scans,
            count=settings.variant.count,
        )

    def _started(self, reply: Telegram, t: float) -> None:
        if telegrams.first_data_byte(reply) != telegrams.MODE_SELECTED:
            self._start_over(self._with_health("laser refused to stream"), t)
            return
        self.state = SessionState.STREAMING
        self._exchange.deadline = t + self._settings.silence
