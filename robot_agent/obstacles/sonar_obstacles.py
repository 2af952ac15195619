"""What the sonars beside and behind the robot heard, carried along as the robot moves on.

The laser sees what is ahead, and sees it better; the rest is the sonars'.
"""

from __future__ import annotations

import math

import numpy as np
from numpy.typing import NDArray

from drivers.p2os.base_state import BaseState
from drivers.p2os.model import RobotModel
from drivers.p2os.sonar import SonarRing
from maps.pose import Pose
from robot_agent.motion.freshness_limits import SONAR
from robot_agent.perception.scan_points import move_points

ABEAM = math.radians(89.0)
"""Transducers that point less far from straight ahead are left to the laser."""


class SonarObstacles:
    """Echoes in ``odom`` as they were heard, in ``base_link`` as asked for."""

    def __init__(self, model: RobotModel) -> None:
        self._use_model(model)

    def update(self, state: BaseState, odometry: Pose, model: RobotModel) -> None:
        """Take a base report's readings; ``odometry`` is odom_from_base when it was measured.

        A ``model`` other than before is another robot's, and forgets what was heard.
        """
        if model is not self._model:
            self._use_model(model)
        self._ring.update(state.t, state.sonar)
        fresh = [number for number, _ in state.sonar]
        if fresh:
            self._echoes[fresh] = move_points(self._ring.echoes()[fresh], odometry)

    def around(self, t: float, odometry: Pose) -> NDArray[np.float64]:
        """Return the echoes heard lately, (n, 2) m, in base_link where odometry is odom_from_base
        at ``t`` (s)."""
        heard = (
            self._beside & (self._ring.ages(t) <= SONAR.max_age) & np.isfinite(self._echoes[:, 0])
        )
        return move_points(self._echoes[heard], odometry.between(Pose(0.0, 0.0, 0.0)))

    def _use_model(self, model: RobotModel) -> None:
        self._model = model
        self._ring = SonarRing(model)
        self._beside = np.array([abs(mount.heading) >= ABEAM for mount in model.sonar])
        self._echoes = np.full((len(model.sonar), 2), np.nan)
