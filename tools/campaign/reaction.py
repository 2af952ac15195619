"""A robot's reaction to a fault: times of detection, stop and recovery, against their limits."""

from __future__ import annotations

import math
from collections.abc import Sequence
from dataclasses import dataclass, field
from pathlib import Path

from robot_agent.messages.effects import Publish
from robot_agent.messages.events import Shutdown
from robot_agent.messages.foxglove import Log
from robot_agent.messages.streams import StatusPayload, decode
from tools.campaign.agent_stage import Moment
from tools.campaign.fault import Expected, Fault
from tools.campaign.service_watch import WATCHDOG_S
from tools.logs.recording import read_recording

STEADY_S = 0.7
"""A robot that has moved this long without a break is patrolling, s."""
STANDING_S = 0.3
"""Wheels at rest this long have stopped, s; in a turn they pass zero for less."""
AGENT_LIMIT_S = 0.3
"""Limit for the agent's stop order where it detects the fault and can still command, s."""
WATCHDOG_LIMIT_S = 2.0
"""Limit for the base to begin to stop by itself where the agent cannot command, s."""
STOP_LIMIT_S = 2.0
"""Limit for the wheels to be at rest in either case, s."""
RECOVERY_LIMIT_S = 10.0
BORDER_LIMIT_S = 60.0
"""Limit for a robot that was moved to be back on its border, s."""
SAMPLING_S = 0.05
"""Tolerance for the emulator's steps and watchdog on a loaded machine, s."""

_DEVICES = ("base", "laser", "camera")
_BESIDE_THE_LOOP = ("recorder", "pose file", "journal")
_HEALTHY = ("port open", "pictures come")
STANDING_FIRST = ("", "STOP", "VEL 0", "RVEL 0", "CLOSE", "ENABLE 0")


@dataclass(slots=True)
class Reaction:
    """Reaction of the robot to a fault; times in s since the fault began, None: did not happen."""

    fault: str
    what: str
    expected: Expected
    back_within: float | None
    """Limit of ``back``, s."""
    order_within: float | None = None
    """Limit of ``ordered``, s; None for the usual one."""
    recover_within: float = 10.0
    """Limit of ``recovered``, s."""
    detected: float | None = None
    """Time of the first event, status or standing order."""
    detected_by: str = ""
    ordered: float | None = None
    """Time of the first order to stand."""
    ordered_by: str = ""
    speed: float = 0.0
    """Speed at that time, m/s."""
    stopped: float | None = None
    """Time from which the wheels are at rest."""
    back: float | None = None
    """First order to the base, or first scan decoded, since the fault's end."""
    recovered: float | None = None
    """Moving again, since the fault's end."""
    first_order: str = ""
    """First motion order after the fault's end, of the new session if there is one."""
    contacts: int = 0
    hunger: float = 0.0
    """Longest time in which the service's watchdog was not fed, s."""
    skipped: str = ""
    """Why this machine cannot make the fault; empty if it can."""
    data_lost: float = 0.0
    """Time at the ends of the runs that is missing in their recordings, s."""
    complaints: list[str] = field(default_factory=list)


def new_reaction(fault: Fault) -> Reaction:
    """Return a reaction with limits only, before any measurement."""
    return Reaction(
        *(fault.name, fault.what, fault.expected, fault.back_within, fault.order_within),
        fault.recover_within or (BORDER_LIMIT_S if fault.to_border else RECOVERY_LIMIT_S),
    )


def steady_since(moments: Sequence[Moment]) -> float:
    """Return the time since which the robot has been moving up to the last moment; inf if not."""
    since = math.inf
    for moment in reversed(moments):
        if not moment.moving:
            break
        since = moment.t
    return since


def patrols(moments: Sequence[Moment]) -> bool:
    """Whether the robot has been moving for STEADY_S up to the last moment."""
    return moments[-1].t - steady_since(moments) >= STEADY_S


def measure_stop(reaction: Reaction, begun: float, moments: Sequence[Moment]) -> None:
    """Set the times of the first standing order and of the wheels' rest."""
    for number, moment in enumerate(moments):
        if reaction.ordered is None and moment.order:
            reaction.ordered, reaction.ordered_by = moment.t - begun, moment.order
            reaction.speed = moments[max(0, number - 1)].v
        stands = reaction.stopped is None and moment.standing
        if stands and _stays_standing(moments[number:]):
            reaction.stopped = moment.t - begun
        if reaction.stopped is not None and reaction.ordered is not None:
            return


def _stays_standing(moments: Sequence[Moment]) -> bool:
    for moment in moments:
        if not moment.standing:
            return False
        if moment.t - moments[0].t >= STANDING_S:
            return True
    return False


