"""Alarms, histories and coverage that the monitor derives from the team's telemetry."""

from __future__ import annotations

from collections.abc import Callable, Iterable, Iterator
from dataclasses import replace
from functools import partial
from typing import TypeVar

from maps.input_limits import BAD_DATA
from tools.monitor.alarm import REMEMBERED_S, Condition, Severity, conditions_of
from tools.monitor.alarm_board import Alarm, AlarmBoard
from tools.monitor.coverage import Coverage
from tools.monitor.history import RobotHistory
from tools.monitor.intruder_groups import IntruderGroups
from tools.monitor.robot_state import RobotState
from tools.monitor.site import Site
from tools.monitor.site_conditions import site_conditions
from tools.monitor.team_state import MAX_ROBOTS, TeamState

T = TypeVar("T")

_VISIT_PERIOD_S = 0.2
_FRESH_S = 1.0
_NAMED = 5
"""Robots named in one alarm."""


class Watch:
    """Alarms, histories and coverage of one team; reads no clock.

    ``advance`` must be called a few times a second, by one thread at a time.
    """

    def __init__(
        self,
        team: TeamState,
        site: Site,
        own_conditions: Callable[[], Iterable[Condition]] = tuple,
        on_alarm: Callable[[Alarm], object] = bool,
    ) -> None:
        """Watch a team at a site.

        own_conditions: returns the conditions of the monitor itself. on_alarm: called with each
        alarm that is new or has changed.
        """
        self.team = team
        self.site = site
        self._on_alarm = on_alarm
        self.alarms = AlarmBoard(on_alarm)
        self.histories: dict[str, RobotHistory] = {}
        self.coverage: Coverage | None = None
        self.robots: list[RobotState] = []
        self.now = 0.0
        self.wall = 0.0
        self._own_conditions = own_conditions
        self._visited_at = float("-inf")
        self._intruders = IntruderGroups()

    def advance(self, now: float, wall: float) -> None:
        """Take a snapshot of the team at now (monotonic) and wall (s since 1970); update all."""
        self.now, self.wall = now, wall
        self.robots = self.team.snapshot()
        self.alarms.update(self._conditions(), now, wall)
        known = {robot.id for robot in self.robots}
        for gone in self.histories.keys() - known:
            del self.histories[gone]
        for robot in self.robots:
            history = self.histories.setdefault(robot.id, RobotHistory())
            self.made(robot, partial(history.sample, robot, now, wall))
        self._update_coverage()

    def made(self, robot: RobotState, make: Callable[[], T]) -> T | None:
        """Return what ``make`` makes of a robot's telemetry.

        None if it cannot be made: that costs nothing else and is counted as malformed.
        """
        try:
            return make()
        except BAD_DATA:
            self.team.refuse(robot.key_parts, self.now)
            return None

    def restart(self) -> None:
        """Discard everything but the site, for playback from another time."""
        self.team.clear()
        self.histories.clear()
        self.alarms = AlarmBoard(self._on_alarm)
        self.coverage = None
        self._visited_at = float("-inf")
        self._intruders = IntruderGroups()

    def _conditions(self) -> Iterator[Condition]:
        intruders: list[Condition] = []
        for robot in self.robots:
            for condition in self.made(robot, partial(_listed, robot, self.now, self.site)) or ():
                if condition.sighting is None:
                    yield condition
                else:
                    intruders.append(condition)
        yield from self._intruders.merged(intruders, self.now)
        yield from self._own_conditions()
        hidden = self.team.hidden_since(self.now - REMEMBERED_S)
        if hidden:
            more = f" and {len(hidden) - _NAMED} more" if len(hidden) > _NAMED else ""
            words = (
                f"not shown: {', '.join(hidden[:_NAMED])}{more}; {MAX_ROBOTS} robots are shown at "
                "most, look who reports under names you do not know"
            )
            yield Condition("", "hidden", Severity.CRITICAL, words)
        stray_at = self.team.stray_at
        if stray_at is not None and self.now - stray_at < REMEMBERED_S:
            words = f"{self.team.stray} messages under names that are no robot's"
            yield Condition("", "stray", Severity.WARNING, words)

    def _update_coverage(self) -> None:
        """Update the coverage from the robots' fresh poses."""
        folder = self.site.folder
        if folder is None or folder.border is None:
            return
        if self.coverage is None:
            self.coverage = Coverage(folder.border, self.now)
        if self.now - self._visited_at < _VISIT_PERIOD_S:
            return
        self._visited_at = self.now
        places = [
            (robot.poses[-1][1].x, robot.poses[-1][1].y)
            for robot in self.robots
            if robot.poses and (robot.age("pose", self.now) or 0.0) < _FRESH_S
        ]
        if places:
            self.coverage.visit(places, self.now)


def _listed(robot: RobotState, now: float, site: Site) -> list[Condition]:
    """Return a robot's conditions with its place, and with the zones of all places told."""
    place = robot.poses[-1][1][:2] if robot.poses else None
    return [
        replace(each, text=site.words.placed(each.text, place), place=place)
        for each in (*conditions_of(robot, now), *site_conditions(robot, now, site))
    ]
