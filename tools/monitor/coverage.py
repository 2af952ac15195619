"""Idleness of the border, live: time since each point's last visit, as the bench defines it."""

from __future__ import annotations

import numpy as np
from numpy.typing import ArrayLike, NDArray

from maps.border import Border
from tools.metrics.border_visits import BORDER_STEP, VISIT_RADIUS

_FAR = 1e6  # m; beyond any map, and its square is finite


class Coverage:
    """Time of the last visit of each border point; a visit is a robot within ``VISIT_RADIUS``."""

    def __init__(self, border: Border, start: float) -> None:
        """Start at time ``start``: an unvisited point is idle since then."""
        self.points: NDArray[np.float64] = border.polyline(BORDER_STEP)
        self._start = start
        self._visited = np.full(len(self.points), np.nan)
        self._longest = np.zeros(len(self.points))

    def visit(self, positions: ArrayLike, t: float) -> None:
        """Note visits by robots at positions (n, 2), m, map frame, at t."""
        at = np.clip(np.asarray(positions, dtype=np.float64).reshape(-1, 2), -_FAR, _FAR)
        offset = at[:, None, :] - self.points[None, :, :]
        here = ((offset**2).sum(axis=2) <= VISIT_RADIUS**2).any(axis=0)
        self._longest[here] = np.maximum(self._longest, self.idle(t))[here]
        self._visited[here] = t

    def idle(self, t: float) -> NDArray[np.float64]:
        """Return the idleness of each point at t, (points,), s."""
        return t - np.where(np.isnan(self._visited), self._start, self._visited)

    def seen(self) -> NDArray[np.bool_]:
        """Return whether each point has ever been visited, (points,)."""
        return np.asarray(np.isfinite(self._visited), dtype=np.bool_)

    def average(self, t: float) -> float:
        """Return the mean idleness of the points at t, s."""
        return float(self.idle(t).mean())

    def worst(self, t: float) -> float:
        """Return the largest idleness of any point up to t, s."""
        return float(np.maximum(self._longest, self.idle(t)).max())
