"""Pose graph optimization with robust edges.

Gauss-Newton on sparse normal equations (Grisetti et al., "A tutorial on graph-based SLAM", 2010),
with Geman-McClure weights on the edges that may be wrong: the larger the residual of a wrong loop
the less its weight.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray
from scipy.sparse import coo_matrix
from scipy.sparse.linalg import splu

from maps.pose import Pose, wrap_angle

_MAX_STEPS = 30
_CONVERGED = 1e-4  # m and rad
_ROUGH = 0.01  # m and rad, before the last scale
_ROUGH_STEPS = 6
_GRADUATION = 3.0  # ratio of successive scales
_ANCHOR = 1e8  # information that holds the first pose


@dataclass(frozen=True, slots=True, eq=False)
class Edge:
    """A measured relative pose of two nodes."""

    start: int
    end: int
    pose: Pose
    """start_from_end."""
    information: NDArray[np.float64]
    """(3, 3) inverse covariance of x, y, theta, in the frame of ``start``."""
    robust: bool = True
    """Whether it is weighted robustly, because it may be wrong."""


def optimize(poses: Sequence[Pose], edges: Sequence[Edge], scale: float = 3.0) -> list[Pose]:
    """Return the poses with the least weighted squared errors of the edges; the first is fixed.

    scale: the residual, in standard deviations, at which a robust edge has a quarter of its weight.
    """
    state = np.array(poses, dtype=np.float64)
    graph = _Arrays(edges)
    # All edges have full weight at first, then outliers lose theirs gradually (Yang et al.,
    # "Graduated non-convexity", 2020): a right loop after much drift has a large first residual.
    at = max(scale, 2.0 * float(np.sqrt(graph.squares(graph.errors(state)[0]).max())))
    while True:
        for _ in range(_MAX_STEPS if at == scale else _ROUGH_STEPS):
            change = graph.step(state, at)
            state += change
            if np.abs(change).max() < (_CONVERGED if at == scale else _ROUGH):
                break
        if at == scale:
            break
        at = max(scale, at / _GRADUATION)
    return [Pose(float(x), float(y), wrap_angle(float(theta))) for x, y, theta in state]


class _Arrays:
    """Edges as arrays, linearized together."""

    def __init__(self, edges: Sequence[Edge]) -> None:
        self._start = np.array([edge.start for edge in edges])
        self._end = np.array([edge.end for edge in edges])
        self._measured = np.array([edge.pose for edge in edges], dtype=np.float64)
        self._information = np.array([edge.information for edge in edges])
        self._robust = np.array([edge.robust for edge in edges])

    def errors(
        self, state: NDArray[np.float64]
    ) -> tuple[NDArray[np.float64], tuple[NDArray[np.float64], NDArray[np.float64]]]:
        """Return (n, 3) errors and (n, 3, 3) Jacobians by start and end."""
        start, end = state[self._start], state[self._end]
        c, s = np.cos(start[:, 2]), np.sin(start[:, 2])
        dx, dy = end[:, 0] - start[:, 0], end[:, 1] - start[:, 1]
        errors = np.column_stack((c * dx + s * dy, c * dy - s * dx, end[:, 2] - start[:, 2]))
        by_start, by_end = np.zeros((2, len(start), 3, 3))
        by_end[:, 0, 0], by_end[:, 0, 1] = c, s
        by_end[:, 1, 0], by_end[:, 1, 1] = -s, c
        by_end[:, 2, 2] = 1.0
        by_start[:] = -by_end
        by_start[:, 0, 2], by_start[:, 1, 2] = errors[:, 1], -errors[:, 0]
        errors -= self._measured
        errors[:, 2] = np.remainder(errors[:, 2] + np.pi, 2.0 * np.pi) - np.pi
        return errors, (by_start, by_end)

    def squares(self, errors: NDArray[np.float64]) -> NDArray[np.float64]:
        """Return (n,) the edges' squared errors in standard deviations."""
        weighted = (self._information @ errors[:, :, None])[:, :, 0]
        return np.asarray(np.sum(errors * weighted, axis=1))

    def step(self, state: NDArray[np.float64], scale: float) -> NDArray[np.float64]:
        """Return the Gauss-Newton change of all poses, (n, 3)."""
        errors, jacobians = self.errors(state)
        weights = (1.0 + self.squares(errors) / scale**2) ** -2
        weights[~self._robust] = 1.0
        information = self._information * weights[:, None, None]
        ends = (self._start, self._end)
        gradient = np.zeros_like(state)
        rows, cols, values = [], [], []
        axes = np.arange(3)
        for ja, a in zip(jacobians, ends, strict=True):
            weighted = ja.transpose(0, 2, 1) @ information
            np.add.at(gradient, a, (weighted @ errors[:, :, None])[:, :, 0])
            for jb, b in zip(jacobians, ends, strict=True):
                values.append((weighted @ jb).ravel())
                shape = (len(a), 3, 3)
                rows.append(np.broadcast_to(3 * a[:, None, None] + axes[:, None], shape).ravel())
                cols.append(np.broadcast_to(3 * b[:, None, None] + axes, shape).ravel())
        rows.append(axes)
        cols.append(axes)
        values.append(np.full(3, _ANCHOR))
        size = state.size
        hessian = coo_matrix(
            (np.concatenate(values), (np.concatenate(rows), np.concatenate(cols))), (size, size)
        )
        # An ordering for symmetric matrices: a graph's Hessian stays sparse when factored.
        factors = splu(hessian.tocsc(), permc_spec="MMD_AT_PLUS_A", options={"SymmetricMode": True})
        change = factors.solve(-gradient.ravel())
        return np.asarray(change).reshape(state.shape)
