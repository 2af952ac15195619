"""Situations for the tests of single modifiers."""

import math

from maps.border import Border
from maps.border_primitives import Segment
from robot_agent.patrol.actions import Action
from robot_agent.patrol.neighbor_state import NO_NEIGHBOR
from robot_agent.patrol.situation import Situation
from robot_agent.patrol.supervisor import Choice

LINE = Border([Segment((0.0, 0.0), (20.0, 0.0))], closed=False)


def situation(
    t,
    position=(10.0, 0.0),
    *,
    border=LINE,
    neighbor=NO_NEIGHBOR,
    teammate=None,
    ends=(math.inf, math.inf),
    direction=1,
    held=False,
):
    """The situation of a robot at a position, m, with the closest teammate's and a view of it."""
    foot = border.project(*position)
    return Situation(
        *(t, position, 0.0, foot, teammate, neighbor, ends, None, direction),
        held=held,
        way_to_border=foot.distance,
    )


def choice(winner, *, caught=False):
    """The rules' choice; caught: both directions are activated."""
    degrees = {action: float(action is winner) for action in Action}
    if caught:
        degrees |= {Action.PATROL_CLOCKWISE: 0.9, Action.PATROL_COUNTER_CLOCKWISE: 0.9}
        degrees |= {Action.KEEP_GOING: 0.0, Action.AVOID_TEAMMATE: 0.0}
    return Choice(degrees, winner, winner, winner)
