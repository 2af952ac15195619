"""Conditions that raise alarms about a robot or the monitor, derived from telemetry alone."""

from __future__ import annotations

from collections.abc import Iterator
from dataclasses import dataclass, replace
from enum import IntEnum

from robot_agent.messages.log_level import LogLevel
from robot_agent.messages.streams import DeviceStatus, IntruderPayload, StatusPayload
from tools.monitor.reason import held_by_gate, why
from tools.monitor.robot_state import RobotState
from tools.monitor.sighting import Sighting

SILENT_S = 1.5
"""Time without payload after which a robot is silent: three of its statuses, 2 Hz, are missing."""
BATTERY_LOW_V = 11.5
BATTERY_EMPTY_V = 11.0
SKEW_S = 1.0
"""Clock offset that is an alarm: more than the delay of a bad link."""
STARTUP_S = 15.0
"""Uptime within which a device may be in configuration without an alarm."""
OPENING_S = 5.0
"""Uptime within which a robot may be without open ports and pose without an alarm."""
REMEMBERED_S = 10.0
"""Time for which a momentary event (bad payload, intruder report) holds its condition."""
_FRESH_S = 1.5
_CAUSE_S = 0.8
"""Time that a missing input must last: its cause is known by the next status, 2 Hz."""
_WITHOUT_SCANS = ("trust.laser", "trust.pose", "lost", "gate")
_CONSEQUENCES: dict[str, tuple[str, ...]] = {
    "link base": ("trust.base", "trust.sonar", *_WITHOUT_SCANS),
    "link laser": _WITHOUT_SCANS,
    "trust.base": ("trust.sonar", *_WITHOUT_SCANS),
    "trust.laser": ("trust.pose", "lost", "gate"),
}
"""Faults by the fault that brings them along."""


class Severity(IntEnum):
    """Severity of a condition: CRITICAL needs a person now."""

    INFO = 1
    WARNING = 2
    CRITICAL = 3


@dataclass(frozen=True, slots=True)
class Condition:
    """A fault that holds at present."""

    robot: str  # team/name; empty: the monitor itself
    kind: str
    severity: Severity
    text: str
    delay: float = 0.0  # s it must last before it is an alarm (debounce)
    place: tuple[float, float] | None = None  # of the robot, m, map frame
    sighting: Sighting | None = None  # of an intruder


def conditions_of(robot: RobotState, now: float) -> Iterator[Condition]:
    """Yield the conditions of a robot at the operator's monotonic time now, s."""
    if robot.rivals_at is not None and now - robot.rivals_at < REMEMBERED_S:
        words = "two programs report under this name: what is shown may be either's"
        yield Condition(robot.id, "twin", Severity.CRITICAL, words)
    silence = None if robot.last_heard is None else now - robot.last_heard
    if silence is None:  # connected, no payload yet
        yield Condition(robot.id, "silent", Severity.CRITICAL, "sends nothing", OPENING_S)
        return
    if silence > SILENT_S:
        gone = "" if robot.online else ", connection gone"
        words = f"nothing received for {_coarse(silence)}{gone}"
        yield Condition(robot.id, "silent", Severity.CRITICAL, words)
        return  # all other payloads are stale
    status_age = robot.age("status", now)
    faults: list[Condition] = []
    if robot.status is not None and status_age is not None and status_age < _FRESH_S:
        faults += _of_status(robot, robot.status)
    faults += _of_decision(robot, now)
    faults += _of_missing_inputs(robot)
    yield from _causes(faults)
    yield from _of_sightings(robot, now)
    if robot.malformed_at is not None and now - robot.malformed_at < REMEMBERED_S:
        words = f"{robot.malformed} payloads could not be read"
        yield Condition(robot.id, "malformed", Severity.WARNING, words)
    if robot.process is not None and robot.process.recorder_trouble:
        yield Condition(robot.id, "recorder", Severity.WARNING, robot.process.recorder_trouble)


def _causes(faults: list[Condition]) -> list[Condition]:
    """Leave out what follows from another fault of the list: one cause, one alarm."""
    present = {fault.kind for fault in faults}
    follow = {kind for cause in present for kind in _CONSEQUENCES.get(cause, ())}
    return [fault for fault in faults if fault.kind not in follow]


def _of_status(robot: RobotState, status: StatusPayload) -> Iterator[Condition]:
    settled = status.uptime > OPENING_S
    if status.localization.health == "lost" and settled:
        yield Condition(robot.id, "lost", Severity.CRITICAL, "localization lost", 0.8)
    if status.stalled:
        yield Condition(robot.id, "stalled", Severity.CRITICAL, "a motor is stalled")
    if status.bumpers:
        yield Condition(robot.id, "bumper", Severity.CRITICAL, "a bumper is pressed")
    if status.battery is not None and status.battery < BATTERY_LOW_V:
        empty = status.battery < BATTERY_EMPTY_V
        severity = Severity.CRITICAL if empty else Severity.WARNING
        yield Condition(robot.id, "battery", severity, f"battery at {status.battery:.1f} V")
    for name, device, wanted in (
        ("base", status.base, "ready"),
        ("laser", status.laser, "streaming"),
    ):
        words = _link_words(device, wanted, status.uptime)
        if words and settled:
            yield Condition(robot.id, f"link {name}", Severity.CRITICAL, f"{name}: {words}")
    if robot.skew is not None and abs(robot.skew) > SKEW_S:
        way = "ahead of" if robot.skew > 0 else "behind"
        words = f"clock is {_long(abs(robot.skew))} {way} this computer's; set it"
        yield Condition(robot.id, "clock", Severity.WARNING, words)


