"""Fits the laser's mount and the wheels to one drive, at once.

After Censi, Franchi, Marchionni and Oriolo, "Simultaneous calibration of odometry and sensor
parameters for mobile robots", IEEE T-RO 2013; here by robust least squares over all pairs of
scans. The motion of the laser that the wheels predict, given mount, scale of each wheel and
track, is compared with the one its scans show.
"""

from __future__ import annotations

import math
from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray
from scipy.optimize import least_squares

from maps.pose import Pose, wrap_angle
from tools.calibration.color_calibration import CalibrationError
from tools.calibration.ego_motion import OVERLAP, LaserMotion
from tools.calibration.geometry import Geometry

MIN_TRAVEL = 4.0  # m
MIN_TURN = math.radians(180.0)  # each way
MIN_MOTIONS = 25
_ALIGNED = 14.0  # information of a pair over that of ``align``, whose floor is for maps: 4 mm
_LEAST = 1e-4  # m and rad
_LEAST_FACTOR = 0.7  # on wheels and track
_BOUNDS = (
    (-np.inf, -np.inf, -np.inf, _LEAST_FACTOR, _LEAST_FACTOR, _LEAST_FACTOR),
    (np.inf, np.inf, np.inf, 1.0 / _LEAST_FACTOR, 1.0 / _LEAST_FACTOR, 1.0 / _LEAST_FACTOR),
)
"""Without, a laser turned by half a turn on wheels that count backwards fits as well."""
_SCALES = (0.1, 0.1, 0.1, 0.02, 0.02, 0.02)  # of the parameters, for the solver
_STARTS = tuple(math.radians(45.0 * number) for number in range(8))  # of the mount's theta


@dataclass(frozen=True, slots=True)
class Residual:
    """Root mean square difference of motions by wheels and by scans, per pair of scans."""

    metres: float
    degrees: float

    def __str__(self) -> str:
        return f"{1000.0 * self.metres:.1f} mm, {self.degrees:.2f} deg"


@dataclass(frozen=True, slots=True)
class GeometryFit:
    """Fitted geometry with its standard deviations, residuals of the start and of the fit, number
    of pairs of scans, way driven, m.

    sigma: of the mount's x, y, m, and theta, rad; of the factors on left wheel, right wheel, track.
    """

    geometry: Geometry
    sigma: tuple[float, ...]
    before: Residual
    after: Residual
    pairs: int
    way: float

    def way_for(self, wanted: float) -> float:
        """Return how long a drive gives the factors on both wheels a standard deviation, m.

        Slip is independent from metre to metre: its mean falls with the root of the way.
        """
        return self.way * (max(self.sigma[3:5]) / wanted) ** 2


def fit_geometry(
    odometry: Sequence[Pose], motions: Sequence[LaserMotion], configured: Geometry
) -> GeometryFit:
    """Fit mount and wheels to a drive.

    odometry: odom_from_base at each scan, as counted with the scales and track of ``configured``.
    Raises CalibrationError for a drive that does not determine them.
    """
    way, turn = wheel_steps(odometry)
    _check(way, turn, len(motions))
    # 1. Does the laser see the turns as the wheels count them?
    counted = np.array([turn[m.first : m.second].sum() for m in motions])
    seen = np.array([m.motion.theta for m in motions])
    mirrored = bool(np.median(seen * counted) < 0.0)
    problem = _Problem(way, turn, motions, mirrored, configured)
    # 2. Fit from several directions of the mount; the best one is it.
    fits = [problem.fit(theta) for theta in _STARTS]
    found, _, _ = min(fits, key=lambda fit: fit[1])
    # 3. Once more with the weights that the wheels' slip leaves to shift and turn.
    problem.weigh_by(found)
    found, _, sigma = problem.fit_from(found)
    before = _Problem(way, turn, motions, configured.upside_down, configured)
    start = np.array((*configured.mount, 1.0, 1.0, 1.0))
    geometry = Geometry(
        mount=Pose(float(found[0]), float(found[1]), wrap_angle(float(found[2]))),
        left=configured.left * float(found[3]),
        right=configured.right * float(found[4]),
        track=configured.track * float(found[5]),
        upside_down=mirrored,
    )
    return GeometryFit(
        geometry,
        sigma,
        before.residual(start),
        problem.residual(found),
        len(motions),
        way=float(np.abs(way).sum()),
    )


def wheel_steps(odometry: Sequence[Pose]) -> tuple[NDArray[np.float64], NDArray[np.float64]]:
    """Return the way driven, m, and the turn, rad, both (n - 1,), from each pose to the next."""
    x, y, theta = np.array(odometry).reshape(-1, 3).T
    turn = np.diff(theta)
    turn -= math.tau * np.round(turn / math.tau)
    middle = theta[:-1] + 0.5 * turn
    chord = np.diff(x) * np.cos(middle) + np.diff(y) * np.sin(middle)
    return np.asarray(chord / np.sinc(0.5 * turn / math.pi)), turn


