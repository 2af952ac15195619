"""The terminal's details of one robot: every figure that its line has no room for."""

from __future__ import annotations

import math
from collections.abc import Iterator
from functools import partial

from robot_agent.messages.foxglove import planar_pose
from robot_agent.messages.log_level import LogLevel
from robot_agent.messages.streams import ACTIONS, DecisionPayload, DeviceStatus
from tools.monitor.reason import OVERRIDE_WORDS, turn_words, why
from tools.monitor.robot_state import RobotState
from tools.monitor.watch import Watch

EVENTS_SHOWN = 5


def detail_lines(watch: Watch, robot: RobotState) -> list[str]:
    """Return a robot's details, a line each; its name alone if its telemetry makes none."""
    lines = watch.made(robot, partial(_lines, robot, watch.now)) or []
    return [robot.id, *(watch.site.words.explained(line) for line in lines)]


def idleness_words(watch: Watch) -> str:
    """Return how long the border was unseen; empty without a border."""
    if watch.coverage is None:
        return ""
    average, worst = watch.coverage.average(watch.now), watch.coverage.worst(watch.now)
    return f"border unseen for {average:.0f} s on average, {worst:.0f} s at worst"


def _lines(robot: RobotState, now: float) -> list[str]:
    lines = [
        why(robot, now),
        *_place_parts(robot),
        *_decision_parts(robot.decision),
        *_status_parts(robot),
        *_process_parts(robot),
    ]
    turned = turn_words(robot, now)
    if turned:
        lines.append(f"turned {turned}")
    return [*lines, *_events(robot, now)]


def _place_parts(robot: RobotState) -> Iterator[str]:
    if robot.pose is not None:
        x, y, theta = planar_pose(robot.pose.pose)
        yield f"at {x:.2f}, {y:.2f} m, heading {math.degrees(theta):.0f}°"


def _events(robot: RobotState, now: float) -> Iterator[str]:
    """Yield the robot's last events, the newest first."""
    for event in robot.events[: -EVENTS_SHOWN - 1 : -1]:
        try:
            level = f"{LogLevel(event.log.level).name.lower()}, "
        except ValueError:
            level = ""
        yield f"{max(now - event.t, 0.0):.0f} s ago: {level}{event.log.name}: {event.log.message}"


def _decision_parts(decision: DecisionPayload | None) -> Iterator[str]:
    if decision is None:
        return
    marks = {decision.runner_up: " (second)", decision.winner: " (first)"}
    yield ", ".join(
        f"{action.replace('_', ' ')} {decision.degrees.get(action, 0.0):.2f}{marks.get(action, '')}"
        for action in ACTIONS
    )
    asked, sent = decision.requested, decision.command
    yield (
        f"asked for {asked.v:.2f} m/s {asked.w:.2f} rad/s, the gate lets {sent.v:.2f} m/s "
        f"{sent.w:.2f} rad/s"
    )
    if decision.override is not None:
        yield f"beyond the rules: {OVERRIDE_WORDS.get(decision.override, decision.override)}"
    yield (
        f"{decision.distance_from_border:.2f} m from the border, at {decision.abscissa:.1f} m of "
        f"the border, neighbor state {decision.gamma:.2f}"
    )


def _status_parts(robot: RobotState) -> Iterator[str]:
    status = robot.status
    if status is None:
        return
    yield f"health {status.health}, motors {'on' if status.motors_enabled else 'off'}"
    for name, device in (("base", status.base), ("laser", status.laser)):
        yield _device_words(name, device, robot.rates.get(name))
    localization = status.localization
    yield (
        f"pose {localization.health}, {localization.particle_count} particles, "
        f"fit {localization.likelihood:.2f}"
    )
    if robot.skew is not None:
        yield f"clock {robot.skew:+.2f} s"


def _device_words(name: str, device: DeviceStatus, rate: float | None) -> str:
    pace = "" if rate is None else f" {rate:.1f} /s,"
    lost = f"{device.packets_bad} bad, {device.bytes_discarded} bytes lost"
    words = f"{name} {device.state},{pace} {lost}"
    return "; ".join(filter(None, (words, device.happened, device.trouble)))


def _process_parts(robot: RobotState) -> Iterator[str]:
    process = robot.process
    if process is not None:
        yield f"CPU {100 * process.cpu:.1f} %, {process.memory_mb:.0f} MB"
        yield f"{process.telemetry_dropped} payloads not sent"
