"""Keyframes: the scans selected for matching, with the surface normal at each point."""

from __future__ import annotations

import math
from collections.abc import Sequence
from dataclasses import dataclass
from typing import Protocol

import numpy as np
from numpy.typing import NDArray

from localization.scan_motion import share_on_surfaces, surfaces_of
from maps.pose import Pose

_STEP = 0.25  # m; a scan becomes a keyframe this far from the last one
_TURN = math.radians(10.0)  # rad; or turned by this
_LEAST_SHARE = 0.6  # of its points on the surfaces of the last one; with less it has moved
_REACH = 20.0  # m; beyond, beams are too far apart for normals
_NEIGHBOURS = 8  # beams to each side used for the normal
_NEAR = 0.3  # m; neighbours farther away belong to another surface
_MIN_POINTS = 3  # needed for a normal
_FLATNESS = 0.05  # largest ratio of the variances across and along a surface


class Measurement(Protocol):
    """A laser scan with the raw odometry of the laser at its time."""

    @property
    def t(self) -> float:
        """Time of the scan."""

    @property
    def odometry(self) -> Pose:
        """odom_from_laser."""

    def points(self) -> NDArray[np.float64]:
        """Return (n, 2) end points, m, laser frame, in the order of the beams."""


@dataclass(frozen=True, slots=True, eq=False)
class Keyframe:
    """A scan prepared for matching."""

    t: float
    odometry: Pose
    """odom_from_laser."""
    points: NDArray[np.float64]
    """(n, 2) m, laser frame."""
    normals: NDArray[np.float64]
    """(n, 2) unit surface normals at each point; nan where unknown."""


def choose_keyframes(scans: Sequence[Measurement]) -> list[int]:
    """Return the indices of the scans taken a step or a turn apart; the first and last always.

    By the odometry, and by the scans, as wheels may miss a turn: a scan that does not lie on the
    surfaces of the last one chosen, where the odometry puts it, is taken as well.
    """
    chosen = [0]
    surfaces = surfaces_of(scans[0].points())
    for index, scan in enumerate(scans):
        last = scans[chosen[-1]].odometry
        moved = math.dist(scan.odometry[:2], last[:2]) >= _STEP
        turned = abs(math.remainder(scan.odometry.theta - last.theta, math.tau)) >= _TURN
        taken = moved or turned or index == len(scans) - 1
        if index and not taken and surfaces is not None:
            points, step = scan.points(), last.between(scan.odometry)
            taken = share_on_surfaces(surfaces, points, step) < _LEAST_SHARE
        if index and taken:
            chosen.append(index)
            surfaces = surfaces_of(scan.points())
    return chosen


def make_keyframe(scan: Measurement) -> Keyframe:
    """Return a scan prepared for matching."""
    points = scan.points()
    points = points[np.hypot(points[:, 0], points[:, 1]) < _REACH]
    return Keyframe(scan.t, scan.odometry, points, surface_normals(points))


def surface_normals(points: NDArray[np.float64]) -> NDArray[np.float64]:
    """Return (n, 2) unit normals of the line through each point's neighbours among the beams.

    points: (n, 2) m, in the order of the beams. nan where the neighbours lie on no line.
    """
    count = np.zeros(len(points))
    first = np.zeros((len(points), 2))
    second = np.zeros((len(points), 3))
    for offset in range(-_NEIGHBOURS, _NEIGHBOURS + 1):
        here = slice(max(0, -offset), len(points) - max(0, offset))
        there = slice(max(0, offset), len(points) - max(0, -offset))
        if here.start >= len(points) or there.start >= len(points):
            continue
        away = points[there] - points[here]
        near = np.hypot(away[:, 0], away[:, 1]) < _NEAR
        away = away * near[:, None]
        count[here] += near
        first[here] += away
        second[here] += np.column_stack((away[:, 0] ** 2, away[:, 0] * away[:, 1], away[:, 1] ** 2))
    mean = first / np.maximum(count, 1.0)[:, None]
    xx, xy, yy = (second / np.maximum(count, 1.0)[:, None]).T
    xx, xy, yy = xx - mean[:, 0] ** 2, xy - mean[:, 0] * mean[:, 1], yy - mean[:, 1] ** 2
    # Principal axis of a 2 x 2 covariance; the normal is a quarter turn from it.
    along = 0.5 * np.arctan2(2.0 * xy, xx - yy)
    spread = np.hypot(0.5 * (xx - yy), xy)
    largest, smallest = 0.5 * (xx + yy) + spread, 0.5 * (xx + yy) - spread
    normals = np.column_stack((-np.sin(along), np.cos(along)))
    normals[(count < _MIN_POINTS) | (smallest > _FLATNESS * largest)] = np.nan
    return normals
