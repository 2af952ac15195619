"""The list of alarms: debounced, raised, cleared, acknowledged.

Acknowledgements stay on this computer: nothing is sent to a robot.
"""

from __future__ import annotations

from collections.abc import Iterable
from dataclasses import dataclass, replace

from tools.monitor.alarm import Condition, Severity

CLEAR_S = 1.0
"""Time for which a condition must be absent before its alarm clears (debounce)."""
CLEARED_KEPT_S = 300.0
"""Time for which an acknowledged, cleared alarm stays in the list."""
MAX_ALARMS = 200


@dataclass(frozen=True, slots=True)
class Alarm:
    """One alarm; times in s of the clock given to ``update``, wall times in s since 1970."""

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
        """Whether the condition still holds."""
        return self.cleared is None


@dataclass(slots=True)
class _Ongoing:
    """A condition that holds, with the times it began and was last given."""

    condition: Condition
    since: float
    last: float


class AlarmBoard:
    """Turns conditions over time into alarms; pure: reads no clock, times are arguments."""

    def __init__(self) -> None:
        self.version = 0
        """Incremented by every change of the list."""
        self._alarms: dict[int, Alarm] = {}
        self._ongoing: dict[tuple[str, str], _Ongoing] = {}
        self._active: dict[tuple[str, str], int] = {}
        self._next = 1

    def update(self, conditions: Iterable[Condition], now: float, wall: float) -> None:
        """Raise, change and clear alarms.

        conditions: all that hold at now; now: s, increasing; wall: s since 1970.
        """
        for condition in conditions:
            self._note(condition, now)
        for key, ongoing in list(self._ongoing.items()):
            if now - ongoing.last > CLEAR_S:
                del self._ongoing[key]
                self._clear(key, now)
            elif now - ongoing.since >= ongoing.condition.delay:
                self._raise(key, ongoing.condition, now, wall)
        self._drop_old(now)

    def _note(self, condition: Condition, now: float) -> None:
        key = (condition.robot, condition.kind)
        ongoing = self._ongoing.get(key)
        if ongoing is None:
            self._ongoing[key] = _Ongoing(condition, now, now)
        elif ongoing.last < now or condition.severity >= ongoing.condition.severity:
            ongoing.condition, ongoing.last = condition, now

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
            # A higher severity must be acknowledged again.
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

    def _drop_old(self, now: float) -> None:
        """Drop acknowledged alarms cleared long ago and, beyond MAX_ALARMS, the oldest cleared."""
        over = [alarm for alarm in self._alarms.values() if alarm.cleared is not None]
        excess = len(self._alarms) - MAX_ALARMS
        for index, alarm in enumerate(over):
            old = alarm.acknowledged and now - (alarm.cleared or now) > CLEARED_KEPT_S
            if old or index < excess:
                del self._alarms[alarm.number]
                self.version += 1

    def acknowledge(self, number: int) -> None:
        """Mark an alarm as acknowledged; an unknown number is ignored."""
        alarm = self._alarms.get(number)
        if alarm is not None and not alarm.acknowledged:
            self._put(replace(alarm, acknowledged=True))

    def alarms(self) -> list[Alarm]:
        """Return all alarms: active first, then most severe, then unacknowledged, then newest."""
        return sorted(
            self._alarms.values(),
            key=lambda a: (not a.active, -a.severity, a.acknowledged, -a.raised, -a.number),
        )
