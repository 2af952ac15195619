"""The host's session with a SOPAS scanner, from finding its dialect to a stream of scans.

Sans-I/O: takes bytes and times, returns requests to the link. Order of steps: find the dialect (a
scanner left streaming is stopped by the same command), login, identity, window, then scanning,
output range and content: each is read, written where it is another, and read back; start to
measure, log out, stream. What is written is not stored in the scanner's EEPROM: it endures few
writes, and every session sets it. Source: SICK "Telegram Listing" 8014631, workflows.
"""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass
from enum import StrEnum

from drivers.lms1xx import telegrams
from drivers.lms1xx.exchange import TRIES, Exchange
from drivers.lms1xx.fields import FieldWriter
from drivers.lms1xx.framing import Dialect, Telegram, TelegramFramer, encode_telegram
from drivers.lms1xx.health import LaserHealth
from drivers.lms1xx.health_watch import HealthWatch
from drivers.lms1xx.measurement import decode_measurement
from drivers.lms1xx.scan import scan_of
from drivers.lms1xx.settings import LaserSettings
from drivers.lms1xx.telegrams import OutputRange, ScanContent, Scanning
from drivers.mounting import Mounting, as_mounted
from drivers.requests import Request, Write
from drivers.scan import Scan

SEARCH_LIMIT = 0.7  # s for the reply in one dialect; recorded scanners take 1 to 7 ms
REPLY_LIMIT = 2.0  # s
SETTING_LIMIT = 10.0  # s: another frequency changes the motor's speed
RUN_UP = 20.0  # s from the start to the first scan: the motor may have stood
INNER_SILENCE = 0.5  # s without a byte inside a telegram: its end is lost
RESTART_PAUSE = 0.5  # s
REQUEST_PAUSE = 0.02  # s after a scan: one that is asked answers at once, with the scan it has
REQUEST_LIMIT = 0.5  # s for a scan asked for, then it is asked for again
MAX_WRITES = 2  # of each setting; then the scanner is used as it is


class SessionState(StrEnum):
    """State of the session."""

    DOWN = "down"
    PAUSING = "pausing"
    SEARCHING = "searching"
    LOGGING_IN = "logging in"
    IDENTIFYING = "identifying"
    READING_WINDOW = "reading window"
    READING_SCANNING = "reading scanning"
    SETTING_SCANNING = "setting scanning"
    READING_RANGE = "reading range"
    SETTING_RANGE = "setting range"
    READING_CONTENT = "reading content"
    SETTING_CONTENT = "setting content"
    MEASURING = "starting to measure"
    LOGGING_OUT = "logging out"
    STARTING = "starting"
    STREAMING = "streaming"


@dataclass(slots=True)
class LaserCounters:
    """Counts since the session was made."""

    scans: int = 0
    unusable: int = 0  # telegrams of measured values that are no scan
    timeouts: int = 0
    refusals: int = 0
    searches: int = 0
    configuration_writes: int = 0


