"""A team's runs on one clock, resampled at a fixed rate, for figures and numbers."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass
from functools import cached_property
from itertools import pairwise
from pathlib import Path

import numpy as np

from maps.map_folder import MapFolder, map_folder_from_files
from maps.place_words import PlaceWords
from maps.zone import Zone
from robot_agent.config import MapSettings
from tools.logs.recorded_config import parse_old_config
from tools.metrics.border_visits import BorderVisits, border_visits
from tools.metrics.metrics import MEETING_M, Meeting, RobotRun, arrival_index, meetings
from tools.report.alignment import ClockNote
from tools.report.incidents import Incident, absences, incidents
from tools.report.run_log import Floats, RunLog

STEP_S = 0.1
VISIT_STEPS = 5
"""Steps between samples for idleness, 0.5 s: a robot moves less than the visit radius meanwhile."""
PAUSE_S = 1.0
"""Age of a decision from which the robot's position is unknown."""


@dataclass(eq=False)
class Team:
    """All runs of a report, aligned; times are team times, s."""

    runs: list[RunLog]
    clocks: list[ClockNote]
    zones: tuple[Zone, ...] = ()
    """Names of places on the map; none: texts tell numbers alone."""

    @cached_property
    def words(self) -> PlaceWords:
        """What names the places in texts."""
        return PlaceWords(self.zones, self.folder.border)

    def place(self, robot: str, t: float) -> tuple[float, float] | None:
        """Return where a robot was by its own pose at a time, m, map frame; None: unknown."""
        run = next(run for run in self.sampled if run.name == robot)
        x, y = run.position[int(np.clip(np.searchsorted(self.t, t), 0, self.t.size - 1))].tolist()
        return None if np.isnan(x) else (x, y)

    @cached_property
    def names(self) -> list[str]:
        """The robots' names in the order of their first recording."""
        return list(dict.fromkeys(run.name for run in self.runs))

    @cached_property
    def end(self) -> float:
        """End of the last recording."""
        return max(run.end + run.shift for run in self.runs)

    @cached_property
    def folder(self) -> MapFolder:
        """The map of the first recording; raises MapError or BorderError."""
        return map_folder_from_files(
            Path(self.map_named).name, self.runs[0].header.map_files, self._map_settings.border
        )

    @property
    def map_named(self) -> str:
        """The map folder, or name of a shipped map, of the first recording's configuration."""
        return self._map_settings.folder

    @cached_property
    def _map_settings(self) -> MapSettings:
        first = self.runs[0]
        return parse_old_config(first.header.configuration, str(first.path))[0].map

    @cached_property
    def t(self) -> Floats:
        """Sampling times, (n,), STEP_S apart."""
        return np.arange(0.0, self.end + STEP_S, STEP_S, dtype=np.float64)

    @cached_property
    def sampled(self) -> list[RobotRun]:
        """One run per robot at the times ``t``, by its own poses; nan where unknown."""
        return [
            _sampled(name, self.t, [run for run in self.runs if run.name == name])
            for name in self.names
        ]

    @cached_property
    def meetings(self) -> list[Meeting]:
        """All meetings of two robots of the team."""
        border = self.folder.border
        return [] if border is None else meetings(border, self.sampled)

    def pair(self, meeting: Meeting) -> tuple[RobotRun, RobotRun]:
        """Return the runs of the two robots that met."""
        by_name = {run.name: run for run in self.sampled}
        return by_name[meeting.robots[0]], by_name[meeting.robots[1]]

    def closest(self, meeting: Meeting) -> int:
        """Return the index of a meeting's closest approach."""
        a, b = self.pair(meeting)
        start = int(np.searchsorted(self.t, meeting.t))
        distance = np.hypot(*(a.position[start:] - b.position[start:]).T)
        far = np.flatnonzero(~(distance < MEETING_M))
        end = int(far[0]) if far.size else distance.size
        return start + int(np.nanargmin(distance[: max(end, 1)]))

    def middle(self, meeting: Meeting) -> tuple[float, float]:
        """Return the place between two robots at their closest approach, m, map frame."""
        a, b = self.pair(meeting)
        closest = self.closest(meeting)
        x, y = (a.position[closest] + b.position[closest]) / 2.0
        return float(x), float(y)

    @cached_property
    def incidents(self) -> list[Incident]:
        """The incidents of all robots, in order of time."""
        in_order = sorted(self.runs, key=lambda run: (run.shift, run.end))
        last = {run.name: run for run in in_order}
        found = [
            incident
            for run in self.runs
            for incident in incidents(run)
            if run is last[run.name] or not incident.is_end
        ]
        for name in self.names:
            own = [run for run in in_order if run.name == name]
            found += [
                absences(earlier, later)
                for earlier, later in pairwise(own)
                if not later.continues(earlier)
            ]
        return sorted(found, key=lambda incident: incident.start)

    @cached_property
    def visits(self) -> BorderVisits | None:
        """Visits of the border's points since all robots had reached it; None if none did."""
        border = self.folder.border
        if border is None:
            return None
        arrivals = [
            arrival_index(np.nan_to_num(border.project_many(run.position)[1], nan=np.inf))
            for run in self.sampled
        ]
        reached = [index for index in arrivals if index is not None]
        if not reached:
            return None
        kept = slice(max(reached), None, VISIT_STEPS)
        if self.t[kept].size < 2:
            return None
        return border_visits(border, [run.position[kept] for run in self.sampled], self.t[kept])


def _sampled(name: str, t: Floats, runs: Sequence[RunLog]) -> RobotRun:
    """Resample a robot's decisions from its recordings, which do not overlap, at times t (n,)."""
    position = np.full((t.size, 2), np.nan)
    action = np.full(t.size, "", dtype=object)
    direction = np.zeros(t.size, np.int8)
    for run in runs:
        if not run.decision_t.size:
            continue
        own = run.decision_t + run.shift
        latest = np.searchsorted(own, t, side="right") - 1
        known = (latest >= 0) & (t - own[latest.clip(0)] < PAUSE_S)
        for axis in (0, 1):
            position[known, axis] = np.interp(t[known], own, run.pose[:, axis])
        action[known] = np.array(run.action, dtype=object)[latest[known]]
        direction[known] = run.direction[latest[known]]
    return RobotRun(name, t, position, action.tolist(), direction)
