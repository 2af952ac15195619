"""A finite state automaton in place of the fuzzy supervisor, after the authors' sister paper.

"Behavioral Control for Multi-Robot Perimeter Patrol: A Finite State Automata approach" chooses
among the same actions from the same inputs. Only its abstract is known to us, so the transitions
are ours: thresholds where the fuzzy sets of the shipped rules cross, each with a hysteresis.
"""

from __future__ import annotations

from collections.abc import Mapping

from robot_agent.patrol.action_dwell import ActionDwell
from robot_agent.patrol.actions import PATROLLING, Action
from robot_agent.patrol.rules import RulesError
from robot_agent.patrol.supervisor import Choice

# Thresholds of the transitions; a state once taken holds half a hysteresis beyond them.
_BORDER_DISTANCE = 1.5  # m; farther from the border: reach it
_ENCOUNTER_BORDER_DISTANCE = 0.7  # m; so near the border teammates turn, not avoid
_AVOID_DISTANCE = 1.1  # m; a teammate nearer is avoided
_ENCOUNTER_DISTANCE = 1.9  # m; a patrolling teammate nearer makes the robot turn
_ENCOUNTER_GAMMA = 0.375  # magnitude of gamma from which a teammate patrols
_END_DISTANCE = 0.55  # m from an end of an open border: turn
_HYSTERESIS = 0.1  # m
_GAMMA_HYSTERESIS = 0.1


def require_safety_distance(safety_distance: float) -> None:
    """Raise RulesError for a safety distance, m, below the distance that Avoid Teammate reaches.

    Robots would stop there for good. Rule files are checked for the same.
    """
    farthest = _ENCOUNTER_DISTANCE + _HYSTERESIS / 2.0
    if safety_distance < farthest:
        raise RulesError(
            f"safety_distance {safety_distance} m must be at least {farthest} m, up to "
            "which the automaton avoids a teammate"
        )


class Automaton:
    """Finite state automaton whose states are the actions, with a minimum dwell in each."""

    def __init__(self, minimum_dwell: float) -> None:
        """minimum_dwell: s an action lasts."""
        self.present = ActionDwell(minimum_dwell)

    def choose(self, t: float, inputs: Mapping[str, float]) -> Choice:
        """Choose the action at t from the crisp inputs of the rule base by name.

        Degrees are 1 for the candidate states (both patrol directions for a robot between an end
        and a teammate) and 0 for the others.
        """
        candidates = self._candidates(inputs)
        degrees = {action: 1.0 if action in candidates else 0.0 for action in Action}
        present = self.present.action
        wanted = present if present in candidates else candidates[0]
        runner_up = next(a for a in (*candidates, *Action) if a is not wanted)
        winner = self.present.update(t, wanted, inputs["distance_from_neighbor"])
        return Choice(degrees, wanted, runner_up, winner)

    def _candidates(self, inputs: Mapping[str, float]) -> tuple[Action, ...]:
        """Return the states to go to: one, or both directions between an end and a teammate."""
        border, neighbor = inputs["distance_from_border"], inputs["distance_from_neighbor"]
        # 1. A teammate within the avoidance distance comes first, wherever the robot is.
        if self._below(neighbor, _AVOID_DISTANCE, Action.AVOID_TEAMMATE):
            return (Action.AVOID_TEAMMATE,)
        # 2. Not at the border: reach it, but not through a teammate.
        if not self._below(border, _BORDER_DISTANCE, *PATROLLING):
            near = self._below(neighbor, _ENCOUNTER_DISTANCE, Action.AVOID_TEAMMATE)
            return (Action.AVOID_TEAMMATE,) if near else (Action.REACH_FRONTIER,)
        # 3. At the border: turn away from a teammate or an end, else keep going.
        meeting = self._meeting(inputs)
        if meeting and not self._below(border, _ENCOUNTER_BORDER_DISTANCE, *PATROLLING):
            return (Action.AVOID_TEAMMATE,)  # off the border this robot gives way
        away = [action for action in (meeting, *self._at_ends(inputs)) if action]
        return tuple(dict.fromkeys(away)) or (Action.KEEP_GOING,)

    def _meeting(self, inputs: Mapping[str, float]) -> Action | None:
        """Return the direction away from a patrolling teammate within range; None without one."""
        gamma = inputs["neighbor_state"]
        away = Action.PATROL_CLOCKWISE if gamma < 0.0 else Action.PATROL_COUNTER_CLOCKWISE
        states = (away, Action.AVOID_TEAMMATE)
        if not self._below(inputs["distance_from_neighbor"], _ENCOUNTER_DISTANCE, *states):
            return None
        margin = _GAMMA_HYSTERESIS / 2.0
        margin = -margin if self.present.action in states else margin
        return away if abs(gamma) >= _ENCOUNTER_GAMMA + margin else None

    def _at_ends(self, inputs: Mapping[str, float]) -> list[Action]:
        ends = {
            "distance_from_left_end": Action.PATROL_CLOCKWISE,
            "distance_from_right_end": Action.PATROL_COUNTER_CLOCKWISE,
        }
        return [back for end, back in ends.items() if self._below(inputs[end], _END_DISTANCE, back)]

    def _below(self, value: float, threshold: float, *states: Action) -> bool:
        """Return whether a value is below a threshold, with hysteresis.

        The threshold is half a hysteresis higher while in one of ``states``, else as much lower.
        """
        margin = _HYSTERESIS / 2.0
        return value < threshold + (margin if self.present.action in states else -margin)
