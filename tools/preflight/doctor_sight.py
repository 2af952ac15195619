"""Preflight of the sensors' fields of view: whether one covers the way ahead."""

from __future__ import annotations

import math

from drivers.lms200.settings import LaserSettings as Lms200Settings
from drivers.p2os.model import RobotModel
from drivers.scanner import ScannerSettings
from maps.pose import Pose
from robot_agent.motion.field_of_view import are_covered, views_without
from robot_agent.motion.gate_limits import GateLimits
from robot_agent.motion.stopping import stopping_way
from robot_agent.motion.swept_footprint import SweptFootprint
from robot_agent.obstacles.sonar_obstacles import front_cones
from tools.preflight.finding import Finding, failed, ok, warning

_REMEDY = "mount the scanner to look ahead, and check laser.mount (x, y in m, theta in rad)"


def examine_sight(laser: ScannerSettings, model: RobotModel, limits: GateLimits) -> Finding:
    """Check that laser or front sonars cover the way ahead, as the gate requires for driving."""
    mount = laser.mount or model.laser_mount
    mounted = laser.mounted(upside_down=model.laser.upside_down, ignore=model.laser.ignore)
    half = math.radians(laser.field_of_view_deg / 2)
    first, last = mounted.seen if isinstance(mounted, Lms200Settings) else (-half, half)
    scanner = views_without(Pose(*mount), first, last, mounted.ignored)
    stop = stopping_way(limits.max_speed, limits.braking, limits.reaction_delay)
    edge = SweptFootprint(limits).front_edge(stop, 0.0)
    if are_covered(edge, scanner):
        return ok("sight", "the laser covers the way ahead")
    where = f"the laser looks {math.degrees(mount[2]):.0f} deg from ahead"
    if are_covered(edge, front_cones(model)):
        return warning("sight", f"{where}: only the front sonars cover the way", _REMEDY)
    return failed("sight", f"{where}, and no sonar covers the way: it will not drive", _REMEDY)
