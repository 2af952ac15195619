"""The list of alarms: debounced, raised, cleared, acknowledged.

Acknowledgements stay on this computer: nothing is sent to a robot.
"""

from __future__ import annotations

from collections.abc import Callable, Iterable
from dataclasses import dataclass, replace

from tools.monitor.alarm import Condition, Severity
from tools.monitor.sighting import Sighting

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
    acknowledged_by: str = ""  # as given on the page; empty: not told
    acknowledged_wall: float | None = None
    cleared_wall: float | None = None
    place: tuple[float, float] | None = None  # of the robot when it was raised, m, map frame
    sighting: Sighting | None = None  # the last, of an intruder

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

    def __init__(self, on_change: Callable[[Alarm], object] = bool) -> None:
        """on_change: called with each alarm that is new or has changed."""
        self._on_change = on_change
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
                self._clear(key, now, wall)
            elif ongoing.last == now and now - ongoing.since >= ongoing.condition.delay:
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
                    place=condition.place,
                    sighting=condition.sighting,
                )
            )
            return
        self._change(self._alarms[number], condition)

    def _change(self, alarm: Alarm, condition: Condition) -> None:
        """Bring an active alarm up to date; a higher severity must be acknowledged again."""
        told = (condition.severity, condition.text)
        news = condition.sighting is not None and condition.sighting.news_after(alarm.sighting)
        if told == (alarm.severity, alarm.text) and not news:
            return
        changed = replace(alarm, severity=condition.severity, text=condition.text)
        if condition.sighting is not None:
            changed = replace(changed, sighting=condition.sighting.after(alarm.sighting))
        if condition.severity > alarm.severity:
            changed = replace(changed, acknowledged=False, acknowledged_by="")
        self._put(changed)

    def _clear(self, key: tuple[str, str], now: float, wall: float) -> None:
        number = self._active.pop(key, None)
        if number is not None:
            self._put(replace(self._alarms[number], cleared=now, cleared_wall=wall))

    def _put(self, alarm: Alarm) -> None:
        self._alarms[alarm.number] = alarm
        self.version += 1
        self._on_change(alarm)

    def _drop_old(self, now: float) -> None:
        """Drop acknowledged alarms cleared long ago and, beyond MAX_ALARMS, the oldest cleared."""
        over = [alarm for alarm in self._alarms.values() if alarm.cleared is not None]
        excess = len(self._alarms) - MAX_ALARMS
        for index, alarm in enumerate(over):
            old = alarm.acknowledged and now - (alarm.cleared or now) > CLEARED_KEPT_S
            if old or index < excess:
                del self._alarms[alarm.number]
                self.version += 1

    def acknowledge(self, number: int, by: str = "", wall: float | None = None) -> None:
        """Mark an alarm as acknowledged by a person at wall, s since 1970; ignore others."""
        alarm = self._alarms.get(number)
        if alarm is not None and not alarm.acknowledged:
            by = by if by.isprintable() else ""
            self._put(replace(alarm, acknowledged=True, acknowledged_by=by, acknowledged_wall=wall))

    def alarm(self, number: int) -> Alarm | None:
        """Return the alarm of a number, None if there is none any more."""
        return self._alarms.get(number)

    def alarms(self) -> list[Alarm]:
        """Return all alarms: active first, then most severe, intruders, unacknowledged, newest."""
        return sorted(self._alarms.values(), key=_rank)


def _rank(alarm: Alarm) -> tuple[bool, int, bool, bool, float, int]:
    """Return what an alarm's place in the list goes by; intruders are what a patrol is for."""
    other = alarm.kind != "intruder"
    seen = alarm.acknowledged
    return not alarm.active, -alarm.severity, other, seen, -alarm.raised, -alarm.number
