"""Checks of loops: what the way between its ends allows, and whether the other loops agree.

Look-alike places give matches as good as a true one. A false one bends the way between its ends by
more than the errors of odometry and scan matching along it, or is contradicted by the other loops.
"""

from __future__ import annotations

import csv
import math
from collections.abc import Sequence
from dataclasses import dataclass
from pathlib import Path

import numpy as np
from numpy.typing import NDArray

from maps.pose import Pose, wrap_angle
from maps.whole_file import whole_file
from tools.mapping.slam.pose_graph import Edge
from tools.mapping.slam.way_error import WayError

MOST_STRAIN = 4.03
"""Root of the 99.9 % quantile of chi-square with 3 degrees of freedom: more is no true loop."""
_SAME = np.diag(np.square((0.13, 0.13, math.radians(1.3))))
"""Of the graph's poses of one place, m^2 and rad^2: at 3 sigmas 0.4 m and 4 degrees apart."""
_SHORTEST_WAY = 64  # steps, about 16 m: errors of single steps are not bends
_UNSEEN = 1e-6 * np.eye(3)
"""Information along directions that scans do not determine: as good as none."""


@dataclass(frozen=True, slots=True)
class CheckedLoop:
    """One loop of a map, for people."""

    pose: Pose
    """map_from_laser where it was closed."""
    way: float
    """m between its ends."""
    shift: float
    turn: float
    """By which it moved its end against the chain, m and rad."""
    strain: float
    """That in standard deviations of the chain's errors along the way."""
    kept: bool
    """Whether the others agree; one that was overruled is left out."""


def strain(loop: Edge, chain: Sequence[Pose], errors: WayError) -> float:
    """Return a loop's distance from the chain, in standard deviations of their errors."""
    allowed = errors.between(loop.start, loop.end) + _covariance(loop)
    return _distance(chain[loop.start].between(chain[loop.end]), loop.pose, allowed)


def is_overruled(loop: Edge, poses: Sequence[Pose]) -> bool:
    """Whether poses that all loops gave together are not those of a loop."""
    found = poses[loop.start].between(poses[loop.end])
    return _distance(found, loop.pose, _covariance(loop) + _SAME) > MOST_STRAIN


def worst_bend(poses: Sequence[Pose], chain: Sequence[Pose], errors: WayError) -> tuple[float, int]:
    """Return by how many standard deviations poses bend the chain most, and a keyframe there.

    Ways of all lengths are looked at: several loops together may bend one more than each does.
    """
    worst, place, span = 0.0, 0, _SHORTEST_WAY
    while span < len(poses):
        for start in range(0, len(poses) - span, span // 4):
            end = start + span
            drifted, found = chain[start].between(chain[end]), poses[start].between(poses[end])
            bend = _distance(drifted, found, errors.between(start, end))
            if bend > worst:
                worst, place = bend, (start + end) // 2
        span *= 2
    return worst, place


def write_loops(path: Path, loops: Sequence[CheckedLoop]) -> None:
    """Write a CSV with one line per loop."""
    with whole_file(path) as part, part.open("w", newline="", encoding="utf-8") as file:
        writer = csv.writer(file, lineterminator="\n")
        writer.writerow(("x_m", "y_m", "way_m", "shift_m", "turn_deg", "strain", "kept"))
        for loop in loops:
            numbers = (*loop.pose[:2], loop.way, loop.shift, math.degrees(loop.turn), loop.strain)
            writer.writerow((*(f"{number:.3f}" for number in numbers), int(loop.kept)))


def _covariance(loop: Edge) -> NDArray[np.float64]:
    return np.asarray(np.linalg.inv(loop.information + _UNSEEN))


def _distance(one: Pose, other: Pose, covariance: NDArray[np.float64]) -> float:
    off = np.array((other.x - one.x, other.y - one.y, wrap_angle(other.theta - one.theta)))
    return math.sqrt(float(off @ np.linalg.solve(covariance, off)))
