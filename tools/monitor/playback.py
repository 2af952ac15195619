"""Plays recordings into a watch: several files in step, with pause, speed and seek."""

from __future__ import annotations

import time
from collections.abc import Callable, Sequence
from pathlib import Path
from typing import Any

from maps.map_folder import DEFAULT_BORDER, map_folder_from_files
from maps.zone_file import ZONES_FILE, read_zones
from robot_agent.recording.recording_writer import CONFIGURATION_ATTACHMENT, RUN_METADATA
from tools.logs.recorded_config import parse_old_config
from tools.monitor.payload_stream import PayloadStream
from tools.monitor.recorded_payloads import RecordedPayloads
from tools.monitor.site import Site
from tools.monitor.team_recorder import TEAM_METADATA
from tools.monitor.watch import Watch

PREROLL_S = 300.0
"""Time before a seek target that is played fast, to fill plots, trails and coverage."""
_PREROLL_STEP_S = 1.0  # short enough that a patrolling robot visits every border point
_LAST_S = 2.0  # all streams are read this long before the target: each has occurred by then
_BUDGET_S = 0.05
"""Real time per step of the fast playback: pages are served in between."""
_SPEEDS = (0.1, 100.0)
_MAX_STEP_S = 0.5
"""Most real time per step: a delayed step does not make the playback jump."""


class Playback:
    """Source of recorded telemetry; its time is the recordings' wall time, s since 1970."""

    def __init__(self, paths: Sequence[Path], clock: Callable[[], float] = time.monotonic) -> None:
        """Open recordings; ``clock`` returns real time, s.

        Raises:
            RecordingError: a file is no recording, or holds no telemetry.
        """
        self.files = [RecordedPayloads(path) for path in paths]
        self._stream = PayloadStream(self.files)
        self.start, self.end = self._stream.start, self._stream.end
        self.epoch = 0
        self.listen = ""
        self.t = self.start
        self.speed = 1.0
        self.paused = False
        self._clock = clock
        self._last = clock()
        self._seek_target: float | None = None
        self._catch_up_target: float | None = None  # target of the fast playback

    def site(self) -> Site:
        """Return the site of the first recording that holds one; without a map if none does."""
        for file in self.files:
            if file.map_files:
                name, border = _map_of(file)
                folder = map_folder_from_files(name, file.map_files, border)
                return Site(folder, read_zones(file.map_files.get(ZONES_FILE, b""), name))
        return Site(None)

    def description(self) -> dict[str, Any]:
        """Return start, end and present time (s since 1970), speed and pause, for the page."""
        return {
            "kind": "playback",
            "start": self.start,
            "end": self.end,
            "t": self.t,
            "speed": self.speed,
            "paused": self.paused,
        }

    def steer(self, *, pause: bool | None, speed: float | None, seek: float | None) -> None:
        """Pause or resume, set the speed (x real time), seek (s since 1970); None: no change.

        Values out of range are clamped. Resuming at the end starts again.
        """
        if pause is not None:
            self.paused = pause
            if not pause and self.t >= self.end:
                self._seek_target = self.start
        if speed is not None:
            self.speed = min(max(speed, _SPEEDS[0]), _SPEEDS[1])
        if seek is not None:
            self._seek_target = min(max(seek, self.start), self.end)

    def advance(self, watch: Watch) -> None:
        """Advance the watch by the elapsed real time, times the speed."""
        now = self._clock()
        elapsed, self._last = min(now - self._last, _MAX_STEP_S), now
        if self._seek_target is not None:
            self._restart_before(watch, self._seek_target)
            self._catch_up_target, self._seek_target = self._seek_target, None
        if self._catch_up_target is not None:
            self._catch_up(watch, self._catch_up_target, now + _BUDGET_S)
        elif not self.paused:
            self.t = min(self.t + elapsed * self.speed, self.end)
            self._stream.feed(watch.team, self.t)
            self.paused = self.t >= self.end
        watch.advance(self.t, self.t)

    def _restart_before(self, watch: Watch, t: float) -> None:
        """Reset the watch and start ``PREROLL_S`` before t."""
        self.epoch += 1
        watch.restart()
        self.t = max(self.start, t - PREROLL_S)
        self._stream.restart(self.t)

    def _catch_up(self, watch: Watch, goal: float, until: float) -> None:
        """Play fast towards the goal until real time ``until``."""
        while self.t < goal:
            self.t = min(self.t + _PREROLL_STEP_S, goal)
            last = goal - self.t < _LAST_S
            self._stream.feed_newest(watch.team, self.t, all_streams=last)
            watch.advance(self.t, self.t)
            if self._clock() >= until:
                return
        self._catch_up_target = None


def _map_of(file: RecordedPayloads) -> tuple[str, str]:
    """Return the names of the map and the border a recording was made on."""
    if RUN_METADATA in file.metadata:
        content = file.attachments.get(CONFIGURATION_ATTACHMENT, b"")
        settings = parse_old_config(content, str(file.path))[0].map
        return Path(settings.folder).name, settings.border
    team = file.metadata.get(TEAM_METADATA, {})
    return team.get("map", file.path.stem), team.get("border", DEFAULT_BORDER)