def measure_detection(reaction: Reaction, begun: float, until: float, recording: Path) -> None:
    """Set the detection: the first event or status about it, or an earlier standing order."""
    if reaction.expected is Expected.PATROLS_ON:
        reaction.detected, reaction.detected_by = _told_by_process(recording, begun, until)
        return
    for t, item in _published(recording, begun):
        if t <= until and (alarm := _alarm(item)):
            reaction.detected, reaction.detected_by = t - begun, alarm
            break
    if reaction.ordered is not None and (
        reaction.detected is None or reaction.ordered < reaction.detected
    ):
        reaction.detected, reaction.detected_by = reaction.ordered, reaction.ordered_by


def _told_by_process(path: Path, begun: float, until: float) -> tuple[float | None, str]:
    """Return when and as which part the process first told of a trouble beside its loop."""
    recording = read_recording(path)
    start = 1e-9 * recording.header.start_monotonic_ns
    for _, t, payload in recording.messages(("process_log",)):
        log = decode("event", payload)
        assert isinstance(log, Log)
        if begun <= start + t <= until and log.name in _BESIDE_THE_LOOP:
            return start + t - begun, f"event: {log.name}"
    return None, ""


def first_scan(ended: float, recording: Path) -> float | None:
    """Return the time from the fault's end to the agent's next scan, s; None if there is none."""
    times = (t for t, item in _published(recording, ended) if item.stream == "scan")
    first = next(times, None)
    return None if first is None else first - ended


def data_lost(ends: Sequence[float], recordings: Sequence[Path]) -> float:
    """Return the total time at the ends of runs that is missing in their recordings, s."""
    return sum(_lost_at_end(end, path) for end, path in zip(ends, recordings, strict=True))


def _lost_at_end(end: float, path: Path) -> float:
    """Return how long before its process's end (monotonic, s) a recording ends, s."""
    recording = read_recording(path)
    last = 0.0
    for item in recording.items():
        if isinstance(item, Shutdown):
            return 0.0  # a complete run; what follows is not part of it
        last = getattr(item, "t", last)
    return max(0.0, end - 1e-9 * recording.header.start_monotonic_ns - last)


def _published(path: Path, since: float) -> list[tuple[float, Publish]]:
    """Return the agent's publications after a time (monotonic, s), with their times."""
    recording = read_recording(path)
    start = 1e-9 * recording.header.start_monotonic_ns
    published = []
    t = 0.0
    for item in recording.items():
        if not isinstance(item, Publish):
            t = getattr(item, "t", t)
        elif start + t > since:
            published.append((start + t, item))
    return published


def _alarm(item: Publish) -> str:
    """Return the alarm in an event or a status, empty if there is none."""
    if item.stream == "status":
        status = decode("status", item.payload)
        assert isinstance(status, StatusPayload)
        return "" if status.health == "ok" else f"status: {status.health}"
    if item.stream != "event":
        return ""
    log = decode("event", item.payload)
    assert isinstance(log, Log)
    if log.name in _DEVICES and log.message not in _HEALTHY:
        return f"event: {log.name}"
    held = log.name == "gate" and log.message.startswith("holds the robot")
    return f"event: {log.message}" if held else ""


def complaints(reaction: Reaction) -> list[str]:
    """Return the limits that the reaction misses."""
    found: list[str] = []
    if reaction.skipped:
        return found
    if reaction.contacts:
        found.append(f"{reaction.contacts} contacts")
    if reaction.recovered is None or reaction.recovered > reaction.recover_within:
        found.append(f"not patrolling within {reaction.recover_within:g} s")
    if reaction.expected is Expected.PATROLS_ON:
        return found + _patrol_complaints(reaction)
    if reaction.expected is Expected.MAY_PATROL:
        return found
    by_agent = reaction.expected is Expected.AGENT_STOPS
    order_limit = reaction.order_within or (AGENT_LIMIT_S if by_agent else WATCHDOG_LIMIT_S)
    if not _within(reaction.ordered, order_limit):
        found.append(f"no standing order within {order_limit:g} s")
    stop_limit = STOP_LIMIT_S + (max(0.0, order_limit - AGENT_LIMIT_S) if by_agent else 0.0)
    if not _within(reaction.stopped, stop_limit):
        found.append(f"not at rest within {stop_limit:.2f} s")
    if reaction.back_within is not None and not _within(reaction.back, reaction.back_within):
        found.append(f"not back within {reaction.back_within:g} s")
    if reaction.first_order not in STANDING_FIRST:
        found.append(f"first order after it was {reaction.first_order}")
    return found


def _patrol_complaints(reaction: Reaction) -> list[str]:
    found = []
    if reaction.ordered is not None:
        found.append("ordered to stand")
    if reaction.detected is None:
        found.append("nothing was said")
    if reaction.hunger > WATCHDOG_S:
        found.append(f"watchdog not fed for {reaction.hunger:.1f} s")
    return found


def _within(time: float | None, limit: float) -> bool:
    return time is not None and time <= limit + SAMPLING_S
