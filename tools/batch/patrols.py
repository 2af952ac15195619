"""``Patrol`` for many robots: situation, choice, override, direction and velocity, in arrays."""

from __future__ import annotations

import math
from collections.abc import Sequence
from dataclasses import dataclass
from functools import cache
from typing import Protocol

import numpy as np

from maps.approach_field import ApproachField
from maps.border import Border
from robot_agent.patrol.action_dwell import MINIMUM_DWELL
from robot_agent.patrol.behaviors import CLOCKWISE, COUNTER_CLOCKWISE
from robot_agent.patrol.common_clock import CommonClock
from robot_agent.patrol.patrol import REVERSAL_END_DISTANCE, rules_of
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
from robot_agent.patrol.turn_log import Turn, TurnCause
from tools.batch.approaches import Approaches
from tools.batch.arbiters import Arbiters, Choices
from tools.batch.arrays import Codes, Flags, Indices, Reals, pick
from tools.batch.blockages import Blockages
from tools.batch.border_feet import BorderFeet
from tools.batch.closings_in import ClosingsIn
from tools.batch.common_turns import CommonTurnsOfMany
from tools.batch.ends import HoldsAtEnds
from tools.batch.even_gaps import EvenGapsOfMany
from tools.batch.fuzzy_arrays import FuzzyArrays
from tools.batch.neighbor_states import NeighborStates
from tools.batch.reversals import Reversals
from tools.batch.situations import (
    CAUSES,
    NONE,
    PATROLS,
    SETS_DIRECTION,
    Act,
    Overrides,
    Situations,
)
from tools.batch.standoffs import Standoffs
from tools.batch.turn_logs import TurnLogs
from tools.batch.velocities import action_velocities

_TEAMMATE, _RULES, _CHANCE = (
    CAUSES.index(cause) for cause in (TurnCause.TEAMMATE, TurnCause.RULES, TurnCause.CHANCE)
)
_KNOWN = (
    *(STANDOFF, HOLD_AT_END, BLOCKAGE, CLOSING_IN),
    *(COMMON_TURNS, EVEN_GAPS, AROUND_WALLS, DWELL),
)


@dataclass(slots=True, eq=False)
class Decisions:
    """What ``PatrolDecision`` says of each robot, arrays (n,)."""

    action: Codes
    direction: Codes
    vx: Reals  # m/s, map frame
    vy: Reals
    curvature: Reals  # of the border ahead, 1/m
    distance: Reals  # from the border, m
    abscissa: Reals
    reason: Codes  # of the override; NONE without one
    turn: Codes  # cause of a turn in this step, else NONE

    @property
    def on_patrol(self) -> tuple[Codes, Reals]:
        """The actions and the distances from the border."""
        return self.action, self.distance


class ManyModifiers(Protocol):
    """A modifier of the paper's choice, of many robots."""

    def propose(self, at: Situations, choices: Choices, action: Codes, found: Overrides) -> Indices:
        """Put overrides into ``found``; return the numbers of their robots."""

    def pick(self, robots: Indices) -> None:
        """Keep some robots, as ``arrays.pick`` does."""


