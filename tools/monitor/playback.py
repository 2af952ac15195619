"""Plays recordings into a watch: several robots' files in step, paused, faster, from any time."""

from __future__ import annotations

import heapq
import time
from collections.abc import Callable, Iterator, Sequence
from pathlib import Path
from typing import Any

from maps.map_folder import DEFAULT_BORDER, MapFolder, map_folder_from_files
from robot_agent.config import parse_config
from robot_agent.recording.recording_writer import CONFIGURATION_ATTACHMENT, RUN_METADATA
from tools.monitor.recorded_payloads import RecordedPayload, RecordedPayloads
from tools.monitor.team_recorder import TEAM_METADATA
from tools.monitor.watch import Watch

BEFORE_S = 300.0
"""So much before a chosen time is gone through, so that plots, trails and coverage are there."""
_BEFORE_STEP_S = 1.0  # a patrolling robot does not drive past a point of the border meanwhile
_BEFORE_STREAMS = ("pose", "decision", "status", "event")
_LAST_S = 2.0  # before the chosen time all streams are taken: each has come at least once
_BUDGET_S = 0.05
"""So long a step of catching up may take: pages are served in between."""
_SPEEDS = (0.1, 100.0)
_LATEST_STEP_S = 0.5
"""A page that was held up does not make the recording leap."""


class Playback:
    """A source of the past. Its time is the recordings' own wall-clock time, s since 1970."""

    def __init__(self, paths: Sequence[Path], clock: Callable[[], float] = time.monotonic) -> None:
        """Open recordings; ``clock`` tells how real time passes, s.

        Raises:
            RecordingError: a file is none, or holds no telemetry.
        """
        self.files = [RecordedPayloads(path) for path in paths]
        self.start = min(file.start for file in self.files)
        self.end = max(file.end for file in self.files)
        self.epoch = 0
        self.t = self.start
        self.speed = 1.0
        self.paused = False
        self._clock = clock
        self._last = clock()
        self._wanted: float | None = None
        self._goal: float | None = None  # catching up until then
        self._rest = self._payloads(self.start)
        self._next: RecordedPayload | None = next(self._rest, None)

    def site_folder(self) -> MapFolder | None:
        """Return the map folder the first recording carries, if any does."""
        for file in self.files:
            if file.map_files:
                name, border = _map_of(file)
                return map_folder_from_files(name, file.map_files, border)
        return None

    def description(self) -> dict[str, Any]:
        """Return what the page shows of the playback."""
        return {
            "kind": "playback",
            "start": self.start,
            "end": self.end,
            "t": self.t,
            "speed": self.speed,
            "paused": self.paused,
        }

    def steer(self, *, pause: bool | None, speed: float | None, seek: float | None) -> None:
        """Hold or go on, at a speed (x real time), from a time (s); senseless wishes are bent."""
        if pause is not None:
            self.paused = pause
            if not pause and self.t >= self.end:
                self._wanted = self.start
        if speed is not None:
            self.speed = min(max(speed, _SPEEDS[0]), _SPEEDS[1])
        if seek is not None:
            self._wanted = min(max(seek, self.start), self.end)

    def advance(self, watch: Watch) -> None:
        """Move on by the real time that has passed, times the speed."""
        now = self._clock()
        elapsed, self._last = min(now - self._last, _LATEST_STEP_S), now
        if self._wanted is not None:
            self._begin_before(watch, self._wanted)
            self._goal, self._wanted = self._wanted, None
        if self._goal is not None:
            self._catch_up(watch, self._goal, now + _BUDGET_S)
        elif not self.paused:
            self.t = min(self.t + elapsed * self.speed, self.end)
            self._feed(watch, self.t)
            self.paused = self.t >= self.end
        watch.advance(self.t, self.t)

    def _payloads(self, since: float) -> Iterator[RecordedPayload]:
        return heapq.merge(
            *(file.payloads(since) for file in self.files), key=lambda payload: payload.t
        )

    def _begin_before(self, watch: Watch, t: float) -> None:
        """Begin afresh, a while before t."""
        self.epoch += 1
        watch.restart()
        self.t = max(self.start, t - BEFORE_S)
        self._rest = self._payloads(self.t)
        self._next = next(self._rest, None)

    def _catch_up(self, watch: Watch, goal: float, until: float) -> None:
        """Go on towards the goal quickly, as far as the clock allows."""
        while self.t < goal:
            self.t = min(self.t + _BEFORE_STEP_S, goal)
            self._feed_newest(watch, self.t, all_streams=goal - self.t < _LAST_S)
            watch.advance(self.t, self.t)
            if self._clock() >= until:
                return
        self._goal = None

    def _feed(self, watch: Watch, t: float) -> None:
        """Give the watch the payloads up to t."""
        for payload in self._up_to(t):
            watch.team.receive(payload.key, payload.data, payload.t, payload.t)

    def _feed_newest(self, watch: Watch, t: float, *, all_streams: bool) -> None:
        """Give the watch the log up to t, and the newest payload of other streams."""
        newest: dict[str, RecordedPayload] = {}
        for payload in self._up_to(t):
            stream = payload.key.rpartition("/")[2]
            if stream == "event":
                watch.team.receive(payload.key, payload.data, payload.t, payload.t)
            elif all_streams or stream in _BEFORE_STREAMS:
                newest[payload.key] = payload
        for payload in newest.values():
            watch.team.receive(payload.key, payload.data, payload.t, payload.t)

    def _up_to(self, t: float) -> Iterator[RecordedPayload]:
        while self._next is not None and self._next.t <= t:
            payload, self._next = self._next, next(self._rest, None)
            yield payload


def _map_of(file: RecordedPayloads) -> tuple[str, str]:
    """Return the names of the map and the border a recording was made on."""
    if RUN_METADATA in file.metadata:
        content = file.attachments.get(CONFIGURATION_ATTACHMENT, b"")
        settings = parse_config(content, str(file.path)).map
        return Path(settings.folder).name, settings.border
    team = file.metadata.get(TEAM_METADATA, {})
    return team.get("map", file.path.stem), team.get("border", DEFAULT_BORDER)
