"""Fans of rays that a body's lasers and sonars send out."""

from __future__ import annotations

import math
from collections.abc import Sequence
from typing import NamedTuple

import numpy as np
from numpy.typing import NDArray

from maps.pose import Pose
from tools.simulation.robot_body import RobotBody
from tools.simulation.truth.robot_truth import SonarPlace


class Fan(NamedTuple):
    """Rays from a body: origins x and y (n,), m, and directions (n,), rad, map frame.

    ends: (n,) ranges, m, at which rays end in any surroundings, None if nowhere.
    """

    body: RobotBody
    x: NDArray[np.float64]
    y: NDArray[np.float64]
    angles: NDArray[np.float64]
    ends: NDArray[np.float64] | None = None


class Returns(NamedTuple):
    """What a laser measures with a fan.

    ranges (n,): m, inf where nothing returns. reflectors (n,): which beams return the light of a
    reflector; None where no robot wears tape, then none are looked for.
    """

    ranges: NDArray[np.float64]
    reflectors: NDArray[np.bool_] | None


class Rays(NamedTuple):
    """The rays of several fans, one after another: as in ``Fan``; own (n,): index of the body."""

    x: NDArray[np.float64]
    y: NDArray[np.float64]
    angles: NDArray[np.float64]
    own: NDArray[np.intp]


def laser_fan(
    body: RobotBody,
    pose: Pose,
    bearings: NDArray[np.float64],
    mount: tuple[float, float, float],
    swept: NDArray[np.float64] | float = 0.0,
) -> Fan:
    """Return the rays of a laser scan; the arguments are those of ``World.scan``.

    bearings (n,): rad from the laser's axis, left positive.
    """
    laser, n = pose.compose(Pose(*mount)), len(bearings)
    return Fan(body, np.full(n, laser.x), np.full(n, laser.y), laser.theta + bearings + swept)


def sonar_fan(body: RobotBody, ring: Sequence[SonarPlace], cone: NDArray[np.float64]) -> Fan:
    """Return the rays of each transducer, at the directions of its cone, rad from its axis."""
    c, s = math.cos(body.pose.theta), math.sin(body.pose.theta)
    x = [body.pose.x + c * mount.x - s * mount.y for mount in ring]
    y = [body.pose.y + s * mount.x + c * mount.y for mount in ring]
    heading = [body.pose.theta + math.radians(mount.heading_deg) for mount in ring]
    angles = (np.array(heading)[:, None] + cone).ravel()
    return Fan(body, np.repeat(x, len(cone)), np.repeat(y, len(cone)), angles)


def rays_of(fans: Sequence[Fan]) -> Rays:
    """Return the rays of several fans."""
    x, y, angles = (np.concatenate([fan[row] for fan in fans]) for row in (1, 2, 3))
    own = np.repeat([fan.body.index for fan in fans], [len(fan.angles) for fan in fans])
    return Rays(x, y, angles, own)


def ends_of(fan: Fan) -> NDArray[np.float64]:
    """Return where a fan's rays end in any surroundings (n,), m; inf for nowhere."""
    return np.full(len(fan.angles), np.inf) if fan.ends is None else fan.ends
