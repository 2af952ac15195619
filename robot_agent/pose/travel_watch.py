"""The watch of travel: whether scans show the motion that the wheels count.

A laser that is mounted other than the configuration says sees the robot travel in another
direction: turned by the error of theta; a mirrored one, or one upside down, sees it turn the
other way; one that repeats its scan sees no motion at all. Each of these is a hypothesis. Every
few decimetres two scans are aligned without the map, and each hypothesis is compared with "as
configured" by how far the motion seen is from the one expected, in standard deviations. The
gain of each is summed up and never below zero (Page's CUSUM test): a single wrong sample, by
people or a sill, decides nothing, and directions that the scans do not determine, as along a
corridor, count for no hypothesis. One that gains ENOUGH is believed until the laser's line is
opened again.
"""

from __future__ import annotations

import math
from enum import StrEnum
from typing import NamedTuple

import numpy as np
from numpy.typing import NDArray

from localization.scan_motion import (
    ScanMotion,
    Surfaces,
    motion_between,
    share_on_surfaces,
    surfaces_of,
)
from maps.pose import Pose
from robot_agent.pose.travel_scale import TravelScale

TOLERANCE_DEG = 3.0
"""Error of the mount's theta that is not judged: bent brackets, and 1 degree of mounting."""
_TURNS_DEG = (*range(-170, -5, 10), *range(10, 190, 10))
"""Errors of theta that are hypotheses: the nearest one, when it is in between, gains."""
_TOLERATED_DEG = tuple(TOLERANCE_DEG * share for share in (-1.0, -0.5, 0.0, 0.5, 1.0))
_DIRECTIONS = np.exp(1j * np.radians((*_TURNS_DEG, *_TOLERATED_DEG)))
ENOUGH = 32.0
"""Sum of the gains, in squared standard deviations, for which a hypothesis is believed. Ours."""
_GAIN = 9.0  # at most, of one sample: four are needed at least
_FAR = 16.0  # squared standard deviations of a motion that a hypothesis does not explain
FIRST_STEP = 0.1  # m between two scans that are compared, while nothing is known
STEP = 0.6  # m likewise, once enough samples were as configured
PEEK = 0.3  # m at which it is then tested whether the scan has changed at all
FIRST_TURN, TURN = 0.17, 0.35  # rad, as FIRST_STEP and STEP
_DOUBT = 0.1 * ENOUGH  # evidence from which steps are short again
_FIRST_AGREED = 4  # samples as configured in a row, before the robot may go fast
_UNSEEN_WAY = 3.0  # m after which it may as well, where scans show nothing, as in a wide hall
_CONFIRMED = 8  # samples as configured in a row, before the longer step
_LEAST = 0.03  # m; a shorter way has no direction
_LONGEST = 1.0  # m, and rad; a longer motion between two scans is not judged
_OLDEST_S = 4.0  # of the first scan: people and teammates move
_MIN_SHARE = 0.4  # of the points on surfaces; less is no alignment
_WELL = 0.55  # of an alignment that needs no other start
_STILL = Pose(0.0, 0.0, 0.0)
# A tilted scanner sees the floor ahead as a wall that travels with the robot, and along a corridor
# little else may show the motion: a scan repeats only if nearly all of it, or what is near, stays.
_FLOOR = 3.5  # m; no floor is nearer to a scanner 0.19 m above it that is tilted by 3 degrees
_SAME = 0.05  # m; of a range from the one seen at its bearing before. Ours
_SAME_SHARE = 0.97  # ours
# Standard deviations of the wheels' motion, ours, wide enough for slip and skid-steering.
_ALONG = 0.25  # m/m
_ACROSS = 0.03  # m/m: 1.7 degrees
_TURNED = 0.25  # rad/rad
_TURNED_REST = 0.02  # rad
_TURNED_WAY = 0.05  # rad/m
_OFFSET = 0.03  # m/rad: error of the mount's x and y, and slip sideways
# Of the alignment, besides its own: errors that all points share. Ours.
_SEEN_XY = 0.004  # m
_SEEN_THETA = 0.006  # rad


class TravelFault(StrEnum):
    """What is wrong with the laser."""

    TURNED = "turned"
    MIRRORED = "mirrored"
    REPEATS = "repeats"


