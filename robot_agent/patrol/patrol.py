"""The patrol of one robot: from pose and closest teammate to action and velocity.

Each step computes in order: the situation; the paper's choice; at most one override by a modifier;
at most one turn; the velocity of the action.
"""

from __future__ import annotations

import math
from collections.abc import Callable, Mapping
from functools import cache
from pathlib import Path
from typing import TYPE_CHECKING

import msgspec
import numpy as np

from maps.border import Border, BorderProjection
from maps.pose import Pose
from robot_agent.patrol.action_dwell import MINIMUM_DWELL
from robot_agent.patrol.actions import PATROL_DIRECTION, PATROLLING, Action, action_velocity
from robot_agent.patrol.automaton import Automaton, require_safety_distance
from robot_agent.patrol.behaviors import CLOCKWISE, COUNTER_CLOCKWISE
from robot_agent.patrol.blockage import Blockage
from robot_agent.patrol.closing_in import ClosingIn
from robot_agent.patrol.common_clock import CommonClock
from robot_agent.patrol.common_turns import CommonTurns
from robot_agent.patrol.end_trap import HoldAtEnd
from robot_agent.patrol.even_gaps import EvenGaps
from robot_agent.patrol.fuzzy import MamdaniSystem
from robot_agent.patrol.modifier import Modifier, Override, OverrideReason
from robot_agent.patrol.neighbor_state import NeighborState
from robot_agent.patrol.reversal import RandomReversal
from robot_agent.patrol.rules import RULES_FILE, load_rules
from robot_agent.patrol.settings import (
    AROUND_WALLS,
    BLOCKAGE,
    CLOSING_IN,
    COMMON_TURNS,
    DWELL,
    EVEN_GAPS,
    HOLD_AT_END,
    STANDOFF,
    PatrolSettings,
)
from robot_agent.patrol.situation import Situation
from robot_agent.patrol.standoff import Standoff
from robot_agent.patrol.supervisor import ActionChooser, Choice, Supervisor
from robot_agent.patrol.turn_log import Turn, TurnCause, TurnLog

if TYPE_CHECKING:
    from maps.approach_field import Approach, ApproachField

REVERSAL_END_DISTANCE = 0.8  # m from an end of an open border without random reversal


class PatrolDecision(msgspec.Struct, frozen=True):
    """Result of one patrol step with its intermediate values; map frame, SI units.

    Distances that do not exist (no teammate in range, a closed border's ends, no path to the
    border) are infinite.
    """

    t: float
    action: Action  # in force
    raw_winner: Action  # the paper's: largest degree, before the minimum dwell
    runner_up: Action
    degrees: Mapping[Action, float]
    direction: int  # +1 clockwise, -1 counter-clockwise
    velocity: tuple[float, float]  # m/s
    distance_from_border: float  # in a straight line
    way_to_border: float  # path length round walls; the straight distance where none is between
    distance_from_neighbor: float
    gamma: float  # neighbor state, eq. 13
    distance_from_left_end: float
    distance_from_right_end: float
    abscissa: float
    tangent: tuple[float, float]  # unit vector along +s at the border's nearest point
    curvature: float  # 1/m of the border ahead in the direction of patrol, + left; else 0
    override: OverrideReason | None  # None: the paper's choice alone
    turn: TurnCause | None  # cause if the robot turned back in this step, else None

    @property
    def blocked(self) -> bool:
        """Whether the robot turns back before an object in this step."""
        return self.override is OverrideReason.BLOCKAGE

    @property
    def holding(self) -> bool:
        """Whether the robot stands, caught at an end or in the random wait of closing_in."""
        return self.override in (OverrideReason.HOLD_AT_END, OverrideReason.WAIT)


