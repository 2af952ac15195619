"""A finite state automaton in place of the fuzzy supervisor, after the authors' sister paper.

"Behavioral Control for Multi-Robot Perimeter Patrol: A Finite State Automata approach" chooses
among the same actions from the same inputs. Only its abstract is known to us, so the transitions
are ours: thresholds where the fuzzy sets of the shipped rules cross, each with a hysteresis.
"""

from __future__ import annotations

from collections.abc import Mapping

from robot_agent.patrol.action_dwell import ActionDwell
from robot_agent.patrol.actions import PATROLLING, Action
from robot_agent.patrol.settings import AutomatonSettings
from robot_agent.patrol.supervisor import Choice


class Automaton:
    """States are the actions; remembers the present one and since when."""

    def __init__(self, settings: AutomatonSettings, minimum_dwell: float) -> None:
        self._settings = settings
        self._present = ActionDwell(minimum_dwell)

    def choose(self, t: float, inputs: Mapping[str, float]) -> Choice:
        """Choose the action at t, s, from the crisp inputs of the rule base by name.

        Degrees are 1 for the state called for (for both directions of a robot caught between an
        end and a teammate) and 0 for the others.
        """
        called = self._called_for(inputs)
        degrees = {action: 1.0 if action in called else 0.0 for action in Action}
        present = self._present.action
        wanted = present if present in called else called[0]
        runner_up = next(a for a in (*called, *Action) if a is not wanted)
        winner = self._present.update(t, wanted, inputs["distance_from_neighbor"])
        return Choice(degrees, wanted, runner_up, winner)

    def _called_for(self, inputs: Mapping[str, float]) -> tuple[Action, ...]:
        """Return the states the inputs call for: one, or both directions of a robot caught."""
        settings = self._settings
        border, neighbor = inputs["distance_from_border"], inputs["distance_from_neighbor"]
        # 1. Safety first, wherever the robot is.
        if self._below(neighbor, settings.avoid_distance, Action.AVOID_TEAMMATE):
            return (Action.AVOID_TEAMMATE,)
        # 2. Not at the border: reach it, but not through a teammate.
        if not self._below(border, settings.border_distance, *PATROLLING):
            near = self._below(neighbor, settings.encounter_distance, Action.AVOID_TEAMMATE)
            return (Action.AVOID_TEAMMATE,) if near else (Action.REACH_FRONTIER,)
        # 3. At the border: turn away from what is met, else keep going.
        meeting = self._meeting(inputs)
        if meeting and not self._below(border, settings.encounter_border_distance, *PATROLLING):
            return (Action.AVOID_TEAMMATE,)  # off the border it gives way
        away = [action for action in (meeting, *self._at_ends(inputs)) if action]
        return tuple(dict.fromkeys(away)) or (Action.KEEP_GOING,)

    def _meeting(self, inputs: Mapping[str, float]) -> Action | None:
        """Return the direction away from a patrolling teammate, if one is met."""
        settings = self._settings
        gamma = inputs["neighbor_state"]
        away = Action.PATROL_CLOCKWISE if gamma < 0.0 else Action.PATROL_COUNTER_CLOCKWISE
        states = (away, Action.AVOID_TEAMMATE)
        if not self._below(inputs["distance_from_neighbor"], settings.encounter_distance, *states):
            return None
        margin = settings.gamma_hysteresis / 2.0
        margin = -margin if self._present.action in states else margin
        return away if abs(gamma) >= settings.encounter_gamma + margin else None

    def _at_ends(self, inputs: Mapping[str, float]) -> list[Action]:
        ends = {
            "distance_from_left_end": Action.PATROL_CLOCKWISE,
            "distance_from_right_end": Action.PATROL_COUNTER_CLOCKWISE,
        }
        return [
            back
            for end, back in ends.items()
            if self._below(inputs[end], self._settings.end_distance, back)
        ]

    def _below(self, value: float, threshold: float, *states: Action) -> bool:
        """Compare with a threshold that lies half a hysteresis higher while in one of states."""
        margin = self._settings.hysteresis / 2.0
        return value < threshold + (margin if self._present.action in states else -margin)
