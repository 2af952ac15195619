"""Echoes of the sonars as obstacles, transformed by odometry as the robot moves on.

Beside and behind every echo counts. Ahead the laser is more precise, but covers one plane only: a
front echo counts for things under or above that plane, and outside the laser's field of view. Such
an echo has nothing in the transducer's cone at its range or nearer that is known already, as a
wall has; and a second echo from the same place confirms it, which false echoes such as crosstalk do
not have.
"""

from __future__ import annotations

import math
from collections.abc import Callable
from functools import cache

import numpy as np
from numpy.typing import NDArray

from drivers.p2os.base_state import BaseState
from drivers.p2os.model import RobotModel, SonarMount
from drivers.p2os.sonar import SonarRing
from maps.pose import Pose
from robot_agent.motion.field_of_view import FieldOfView
from robot_agent.motion.freshness_limits import SONAR
from robot_agent.perception.scan_points import move_points

ABEAM = math.radians(89.0)
"""rad; transducers at smaller angles from straight ahead are those of the front."""
FRONT_REACH = 1.5  # m from the transducer; farther front echoes cannot matter to the gate yet
HEARD_WITHIN = 2.0  # m from the axle; nothing farther away explains such an echo
HALF_CONE = math.radians(15.0)  # of a transducer (Stage's Pioneer models: 15 to 30 deg in all)
SAME_PLACE = 0.15  # m between two echoes that confirm each other
CONFIRM_WITHIN = 1.0  # s; a ring of eight fires each transducer every 0.32 s
MEMORY = 5.0
"""s that a front echo counts after it was last heard: beside a low thing it is heard no longer, and
a turning robot's corner must not hit it."""
MISSES = 2
"""Readings through a place without an echo after which nothing is there: a slanted face sends one
ping elsewhere (specular loss), and the robot would turn its corner into it."""
_SEEN_BEYOND = 0.15  # m farther than the echo at which a known point still explains it
_WIDE_CONE = math.radians(20.0)  # to each side: within it near things are heard, if weakly
_SIDE_LOBES = math.radians(30.0)  # likewise, near walls and door frames; ours
_ORIGIN = Pose(0.0, 0.0, 0.0)


def front_cones(model: RobotModel) -> tuple[FieldOfView, ...]:
    """Return the fields of view, base_link, of a model's front transducers."""
    return tuple(_cone(mount, model) for mount in model.sonar if _is_front(mount))


def _cone(mount: SonarMount, model: RobotModel) -> FieldOfView:
    return FieldOfView(mount.x, mount.y, mount.heading, _WIDE_CONE, model.sonar_far)


def _is_front(mount: SonarMount) -> bool:
    return abs(mount.heading) < ABEAM


class SonarObstacles:
    """Latest echo of each transducer: stored in ``odom``, returned in ``base_link``."""

    _low: NDArray[np.float64]  # (n, 2) m, odom: front echoes that count
    _low_t: NDArray[np.float64]  # (n,) s, when each was heard
    _low_misses: NDArray[np.int64]  # (n,) readings through its place since then

    def __init__(self, model: RobotModel) -> None:
        count = len(model.sonar)
        self._ring = SonarRing(model)
        self._cones = [_cone(mount, model) for mount in model.sonar]
        self._is_front = np.array([_is_front(mount) for mount in model.sonar], dtype=bool)
        self._echoes = np.full((count, 2), np.nan)
        self._heard_t = np.full(count, -np.inf)  # of these echoes
        self._low = np.empty((0, 2))
        self._low_t = np.empty(0)
        self._low_misses = np.empty(0, dtype=np.int64)

    def update(
        self,
        state: BaseState,
        odometry: Pose,
        known: Callable[[], NDArray[np.float64]],
    ) -> None:
        """Store a base report's readings; odometry: odom_from_base when it was measured.

        known: returns the points near the robot of what the gate knows otherwise, (n, 2), m,
        base_link; few reports need them.
        """
        self._ring.update(state.t, state.sonar)
        fresh = [number for number, _ in state.sonar]
        if not fresh:
            return
        known = cache(known)
        places = move_points(self._ring.echoes()[fresh], odometry)
        for number, place in zip(fresh, places, strict=True):
            if self._is_front[number]:
                self._update_front(state.t, number, place, odometry, known)
            self._echoes[number], self._heard_t[number] = place, state.t

    def around(self, t: float, odometry: Pose) -> NDArray[np.float64]:
        """Return the echoes that count at t, (n, 2), m, base_link; odometry: odom_from_base at t.

        Those beside and behind while fresh, those ahead for ``MEMORY`` unless heard to be gone.
        """
        beside = ~self._is_front & (self._ring.ages(t) <= SONAR.max_age)
        beside &= np.isfinite(self._echoes[:, 0])
        ahead = self._low[t - self._low_t <= MEMORY]
        echoes = np.concatenate((self._echoes[beside], ahead))
        return move_points(echoes, odometry.between(_ORIGIN))

    def views(self, t: float) -> tuple[FieldOfView, ...]:
        """Return the cones of the front transducers with a fresh reading at t, echo or not."""
        fresh = np.flatnonzero(self._is_front & (self._ring.ages(t) <= SONAR.max_age))
        return tuple(self._cones[number] for number in fresh.tolist())

    def _update_front(
        self,
        t: float,
        number: int,
        place: NDArray[np.float64],
        odometry: Pose,
        known: Callable[[], NDArray[np.float64]],
    ) -> None:
        """Add a front echo at a place (x, y), m, odom, if it counts; nan: there is none.

        Earlier ones that the transducer would hear and does not are dropped.
        """
        distance = self._ring.ranges[number]
        if len(self._low):
            low = move_points(self._low, odometry.between(_ORIGIN))
            past = self._cone_to(number, HALF_CONE, distance - SAME_PLACE)
            self._low_misses += past.mask(low)
            kept = (self._low_misses < MISSES) & (t - self._low_t <= MEMORY)
            self._low = self._low[kept]
            self._low_t = self._low_t[kept]
            self._low_misses = self._low_misses[kept]
        if distance < FRONT_REACH and self._is_confirmed(t, number, place):
            explained = self._cone_to(number, _SIDE_LOBES, distance + _SEEN_BEYOND).mask(known())
            if not explained.any():
                self._low = np.concatenate((self._low, place[None]))
                self._low_t = np.append(self._low_t, t)
                self._low_misses = np.append(self._low_misses, 0)

    def _is_confirmed(self, t: float, number: int, place: NDArray[np.float64]) -> bool:
        """Return whether this front transducer or one next to it has just heard the same place."""
        near = slice(max(number - 1, 0), number + 2)
        away = self._echoes[near] - place
        lately = self._is_front[near] & (t - self._heard_t[near] <= CONFIRM_WITHIN)
        return bool((lately & (np.hypot(away[:, 0], away[:, 1]) < SAME_PLACE)).any())

    def _cone_to(self, number: int, half_angle: float, reach: float) -> FieldOfView:
        """Return a transducer's cone of another half angle, rad, and reach, m."""
        return self._cones[number]._replace(half_angle=half_angle, reach=reach)