class Patrol:
    """The paper's control structure, with the modifiers that the settings name."""

    def __init__(
        self,
        settings: PatrolSettings,
        border: Border,
        rng: np.random.Generator,
        approach_field: ApproachField | None = None,
        clock: CommonClock | None = None,
    ) -> None:
        """Load the rules; without an approach_field no walls are taken into account.

        rng: for random reversals and modifiers. clock: None if it was not set.

        Raises RulesError for an unusable rule file, and BorderError for a border that turns
        tighter than settings.turning_radius.
        """
        border.require_radius(settings.turning_radius)
        self._settings = settings
        self._border = border
        self._approach_field = approach_field if AROUND_WALLS in settings.modifiers else None
        make_chooser = _choosers(settings, border)
        self._supervisor = make_chooser()
        self._neighbor_state = NeighborState(settings, border)
        self._reversal = RandomReversal(
            settings.reversal_period,
            settings.reversal_probability,
            rng,
            settings.reversal_distribution,
        )
        self._turns = TurnLog()
        modifiers = _make_modifiers(
            settings, border, self._supervisor, make_chooser, self._turns, rng, clock
        )
        self._last_to_first = tuple(reversed(modifiers))
        self._slower: dict[float, PatrolSettings] = {}  # by speed limit, m/s
        self._abscissa: float | None = None  # of the last step, m
        self._direction: int | None = None  # of the last patrol; None before the first

    def use_approach_field(self, approach_field: ApproachField | None) -> None:
        """Take the paths round walls of a robot of another size."""
        if AROUND_WALLS in self._settings.modifiers:
            self._approach_field = approach_field

    def step(
        self,
        t: float,
        pose: Pose,
        teammate: tuple[float, float] | None,
        *,
        held: bool = False,
    ) -> PatrolDecision:
        """Return the decision at t. Changes the patrol's state: call it once per control step.

        pose: map_from_base. teammate: (x, y) of the closest one, m, map frame; None if none is in
        range. held: an obstacle kept the robot from driving since the last step.
        """
        # 1. The situation.
        situation = self._look_up(t, pose, teammate, held=held)
        neighbor, foot, ends = situation.neighbor, situation.foot, situation.ends
        # 2. The paper's choice: rules and arbiter.
        choice = self._supervisor.choose(t, situation.inputs(neighbor))
        # 3. At most one override, by the first modifier in the list that proposes one.
        override, action = self._modify(situation, choice)
        # 4. The direction, with at most one turn.
        direction, turn = self._turn(situation, action, override)
        # 5. The velocity of the action.
        velocity = self._velocity(situation, action, direction, override)
        return PatrolDecision(  # in the order of its fields: by name it takes 7 times as long
            t,
            action,
            choice.raw_winner,
            choice.runner_up,
            choice.degrees,
            direction,
            velocity,
            foot.distance,
            situation.way_to_border,
            neighbor.distance,
            neighbor.gamma,
            ends[0],
            ends[1],
            foot.abscissa,
            foot.tangent,
            direction * foot.curvature if action in PATROLLING else 0.0,
            None if override is None else override.reason,
            turn,
        )

    # ---- 1. situation -------------------------------------------------------------------------

    def _look_up(
        self, t: float, pose: Pose, teammate: tuple[float, float] | None, *, held: bool
    ) -> Situation:
        position = (pose.x, pose.y)
        foot = self._border.project(pose.x, pose.y, self._abscissa)
        self._abscissa = foot.abscissa
        approach = self._approach(position, foot)
        return Situation(  # in the order of its fields
            t,
            position,
            pose.theta,
            foot,
            teammate,
            self._neighbor_state.view(position, foot, teammate),
            self._distances_from_ends(foot),
            approach,
            self._direction,
            held,
            foot.distance if approach is None else approach.distance,
        )

    def _approach(self, position: tuple[float, float], foot: BorderProjection) -> Approach | None:
        if self._approach_field is None:
            return None
        return self._approach_field.around_walls(*position, (foot.x, foot.y))

    def _distances_from_ends(self, foot: BorderProjection) -> tuple[float, float]:
        if self._border.closed:
            return math.inf, math.inf
        return foot.abscissa, self._border.length - foot.abscissa

    # ---- 3. override --------------------------------------------------------------------------

    def _modify(self, situation: Situation, choice: Choice) -> tuple[Override | None, Action]:
        """Return the override of this step, None if there is none, and the action in force.

        All modifiers are called, as they keep state; each gets the action that results from those
        after it in the list.
        """
        override, action = None, choice.winner
        for modifier in self._last_to_first:
            proposed = modifier.propose(situation, choice, action)
            if proposed is not None:
                override = proposed
                action = choice.winner if proposed.action is None else proposed.action
        return override, action

    # ---- 4. direction -------------------------------------------------------------------------

    def _turn(
        self, situation: Situation, action: Action, override: Override | None
    ) -> tuple[int, TurnCause | None]:
        """Return the direction of patrol and the cause of a turn, None if there is no turn.

        The direction is that of the last Patrol CW or CCW, at first that of the heading. Reversals
        by chance or by a modifier happen only during Keep Going.
        """
        before = situation.direction
        chosen = self._chosen_turn(situation, action, override)
        after = PATROL_DIRECTION.get(action, before)
        if chosen is not None and before is not None:
            after = -before
        if after is None:
            return self._first_direction(situation, action), None
        self._direction = after
        if before is None or after == before:
            return after, None
        met = situation.neighbor.gamma * before > 0.0
        cause = chosen or (TurnCause.TEAMMATE if met else TurnCause.RULES)
        self._turns.add(Turn(situation.t, situation.foot.abscissa, after, cause))
        return after, cause

    def _chosen_turn(
        self, situation: Situation, action: Action, override: Override | None
    ) -> TurnCause | None:
        """Return the cause of a reversal during Keep Going: a modifier, or chance; None if none."""
        keeps_going = action is Action.KEEP_GOING and situation.direction is not None
        proposed = None if override is None else override.turn
        by_chance = self._reversal.due(
            situation.t,
            permitted=keeps_going
            and min(situation.ends) >= REVERSAL_END_DISTANCE
            and (override is None or override.may_turn),
        )
        if not keeps_going:
            return None
        return proposed or (TurnCause.CHANCE if by_chance else None)

    def _first_direction(self, situation: Situation, action: Action) -> int:
        """Return the direction nearest the heading; store it if the action is Keep Going."""
        tx, ty = situation.foot.tangent
        ahead = tx * math.cos(situation.theta) + ty * math.sin(situation.theta) >= 0.0
        direction = CLOCKWISE if ahead else COUNTER_CLOCKWISE
        if action is Action.KEEP_GOING:
            self._direction = direction
        return direction

    # ---- 5. velocity --------------------------------------------------------------------------

    def _velocity(
        self, situation: Situation, action: Action, direction: int, override: Override | None
    ) -> tuple[float, float]:
        limit = None if override is None else override.speed_limit
        if limit == 0.0:
            return 0.0, 0.0
        settings = self._settings if limit is None else self._slowed_to(limit)
        return action_velocity(action, situation, direction, settings)

    def _slowed_to(self, speed: float) -> PatrolSettings:
        """Return the settings with patrol_speed limited to a speed, m/s."""
        if speed not in self._slower:
            patrol_speed = min(self._settings.patrol_speed, speed)
            self._slower[speed] = msgspec.structs.replace(self._settings, patrol_speed=patrol_speed)
        return self._slower[speed]


