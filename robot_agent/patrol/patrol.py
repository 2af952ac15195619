"""One robot's patrol: pose and closest teammate in, action and velocity out."""

from __future__ import annotations

import math
from collections.abc import Mapping
from pathlib import Path
from typing import TYPE_CHECKING

import msgspec
import numpy as np

from maps.border import Border, BorderProjection
from maps.pose import Pose
from robot_agent.patrol.actions import PATROLLING, Action, Situation, action_velocity
from robot_agent.patrol.automaton import Automaton
from robot_agent.patrol.behaviors import CLOCKWISE, COUNTER_CLOCKWISE
from robot_agent.patrol.blockage import Blockage
from robot_agent.patrol.closing_in import ClosingIn
from robot_agent.patrol.even_gaps import EvenGaps
from robot_agent.patrol.neighbor_state import NeighborState, NeighborView
from robot_agent.patrol.owed_way import OwedWay
from robot_agent.patrol.reversal import RandomReversal
from robot_agent.patrol.reversal_rest import ReversalRest
from robot_agent.patrol.rules import RULES_FILE, load_rules
from robot_agent.patrol.settings import PatrolSettings
from robot_agent.patrol.standoff import Standoff
from robot_agent.patrol.supervisor import ActionChooser, Choice, Supervisor

if TYPE_CHECKING:
    from maps.approach_field import Approach, ApproachField


_OF_ACTION = {
    Action.PATROL_CLOCKWISE: CLOCKWISE,
    Action.PATROL_COUNTER_CLOCKWISE: COUNTER_CLOCKWISE,
}


class PatrolDecision(msgspec.Struct, frozen=True):
    """Everything about one decision, in the map frame, SI units.

    Distances that do not exist (nobody seen, a border without ends, no way to the border) are
    infinite.
    """

    t: float
    action: Action
    raw_winner: Action  # largest degree, before the minimum dwell
    runner_up: Action
    degrees: Mapping[Action, float]
    direction: int  # +1 clockwise, -1 counter-clockwise
    velocity: tuple[float, float]  # m/s
    distance_from_border: float  # straight
    way_to_border: float  # round walls; the same as the straight one in sight of the border
    distance_from_neighbor: float
    gamma: float  # neighbor state, eq. 13
    distance_from_left_end: float
    distance_from_right_end: float
    abscissa: float
    tangent: tuple[float, float]  # unit vector along +s at the border's nearest point
    curvature: float  # 1/m of the way ahead in the direction of patrol, + turns left; 0 off it
    reversed_at_random: bool
    blocked: bool  # gave up waiting for an object on its way, just now
    holding: bool  # stands still, caught between an end and a teammate or for a moment in a crowd
    closes_in: bool  # slowly, on a teammate at which it would turn as before
    insists: bool  # on a way whatever the rules say: kept from it, in Avoid or caught for too long


