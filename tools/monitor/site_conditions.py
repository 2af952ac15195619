"""Conditions of a robot that patrols on another map or border than the monitor shows."""

from __future__ import annotations

from collections.abc import Iterator

from tools.monitor.alarm import SILENT_S, Condition, Severity
from tools.monitor.robot_state import RobotState
from tools.monitor.site import Site


def site_conditions(robot: RobotState, now: float, site: Site) -> Iterator[Condition]:
    """Yield what of a robot's map differs from the site's, at the monotonic time now, s.

    Nothing for a silent robot, for one that tells no hashes, and for a site without a map.
    """
    status, age = robot.status, robot.age("status", now)
    if status is None or age is None or age > SILENT_S:
        return
    map_hash, border_hash = site.hashes
    if map_hash and status.map_hash and status.map_hash != map_hash:
        words = "its map is not the one shown here: its place on it is not right"
        yield Condition(robot.id, "map", Severity.WARNING, words)
    elif border_hash and status.border_hash and status.border_hash != border_hash:
        words = "its border is not the one shown here: its s and the visits are not right"
        yield Condition(robot.id, "border", Severity.WARNING, words)