class Patrols:
    """The paper's control structure of n robots, with the modifiers that the settings name."""

    def __init__(
        self,
        settings: PatrolSettings,
        border: Border,
        feet: BorderFeet,
        rngs: Sequence[np.random.Generator],
        approach_field: ApproachField | None,
        clocks: Sequence[CommonClock] = (),
        secrets: Sequence[str] = (),
    ) -> None:
        """rngs: of the robots, as ``Patrol`` takes one; clocks, secrets: likewise, of
        common turns.

        Raises ValueError for a supervisor or a modifier that has no arrays.
        """
        if not has_arrays(settings):
            raise ValueError(f"{settings.supervisor} or {settings.modifiers} has no arrays")
        n = len(rngs)
        self._settings = settings
        self._feet, self._border = feet, border
        self._rngs = list(rngs)
        self._clocks, self._secrets = list(clocks), list(secrets)
        self._common: CommonTurnsOfMany | None = None
        self._approaches: Approaches | None = None
        if AROUND_WALLS in settings.modifiers and approach_field is not None:
            self._approaches = Approaches(approach_field)
        self._system = FuzzyArrays(rules_of(settings, border))
        dwell = MINIMUM_DWELL if DWELL in settings.modifiers else 0.0
        self._arbiters = Arbiters(self._system, dwell, n)
        self._neighbors = NeighborStates(settings, feet, n)
        self.turns = TurnLogs(n)
        self._reversals = Reversals(settings, self._rngs)
        self._last_to_first = self._modifiers(dwell)[::-1]
        self._abscissa = np.full(n, math.nan)
        self.direction = np.zeros(n, dtype=np.int8)
        """Of the last patrol; 0 before the first."""

    def step(
        self,
        t: float,
        x: Reals,
        y: Reals,
        theta: Reals,
        mates: tuple[Flags, Reals, Reals],
        held: Flags,
    ) -> Decisions:
        """Return the decisions at t of robots at poses (n,), m and rad, map frame.

        mates: whether a teammate is in range, and the position, m, of the closest one. held: an
        obstacle kept the robot from driving since the last step.
        """
        at = self._look_up(t, x, y, theta, mates, held)
        choices = self._arbiters.choose(at)
        overrides, action = self._modify(at, choices)
        direction, turn = self._turn(at, action, overrides)
        vx, vy = self._velocity(at, action, direction, overrides)
        curvature = np.where(PATROLS[action], direction * at.curvature, 0.0)
        return Decisions(
            action, direction, vx, vy, curvature, at.distance, at.s, overrides.reason, turn
        )

    @property
    def shared(self) -> tuple[object, ...]:
        """What copies need not copy, as it never changes."""
        return self._settings, self._feet, self._border, self._approaches, self._system

    def pick(self, robots: Indices, rngs: Sequence[np.random.Generator]) -> None:
        """Keep some robots, as ``arrays.pick`` does, with generators of their own."""
        self._rngs[:] = rngs
        pick(self, ("_abscissa", "direction"), robots)
        for part in (self._arbiters, self._neighbors, self.turns, self._reversals):
            part.pick(robots)
        for modifier in self._last_to_first:
            modifier.pick(robots)

    def draw_anew(self, seed: int, team: int) -> None:
        """Give each run of ``team`` robots a common secret of its own from now on."""
        if self._common is not None:
            self._common.draw_anew(seed, team)

    # ---- 1. situation -------------------------------------------------------------------------

    def _look_up(
        self,
        t: float,
        x: Reals,
        y: Reals,
        theta: Reals,
        mates: tuple[Flags, Reals, Reals],
        held: Flags,
    ) -> Situations:
        distance, s = self._feet.nearest(x, y, self._abscissa)
        self._abscissa = s
        foot_x, foot_y, tx, ty, curvature = self._feet.at(s)
        neighbor, gamma = self._neighbors.view(x, y, s, *mates)
        left, right = (
            (np.full(len(x), math.inf),) * 2 if self._feet.closed else (s, self._feet.length - s)
        )
        hidden, aim_x, aim_y, way = np.empty(0, dtype=np.intp), _NO_REALS, _NO_REALS, distance
        if self._approaches is not None:
            hidden, length, aim_x, aim_y = self._approaches.around_walls(
                x, y, foot_x, foot_y, distance
            )
            if hidden.size:
                way = distance.copy()
                way[hidden] = length
        return Situations(
            t, x, y, theta, s, foot_x, foot_y, distance, tx, ty, curvature, *mates, neighbor, gamma,
            left, right, hidden, aim_x, aim_y, self.direction.copy(), held, way,
        )  # fmt: skip

    # ---- 3. override --------------------------------------------------------------------------

    def _modify(self, at: Situations, choices: Choices) -> tuple[Overrides, Codes]:
        """Return the overrides of this step and the actions in force, as ``Patrol`` finds them."""
        overrides, action = Overrides.of_none(len(at.x)), choices.winner.copy()
        for modifier in self._last_to_first:
            some = modifier.propose(at, choices, action, overrides)
            if some.size:
                proposed = overrides.action[some]
                action[some] = np.where(proposed == NONE, choices.winner[some], proposed)
        return overrides, action

    # ---- 4. direction -------------------------------------------------------------------------

    def _turn(self, at: Situations, action: Codes, overrides: Overrides) -> tuple[Codes, Codes]:
        """Return the directions of patrol, and the causes of turns, NONE where there is none."""
        before = at.direction
        chosen = self._chosen_turns(at, action, overrides)
        sets = SETS_DIRECTION[action]
        after = np.where(sets != 0, sets, before)
        after = np.where((chosen != NONE) & (before != 0), -before, after)
        shown, first = after.copy(), (after == 0).nonzero()[0]
        if first.size:
            along = at.tx[first] * np.cos(at.theta[first])
            ahead = along + at.ty[first] * np.sin(at.theta[first]) >= 0.0
            shown[first] = np.where(ahead, CLOCKWISE, COUNTER_CLOCKWISE)
            goes = action[first] == Act.KEEP_GOING
            after[first] = np.where(goes, shown[first], 0)
        self.direction = after
        cause = np.full(len(after), NONE, dtype=np.int8)
        turned = ((before != 0) & (after != before)).nonzero()[0]
        if turned.size:
            met = at.gamma[turned] * before[turned] > 0.0
            by_rules = np.where(met, _TEAMMATE, _RULES)
            own = chosen[turned]
            cause[turned] = np.where(own != NONE, own, by_rules)
            for robot in turned.tolist():
                turn = (float(at.s[robot]), int(after[robot]), CAUSES[cause[robot]])
                self.turns.add(robot, Turn(at.t, *turn))
        return shown, cause

    def _chosen_turns(self, at: Situations, action: Codes, overrides: Overrides) -> Codes:
        """Return the causes of reversals during Keep Going: a modifier, or chance; else NONE."""
        keeps = (action == Act.KEEP_GOING) & (at.direction != 0)
        chosen = np.where(keeps, overrides.turn, NONE).astype(np.int8)
        may = keeps & overrides.may_turn
        if not at.closed:
            may &= np.minimum(at.left, at.right) >= REVERSAL_END_DISTANCE
        turning = self._reversals.due(at.t, may)
        turning = turning[chosen[turning] == NONE]
        chosen[turning] = _CHANCE
        return chosen

    # ---- 5. velocity --------------------------------------------------------------------------

    def _velocity(
        self, at: Situations, action: Codes, direction: Codes, overrides: Overrides
    ) -> tuple[Reals, Reals]:
        speed = np.minimum(overrides.speed_limit, self._settings.patrol_speed)
        vx, vy = action_velocities(at, action, direction, speed, self._settings)
        stopped = overrides.speed_limit == 0.0
        vx[stopped] = vy[stopped] = 0.0
        return vx, vy

    def _modifiers(self, dwell: float) -> list[ManyModifiers]:
        """Return the modifiers that the settings name, in that order."""
        n, settings = len(self._rngs), self._settings

        @cache
        def even_gaps() -> EvenGapsOfMany:
            return EvenGapsOfMany(self._feet, settings, self.turns, self._rngs)

        def make(name: str) -> ManyModifiers:
            match name:
                case "standoff":
                    return Standoffs(n)
                case "hold_at_end":
                    return HoldsAtEnds()
                case "blockage":
                    return Blockages(n)
                case "closing_in":
                    rules = Arbiters(self._system, dwell, n)
                    return ClosingsIn(self._border, self._arbiters, rules, self.turns, self._rngs)
                case "common_turns":
                    self._common = CommonTurnsOfMany(
                        even_gaps(),
                        self._feet.length,
                        settings,
                        self.turns,
                        self._clocks,
                        self._secrets,
                    )
                    return self._common
                case _:
                    return even_gaps()

        without = {AROUND_WALLS, DWELL}
        without |= {HOLD_AT_END} if self._border.closed else {EVEN_GAPS, COMMON_TURNS}
        if not (settings.common_secret and self._clocks):
            without.add(COMMON_TURNS)
        return [make(name) for name in settings.modifiers if name not in without]


_NO_REALS = np.empty(0)


def has_arrays(settings: PatrolSettings) -> bool:
    """Return whether supervisor and modifiers of some settings have arrays here."""
    return settings.supervisor == "fuzzy" and set(settings.modifiers) <= set(_KNOWN)