class TravelWatch:
    """Compares travel by wheels with travel by scans; ``fault`` is what it found, None if well."""

    def __init__(self) -> None:
        """Start without scans."""
        self.fault: TravelFault | None = None
        self.turned_deg = 0
        """By how much the laser is turned to the left of the configured theta, about; of TURNED."""
        self.confirmed = False
        """Whether scans and wheels have agreed since the laser's line was opened."""
        self.began: float | None = None
        """When the first scan came since then, s."""
        self.restart()

    def restart(self) -> None:
        """Forget everything: the laser's line was opened."""
        self.fault, self.confirmed, self.began = None, False, None
        self._unjudged = 0.0  # m driven without evidence
        self._first: Surfaces | None = None
        self._first_points = np.empty((0, 2))
        self._first_t = 0.0
        self._peeked = False  # whether the first scan was tested at PEEK
        self._odometry = Pose(0.0, 0.0, 0.0)
        self._turn_gains = np.zeros(len(_TURNS_DEG))
        self._mirror_gain = self._repeat_gain = 0.0
        self._as_configured = 0
        self.scale = TravelScale()

    def forget_scan(self) -> None:
        """Do not compare with the last scan: the wheels cannot be believed, e.g. in a stall."""
        self._first = None

    def update(self, t: float, odometry: Pose, points: NDArray[np.float64]) -> None:
        """Take in a scan at t: odom_from_base, and points (n, 2), m, base_link, by bearing.

        Points on bodies known to move are left out by the caller.
        """
        if self.began is None:
            self.began, self._odometry = t, odometry
        wheels = self._odometry.between(odometry)
        travel, turn = math.hypot(wheels.x, wheels.y), abs(wheels.theta)
        if self._first is None or t - self._first_t > _OLDEST_S or max(travel, turn) > _LONGEST:
            if self._first is None:
                self._pass_unjudged(travel)
            self._begin(t, odometry, points)
            return
        if self._as_configured >= _CONFIRMED and travel >= PEEK and not self._peeked:
            self._peeked = True
            if _looks_still(self._first, points, wheels):
                self._as_configured = 0
        well = self._as_configured >= _CONFIRMED
        step, least = (STEP, TURN) if well else (FIRST_STEP, FIRST_TURN)
        if travel < step and turn < least:
            return
        seen = _motion_seen(self._first, points, wheels)
        if seen is not None:
            self._judge(points, wheels, seen)
        else:
            self._pass_unjudged(travel)
        self._begin(t, odometry, points)

    def _begin(self, t: float, odometry: Pose, points: NDArray[np.float64]) -> None:
        self._first, self._first_t, self._odometry = surfaces_of(points), t, odometry
        self._first_points = points
        self._peeked = False

    def _pass_unjudged(self, travel: float) -> None:
        self._unjudged += travel
        self.confirmed = self.confirmed or self._unjudged >= _UNSEEN_WAY

    def _judge(self, points: NDArray[np.float64], wheels: Pose, seen: ScanMotion) -> None:
        """Sum up what one sample says for each hypothesis; wheels: motion they counted."""
        gains = _gains(wheels, seen)
        self.scale.add(wheels, seen.pose, gains.shift)
        self._turn_gains = np.maximum(self._turn_gains + gains.turned, 0.0)
        self._mirror_gain = max(self._mirror_gain + gains.mirrored, 0.0)
        repeating = self._repeating(points, wheels, gains.still)
        self._repeat_gain = max(self._repeat_gain + repeating, 0.0)
        most = max(float(self._turn_gains.max()), self._mirror_gain, self._repeat_gain)
        if most >= _DOUBT:
            self._as_configured = 0
        elif math.hypot(wheels.x, wheels.y) > _LEAST:  # a turn in place shows no direction
            self._as_configured += 1
        if self.fault is None and most >= ENOUGH:
            self._find(most)
        self.confirmed = self.confirmed or self._as_configured >= _FIRST_AGREED

    def _repeating(self, points: NDArray[np.float64], wheels: Pose, still: float) -> float:
        """Return what a sample says for a scan that repeats, of what it says for no motion."""
        if still <= 0.0 or self._first is None or _is_same(self._first_points, points):
            return still
        near = points[np.hypot(*points.T) < _FLOOR]
        seen = _motion_seen(self._first, near, wheels)
        return 0.0 if seen is None else min(still, _gains(wheels, seen).still)

    def _find(self, most: float) -> None:
        if self._repeat_gain == most:
            self.fault = TravelFault.REPEATS
        elif self._mirror_gain == most:
            self.fault = TravelFault.MIRRORED
        else:
            self.fault = TravelFault.TURNED
            # Seen from a laser turned to the left the travel is turned to the right.
            self.turned_deg = -_TURNS_DEG[int(self._turn_gains.argmax())]


def _motion_seen(first: Surfaces, points: NDArray[np.float64], wheels: Pose) -> ScanMotion | None:
    """Return the motion between two scans that explains most of the points; None: no good one.

    Begins at the wheels' motion, at none or at the reverse of it, where the scans fit best; where
    that leads to no good alignment, also at the others.
    """
    best: ScanMotion | None = None
    guesses = [wheels, _STILL, Pose(-wheels.x, -wheels.y, -wheels.theta)]
    shares = [share_on_surfaces(first, points, guess) for guess in guesses]
    for number in sorted(range(len(guesses)), key=lambda number: -shares[number]):
        found = motion_between(first, points, guesses[number])
        if found is not None and (best is None or found.share > best.share):
            best = found
        if best is not None and best.share >= _WELL:
            break
    return best if best is not None and best.share >= _MIN_SHARE else None


def _looks_still(first: Surfaces, points: NDArray[np.float64], wheels: Pose) -> bool:
    """Return whether two scans fit better without motion than with the wheels'."""
    moved = share_on_surfaces(first, points, wheels)
    return share_on_surfaces(first, points, _STILL) > moved


