"""The operator's side put together: hears the team, derives what is wrong, serves the page."""

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
from tools.monitor.forwarder import Forwarder
from tools.monitor.foxglove_server import FoxgloveServer
from tools.monitor.operator import Operator, Tap
from tools.monitor.site import Site
from tools.monitor.source import LiveSource
from tools.monitor.team_recorder import TeamRecorder
from tools.monitor.watch import Watch
from tools.monitor.web_server import WebServer


@dataclass(frozen=True)
class MonitorOptions:
    """What a monitor is made of."""

    listen: str
    """Zenoh endpoint robots dial."""
    http: str | None
    """Where the page is served; None: no page."""
    site: Site
    record: Path | None = None
    """Where every payload is written to; None: nowhere."""
    border: str = DEFAULT_BORDER
    """Name of the site's border, for whoever plays the recording."""
    keys: Path | None = None
    """The operator's folder of ``patrol keys``, for a tls endpoint."""
    forward: str | None = None
    """Zenoh endpoint of a head office that hears everything too."""
    foxglove: str | None = None
    """Where Foxglove viewers are served."""


class Monitor:
    """A live monitor, until closed."""

    def __init__(self, options: MonitorOptions) -> None:
        """Listen, and serve the page.

        Raises:
            OperatorError: the robots' endpoint is none, or taken.
            WebError: the page's address is.
        """
        self.options = options
        self.url: str | None = None
        self._recorder: TeamRecorder | None = None
        with ExitStack() as stack:
            taps = list(self._open_taps(stack))
            self.operator = Operator(self.options.listen, taps, self.options.keys)
            stack.callback(self.operator.close)
            self.watch = Watch(self.operator.team, self.options.site, self._ailments)
            source = LiveSource()
            if self.options.http is None:
                stack.callback(Beat(lambda: source.advance(self.watch)).close)
            else:
                server = WebServer(self.watch, source, self.options.http)
                stack.callback(server.close)
                self.url = server.url
            self._stack = stack.pop_all()

    def close(self) -> None:
        """Close everything; idempotent."""
        self._stack.close()

    def _open_taps(self, stack: ExitStack) -> Iterator[Tap]:
        """Yield what gets every payload as it comes: recording, office, viewer."""
        options = self.options
        if options.record is not None:
            self._recorder = TeamRecorder(options.record, options.site.folder, options.border)
            stack.callback(self._recorder.close)
            yield self._recorder.on_payload
        if options.forward is not None:
            forwarder = Forwarder(options.forward)
            stack.callback(forwarder.close)
            yield forwarder.on_payload
        if options.foxglove is not None:
            viewers = FoxgloveServer(options.foxglove)
            stack.callback(viewers.close)
            yield viewers.on_payload

    def _ailments(self) -> Iterator[Condition]:
        """Yield what is wrong with the monitor itself."""
        recorder = self._recorder
        if recorder is not None and (recorder.failed or recorder.lost):
            words = recorder.failed or f"{recorder.lost} payloads not recorded, the disk is slow"
            yield Condition("", "recording", Severity.CRITICAL, words)


class Beat:
    """Calls something a few times a second on a thread of its own, until closed."""

    def __init__(self, call: Callable[[], None], period: float = 0.1) -> None:
        """Begin at once; period in s."""
        self._ending = threading.Event()
        self._thread = threading.Thread(target=self._run, args=(call, period), daemon=True)
        self._thread.start()

    def _run(self, call: Callable[[], None], period: float) -> None:
        while True:
            call()
            if self._ending.wait(period):
                return

    def close(self) -> None:
        """Let the last call end."""
        self._ending.set()
        self._thread.join()


def until(duration: float | None) -> Callable[[], bool]:
    """Return what tells whether a duration (s) from now is still going on; None: for ever."""
    end = math.inf if duration is None else time.monotonic() + duration
    return lambda: time.monotonic() < end