class Patrol:
    """The paper's control structure: behaviors, actions, supervisor, direction memory."""

    def __init__(
        self,
        settings: PatrolSettings,
        border: Border,
        rng: np.random.Generator,
        approach_field: ApproachField | None = None,
    ) -> None:
        """Load the rules; without an approach_field there are no walls.

        Raises RulesError, and BorderError for a border that turns tighter than robots can follow.
        """
        border.require_radius(settings.turning_radius)
        self._settings = settings
        self._border = border
        self._approach_field = approach_field
        self._supervisor = _make_supervisor(settings, border)
        self._neighbor_state = NeighborState(settings, border)
        self._reversal = RandomReversal(
            settings.reversal_period,
            settings.reversal_probability,
            rng,
            settings.reversal_distribution,
        )
        self._owed_way = OwedWay(border) if settings.reversal_owes_way else None
        lap = border.length / settings.patrol_speed  # s
        self._reversal_rest = ReversalRest(settings.reversal_rest * lap)
        self._even_gaps = (
            EvenGaps(settings.even_gaps, border, settings.patrol_speed, rng)
            if settings.strategy == "even_gaps" and border.closed
            else None
        )
        self._blockage = Blockage(settings)
        self._standoff = Standoff(settings)
        self._closing_in = ClosingIn(border, rng, settings.closing_in, settings.closing_in_wait)
        self._slowly = msgspec.structs.replace(
            settings, patrol_speed=min(settings.patrol_speed, settings.closing_in_speed)
        )
        self._abscissa: float | None = None
        self._direction: int | None = None  # of the last patrol; none before the first

    def step(
        self,
        t: float,
        pose: Pose,
        teammate: tuple[float, float] | None,
        *,
        held: bool = False,
    ) -> PatrolDecision:
        """Decide at t, s, from map_from_base and the closest teammate (x, y) in the map, if any.

        held: an obstacle kept the robot from driving since the last step.
        """
        position = (pose.x, pose.y)
        foot = self._border.project(pose.x, pose.y, self._abscissa)
        self._abscissa = foot.abscissa
        neighbor = self._neighbor_state.view(position, foot, teammate)
        ends = self._distances_from_ends(foot)
        approach = self._approach(position, foot)
        # Beside the border but behind a wall a robot is as far from patrolling as its way is long.
        way = foot.distance if approach is None else approach.distance
        told = self._closing_in.told(neighbor, self._direction)
        closes_in = told is not neighbor
        choice = self._supervisor.choose(t, _inputs(way, told, ends))
        way_out = self._way_out(choice, ends)
        insisted = self._standoff.insists_on(t, position, way, choice.winner, way_out)
        action = choice.winner if insisted is None else insisted
        rests = self._reversal_rest.rests(t, teammate, neighbor.gamma)
        reversed_at_random = self._turned_back(t, action, foot.abscissa, ends, rests=rests)
        self._even_out(t, action, foot.abscissa)
        blocked = self._blockage.ends_waiting(t, position, neighbor.distance, held=held)
        if blocked:
            self._turn_back(action)
        before = self._direction
        direction = self._update_direction(action, foot, pose.theta)
        if before == -direction and neighbor.gamma * before > 0.0:
            self._closing_in.sent_back(t, foot.abscissa, before)
        stands = way_out is not None or self._closing_in.waits(t, action)
        holding = insisted is None and stands
        situation = Situation(
            position, foot, teammate, direction, ends[0] <= 0.0, ends[1] <= 0.0, approach
        )
        slowly = closes_in or insisted in _OF_ACTION
        settings = self._slowly if slowly else self._settings
        velocity = (0.0, 0.0) if holding else action_velocity(action, situation, settings)
        return PatrolDecision(  # in the order of its fields: by name it takes 7 times as long
            t,
            action,
            choice.raw_winner,
            choice.runner_up,
            choice.degrees,
            direction,
            velocity,
            foot.distance,
            way,
            neighbor.distance,
            neighbor.gamma,
            ends[0],
            ends[1],
            foot.abscissa,
            foot.tangent,
            direction * foot.curvature if action in PATROLLING else 0.0,
            reversed_at_random,
            blocked,
            holding,
            closes_in,
            insisted is not None,
        )

    def _approach(self, position: tuple[float, float], foot: BorderProjection) -> Approach | None:
        if self._approach_field is None:
            return None
        return self._approach_field.around_walls(*position, (foot.x, foot.y))

    def _distances_from_ends(self, foot: BorderProjection) -> tuple[float, float]:
        if self._border.closed:
            return math.inf, math.inf
        return foot.abscissa, self._border.length - foot.abscissa

    def _turned_back(
        self,
        t: float,
        action: Action,
        abscissa: float,
        ends: tuple[float, float],
        *,
        rests: bool,
    ) -> bool:
        """Reverse at random while keeping going, but not near an end of an open border."""
        away_from_ends = min(ends) >= self._settings.reversal_end_distance
        keeps_going = action is Action.KEEP_GOING and self._direction is not None
        onwards = self._even_gaps is None or self._even_gaps.goes_onwards
        free = not (rests or self._owes_way(abscissa))
        if not self._reversal.due(t, permitted=keeps_going and away_from_ends and onwards and free):
            return False
        if self._owed_way is not None and self._direction is not None:
            self._owed_way.begin(abscissa, self._direction)
        self._turn_back(action)
        if self._even_gaps is not None and self._direction is not None:
            self._even_gaps.turned(t, self._direction)
        return True

    def _owes_way(self, abscissa: float) -> bool:
        if self._owed_way is None or self._direction is None:
            return False
        return self._owed_way.is_owed(abscissa, self._direction)

    def _even_out(self, t: float, action: Action, abscissa: float) -> None:
        """Turn back for the sake of even gaps, if that is the strategy."""
        if self._even_gaps is None or self._direction is None or action not in PATROLLING:
            return
        direction = _OF_ACTION.get(action, self._direction)
        keeps_going = action is Action.KEEP_GOING
        if self._even_gaps.turns_back(t, abscissa, direction, keeps_going=keeps_going):
            self._turn_back(action)
            self._even_gaps.turned(t, self._direction)

    def _turn_back(self, action: Action) -> None:
        """Keep going the other way; any other action has its direction from the supervisor."""
        if action is Action.KEEP_GOING and self._direction is not None:
            self._direction = -self._direction

    def _update_direction(self, action: Action, foot: BorderProjection, theta: float) -> int:
        """Remember the direction of the last Patrol CW or CCW; at first that of the heading."""
        self._direction = _OF_ACTION.get(action, self._direction)
        if self._direction is not None:
            return self._direction
        tx, ty = foot.tangent
        ahead = tx * math.cos(theta) + ty * math.sin(theta) >= 0.0
        direction = CLOCKWISE if ahead else COUNTER_CLOCKWISE
        if action is Action.KEEP_GOING:
            self._direction = direction
        return direction

    def _way_out(self, choice: Choice, ends: tuple[float, float]) -> Action | None:
        """Return what leads away from the nearer end, m off, of a robot caught there; else None.

        Caught: the end and a teammate call for both directions at once.
        """
        if self._border.closed:
            return None
        degrees = choice.degrees
        both = min(degrees[Action.PATROL_CLOCKWISE], degrees[Action.PATROL_COUNTER_CLOCKWISE])
        others = (Action.KEEP_GOING, Action.REACH_FRONTIER, Action.AVOID_TEAMMATE)
        if both <= max(degrees[action] for action in others):
            return None
        left = ends[0] <= ends[1]
        return Action.PATROL_CLOCKWISE if left else Action.PATROL_COUNTER_CLOCKWISE


def _make_supervisor(settings: PatrolSettings, border: Border) -> ActionChooser:
    if settings.supervisor == "automaton":
        return Automaton(settings.automaton, settings.minimum_dwell)
    rules = load_rules(
        Path(settings.rules_file) if settings.rules_file else RULES_FILE,
        reading=settings.reading,
        safety_distance=settings.safety_distance,
        open_border=not border.closed,
    )
    return Supervisor(rules, settings.minimum_dwell)


def _inputs(
    way_to_border: float, neighbor: NeighborView, ends: tuple[float, float]
) -> dict[str, float]:
    """Crisp inputs by the names of the rule file."""
    return {
        "distance_from_border": way_to_border,
        "distance_from_neighbor": neighbor.distance,
        "neighbor_state": neighbor.gamma,
        "distance_from_left_end": ends[0],
        "distance_from_right_end": ends[1],
    }
