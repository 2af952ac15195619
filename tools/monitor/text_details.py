"""Lines below the terminal's table: each robot's detailed figures, and the border's idleness."""

from __future__ import annotations

from collections.abc import Iterator
from functools import partial

from robot_agent.messages.streams import ACTIONS, DecisionPayload, DeviceStatus
from tools.monitor.reason import turn_words
from tools.monitor.robot_state import RobotState
from tools.monitor.watch import Watch


def detail_lines(watch: Watch) -> Iterator[str]:
    """Yield one line per robot that has reported, then one on the border's idleness."""
    for robot in watch.robots:
        parts = watch.made(robot, partial(_parts, robot, watch.now))
        if parts:
            yield watch.site.words.explained(f"{robot.id}: " + "; ".join(parts))
    if watch.coverage is not None:
        average, worst = watch.coverage.average(watch.now), watch.coverage.worst(watch.now)
        yield f"border unseen for {average:.0f} s on average, {worst:.0f} s at worst"


def _parts(robot: RobotState, now: float) -> list[str]:
    parts = [*_decision_parts(robot.decision), *_status_parts(robot), *_process_parts(robot)]
    turned = turn_words(robot, now)
    if turned:
        parts.append(f"turned {turned}")
    return parts


def _decision_parts(decision: DecisionPayload | None) -> Iterator[str]:
    if decision is None:
        return
    marks = {decision.runner_up: " (second)", decision.winner: " (first)"}
    yield ", ".join(
        f"{action} {decision.degrees.get(action, 0.0):.2f}{marks.get(action, '')}"
        for action in ACTIONS
    )
    yield f"asked for {decision.requested.v:.2f} m/s {decision.requested.w:.2f} rad/s"
    if decision.override is not None:
        yield f"beyond the rules: {decision.override.replace('_', ' ')}"
    yield f"neighbor state {decision.gamma:.2f}, at {decision.abscissa:.1f} m of the border"


def _status_parts(robot: RobotState) -> Iterator[str]:
    status = robot.status
    if status is None:
        return
    yield f"motors {'on' if status.motors_enabled else 'off'}"
    for name, device in (("base", status.base), ("laser", status.laser)):
        yield _device_words(name, device, robot.rates.get(name))
    localization = status.localization
    yield f"{localization.particle_count} particles, fit {localization.likelihood:.2f}"
    if robot.skew is not None:
        yield f"clock {robot.skew:+.2f} s"


def _device_words(name: str, device: DeviceStatus, rate: float | None) -> str:
    pace = "" if rate is None else f" {rate:.1f} /s,"
    words = f"{name}{pace} {device.packets_bad} bad, {device.bytes_discarded} bytes lost"
    return "; ".join(filter(None, (words, device.happened, device.trouble)))


def _process_parts(robot: RobotState) -> Iterator[str]:
    process = robot.process
    if process is not None:
        yield f"CPU {100 * process.cpu:.1f} %, {process.memory_mb:.0f} MB"
        yield f"{process.telemetry_dropped} payloads not sent"
