"""Inputs of one patrol step: pose, border, closest teammate, ends, walls."""

from __future__ import annotations

from typing import TYPE_CHECKING

import msgspec

from maps.border import BorderProjection
from robot_agent.patrol.behaviors import Vector
from robot_agent.patrol.neighbor_state import NeighborView

if TYPE_CHECKING:  # importing it takes SciPy
    from maps.approach_field import Approach


class Situation(msgspec.Struct, frozen=True):
    """Inputs of one patrol step; map frame, m, rad."""

    t: float
    position: Vector
    theta: float
    foot: BorderProjection  # of the position
    teammate: Vector | None  # the closest one
    neighbor: NeighborView  # its distance and eq. 13
    ends: tuple[float, float]  # along the border to left and right end; infinite if closed
    approach: Approach | None  # path to the border round walls; None with a straight line to it
    direction: int | None  # of patrol before this step, +1 clockwise; None before the first
    held: bool  # an obstacle kept the robot from driving since the last step
    way_to_border: float  # m: round walls where one hides the border, else straight

    def inputs(self, neighbor: NeighborView) -> dict[str, float]:
        """Return the crisp inputs of the rules by name, for a view of the closest teammate."""
        return {
            "distance_from_border": self.way_to_border,
            "distance_from_neighbor": neighbor.distance,
            "neighbor_state": neighbor.gamma,
            "distance_from_left_end": self.ends[0],
            "distance_from_right_end": self.ends[1],
        }
