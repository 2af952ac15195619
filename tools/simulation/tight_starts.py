"""Start poses for simulated robots beside walls, where they can hardly turn: it tests the gate."""

from __future__ import annotations

import math

import numpy as np
from numpy.typing import NDArray

from maps.border import Border
from maps.occupancy_map import FREE, OCCUPIED, OccupancyMap
from maps.pose import Pose
from tools.simulation.robot_body import Outline
from tools.simulation.start_poses import StartPoseError

GAP = (0.03, 0.12)
"""Between which, m, a robot's outline is from the nearest wall; ours."""
_FROM_BORDER = 3.0  # m, at most
_APART = 1.5  # m between any two
_STEP = 0.03  # m between the points of an outline
_DRAWS = 20_000


def tight_start_poses(
    occupancy: OccupancyMap,
    border: Border,
    count: int,
    rng: np.random.Generator,
    outline: Outline,
) -> list[Pose]:
    """Return ``count`` poses (map_from_base) whose outline is ``GAP`` from walls, and at none.

    Each is within 3 m of the border, beyond walls too. Raises StartPoseError without room.
    """
    places = occupancy.centres(np.argwhere(occupancy.cells == FREE))
    _, distances = border.project_many(places)
    places = places[distances <= _FROM_BORDER]
    walls = occupancy.centres(np.argwhere(occupancy.cells == OCCUPIED))
    cell = occupancy.resolution
    chosen: list[Pose] = []
    drawn = places[rng.integers(len(places), size=_DRAWS)]
    # Anywhere in a cell: at centres a robot along a wall would have a few distances only.
    drawn += rng.uniform(-0.5, 0.5, drawn.shape) * cell
    for x, y in drawn.tolist():
        pose = Pose(x, y, rng.uniform(-math.pi, math.pi))
        apart = all(math.hypot(other.x - x, other.y - y) > _APART for other in chosen)
        if apart and GAP[0] < _gap(pose, outline, walls, cell) < GAP[1]:
            chosen.append(pose)
            if len(chosen) == count:
                return chosen
    raise StartPoseError(
        f"no room beside walls for {count} robots, found places for {len(chosen)}: use fewer robots"
    )


def _gap(pose: Pose, outline: Outline, walls: NDArray[np.float64], cell: float) -> float:
    """Return the distance, m, of an outline at a pose from wall cells with centres (n, 2), m.

    0 if one is inside it; inf if none is near. cell: side of a cell, m.
    """
    off = walls - (pose.x, pose.y)
    off = off[np.maximum(*np.abs(off.T)) < outline.reach + GAP[1] + cell]
    c, s = math.cos(pose.theta), math.sin(pose.theta)
    x, y = (off @ np.array(((c, -s), (s, c)))).T
    if ((x < outline.front) & (x > -outline.rear) & (np.abs(y) < outline.half_width)).any():
        return 0.0
    perimeter = outline.perimeter(_STEP) @ np.array(((c, s), (-s, c)))
    beyond = np.maximum(np.abs(perimeter[:, None] - off) - 0.5 * cell, 0.0)
    return float(np.hypot(beyond[..., 0], beyond[..., 1]).min(initial=math.inf))