def _coarse(seconds: float) -> str:
    """Return a time that changes less often the longer it is: each change is read to the blind."""
    if seconds < 10.0:
        return f"{seconds:.0f} s"
    if seconds < 60.0:
        return f"{seconds // 10.0 * 10.0:.0f} s"
    if seconds < 3600.0:
        return f"{seconds // 60.0:.0f} min"
    return f"{seconds // 3600.0:.0f} h"


def _long(seconds: float) -> str:
    """Return a time in the largest unit of which there are two."""
    for unit, size in (("years", 365.25 * 86400.0), ("days", 86400.0), ("hours", 3600.0)):
        if seconds >= 2.0 * size:
            return f"{seconds / size:.0f} {unit}"
    return f"{seconds:.1f} s"


def _link_words(device: DeviceStatus, wanted: str, uptime: float) -> str:
    """Return the fault of a device's link as text, empty if there is none."""
    if not device.link_up:
        return device.link_reason or "port not open"
    if device.state != wanted and uptime > STARTUP_S:
        return device.trouble[:200] or f"{device.state}, not {wanted}"
    return ""


def _of_decision(robot: RobotState, now: float) -> Iterator[Condition]:
    decision, age = robot.decision, robot.age("decision", now)
    if decision is None or age is None or age > _FRESH_S:
        return
    starting = robot.status is None or robot.status.uptime < STARTUP_S
    if decision.gate_reason == "motors_off" and starting:
        return  # the agent is switching them on
    if held_by_gate(decision):
        yield Condition(robot.id, "gate", Severity.WARNING, why(robot, now), 0.8)


def _of_sightings(robot: RobotState, now: float) -> Iterator[Condition]:
    """Yield the intruder, by the best that tells of one, and a blockage."""
    intruder = _told(robot, now) or _tracked(robot, now) or _logged(robot, now, "intruder")
    if intruder is not None:
        yield replace(intruder, kind="intruder", severity=Severity.CRITICAL)
    blocked = _logged(robot, now, "patrol")
    if blocked is not None:
        yield replace(blocked, kind="blocked")


def _told(robot: RobotState, now: float) -> Condition | None:
    """Return the intruder that the robot reports with its place, None if it reports none now."""
    age, payload = robot.age("intruder", now), robot.payloads.get("intruder")
    if age is None or age > REMEMBERED_S or not isinstance(payload, IntruderPayload):
        return None
    words = (
        f"intruder at {payload.x:.1f}, {payload.y:.1f} m, {payload.distance:.1f} m from the border "
        f"at s = {payload.abscissa:.1f} m"
    )
    sighting = robot.intruders.get(payload.number)
    return Condition(robot.id, "intruder", Severity.CRITICAL, words, sighting=sighting)


def _tracked(robot: RobotState, now: float) -> Condition | None:
    """Return the intruder among the robot's tracks, None without one."""
    tracks_age = robot.age("tracks", now)
    if robot.tracks is None or tracks_age is None or tracks_age > _FRESH_S:
        return None
    for entity in robot.tracks.entities:
        if any((pair.key, pair.value) == ("kind", "intruder") for pair in entity.metadata):
            at = entity.cylinders[0].pose.position if entity.cylinders else None
            place = "" if at is None else f" at {at.x:.1f}, {at.y:.1f} m"
            return Condition(robot.id, "intruder", Severity.CRITICAL, f"intruder{place}")
    return None


def _logged(robot: RobotState, now: float, part: str) -> Condition | None:
    """Return the newest warning of a part of the robot's log, None if it is old or none."""
    event = next((e for e in reversed(robot.events) if e.log.name == part), None)
    if event is None or now - event.t > REMEMBERED_S or event.log.level < LogLevel.WARNING:
        return None
    return Condition(robot.id, part, Severity.WARNING, event.log.message[:200])


def _of_missing_inputs(robot: RobotState) -> Iterator[Condition]:
    """Yield the inputs the agent reports as missing, until it reports their return."""
    newest = {event.log.name: event.log for event in robot.events}
    for name, log in newest.items():
        if name.startswith("trust.") and log.level >= LogLevel.WARNING:
            bad = log.level >= LogLevel.ERROR
            severity = Severity.CRITICAL if bad else Severity.WARNING
            yield Condition(robot.id, name, severity, log.message[:200], _CAUSE_S)
