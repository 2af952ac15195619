"""One intruder that several robots report is one alarm, of the robot that reported first."""

from __future__ import annotations

import math
from collections.abc import Iterator, Sequence
from dataclasses import dataclass, field, replace

from tools.monitor.alarm import Condition

_SAME_M = 1.5
"""Two robots' places of one intruder differ by less: people walk between two reports; ours."""
_STRIDE_M = 4.0
"""One robot's places of one intruder in two reports differ by less; ours."""
_FORGOTTEN_S = 30.0


@dataclass(slots=True)
class _Group:
    """Reports of one intruder: the robot that reported first, and the last place and time."""

    robot: str
    place: tuple[float, float]
    t: float
    seers: set[str] = field(default_factory=set)


class IntruderGroups:
    """Tells which reports are of the same intruder."""

    def __init__(self) -> None:
        self._groups: list[_Group] = []

    def merged(self, found: Sequence[Condition], now: float) -> Iterator[Condition]:
        """Yield one condition for each intruder that the conditions of robots at now, s, tell."""
        self._groups = [group for group in self._groups if now - group.t < _FORGOTTEN_S]
        reports: dict[int, list[Condition]] = {}
        for condition in found:
            group = self._group_of(condition, now)
            reports.setdefault(id(group), []).append(condition)
        for group in self._groups:
            told = reports.get(id(group))
            if told:
                yield _one(group.robot, told)

    def _group_of(self, condition: Condition, now: float) -> _Group:
        assert condition.sighting is not None
        place = condition.sighting.place
        near = [
            (math.dist(place, group.place), number, group)
            for number, group in enumerate(self._groups)
            if math.dist(place, group.place)
            < (_STRIDE_M if condition.robot in group.seers else _SAME_M)
        ]
        if not near:
            self._groups.append(_Group(condition.robot, place, now))
        group = min(near)[2] if near else self._groups[-1]
        group.place, group.t = place, now
        group.seers.add(condition.robot)
        return group


def _one(robot: str, told: Sequence[Condition]) -> Condition:
    """Return the reports of one intruder as one condition of the robot that reported first."""
    own = next((condition for condition in told if condition.robot == robot), told[0])
    others = sorted({c.robot.rpartition("/")[2] for c in told if c.robot != robot})
    words = f"; seen by {', '.join(others)}" if others else ""
    return replace(own, robot=robot, text=own.text + words)
