"""Map, border and robots of the paper's experiment, for its figures 3 and 6."""

from __future__ import annotations

import math
from collections.abc import Sequence

import numpy as np
from matplotlib.axes import Axes
from matplotlib.patches import Polygon

from maps.map_folder import MapFolder
from maps.occupancy_map import OCCUPIED
from tools.metrics.metrics import RobotRun
from tools.report import style

_MARGIN_M = 2.6  # drawn round border and robots
_LENGTH_M, _WIDTH_M = 0.44, 0.38  # of the paper's robots
_LARGER = 2.0  # times, so that they are seen on the whole map
_ARROW_M = 2.0  # length of an arrow of forward motion
_ON_BORDER_M = 0.5  # up to which a robot patrols


def draw_map(axes: Axes, folder: MapFolder, runs: Sequence[RobotRun]) -> None:
    """Draw the walls and the border round which robots start and patrol."""
    assert folder.border is not None
    grid = folder.map
    rows, cols = grid.cells.shape
    x, y, resolution = grid.origin.x, grid.origin.y, grid.resolution
    axes.imshow(
        grid.cells == OCCUPIED,
        cmap="Greys",
        vmax=1.3,
        origin="lower",
        interpolation="nearest",
        extent=(x, x + cols * resolution, y, y + rows * resolution),
    )
    line = folder.border.polyline(0.05)
    axes.plot(*line.T, color=style.ROBOTS[3], linewidth=1.0)
    shown = np.vstack([line, *(run.position for run in runs)])
    low, high = shown.min(axis=0) - _MARGIN_M, shown.max(axis=0) + _MARGIN_M
    axes.set_xlim(low[0], high[0])
    axes.set_ylim(low[1], high[1])
    axes.set_aspect("equal")
    for axis in (axes.xaxis, axes.yaxis):
        axis.set_major_locator(style.round_ticks(6))


def draw_robot(axes: Axes, place: tuple[float, float], heading: float, color: str) -> None:
    """Draw a robot at a place, m, with an arrow of its heading, rad; larger than it is."""
    along = np.array((math.cos(heading), math.sin(heading)))
    across = np.array((-along[1], along[0]))
    half = _LARGER * _LENGTH_M / 2.0 * along, _LARGER * _WIDTH_M / 2.0 * across
    corners = [half[0] + half[1], half[0] - half[1], -half[0] - half[1], half[1] - half[0]]
    axes.add_patch(Polygon(np.array(corners) + place, facecolor=color, edgecolor="none"))
    axes.annotate(
        "",
        xy=(place[0] + _ARROW_M * along[0], place[1] + _ARROW_M * along[1]),
        xytext=place,
        arrowprops={"arrowstyle": "-|>", "color": color, "shrinkA": 0.0, "shrinkB": 0.0},
    )


def heading_of(folder: MapFolder, run: RobotRun, index: int) -> float:
    """Return the direction of forward motion of a robot at a sample, rad.

    On the border that of its patrol, also while the robot still turns; else of its motion.
    """
    assert folder.border is not None
    foot = folder.border.project(*run.position[index].tolist())
    if foot.distance < _ON_BORDER_M and run.direction[index]:
        tx, ty = foot.tangent
        return math.atan2(run.direction[index] * ty, run.direction[index] * tx)
    later = min(index + 10, len(run.t) - 1)
    dx, dy = run.position[later] - run.position[index]
    return math.atan2(dy, dx)
