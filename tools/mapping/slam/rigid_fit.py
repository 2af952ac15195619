"""Least-squares rigid transform between two lists of positions."""

from __future__ import annotations

import math
from collections.abc import Sequence

import numpy as np

from maps.pose import Pose
from tools.mapping.slam.cloud import rotation_of


def fit(poses: Sequence[Pose], onto: Sequence[Pose]) -> Pose:
    """Return the transform that moves the positions of ``poses`` onto those of ``onto``.

    Least squares, closed form in the plane (Lu and Milios, "Robot pose estimation in unknown
    environments by matching 2D range scans", 1997, appendix).
    """
    here, there = (np.array([pose[:2] for pose in side]) for side in (poses, onto))
    a, b = here - here.mean(axis=0), there - there.mean(axis=0)
    theta = math.atan2(float(np.sum(a[:, 0] * b[:, 1] - a[:, 1] * b[:, 0])), float(np.sum(a * b)))
    x, y = there.mean(axis=0) - rotation_of(theta) @ here.mean(axis=0)
    return Pose(float(x), float(y), theta)
