"""Figures of a run, from the simulator's true positions and the agents' decisions."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass
from itertools import combinations
from typing import Any

import numpy as np
from numpy.typing import NDArray

from maps.border import Border
from robot_agent.patrol.actions import PATROLLING, Action
from tools.metrics.border_recovery import recovery_figures
from tools.metrics.border_visits import border_visits
from tools.metrics.detection_bounds import bound_figures
from tools.metrics.settled import settled_figures, visit_figures
from tools.metrics.wreck import Wreck

ARRIVED_M = 0.10
MEETING_M = 2.5
STUCK_S = 20.0
"""Robots together for longer when the run ends have not ended their meeting, s. Ours."""
INTERFERENCE_M = 2.0
INTERFERENCE_PAUSE_S = 10.0
"""Time after which an interference of the same pair counts again, s (patrolling_sim)."""


@dataclass(frozen=True, eq=False)
class RobotRun:
    """One robot's run: true positions with the decision in force, all arrays of length n."""

    name: str
    t: NDArray[np.float64]
    """Times (n,), common to all robots of the run."""
    position: NDArray[np.float64]
    """True base position in ``map``, shape (n, 2), m."""
    action: Sequence[str]
    """Action in force, empty before the first decision."""
    direction: NDArray[np.int8]
    """Patrol direction in force: +1 clockwise, -1 counter-clockwise."""


@dataclass(frozen=True)
class Meeting:
    """Two robots within visibility of each other, from approach to separation."""

    t: float
    robots: tuple[str, str]
    actions: tuple[str, str]
    """The strongest reaction of each robot during the meeting."""
    closest_m: float
    lasted_s: float
    parted: bool
    """Whether they separated before the run ended."""
    crossed: bool
    """Whether they have changed places along the border."""

    @property
    def outcome(self) -> str:
        """The meeting's outcome, for people."""
        if not self.parted:
            return "cut off" if self.lasted_s < STUCK_S else "still together"
        if Action.AVOID_TEAMMATE in self.actions:
            return "avoided"
        if self.crossed:
            return "passed by"
        turned = {Action.PATROL_CLOCKWISE, Action.PATROL_COUNTER_CLOCKWISE}
        return "turned back" if turned.issuperset(self.actions) else "one turned back"


def distance_from_border(border: Border, run: RobotRun) -> NDArray[np.float64]:
    """Return the true distance from the border at each time, (n,), m."""
    return border.project_many(run.position)[1]


def arrival_index(distance: NDArray[np.float64]) -> int | None:
    """Return the index of the first time within ``ARRIVED_M`` of the border; None if never."""
    arrived = np.flatnonzero(distance <= ARRIVED_M)
    return int(arrived[0]) if arrived.size else None


def patrolling_distances(
    run: RobotRun, distance: NDArray[np.float64], first: int = 0
) -> NDArray[np.float64]:
    """Return the distances from the border, m, while patrolling after the first arrival.

    distance: (n,) m, at each time. first: index of the first time that counts.
    """
    start = arrival_index(distance)
    if start is None:
        return np.empty(0)
    patrolling = np.isin(np.asarray(run.action), sorted(PATROLLING))
    patrolling[: max(start, first)] = False
    return distance[patrolling]


def reach_time(run: RobotRun, distance: NDArray[np.float64]) -> float | None:
    """Return the time from the run's start to the first arrival at the border, s; None if never.

    distance: (n,) from the border, m.
    """
    index = arrival_index(distance)
    return None if index is None else float(run.t[index] - run.t[0])


def spread(values: NDArray[np.float64]) -> dict[str, float | None]:
    """Return median, p95, p99 and maximum; all None without values."""
    if not values.size:
        return {"median": None, "p95": None, "p99": None, "max": None}
    median, p95, p99 = np.percentile(values, (50, 95, 99))
    return {
        "median": float(median),
        "p95": float(p95),
        "p99": float(p99),
        "max": float(values.max()),
    }


def action_share(runs: Sequence[RobotRun]) -> dict[str, float]:
    """Return the share of time in each action, over all robots."""
    names = [name for run in runs for name in run.action if name]
    return {str(action): names.count(action) / len(names) if names else 0.0 for action in Action}


def longest_avoid(runs: Sequence[RobotRun]) -> float:
    """Return the longest uninterrupted Avoid Teammate of any robot, s."""
    longest = 0.0
    for run in runs:
        started: float | None = None
        for t, action in zip(run.t, run.action, strict=True):
            if action != Action.AVOID_TEAMMATE:
                started = None
                continue
            started = float(t) if started is None else started
            longest = max(longest, float(t) - started)
    return longest


def closest_approach(runs: Sequence[RobotRun]) -> float | None:
    """Return the smallest distance between two robots' centres, m; None with fewer than two."""
    distances = [
        float(np.hypot(*(a.position - b.position).T).min()) for a, b in combinations(runs, 2)
    ]
    return min(distances, default=None)