def _is_same(first: NDArray[np.float64], points: NDArray[np.float64]) -> bool:
    """Return whether nearly all points (m, 2) are as far away as the scan before was there."""
    before = np.arctan2(first[:, 1], first[:, 0])
    order = before.argsort()
    ranges = np.interp(
        np.arctan2(points[:, 1], points[:, 0]), before[order], np.hypot(*first[order].T)
    )
    same = np.abs(ranges - np.hypot(*points.T)) < _SAME
    return bool(same.mean() >= _SAME_SHARE)


class _Gains(NamedTuple):
    """What a sample says for each hypothesis: how much better it explains the motion seen than "as
    configured" does, in squared standard deviations.

    turned (n,). shift (2, 2): information of the shift seen, 1/m2.
    """

    turned: NDArray[np.float64]
    mirrored: float
    still: float
    shift: NDArray[np.float64]


def _gains(wheels: Pose, seen: ScanMotion) -> _Gains:
    """Compare a motion seen between two scans with the one that the wheels counted."""
    shift, turn = _certainty(seen)
    turned, configured = _turned_costs(wheels, seen.pose, shift)
    as_counted, mirrored = _turn_costs(wheels, seen.pose, turn)
    moved = min(configured + as_counted, _FAR)
    return _Gains(
        turned=_gain(configured, turned),
        mirrored=float(_gain(as_counted, mirrored)),
        still=float(_gain(moved, _still_cost(seen.pose, shift, turn))),
        shift=shift,
    )


def _certainty(seen: ScanMotion) -> tuple[NDArray[np.float64], float]:
    """Return the information (2, 2) of the shift, 1/m2, and of the turn, 1/rad2.

    Each while the other is unknown (Schur complement), and no more than _SEEN_XY, _SEEN_THETA.
    """
    whole = seen.information
    both, mixed, turn = whole[:2, :2], whole[:2, 2], float(whole[2, 2])
    shift = both - np.outer(mixed, mixed) / turn if turn > 0.0 else both
    values, vectors = np.linalg.eigh(shift)
    values = np.maximum(values, 0.0)
    floored = (vectors * (values / (1.0 + values * _SEEN_XY**2))) @ vectors.T
    alone = max(turn - float(mixed @ np.linalg.pinv(both, hermitian=True) @ mixed), 0.0)
    return floored, alone / (1.0 + alone * _SEEN_THETA**2)


def _turned_costs(
    wheels: Pose, seen: Pose, information: NDArray[np.float64]
) -> tuple[NDArray[np.float64], float]:
    """Return the costs of all hypotheses of a turned laser (n,), and that of a tolerated one."""
    travel = complex(wheels.x, wheels.y)
    way = abs(travel)
    if way < _LEAST:
        return np.zeros(len(_TURNS_DEG)), 0.0
    expected = travel * _DIRECTIONS
    off = complex(seen.x, seen.y) - expected
    along = expected / way
    spread = (_OFFSET * wheels.theta) ** 2
    noise = np.array((_ALONG * way, _ACROSS * way)) ** 2 + spread
    costs = np.minimum(_squares(off, along, noise, information), _FAR)
    count = len(_TURNS_DEG)
    return costs[:count], float(costs[count:].min())


def _squares(
    off: NDArray[np.complex128],
    along: NDArray[np.complex128],
    noise: NDArray[np.float64],
    information: NDArray[np.float64],
) -> NDArray[np.float64]:
    """Return (n,) squared distances in standard deviations, of wheels and scans together.

    noise: (2,) variances of the wheels along and across the direction (n,) along. information:
    (2, 2) of the scans.
    """
    axes = np.stack((along, 1j * along), axis=-1)
    rows = np.stack((axes.real, axes.imag), axis=-2)  # (n, 2, 2): columns along and across
    wheels = (rows / noise) @ rows.transpose(0, 2, 1)
    # The information of a difference, A (A + B)^-1 B: as singular as that of the scans.
    joint = information @ np.linalg.solve(information + wheels, wheels)
    vector = np.stack((off.real, off.imag), axis=-1)
    return np.asarray(np.einsum("ni,nij,nj->n", vector, joint, vector))


def _turn_costs(wheels: Pose, seen: Pose, information: float) -> tuple[float, float]:
    """Return the costs of a turn as counted, and of the opposite one."""
    if information <= 0.0:
        return 0.0, 0.0
    way = math.hypot(wheels.x, wheels.y)
    floor = _TURNED_REST + _TURNED_WAY * way
    variance = (_TURNED * wheels.theta) ** 2 + floor**2 + 1.0 / information
    return (
        min(math.remainder(seen.theta - wheels.theta, math.tau) ** 2 / variance, _FAR),
        min(math.remainder(seen.theta + wheels.theta, math.tau) ** 2 / variance, _FAR),
    )


def _still_cost(seen: Pose, shift: NDArray[np.float64], turn: float) -> float:
    """Return the cost of no motion at all."""
    place = np.array((seen.x, seen.y))
    return min(float(place @ shift @ place) + turn * seen.theta**2, _FAR)


def _gain(configured: float, hypothesis: NDArray[np.float64] | float) -> NDArray[np.float64]:
    return np.clip(configured - np.asarray(hypothesis), -_GAIN, _GAIN)
