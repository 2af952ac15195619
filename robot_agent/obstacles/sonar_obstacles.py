"""Echoes of the sonars beside and behind the robot, transformed by odometry as it moves on.

Sonars that point ahead are not used: the laser covers that, and more precisely.
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
"""rad; transducers at smaller angles from straight ahead are not used."""


class SonarObstacles:
    """Latest echo of each transducer: stored in ``odom``, returned in ``base_link``."""

    def __init__(self, model: RobotModel) -> None:
        self._use_model(model)

    def update(self, state: BaseState, odometry: Pose, model: RobotModel) -> None:
        """Store a base report's readings; odometry: odom_from_base when it was measured.

        model: geometry of the transducers; all echoes are dropped when it changes.
        """
        if model is not self._model:
            self._use_model(model)
        self._ring.update(state.t, state.sonar)
        fresh = [number for number, _ in state.sonar]
        if fresh:
            self._echoes[fresh] = move_points(self._ring.echoes()[fresh], odometry)

    def around(self, t: float, odometry: Pose) -> NDArray[np.float64]:
        """Return the fresh echoes at t, (n, 2), m, base_link; odometry: odom_from_base at t."""
        fresh = (
            self._beside & (self._ring.ages(t) <= SONAR.max_age) & np.isfinite(self._echoes[:, 0])
        )
        return move_points(self._echoes[fresh], odometry.between(Pose(0.0, 0.0, 0.0)))

    def _use_model(self, model: RobotModel) -> None:
        self._model = model
        self._ring = SonarRing(model)
        self._beside = np.array([abs(mount.heading) >= ABEAM for mount in model.sonar])
        self._echoes = np.full((len(model.sonar), 2), np.nan)