def interferences(runs: Sequence[RobotRun]) -> int:
    """Return how often two robots were nearer than 2 m, each pair at most once in 10 s."""
    count = 0
    for a, b in combinations(runs, 2):
        counted_at = -np.inf
        near = np.hypot(*(a.position - b.position).T) < INTERFERENCE_M
        for t in a.t[near].tolist():
            if t - counted_at >= INTERFERENCE_PAUSE_S:
                count += 1
                counted_at = t
    return count


def meetings(border: Border, runs: Sequence[RobotRun]) -> list[Meeting]:
    """Return all meetings of a run, in order of time."""
    found = [meeting for a, b in combinations(runs, 2) for meeting in _meetings_of(border, a, b)]
    return sorted(found, key=lambda meeting: meeting.t)


def _meetings_of(border: Border, a: RobotRun, b: RobotRun) -> list[Meeting]:
    distance = np.hypot(*(a.position - b.position).T)
    near = np.concatenate(([False], distance < MEETING_M, [False]))
    starts = np.flatnonzero(near[1:] & ~near[:-1])
    ends = np.flatnonzero(near[:-1] & ~near[1:])
    found = []
    for start, end in zip(starts.tolist(), ends.tolist(), strict=True):
        actions = (_reaction(a, start, end), _reaction(b, start, end))
        if actions == (Action.KEEP_GOING, Action.KEEP_GOING):
            continue  # neither reacted: one follows the other at a distance
        found.append(
            Meeting(
                t=float(a.t[start]),
                robots=(a.name, b.name),
                actions=actions,
                closest_m=float(distance[start:end].min()),
                lasted_s=float(a.t[end - 1] - a.t[start]),
                parted=bool(end < distance.size),
                crossed=_ahead(border, a, b, start) * _ahead(border, a, b, end - 1) < 0.0,
            )
        )
    return found


def _ahead(border: Border, a: RobotRun, b: RobotRun, index: int) -> float:
    """Return how far b is ahead of a along the border, m, negative if behind."""
    first, second = border.project_many(np.array([a.position[index], b.position[index]]))[0]
    ahead = float(second - first)
    return ahead - border.length * round(ahead / border.length) if border.closed else ahead


def _reaction(run: RobotRun, start: int, end: int) -> str:
    """Return the strongest reaction within an interval: avoid, turn, or the action in force."""
    done = run.action[start:end]
    for action in (Action.AVOID_TEAMMATE, Action.PATROL_CLOCKWISE, Action.PATROL_COUNTER_CLOCKWISE):
        if action in done:
            return action
    return done[-1]


def _patrol_figures(
    border: Border,
    runs: Sequence[RobotRun],
    distances: Sequence[NDArray[np.float64]],
    wrecks: Sequence[Wreck],
    speed: float,
) -> dict[str, Any]:
    """Return idleness and related figures from the time on when the last robot has arrived.

    speed: of the patrol, m/s.
    """
    arrivals = [arrival_index(distance) for distance in distances]
    reached = [index for index in arrivals if index is not None]
    if not reached:
        return {**visit_figures(None), **recovery_figures(border, [], None, wrecks, speed)}
    start = max(reached)
    positions = [run.position[start:] for run in runs]
    visits = border_visits(border, positions, runs[0].t[start:], [wreck[:2] for wreck in wrecks])
    stopped = {wreck.robot for wreck in wrecks}
    left = [place for run, place in zip(runs, positions, strict=True) if run.name not in stopped]
    return {**visit_figures(visits), **recovery_figures(border, left, visits, wrecks, speed)}


def _patrolling_spread(
    runs: Sequence[RobotRun], distances: Sequence[NDArray[np.float64]], first: int = 0
) -> dict[str, float | None]:
    """Return the spread of all robots' ``patrolling_distances``."""
    each = [patrolling_distances(*one, first) for one in zip(runs, distances, strict=True)]
    return spread(np.concatenate(each))


def bench_figures(
    border: Border,
    runs: Sequence[RobotRun],
    contacts: int,
    speed: float,
    wrecks: Sequence[Wreck] = (),
) -> dict[str, Any]:
    """Return the figures of a run that need only true positions and actions.

    speed: of the patrol, m/s. wrecks: robots stopped permanently; the border beside them is left
    out of the idleness.
    """
    distances = [distance_from_border(border, run) for run in runs]
    return {
        "contacts": contacts,
        "closest_m": closest_approach(runs),
        "border_distance_m": _patrolling_spread(runs, distances),
        "reach_s": [reach_time(*one) for one in zip(runs, distances, strict=True)],
        "meetings": [
            {
                "t": meeting.t,
                "robots": list(meeting.robots),
                "actions": list(meeting.actions),
                "closest_m": meeting.closest_m,
                "outcome": meeting.outcome,
            }
            for meeting in meetings(border, runs)
        ],
        "interferences": interferences(runs),
        **_patrol_figures(border, runs, distances, wrecks, speed),
        **bound_figures(border, len(runs), speed),
        "settled": {
            **settled_figures(
                border, [run.position for run in runs], runs[0].t, [wreck[:2] for wreck in wrecks]
            ),
            "border_distance_m": _patrolling_spread(runs, distances, runs[0].t.size // 2),
        },
        "action_share": action_share(runs),
        "longest_avoid_s": longest_avoid(runs),
    }
