"""The five actions of the paper: compositions of behaviors by priority (eq. 9 to 12)."""

from __future__ import annotations

from collections.abc import Sequence
from enum import StrEnum

from robot_agent.patrol.behaviors import (
    CLOCKWISE,
    COUNTER_CLOCKWISE,
    Task,
    Vector,
    patrol_clockwise,
    patrol_counter_clockwise,
    patrol_onward,
    reach_around_walls,
    reach_frontier,
    teammate_avoidance,
)
from robot_agent.patrol.nsb import compose
from robot_agent.patrol.settings import PatrolSettings
from robot_agent.patrol.situation import Situation


class Action(StrEnum):
    """An action of the patrol; one is in force at a time."""

    REACH_FRONTIER = "reach_frontier"
    KEEP_GOING = "keep_going"
    PATROL_CLOCKWISE = "patrol_clockwise"
    PATROL_COUNTER_CLOCKWISE = "patrol_counter_clockwise"
    AVOID_TEAMMATE = "avoid_teammate"


PATROL_DIRECTION = {
    Action.PATROL_CLOCKWISE: CLOCKWISE,
    Action.PATROL_COUNTER_CLOCKWISE: COUNTER_CLOCKWISE,
}
"""The direction each patrol action sets, +1 clockwise or -1."""
PATROLLING = frozenset(
    {Action.KEEP_GOING, Action.PATROL_CLOCKWISE, Action.PATROL_COUNTER_CLOCKWISE}
)


def action_velocity(
    action: Action, situation: Situation, direction: int, settings: PatrolSettings
) -> Vector:
    """Return the velocity (vx, vy) of an action, m/s in the map frame, within approach_speed.

    direction: of Keep Going, +1 clockwise or -1.
    """
    tasks = _COMPOSITIONS[action](situation, direction, settings)
    vx, vy = compose(tasks, settings.approach_speed)
    return vx, vy


def _reach_frontier(
    situation: Situation, _direction: int, settings: PatrolSettings
) -> Sequence[Task]:
    return (_reaching(situation, settings),)


def _keep_going(situation: Situation, direction: int, settings: PatrolSettings) -> Sequence[Task]:
    onward = patrol_onward(situation.foot, direction, speed=settings.patrol_speed)
    return _reaching(situation, settings), _confined(onward, direction, situation)


def _patrol_clockwise(
    situation: Situation, _direction: int, settings: PatrolSettings
) -> Sequence[Task]:
    onward = patrol_clockwise(situation.foot, speed=settings.patrol_speed)
    return _reaching(situation, settings), _confined(onward, 1, situation)


def _patrol_counter_clockwise(
    situation: Situation, _direction: int, settings: PatrolSettings
) -> Sequence[Task]:
    onward = patrol_counter_clockwise(situation.foot, speed=settings.patrol_speed)
    return _reaching(situation, settings), _confined(onward, -1, situation)


def _avoid_teammate(
    situation: Situation, _direction: int, settings: PatrolSettings
) -> Sequence[Task]:
    reaching = _reaching(situation, settings)
    if situation.teammate is None:
        return (reaching,)
    avoiding = teammate_avoidance(
        situation.position,
        situation.teammate,
        gain=settings.avoid_gain,
        safety_distance=settings.safety_distance,
        speed_limit=settings.escape_speed,
        fallback=situation.foot.normal,
    )
    return avoiding, reaching


_COMPOSITIONS = {
    Action.REACH_FRONTIER: _reach_frontier,
    Action.KEEP_GOING: _keep_going,
    Action.PATROL_CLOCKWISE: _patrol_clockwise,
    Action.PATROL_COUNTER_CLOCKWISE: _patrol_counter_clockwise,
    Action.AVOID_TEAMMATE: _avoid_teammate,
}


def _reaching(situation: Situation, settings: PatrolSettings) -> Task:
    if situation.approach is not None:
        return reach_around_walls(
            situation.approach, gain=settings.reach_gain, speed_limit=settings.approach_speed
        )
    return reach_frontier(
        situation.position,
        situation.foot,
        gain=settings.reach_gain,
        speed_limit=settings.approach_speed,
        beyond_end=min(situation.ends) <= 0.0,
    )


def _confined(onward: Task, direction: int, situation: Situation) -> Task:
    """Return the tangential task, with zero velocity beyond an open end or behind a wall."""
    left, right = situation.ends
    leaves = (right if direction > 0 else left) <= 0.0
    if leaves or situation.approach is not None:
        return Task((0.0, 0.0), onward.jacobian)
    return onward
