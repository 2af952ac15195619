"""The list of alarms: raised when a condition has lasted, cleared when it is over, acknowledged.

Acknowledging is the operator's own note: it stays on this computer, no robot hears of it.
"""

from __future__ import annotations

from collections.abc import Iterable
from dataclasses import dataclass, replace

from tools.monitor.alarm import Condition, Severity

CLEAR_S = 1.0
"""A condition must have been gone this long, so that a flicker is one alarm."""
CLEARED_KEPT_S = 300.0
"""So long an acknowledged alarm that is over stays in the list."""
MAX_ALARMS = 200


@dataclass(frozen=True, slots=True)
class Alarm:
    """One alarm; times are s on the clock the board is told, wall ones s since 1970."""

    number: int
    robot: str
    kind: str
    severity: Severity
    text: str
    raised: float
    raised_wall: float
    cleared: float | None = None
    acknowledged: bool = False

    @property
    def active(self) -> bool:
        """Whether its condition still holds."""
        return self.cleared is None


@dataclass(slots=True)
class _Standing:
    """A condition as long as it goes on."""

    condition: Condition
    since: float
    last: float


class AlarmBoard:
    """Turns conditions over time into alarms; pure: it knows no clock but what it is told."""

    def __init__(self) -> None:
        self.version = 0
        """Grows with every change of the list."""
        self._alarms: dict[int, Alarm] = {}
        self._standing: dict[tuple[str, str], _Standing] = {}
        self._active: dict[tuple[str, str], int] = {}
        self._next = 1

    def update(self, conditions: Iterable[Condition], now: float, wall: float) -> None:
        """Take all that is wrong at now; raise, change and clear alarms."""
        for condition in conditions:
            self._stand(condition, now)
        for key, standing in list(self._standing.items()):
            if now - standing.last > CLEAR_S:
                del self._standing[key]
                self._clear(key, now)
            elif now - standing.since >= standing.condition.delay:
                self._raise(key, standing.condition, now, wall)
        self._forget(now)

    def _stand(self, condition: Condition, now: float) -> None:
        key = (condition.robot, condition.kind)
        standing = self._standing.get(key)
        if standing is None:
            self._standing[key] = _Standing(condition, now, now)
        elif standing.last < now or condition.severity >= standing.condition.severity:
            standing.condition, standing.last = condition, now

    def _raise(self, key: tuple[str, str], condition: Condition, now: float, wall: float) -> None:
        number = self._active.get(key)
        if number is None:
            number, self._next = self._next, self._next + 1
            self._active[key] = number
            self._put(
                Alarm(
                    number,
                    condition.robot,
                    condition.kind,
                    condition.severity,
                    condition.text,
                    now,
                    wall,
                )
            )
            return
        alarm = self._alarms[number]
        if (alarm.severity, alarm.text) != (condition.severity, condition.text):
            # One that got worse needs a new look.
            seen = alarm.acknowledged and condition.severity <= alarm.severity
            changed = replace(alarm, severity=condition.severity, text=condition.text)
            self._put(replace(changed, acknowledged=seen))

    def _clear(self, key: tuple[str, str], now: float) -> None:
        number = self._active.pop(key, None)
        if number is not None:
            self._put(replace(self._alarms[number], cleared=now))

    def _put(self, alarm: Alarm) -> None:
        self._alarms[alarm.number] = alarm
        self.version += 1

    def _forget(self, now: float) -> None:
        """Drop what is over and seen for long; beyond the most that are kept, the oldest over."""
        over = [alarm for alarm in self._alarms.values() if alarm.cleared is not None]
        excess = len(self._alarms) - MAX_ALARMS
        for index, alarm in enumerate(over):
            old = alarm.acknowledged and now - (alarm.cleared or now) > CLEARED_KEPT_S
            if old or index < excess:
                del self._alarms[alarm.number]
                self.version += 1

    def acknowledge(self, number: int) -> None:
        """Note that the operator has seen an alarm; one that is not there is no fault."""
        alarm = self._alarms.get(number)
        if alarm is not None and not alarm.acknowledged:
            self._put(replace(alarm, acknowledged=True))

    def alarms(self) -> list[Alarm]:
        """Return all alarms: unseen before seen, active before over, then worst, then newest."""
        return sorted(
            self._alarms.values(),
            key=lambda a: (a.acknowledged, not a.active, -a.severity, -a.raised, -a.number),
        )
