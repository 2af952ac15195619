"""The operator's monitor: receives telemetry, derives alarms, serves the page."""

from __future__ import annotations

import math
import threading
import time
from collections.abc import Callable, Iterator
from contextlib import ExitStack
from dataclasses import dataclass
from pathlib import Path

from maps.map_folder import DEFAULT_BORDER
from tools.monitor.alarm import Condition, Severity
from tools.monitor.certificate_watch import CertificateWatch
from tools.monitor.forwarder import Forwarder
from tools.monitor.foxglove_server import FoxgloveServer
from tools.monitor.lasting_thread import LastingThread
from tools.monitor.operator import Operator, Tap
from tools.monitor.shift_log import ShiftLog
from tools.monitor.site import Site
from tools.monitor.source import LiveSource
from tools.monitor.team_recorder import TeamRecorder
from tools.monitor.watch import Watch
from tools.monitor.web_server import WebServer


@dataclass(frozen=True)
class MonitorOptions:
    """Options of a monitor."""

    listen: str
    """Zenoh endpoint the robots connect to."""
    http: str | None
    """Address of the page, host:port; None: no page."""
    site: Site
    record: Path | None = None
    """File every payload is recorded to; None: no recording."""
    border: str = DEFAULT_BORDER
    """Name of the site's border, stored in the recording."""
    keys: Path | None = None
    """The operator's folder of ``patrol keys``, for a tls endpoint; None: no TLS."""
    forward: str | None = None
    """Zenoh endpoint of a head office that every payload is forwarded to; None: none."""
    forward_keys: Path | None = None
    """This site's folder of the office's ``patrol keys``, for a tls office; None: no TLS."""
    log: Path | None = None
    """File of the shift log; None: kept in memory until the monitor ends."""
    foxglove: str | None = None
    """Address for Foxglove viewers, host:port; None: none."""


class Monitor:
    """A live monitor; runs until ``close``."""

    def __init__(self, options: MonitorOptions) -> None:
        """Listen to robots and serve the page.

        Raises:
            OperatorError: the robots' endpoint is invalid or taken.
            WebError: an address of page or viewers is invalid or taken.
            ForwardError: the office's endpoint is invalid.
            KeysError, CertificateError: the keys cannot be read.
            ShiftLogError: the shift log's file cannot be used.
        """
        self.options = options
        self.url: str | None = None
        """URL that opens the page with the right to act on it; None: no page."""
        self.check: Callable[[], None]
        """Raises RuntimeError if page or table are kept up to date no more."""
        self._recorder: TeamRecorder | None = None
        self._forwarder: Forwarder | None = None
        with ExitStack() as stack:
            self.log = ShiftLog(options.log)
            stack.callback(self.log.close)
            taps = list(self._open_taps(stack))
            self.operator = Operator(self.options.listen, taps, self.options.keys)
            stack.callback(self.operator.close)
            self._certificates = (
                CertificateWatch(options.keys),
                CertificateWatch(options.forward_keys, consequence="the office hears nothing"),
            )
            self.watch = Watch(self.operator.team, self.options.site, self.conditions, self.log.put)
            source = LiveSource(options.listen)
            if self.options.http is None:
                caller = PeriodicCall(lambda: source.advance(self.watch))
                stack.callback(caller.close)
                self.check = caller.check
            else:
                server = WebServer(self.watch, source, self.options.http, self.log)
                stack.callback(server.close)
                self.url = server.link
                self.check = server.check
            self._stack = stack.pop_all()

    def close(self) -> None:
        """Close everything; idempotent."""
        self._stack.close()

    def _open_taps(self, stack: ExitStack) -> Iterator[Tap]:
        """Yield the functions that get every payload: recording, office, viewers."""
        options = self.options
        if options.record is not None:
            site = options.site
            self._recorder = TeamRecorder(options.record, site.folder, options.border, site.zones)
            stack.callback(self._recorder.close)
            yield self._recorder.on_payload
        if options.forward is not None:
            self._forwarder = Forwarder(options.forward, options.forward_keys)
            stack.callback(self._forwarder.close)
            yield self._forwarder.on_payload
        if options.foxglove is not None:
            viewers = FoxgloveServer(options.foxglove, options.site.zones)
            stack.callback(viewers.close)
            yield viewers.on_payload

    def conditions(self) -> Iterator[Condition]:
        """Yield the conditions of the monitor itself."""
        for certificates in self._certificates:
            yield from certificates.conditions()
        if self._forwarder is not None and (trouble := self._forwarder.trouble):
            yield Condition("", "office", Severity.WARNING, trouble)
        if self.log.failed:
            yield Condition("", "shift log", Severity.CRITICAL, self.log.failed)
        recorder = self._recorder
        if recorder is not None and (recorder.failed or recorder.lost):
            words = recorder.failed or f"{recorder.lost} payloads not recorded, the disk is slow"
            yield Condition("", "recording", Severity.CRITICAL, words)


class PeriodicCall:
    """Calls a function periodically on its own thread until closed."""

    def __init__(self, call: Callable[[], None], period: float = 0.1) -> None:
        """Start at once; period: pause between two calls, s."""
        self._ending = threading.Event()
        self._thread = LastingThread(lambda: self._run(call, period), "monitor's clock")

    def _run(self, call: Callable[[], None], period: float) -> None:
        while True:
            call()
            if self._ending.wait(period):
                return

    def check(self) -> None:
        """Raise RuntimeError if a call has raised and no more are made."""
        self._thread.check()

    def close(self) -> None:
        """Stop after the present call and wait for it."""
        self._ending.set()
        self._thread.join()


def until(duration: float | None) -> Callable[[], bool]:
    """Return a function that is True until a duration, s, from now is over; None: for ever."""
    end = math.inf if duration is None else time.monotonic() + duration
    return lambda: time.monotonic() < end


def while_sound(going_on: Callable[[], bool], check: Callable[[], None]) -> Callable[[], bool]:
    """Return ``going_on`` that calls ``check`` first, which raises if the monitor has failed."""

    def sound() -> bool:
        check()
        return going_on()

    return sound
