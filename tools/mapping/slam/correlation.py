"""Exhaustive search for a scan's pose in a cloud (after Olson, "Real-time correlative scan
matching", ICRA 2009): every shift of a grid at once, rotation by rotation."""

from __future__ import annotations

import math
from dataclasses import dataclass

import cv2
import numpy as np
from numpy.lib.stride_tricks import sliding_window_view
from numpy.typing import NDArray

from maps.pose import Pose, wrap_angle
from tools.mapping.slam.cloud import rotation_of

_CELL = 0.1  # m
_SIGMA = 0.1  # m; of a point's distance from its surface
_REACH = 10.0  # m; points of the scan farther away are left out
_TURN = math.radians(1.5)  # rad between two rotations tried
_PRIOR = 0.1  # of score, subtracted at the edge of the window
_SAME_PLACE = 0.7  # m; two peaks nearer than this are one
_LOOKED_UP = 61  # shifts each way; up to 3 m looking cells up is faster than a convolution


@dataclass(frozen=True, slots=True)
class Peak:
    """The best pose found."""

    pose: Pose
    """cloud_from_scan."""
    score: float
    """Mean likelihood of the scan's points, 0 to 1."""
    runner_up: float
    """The score of the best other peak, 0 to 1."""


def search(
    points: NDArray[np.float64],
    target: NDArray[np.float64],
    guess: Pose,
    window: float,
    turn_window: float,
) -> Peak:
    """Score all shifts up to ``window`` m and turns up to ``turn_window`` rad off a guess.

    Of equal scores the one nearer to the guess is preferred, as along a corridor. guess:
    cloud_from_scan. points: (n, 2) m, scan frame. target: (m, 2) m, cloud frame.
    """
    points = points[np.hypot(points[:, 0], points[:, 1]) < _REACH]
    half = round(_REACH / _CELL) + 1
    shifts = math.ceil(window / _CELL)
    field = _likelihood(target - guess[:2], half + shifts)
    many = math.ceil(turn_window / _TURN)
    turns = np.arange(-many, many + 1) * np.float64(_TURN)
    scores = np.stack([_scores(points, guess.theta + turn, field, half) for turn in turns])
    likely = scores - _prior(shifts, turns)
    best = np.unravel_index(int(np.argmax(likely)), scores.shape)
    turn, row, col = (int(index) for index in best)
    over_turns = scores.max(axis=0)
    apart = round(_SAME_PLACE / _CELL)
    score = float(scores[best])
    over_turns[max(row - apart, 0) : row + apart + 1, max(col - apart, 0) : col + apart + 1] = 0.0
    pose = Pose(
        guess.x + (col - shifts) * _CELL,
        guess.y + (row - shifts) * _CELL,
        wrap_angle(guess.theta + float(turns[turn])),
    )
    return Peak(pose, score, float(over_turns.max()))


def _prior(shifts: int, turns: NDArray[np.float64]) -> NDArray[np.float32]:
    """Return the score, (turns, rows, cols), to subtract for the distance from the guess."""
    off = (np.arange(-shifts, shifts + 1) / max(shifts, 1)) ** 2
    turned = (turns / max(turns[-1], _TURN)) ** 2
    cost = turned[:, None, None] + off[None, :, None] + off[None, None, :]
    return np.asarray(_PRIOR * cost, dtype=np.float32)


def _likelihood(target: NDArray[np.float64], half: int) -> NDArray[np.float32]:
    """Return the likelihood of a point in each cell of a square grid round the origin, 0 to 1."""
    empty = np.full((2 * half + 1, 2 * half + 1), 255, dtype=np.uint8)
    cells = np.rint(target / _CELL).astype(int) + half
    cells = cells[((cells >= 0) & (cells <= 2 * half)).all(axis=1)]
    empty[cells[:, 1], cells[:, 0]] = 0
    distance = cv2.distanceTransform(empty, cv2.DIST_L2, cv2.DIST_MASK_PRECISE) * _CELL
    return np.asarray(np.exp(-0.5 * (distance / _SIGMA) ** 2), dtype=np.float32)


def _scores(
    points: NDArray[np.float64], theta: float, field: NDArray[np.float32], half: int
) -> NDArray[np.float32]:
    """Return the mean likelihood of the points at each shift."""
    cells = np.rint(points @ rotation_of(theta).T / _CELL).astype(int) + half
    taken = np.unique(cells[:, 1] * len(field) + cells[:, 0])
    rows, cols = np.divmod(taken, len(field))
    each_way = len(field) - 2 * half  # shifts, none among them
    if each_way <= _LOOKED_UP:
        total = sliding_window_view(field, (each_way, each_way))[rows, cols].sum(axis=0)
    else:
        scan = np.zeros((2 * half + 1, 2 * half + 1), dtype=np.float32)
        scan[rows, cols] = 1.0
        total = cv2.matchTemplate(field, scan, cv2.TM_CCORR)
    return np.asarray(total / max(len(taken), 1), dtype=np.float32)
