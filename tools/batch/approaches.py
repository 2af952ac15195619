"""``ApproachField.around_walls`` for many robots at once."""

from __future__ import annotations

import numpy as np

from maps.approach_field import BESIDE, ApproachField
from tools.batch.arrays import Indices, Reals


class Approaches:
    """Finds the robots from which a wall hides the border, and their paths."""

    def __init__(self, field: ApproachField) -> None:
        self._field = field

    def around_walls(
        self, x: Reals, y: Reals, foot_x: Reals, foot_y: Reals, distance: Reals
    ) -> tuple[Indices, Reals, Reals, Reals]:
        """Return the numbers of the robots, their ways, m, and first directions (x and y).

        foot_x, foot_y: (n,) the border's nearest points, m; distance: (n,) from there.
        """
        far = (distance > BESIDE - 1e-6).nonzero()[0]
        numbers: list[int] = []
        paths: list[tuple[float, float, float]] = []
        if far.size:
            passable = self._field.are_passable(x[far], y[far], foot_x[far], foot_y[far])
            for robot in far[~passable].tolist():
                foot = float(foot_x[robot]), float(foot_y[robot])
                path = self._field.around_walls(float(x[robot]), float(y[robot]), foot)
                if path is not None:
                    numbers.append(robot)
                    paths.append((path.distance, *path.direction))
        ways = np.array(paths).reshape(-1, 3).T
        return np.array(numbers, dtype=np.intp), ways[0], ways[1], ways[2]
