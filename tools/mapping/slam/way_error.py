"""What the chain's errors allow between any two keyframes: the covariance of their relative pose.

Errors of the steps are taken as independent. That of a heading moves all that follows by its lever
arm, so that the sums over a way are those of the steps' moments, kept cumulated.
"""

from __future__ import annotations

from collections.abc import Sequence
from typing import Any

import numpy as np
from numpy.typing import NDArray

from maps.pose import Pose
from tools.mapping.slam.cloud import rotation_of
from tools.mapping.slam.pose_graph import Edge


class WayError:
    """Errors along a chain of keyframes."""

    def __init__(self, poses: Sequence[Pose], edges: Sequence[Edge]) -> None:
        """Take the chain's poses and its edges, one or two for each step."""
        # No step is wrong by more than a metre or a radian or so, whatever scans leave open.
        information = np.tile(np.eye(3), (len(poses) - 1, 1, 1))
        for edge in edges:
            information[edge.start] += edge.information
        covariance: NDArray[np.float64] = np.asarray(np.linalg.inv(information))
        self._poses = np.array(poses)
        turned: NDArray[np.float64] = np.array([rotation_of(pose.theta) for pose in poses[:-1]])
        shifts = np.asarray(turned @ covariance[:, :2, :2] @ turned.transpose(0, 2, 1))
        turns, ends = covariance[:, 2, 2], self._poses[1:, :2]
        self._shifts = _cumulated(shifts)
        self._turns = _cumulated(turns)
        self._first = _cumulated(turns[:, np.newaxis] * ends)
        self._second = _cumulated(
            turns[:, np.newaxis, np.newaxis] * ends[:, :, np.newaxis] * ends[:, np.newaxis, :]
        )

    def between(self, start: int, end: int) -> NDArray[np.float64]:
        """Return the covariance (3, 3) of start_from_end, start before end; m and rad."""
        shift, turn, first, second = (
            sums[end] - sums[start]
            for sums in (self._shifts, self._turns, self._first, self._second)
        )
        here = self._poses[end, :2]
        arm = turn * here - first  # sum of lever arms, weighted
        arms = turn * np.outer(here, here) - np.outer(first, here) - np.outer(here, first) + second
        aside = np.array(((0.0, -1.0), (1.0, 0.0)))
        whole = np.empty((3, 3))
        whole[:2, :2] = shift + aside @ arms @ aside.T
        whole[:2, 2] = whole[2, :2] = aside @ arm
        whole[2, 2] = turn
        back = np.eye(3)
        back[:2, :2] = rotation_of(float(self._poses[start, 2])).T
        return np.asarray(back @ whole @ back.T)


def _cumulated(values: NDArray[Any]) -> NDArray[np.float64]:
    return np.concatenate((np.zeros_like(values[:1]), np.cumsum(values, axis=0)))
