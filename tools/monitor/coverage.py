"""How long the border's points have waited for a robot, live, with the bench's definitions."""

from __future__ import annotations

import numpy as np
from numpy.typing import ArrayLike, NDArray

from maps.border import Border
from tools.metrics.idleness import BORDER_STEP, VISIT_RADIUS

_FAR = 1e6  # m; beyond any map, and squares of it are still numbers


class Coverage:
    """When each point of the border was last visited; a visit is a robot within 0.25 m."""

    def __init__(self, border: Border, start: float) -> None:
        """Watch from start, s: a point nobody has visited has waited since then."""
        self.points: NDArray[np.float64] = border.polyline(BORDER_STEP)
        self._start = start
        self._visited = np.full(len(self.points), np.nan)
        self._longest = np.zeros(len(self.points))

    def visit(self, positions: ArrayLike, t: float) -> None:
        """Take note of robots at positions (n, 2), m in the map, at t, s."""
        at = np.clip(np.asarray(positions, dtype=np.float64).reshape(-1, 2), -_FAR, _FAR)
        offset = at[:, None, :] - self.points[None, :, :]
        here = ((offset**2).sum(axis=2) <= VISIT_RADIUS**2).any(axis=0)
        self._longest[here] = np.maximum(self._longest, self.idle(t))[here]
        self._visited[here] = t

    def idle(self, t: float) -> NDArray[np.float64]:
        """Return (points,) how long each has waited at t, s."""
        return t - np.where(np.isnan(self._visited), self._start, self._visited)

    def seen(self) -> NDArray[np.bool_]:
        """Return (points,) which have ever been visited."""
        return np.asarray(np.isfinite(self._visited), dtype=np.bool_)

    def average(self, t: float) -> float:
        """Return the mean time the points have waited at t, s."""
        return float(self.idle(t).mean())

    def worst(self, t: float) -> float:
        """Return the longest any point has waited for its robot so far, s."""
        return float(np.maximum(self._longest, self.idle(t)).max())