def _check(way: NDArray[np.float64], turn: NDArray[np.float64], pairs: int) -> None:
    """Raise CalibrationError for too little motion."""
    travel, left, right = np.abs(way).sum(), turn[turn > 0.0].sum(), -turn[turn < 0.0].sum()
    if travel < MIN_TRAVEL or min(left, right) < MIN_TURN:
        raise CalibrationError(
            f"{travel:.1f} m driven, turned {math.degrees(left):.0f} deg to the left and "
            f"{math.degrees(right):.0f} to the right: drive {MIN_TRAVEL:g} m or more and turn "
            f"{math.degrees(MIN_TURN):.0f} each way or more, e.g. a square both ways round"
        )
    if pairs < MIN_MOTIONS:
        raise CalibrationError(
            f"only {pairs} pairs of scans show a motion, {MIN_MOTIONS} are needed: drive in a room "
            "with walls in 10 m, and with nobody walking about"
        )


class _Problem:
    """Differences of the motions by wheels and by scans, as a function of six parameters: x, y,
    theta of the mount, factors on left wheel, right wheel, track."""

    def __init__(
        self,
        way: NDArray[np.float64],
        turn: NDArray[np.float64],
        motions: Sequence[LaserMotion],
        mirrored: bool,
        configured: Geometry,
    ) -> None:
        self._half_track = 0.5 * configured.track
        self._left = way - self._half_track * turn
        self._right = way + self._half_track * turn
        self._first = np.array([m.first for m in motions])
        self._second = np.array([m.second for m in motions])
        side = -1.0 if mirrored else 1.0
        seen = np.array([m.motion for m in motions])
        self._place = seen[:, 0] + 1j * side * seen[:, 1]
        self._theta = side * seen[:, 2]
        flip = np.diag((1.0, side, side))
        self._information = np.array([flip @ m.information @ flip for m in motions])
        self._roots = np.array([_root(each) for each in self._information])

    def fit(self, theta: float) -> tuple[NDArray[np.float64], float, tuple[float, ...]]:
        """Return the best parameters found from a mount's theta, rad, their cost and sigmas."""
        return self.fit_from(np.array((0.0, 0.0, theta, 1.0, 1.0, 1.0)))

    def fit_from(
        self, start: NDArray[np.float64]
    ) -> tuple[NDArray[np.float64], float, tuple[float, ...]]:
        """Return as ``fit``, from all parameters."""
        found = least_squares(
            self._weighted, start, bounds=_BOUNDS, loss="soft_l1", x_scale=_SCALES
        )
        variance = 2.0 * found.cost / found.fun.size * OVERLAP
        covariance = variance * np.linalg.pinv(found.jac.T @ found.jac, hermitian=True)
        sigma = np.sqrt(np.maximum(np.diag(covariance), 0.0))
        return np.asarray(found.x), float(found.cost), tuple(sigma.tolist())

    def weigh_by(self, parameters: NDArray[np.float64]) -> None:
        """Weigh shifts and turns by how far they are off at these parameters."""
        off, turned = self._differences(parameters)
        shift, turn = _spread(np.abs(off)) / math.sqrt(2.0), _spread(np.abs(turned))
        slip = np.diag((shift**-2, shift**-2, turn**-2))
        seen = self._information * _ALIGNED
        self._roots = np.array([_root(each @ np.linalg.solve(each + slip, slip)) for each in seen])

    def residual(self, parameters: NDArray[np.float64]) -> Residual:
        """Return the root mean square differences, without the worst tenth of the pairs."""
        off, turned = self._differences(parameters)
        return Residual(_rms(np.abs(off)), math.degrees(_rms(np.abs(turned))))

    def _weighted(self, parameters: NDArray[np.float64]) -> NDArray[np.float64]:
        off, turned = self._differences(parameters)
        vector = np.stack((off.real, off.imag, turned), axis=-1)
        return np.asarray(np.einsum("nij,nj->ni", self._roots, vector).ravel())

    def _differences(
        self, parameters: NDArray[np.float64]
    ) -> tuple[NDArray[np.complex128], NDArray[np.float64]]:
        """Return (n,) shifts, m, as x + iy in the first scan's frame, and (n,) turns, rad."""
        x, y, theta, left, right, track = parameters
        by_left, by_right = left * self._left, right * self._right
        turn = (by_right - by_left) / (2.0 * self._half_track * track)
        heading = np.concatenate(([0.0], np.cumsum(turn)))
        middle = heading[:-1] + 0.5 * turn
        chords = 0.5 * (by_left + by_right) * np.sinc(0.5 * turn / math.pi)
        place = np.concatenate(([0.0], np.cumsum(chords * np.exp(1j * middle))))
        mount = complex(x, y)
        laser = place + mount * np.exp(1j * heading)
        aim = heading + theta
        moved = (laser[self._second] - laser[self._first]) * np.exp(-1j * aim[self._first])
        turned = aim[self._second] - aim[self._first] - self._theta
        turned -= math.tau * np.round(turned / math.tau)
        return moved - self._place, turned


def _root(information: NDArray[np.float64]) -> NDArray[np.float64]:
    """Return the matrix (3, 3) that gives differences in standard deviations."""
    values, vectors = np.linalg.eigh(information)
    return np.asarray(np.sqrt(np.maximum(values, 0.0))[:, None] * vectors.T)


def _spread(values: NDArray[np.float64]) -> float:
    """Return the standard deviation of absolute values, robustly, and no less than tiny."""
    return max(1.48 * float(np.median(values)), _LEAST)


def _rms(values: NDArray[np.float64]) -> float:
    best = np.sort(values)[: max(round(0.9 * len(values)), 1)]
    return float(np.sqrt(np.mean(best**2)))
