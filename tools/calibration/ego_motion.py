"""Motion of the laser over a drive by its scans alone: no map, no odometry, no mount.

Keyframes a step apart are matched one by one with those before them (exhaustive search, then
point-to-line alignment); then each is aligned with one several steps before, and that with it:
the longer motion is measured as precisely.
"""

from __future__ import annotations

import math
from collections.abc import Callable
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from maps.pose import Pose
from tools.calibration.drive import Drive
from tools.mapping.slam.alignment import Alignment, align
from tools.mapping.slam.cloud import join
from tools.mapping.slam.correlation import search
from tools.mapping.slam.keyframe import Keyframe, surface_normals

_STEP = 0.15  # m by the wheels between keyframes
_TURN = math.radians(8.0)  # likewise
_WINDOW = (0.5, math.radians(30.0))  # m, rad; of the search: more than a step by bad wheels
_MIN_SCORE = 0.4  # of the search
_MIN_SHARE = 0.5  # of points on surfaces, of an accepted alignment
_FAR = 15.0  # m; beams farther away are left out
OVERLAP = 4  # keyframes from the first to the second of a pair: as many pairs share each step


@dataclass(frozen=True, slots=True, eq=False)
class LaserMotion:
    """Motion of the laser between two scans: indices of both, first_from_second, information (3, 3)
    of x, y, theta."""

    first: int
    second: int
    motion: Pose
    information: NDArray[np.float64]


def laser_motions(drive: Drive, progress: Callable[[float], None]) -> list[LaserMotion]:
    """Return the measured motions of a drive; progress: called with the number of keyframes."""
    chosen = _keyframes(drive.odometry)
    frames = [_keyframe(drive, index) for index in chosen]
    steps: list[Pose | None] = [None]
    motions = []
    for number in range(1, len(frames)):
        steps.append(_step(frames[number - 1], frames[number]))
        motions += _pair(frames, chosen, steps, number)
        progress(number)
    return motions


def _keyframes(odometry: list[Pose]) -> list[int]:
    chosen = [0] if odometry else []
    for index, pose in enumerate(odometry):
        moved = odometry[chosen[-1]].between(pose)
        if math.hypot(moved.x, moved.y) >= _STEP or abs(moved.theta) >= _TURN:
            chosen.append(index)
    return chosen


def _keyframe(drive: Drive, index: int) -> Keyframe:
    points = drive.points[index]
    points = points[np.hypot(points[:, 0], points[:, 1]) < _FAR]
    return Keyframe(float(index), drive.odometry[index], points, surface_normals(points))


def _step(before: Keyframe, after: Keyframe) -> Pose | None:
    """Return the laser's motion from one keyframe to the next; None if the scans do not tell."""
    still = Pose(0.0, 0.0, 0.0)
    if not len(before.points) or not len(after.points):
        return None
    peak = search(after.points, before.points, still, *_WINDOW)
    if peak.score < _MIN_SCORE:
        return None
    found = _aligned(after, before, peak.pose)
    return None if found is None else found.pose


def _pair(
    frames: list[Keyframe], chosen: list[int], steps: list[Pose | None], number: int
) -> list[LaserMotion]:
    """Return the motion to a keyframe from one OVERLAP before; [] if it is not known."""
    first = number - OVERLAP
    if first < 0:
        return []
    guess = Pose(0.0, 0.0, 0.0)
    for step in steps[first + 1 : number + 1]:
        if step is None:
            return []
        guess = guess.compose(step)
    # Both ways, as errors of which points are paired with which cancel out in part.
    there = _aligned(frames[number], frames[first], guess)
    back = _aligned(frames[first], frames[number], guess.inverse())
    if there is None or back is None:
        return []
    motion = _middle(there.pose, back.pose.inverse())
    return [LaserMotion(chosen[first], chosen[number], motion, there.information)]


def _aligned(frame: Keyframe, on: Keyframe, guess: Pose) -> Alignment | None:
    """Return the pose of a keyframe in another one's frame; None if it is not known."""
    found = align(frame.points, join([(Pose(0.0, 0.0, 0.0), on)]), guess)
    return None if found is None or found.share < _MIN_SHARE else found


def _middle(one: Pose, other: Pose) -> Pose:
    """Return the pose halfway between two near ones."""
    off = one.between(other)
    return one.compose(Pose(0.5 * off.x, 0.5 * off.y, 0.5 * off.theta))