class Lms1xxSession:
    """Brings a scanner from any state to streaming, and keeps it streaming.

    After every call take ``pop_requests()`` and execute them in order. ``trouble`` is a line for
    people: why there are no scans, or which setting the scanner refused; None when all is as set.
    """

    def __init__(self, settings: LaserSettings) -> None:
        self.state = SessionState.DOWN
        self.dialect = Dialect.A
        self.identity: str | None = None
        self.trouble: str | None = None
        self.counters = LaserCounters()
        self.framer = TelegramFramer()
        self._settings = settings
        self._mounting: Mounting = settings
        self._exchange = Exchange()
        self._watch = HealthWatch()
        self._requests: list[Request] = []
        self._dialects: list[Dialect] = []
        self._last_received = 0.0
        self._last_scan: tuple[int, int] | None = None  # its counters
        self._asks_at = 0.0  # when to ask for the next scan, if by request
        self._writes: dict[SessionState, int] = {}
        self._on_reply: dict[SessionState, Callable[[Telegram | None, float], None]] = {
            SessionState.SEARCHING: self._found,
            SessionState.LOGGING_IN: self._logged_in,
            SessionState.IDENTIFYING: self._identified,
            SessionState.READING_WINDOW: self._window_read,
            SessionState.READING_SCANNING: self._scanning_read,
            SessionState.SETTING_SCANNING: self._scanning_set,
            SessionState.READING_RANGE: self._range_read,
            SessionState.SETTING_RANGE: self._range_set,
            SessionState.READING_CONTENT: self._content_read,
            SessionState.SETTING_CONTENT: self._content_set,
            SessionState.MEASURING: self._measuring,
            SessionState.LOGGING_OUT: self._logged_out,
            SessionState.STARTING: self._started,
        }

    @property
    def health(self) -> LaserHealth | None:
        """The scanner's condition as it reports it; None until the first report."""
        return self._watch.health

    @property
    def manner(self) -> str:
        """How it is spoken to, for people."""
        return f"in {self.dialect}"

    # Called by the owner of the link

    def link_up(self, t: float) -> None:
        """Start the search for the dialect: the connection is open."""
        self._search(t)

    def link_down(self, t: float) -> None:  # noqa: ARG002 - every session has this call
        """Drop requests and unfinished telegrams: the connection is closed."""
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
        self._write(telegrams.switch(telegrams.STREAM, self.dialect, 0))

    def pop_requests(self) -> list[Request]:
        """Return and clear the requests to the link, in order."""
        requests, self._requests = self._requests, []
        return requests

    def feed(self, data: bytes, t: float) -> list[Scan]:
        """Take bytes the last of which arrived at ``t``; return the scans they complete."""
        if self.state is SessionState.DOWN:
            return []
        scans: list[Scan] = []
        if self.framer.pending and t - self._last_received >= INNER_SILENCE:
            for telegram in self.framer.flush():
                scans += self._on_telegram(telegram, self._last_received)
        for telegram in self.framer.feed(data):
            scans += self._on_telegram(telegram, t)
        self._last_received = t
        self._ask(t)
        return scans

    def tick(self, t: float) -> None:
        """Handle timeouts: repeat the command, try the other dialect, start over."""
        if self.state is not SessionState.DOWN and t >= self._exchange.deadline:
            self._out_of_time(t)
        self._ask(t)

    # Bytes in

    def _on_telegram(self, telegram: Telegram, t: float) -> list[Scan]:
        if telegram.command in (telegrams.SCAN_SENT, telegrams.SCAN_READ):
            return self._on_measurement(telegram, t)
        self._watch.on_telegram(telegram)
        if self.state in self._on_reply and self._exchange.is_reply(telegram):
            refused = telegrams.decode_fault(telegram) is not None
            self.dialect = telegram.dialect  # the reply to the first question may be late
            self.counters.refusals += refused
            self._on_reply[self.state](None if refused else telegram, t)
        return []

    def _on_measurement(self, telegram: Telegram, t: float) -> list[Scan]:
        if self.state not in (SessionState.STARTING, SessionState.STREAMING):
            return []  # from a stream about to be stopped, of unknown geometry
        measurement = decode_measurement(telegram)
        scan = None if measurement is None else scan_of(measurement, t)
        if measurement is None or scan is None:
            self.counters.unusable += 1
            return []
        self.state = SessionState.STREAMING
        self._exchange.deadline = t + self._settings.silence
        self._asks_at = t + REQUEST_PAUSE
        self._watch.on_scan_status(scan.status)
        counted = measurement.scans, measurement.counted
        if counted == self._last_scan:
            return []  # asked for again before the next one was measured
        self._last_scan = counted
        self.counters.scans += 1
        return [as_mounted(scan, self._mounting)]

    # Time

    def _out_of_time(self, t: float) -> None:
        if self.state is SessionState.PAUSING:
            self._search(t)
        elif self.state is SessionState.STREAMING:
            self._start_over(self._with_health("no scan comes"), t)
        elif self._exchange.tries_left:
            # While it is looked for, silence is what most rates and dialects answer with.
            self.counters.timeouts += self.state is not SessionState.SEARCHING
            self._send(t)
        elif self.state is SessionState.SEARCHING:
            self._try_next_dialect(t)
        else:
            self._start_over(f"no answer to {self._exchange.command}", t)

    def _with_health(self, trouble: str) -> str:
        health = self.health
        return trouble if health is None or health.ok else f"{trouble}; {health.text}"

    def _request(
        self,
        state: SessionState,
        command: str,
        t: float,
        payload: bytes | None = None,
        limit: float = REPLY_LIMIT,
        tries: int = TRIES,
    ) -> None:
        self.state = state
        bare = telegrams.bare(command, self.dialect) if payload is None else payload
        self._exchange.begin(command, bare, limit, tries)
        self._send(t)

    def _send(self, t: float) -> None:
        self._requests.append(Write(self._exchange.send(t, self.dialect)))

    def _write(self, payload: bytes) -> None:
        self._requests.append(Write(encode_telegram(payload, self.dialect)))

    def _ask(self, t: float) -> None:
        """While streaming, ask for what does not come by itself."""
        if self.state is not SessionState.STREAMING:
            return
        if self._watch.question_due(t):
            self._write(telegrams.bare(telegrams.READ_CONTAMINATION, self.dialect))
        if self._settings.by_request and t >= self._asks_at:
            self._asks_at = t + REQUEST_LIMIT
            self._write(telegrams.bare(telegrams.READ_SCAN, self.dialect))

    # Finding the scanner

    def _start_over(self, trouble: str, t: float) -> None:
        self.trouble = trouble
        self.state = SessionState.PAUSING
        self._exchange.deadline = t + RESTART_PAUSE

    def _search(self, t: float) -> None:
        self.counters.searches += 1
        self._writes.clear()
        self._last_scan = None
        other = Dialect.B if self.dialect is Dialect.A else Dialect.A
        self._dialects = [self.dialect, other]
        self._try_next_dialect(t)

    def _try_next_dialect(self, t: float) -> None:
        if not self._dialects:
            self._start_over("no answer in CoLa A or B: is this a SICK scanner's port?", t)
            return
        self.dialect = self._dialects.pop(0)
        stop = telegrams.switch(telegrams.STREAM, self.dialect, 0)
        self._request(SessionState.SEARCHING, telegrams.STREAM, t, stop, SEARCH_LIMIT, tries=1)

    def _found(self, _reply: Telegram | None, t: float) -> None:
        self.trouble = None
        login = telegrams.login(self.dialect)
        self._request(SessionState.LOGGING_IN, telegrams.LOGIN, t, login)

    # Setting it up. A reply is None where the scanner refused the command.

    def _logged_in(self, reply: Telegram | None, t: float) -> None:
        if reply is None or telegrams.decode_byte(reply) != telegrams.LOGGED_IN:
            self.trouble = "laser refused the login: was its password changed?"
        self._request(SessionState.IDENTIFYING, telegrams.READ_IDENTITY, t)

    def _identified(self, reply: Telegram | None, t: float) -> None:
        self.identity = None if reply is None else telegrams.decode_identity(reply)
        self._request(SessionState.READING_WINDOW, telegrams.READ_CONTAMINATION, t)

    def _window_read(self, _reply: Telegram | None, t: float) -> None:
        self._request(SessionState.READING_SCANNING, telegrams.READ_SCANNING, t)

    def _scanning_read(self, reply: Telegram | None, t: float) -> None:
        present = None if reply is None else Scanning.decode(reply)
        wanted = None if present is None else self._settings.scanning(present)
        if wanted is None or present == wanted:
            self._read_range(t)
        elif self._may_write(SessionState.SETTING_SCANNING, "frequency and resolution"):
            writer = FieldWriter(telegrams.SET_SCANNING, self.dialect)
            self._set(
                SessionState.SETTING_SCANNING, telegrams.SET_SCANNING, wanted.write(writer), t
            )
        else:
            self._read_range(t)

    def _scanning_set(self, reply: Telegram | None, t: float) -> None:
        answer = None if reply is None else Scanning.decode_set(reply)
        if answer is None or answer[0] != telegrams.DONE:
            frequency, step = self._settings.frequency, self._settings.resolution_deg
            self.trouble = f"laser refused {frequency:g} Hz in steps of {step:g} degrees"
            self._read_range(t)
        else:
            self._request(SessionState.READING_SCANNING, telegrams.READ_SCANNING, t)

    def _read_range(self, t: float) -> None:
        self._request(SessionState.READING_RANGE, telegrams.READ_RANGE, t)

    def _range_read(self, reply: Telegram | None, t: float) -> None:
        present = None if reply is None else OutputRange.decode(reply)
        wanted = self._settings.output_range
        if present is None or present.fits(wanted):
            self._read_content(t)
        elif self._may_write(SessionState.SETTING_RANGE, "field of view"):
            writer = FieldWriter(telegrams.SET_RANGE, self.dialect)
            self._set(SessionState.SETTING_RANGE, telegrams.SET_RANGE, wanted.write(writer), t)
        else:
            self._read_content(t)

    def _range_set(self, reply: Telegram | None, t: float) -> None:
        if reply is None:
            field = self._settings.field_of_view_deg
            self.trouble = f"laser refused a field of {field:g} degrees"
            self._read_content(t)
        else:
            self._read_range(t)

    def _read_content(self, t: float) -> None:
        self._request(SessionState.READING_CONTENT, telegrams.READ_CONTENT, t)

    def _content_read(self, reply: Telegram | None, t: float) -> None:
        present = None if reply is None else ScanContent.decode(reply)
        wanted = None if present is None else present.for_ranges()
        if wanted is None or present == wanted:
            self._measure(t)
        elif self._may_write(SessionState.SETTING_CONTENT, "content of scans"):
            writer = FieldWriter(telegrams.SET_CONTENT, self.dialect)
            self._set(SessionState.SETTING_CONTENT, telegrams.SET_CONTENT, wanted.write(writer), t)
        else:
            self._measure(t)

    def _content_set(self, reply: Telegram | None, t: float) -> None:
        if reply is None:
            self.trouble = "laser refused the content of its scans"
            self._measure(t)
        else:
            self._read_content(t)

    def _may_write(self, setting: SessionState, what: str) -> bool:
        """Return whether a setting may be written once more; else say that it is not kept."""
        written = self._writes.get(setting, 0)
        self._writes[setting] = written + 1
        if written < MAX_WRITES:
            return True
        self.trouble = f"laser does not keep its {what}"
        return False

    def _set(self, state: SessionState, command: str, writer: FieldWriter, t: float) -> None:
        self.counters.configuration_writes += 1
        self._request(state, command, t, writer.payload, SETTING_LIMIT)

    def _measure(self, t: float) -> None:
        self._request(SessionState.MEASURING, telegrams.START_MEASURING, t, limit=SETTING_LIMIT)

    def _measuring(self, _reply: Telegram | None, t: float) -> None:
        self._request(SessionState.LOGGING_OUT, telegrams.LOGOUT, t, limit=SETTING_LIMIT)

    def _logged_out(self, _reply: Telegram | None, t: float) -> None:
        if self._settings.by_request:
            self._stream(t)
            return
        start = telegrams.switch(telegrams.STREAM, self.dialect, 1)
        self._request(SessionState.STARTING, telegrams.STREAM, t, start)

    def _started(self, reply: Telegram | None, t: float) -> None:
        if reply is None or telegrams.decode_byte(reply) != 1:
            self._start_over(self._with_health("laser refused to stream"), t)
        else:
            self._stream(t)

    def _stream(self, t: float) -> None:
        self.state = SessionState.STREAMING
        self._exchange.deadline = t + RUN_UP
        self._asks_at = t
