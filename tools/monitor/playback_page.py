"""The page of a playback: the recordings played, and surveyed beside that."""

from __future__ import annotations

from collections.abc import Iterator
from contextlib import closing, contextmanager

from tools.monitor.playback import Playback
from tools.monitor.shift_log import ShiftLog
from tools.monitor.site import Site
from tools.monitor.survey import Survey
from tools.monitor.team_state import TeamState
from tools.monitor.watch import Watch
from tools.monitor.web_server import WebServer


@contextmanager
def playback_page(playback: Playback, site: Site, address: str) -> Iterator[WebServer]:
    """Serve a playback at an address such as ``127.0.0.1:8080`` while the context lasts.

    Raises WebError: the address is invalid or taken.
    """
    with (
        closing(ShiftLog(None)) as log,
        closing(Survey(playback.files, site, log)) as survey,
        closing(WebServer(Watch(TeamState(), site), playback, address, log, survey)) as server,
    ):
        yield server
