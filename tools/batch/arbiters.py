"""``Supervisor`` for many robots: the fuzzy winner of each, kept for the minimum dwell."""

from __future__ import annotations

import math
from dataclasses import dataclass

import numpy as np

from robot_agent.patrol.action_dwell import EQUAL as SAME_TIME
from robot_agent.patrol.supervisor import EQUAL, SAFEST_LEFT, SAFEST_RIGHT
from tools.batch.arrays import Codes, Flags, Indices, Reals, pick
from tools.batch.fuzzy_arrays import FuzzyArrays
from tools.batch.situations import ACTIONS, NONE, Act, Situations

_OTHERS = (Act.KEEP_GOING, Act.REACH_FRONTIER, Act.AVOID_TEAMMATE)


def _ranks(safest: tuple[str, ...]) -> Codes:
    return np.array([[safest.index(action)] for action in ACTIONS], dtype=np.int8)


_LEFT, _RIGHT = _ranks(SAFEST_LEFT), _ranks(SAFEST_RIGHT)
_PRESENT_FIRST = -1
_NOT_TIED = 9


@dataclass(slots=True, eq=False)
class Choices:
    """Of each robot (n,): ``winner`` in force, and ``raw`` by the rules before the dwell.

    both_ways: both directions are activated above all other actions, as in ``way_out``.
    degrees: (actions, n) of activation.
    """

    winner: Codes
    raw: Codes
    both_ways: Flags
    degrees: Reals


class Arbiters:
    """Chooses actions; keeps each robot's present one and since when."""

    def __init__(self, system: FuzzyArrays, minimum_dwell: float, n: int) -> None:
        """minimum_dwell: s."""
        self._system = system
        self._dwell = minimum_dwell
        self.action = np.full(n, NONE, dtype=np.int8)
        self.since = np.zeros(n)
        self._flat = system.corners("distance_from_border")[0]
        self._far = max(
            (system.corners(name)[-1] for name in system.inputs if name.endswith("_end")),
            default=0.0,
        )
        self._alone_degrees = self._degrees_alone()
        self._alone = int(self._alone_degrees.argmax())

    def choose(self, at: Situations) -> Choices:
        """Choose the action of every robot."""
        n = len(at.x)
        alone = (at.neighbor == math.inf) & (at.way <= self._flat)
        if not at.closed:
            alone &= np.minimum(at.left, at.right) >= self._far
        raw = np.full(n, self._alone, dtype=np.int8)
        both_ways = np.zeros(n, dtype=np.bool_)
        degrees = np.repeat(self._alone_degrees, n, axis=1)
        rest = (~alone).nonzero()[0]
        if rest.size:
            degrees[:, rest] = own = self._degrees(at, rest, at.neighbor[rest])
            raw[rest] = _best(own, at.gamma[rest] <= 0.0, self.action[rest])
            if not at.closed:
                both = np.minimum(own[Act.PATROL_CLOCKWISE], own[Act.PATROL_COUNTER_CLOCKWISE])
                both_ways[rest] = both > own[list(_OTHERS)].max(axis=0)
        self._update(at.t, raw, at.neighbor, slice(None))
        return Choices(self.action.copy(), raw, both_ways, degrees)

    def choose_some(
        self, at: Situations, paper: Choices, some: Indices, moved: Flags, neighbor: Reals
    ) -> Codes:
        """Choose for some robots with other distances from their teammates; return the winners.

        paper: the choices by the true distances. moved: (m,) which of the distances ``neighbor``
        (m,), m, differ from those.
        """
        degrees = paper.degrees[:, some]
        if moved.any():
            degrees[:, moved] = self._degrees(at, some[moved], neighbor[moved])
        raw = _best(degrees, at.gamma[some] <= 0.0, self.action[some])
        self._update(at.t, raw, neighbor, some)
        return self.action[some]

    def pick(self, robots: Indices) -> None:
        """Keep some robots, as ``arrays.pick`` does."""
        pick(self, ("action", "since"), robots)

    def _degrees(self, at: Situations, some: Indices, neighbor: Reals) -> Reals:
        values = {
            "distance_from_border": at.way,
            "neighbor_state": at.gamma,
            "distance_from_left_end": at.left,
            "distance_from_right_end": at.right,
        }
        return self._system.evaluate(
            [neighbor if key not in values else values[key][some] for key in self._system.inputs]
        )

    def _degrees_alone(self) -> Reals:
        """Return (actions, 1) the degrees on the border, alone and far from its ends."""
        values = {"distance_from_border": 0.0, "neighbor_state": 0.0}
        alone = [np.array([values.get(name, math.inf)]) for name in self._system.inputs]
        degrees = self._system.evaluate(alone)
        assert (degrees >= degrees.max() - EQUAL).sum() == 1, "a tie needs the present action"
        return degrees

    def _update(self, t: float, raw: Codes, neighbor: Reals, some: Indices | slice) -> None:
        """Begin the actions wanted where the present ones may end (``ActionDwell.update``)."""
        present, since = self.action[some], self.since[some]
        ends = raw != present
        if not ends.any():
            return
        may_end = (present == NONE) | (raw == Act.AVOID_TEAMMATE)
        may_end |= (present == Act.AVOID_TEAMMATE) & (neighbor == math.inf)
        may_end |= t - since >= self._dwell - SAME_TIME
        ends &= may_end
        self.action[some] = np.where(ends, raw, present)
        self.since[some] = np.where(ends, t, since)


def _best(degrees: Reals, left: Flags, present: Codes) -> Codes:
    """Return (m,) the actions of highest degree (actions, m); ties as ``Supervisor`` breaks them.

    left: (m,) the neighbor, if any, is on the left.
    """
    tied = degrees >= degrees.max(axis=0) - EQUAL
    rank = np.where(left, _LEFT, _RIGHT)
    several = np.arange(len(ACTIONS))[:, None] == present
    rank = np.where(several, _PRESENT_FIRST, rank)
    return np.asarray(np.where(tied, rank, _NOT_TIED).argmin(axis=0).astype(np.int8))