def _make_modifiers(
    settings: PatrolSettings,
    border: Border,
    supervisor: ActionChooser,
    make_chooser: Callable[[], ActionChooser],
    turns: TurnLog,
    rng: np.random.Generator,
    clock: CommonClock | None,
) -> list[Modifier]:
    """Return the modifiers that the settings name, in that order."""

    @cache
    def even_gaps() -> EvenGaps:
        return EvenGaps(border, settings.patrol_speed, turns, rng, settings.team_size)

    makers: dict[str, Callable[[], Modifier]] = {
        STANDOFF: Standoff,
        HOLD_AT_END: HoldAtEnd,
        BLOCKAGE: Blockage,
        CLOSING_IN: lambda: ClosingIn(border, supervisor, make_chooser(), turns, rng),
        EVEN_GAPS: even_gaps,
    }
    if border.closed and settings.common_secret and clock is not None:
        own_clock = clock
        makers[COMMON_TURNS] = lambda: CommonTurns(even_gaps(), border, settings, turns, own_clock)
    without = EVEN_GAPS if not border.closed else HOLD_AT_END  # no way round, or no end
    names = [name for name in settings.modifiers if name in makers and name != without]
    return [makers[name]() for name in names]


def _choosers(settings: PatrolSettings, border: Border) -> Callable[[], ActionChooser]:
    """Return a factory of choosers by the settings; each one keeps its own state.

    Raises RulesError.
    """
    dwell = MINIMUM_DWELL if DWELL in settings.modifiers else 0.0
    if settings.supervisor == "automaton":
        require_safety_distance(settings.safety_distance)
        return lambda: Automaton(dwell)
    rules = rules_of(settings, border)
    return lambda: Supervisor(rules, dwell)


def rules_of(settings: PatrolSettings, border: Border) -> MamdaniSystem:
    """Return the rules that the settings name, for a border. Raises RulesError."""
    return load_rules(
        Path(settings.rules_file) if settings.rules_file else RULES_FILE,
        reading=settings.reading,
        safety_distance=settings.safety_distance,
        open_border=not border.closed,
    )
