"""The five actions of the paper: behaviors in order of priority (eq. 9 to 12)."""

from __future__ import annotations

from collections.abc import Sequence
from enum import StrEnum
from typing import TYPE_CHECKING

import msgspec

from maps.border import BorderProjection
from robot_agent.patrol.behaviors import (
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

if TYPE_CHECKING:
    from maps.approach_field import Approach


class Action(StrEnum):
    """What a robot can be doing; one at a time."""

    REACH_FRONTIER = "reach_frontier"
    KEEP_GOING = "keep_going"
    PATROL_CLOCKWISE = "patrol_clockwise"
    PATROL_COUNTER_CLOCKWISE = "patrol_counter_clockwise"
    AVOID_TEAMMATE = "avoid_teammate"


PATROLLING = frozenset(
    {Action.KEEP_GOING, Action.PATROL_CLOCKWISE, Action.PATROL_COUNTER_CLOCKWISE}
)


class Situation(msgspec.Struct, frozen=True):
    """What the behaviors look at, map frame: own position, its projection, closest teammate."""

    position: Vector
    foot: BorderProjection
    teammate: Vector | None
    direction: int  # +1 clockwise, -1 counter-clockwise
    left_is_end: bool  # the projection is the end of an open border at abscissa 0
    right_is_end: bool
    approach: Approach | None = None  # the way there, while a wall hides the projection


def action_velocity(action: Action, situation: Situation, settings: PatrolSettings) -> Vector:
    """Return the velocity (vx, vy) of an action, m/s in the map frame, within approach_speed."""
    tasks = _COMPOSITIONS[action](situation, settings)
    vx, vy = compose(tasks, settings.approach_speed)
    return vx, vy


def _reach_frontier(situation: Situation, settings: PatrolSettings) -> Sequence[Task]:
    return (_reaching(situation, settings),)


def _keep_going(situation: Situation, settings: PatrolSettings) -> Sequence[Task]:
    onward = patrol_onward(situation.foot, situation.direction, speed=settings.patrol_speed)
    return _reaching(situation, settings), _confined(onward, situation.direction, situation)


def _patrol_clockwise(situation: Situation, settings: PatrolSettings) -> Sequence[Task]:
    onward = patrol_clockwise(situation.foot, speed=settings.patrol_speed)
    return _reaching(situation, settings), _confined(onward, 1, situation)


def _patrol_counter_clockwise(situation: Situation, settings: PatrolSettings) -> Sequence[Task]:
    onward = patrol_counter_clockwise(situation.foot, speed=settings.patrol_speed)
    return _reaching(situation, settings), _confined(onward, -1, situation)


def _avoid_teammate(situation: Situation, settings: PatrolSettings) -> Sequence[Task]:
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
        beyond_end=situation.left_is_end or situation.right_is_end,
    )


def _confined(onward: Task, direction: int, situation: Situation) -> Task:
    """Cut off a tangential velocity that means nothing: beyond an open end, behind a wall."""
    leaves = situation.right_is_end if direction > 0 else situation.left_is_end
    if leaves or situation.approach is not None:
        return Task((0.0, 0.0), onward.jacobian)
    return onward
