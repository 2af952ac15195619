"""Loop closing: search for revisited places within the possible drift of the odometry.

A loop is accepted when a stretch of scans matches an old stretch, has no second match about as
good, lies within the errors of the way between its ends, and a second stretch farther on gives a
consistent drift. Those that all loops together overrule are dropped in the end.
"""

from __future__ import annotations

import itertools
import math
from collections.abc import Callable, Sequence
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray
from scipy.sparse import coo_matrix
from scipy.sparse.csgraph import dijkstra

from maps.pose import Pose, wrap_angle
from tools.mapping.slam.alignment import align
from tools.mapping.slam.chain import close
from tools.mapping.slam.cloud import join
from tools.mapping.slam.correlation import search
from tools.mapping.slam.keyframe import Keyframe
from tools.mapping.slam.loop_check import MOST_STRAIN, CheckedLoop, is_overruled, strain, worst_bend
from tools.mapping.slam.pose_graph import Edge, optimize
from tools.mapping.slam.way_error import WayError

_EVERY = 2  # every second keyframe is searched for loops
_STRETCH = 4  # keyframes of a stretch to each side
_MIN_TRAVEL = 12.0  # m travelled before a place counts as revisited
_DRIFT = 0.06  # m per m travelled, upper bound
_TURN_DRIFT = math.radians(0.5)  # rad per m
_NEAR = 2.5  # m; distance searched in addition to the drift
_WIDEST = 6.0  # m, largest drift searched for
_WIDEST_TURN = math.radians(50.0)
_MAX_PLACES = 3  # matched for each keyframe
_MIN_SCORE = 0.55
_MIN_SHARE = 0.6
_DISTINCT = 0.9  # the largest ratio of the scores of the second best place and the best
_TRUSTED_TRAVEL = 15.0  # m; loops after less travel need no confirmation
_CONFIRM_WITHIN = 8.0  # m travelled
_AGREEMENT = (0.4, math.radians(4.0))  # m, rad
_NOVELTY = (0.1, math.radians(1.0))  # m, rad


@dataclass(frozen=True, slots=True, eq=False)
class _Candidate:
    edge: Edge
    travel: float
    """Distance over which drift may have grown, m."""


class LoopCloser:
    """Searches for loops along the chain and optimizes the graph with them."""

    def __init__(
        self, frames: Sequence[Keyframe], poses: Sequence[Pose], edges: list[Edge]
    ) -> None:
        self._frames = frames
        self._chain = list(poses)
        self.poses = list(poses)
        """The keyframes' poses, optimized with the loops so far."""
        self.edges = list(edges)
        self.loops: list[Edge] = []
        """Accepted loops."""
        self.overruled: list[Edge] = []
        """Loops dropped in the end, as the others contradict them."""
        self._pending: list[_Candidate] = []
        steps = [math.dist(a[:2], b[:2]) for a, b in itertools.pairwise(poses)]
        self._errors = WayError(poses, edges)
        self._travelled = np.concatenate(([0.0], np.cumsum(steps)))

    def close(self, progress: Callable[[float], None]) -> None:
        """Search the whole chain; ``progress`` is called with each index searched."""
        for index in range(_STRETCH, len(self._frames), _EVERY):
            found = [
                candidate
                for place in self._places(index)
                if (candidate := self._match_place(index, *place)) is not None
            ]
            accepted = [edge for candidate in found for edge in self._confirm(candidate)]
            self.loops += accepted
            if any(self._is_new(edge) for edge in accepted):
                self.poses = optimize(self.poses, self.edges + self.loops)
            progress(index)
        self.poses = optimize(self.poses, self.edges + self.loops)
        self._drop_overruled()

    def checked(self, poses: Sequence[Pose]) -> list[CheckedLoop]:
        """Return all loops, the dropped ones last; poses: the keyframes' final ones."""
        return [
            CheckedLoop(
                pose=poses[loop.end],
                way=float(self._travelled[loop.end] - self._travelled[loop.start]),
                shift=math.dist(loop.pose[:2], drifted[:2]),
                turn=wrap_angle(loop.pose.theta - drifted.theta),
                strain=strain(loop, self._chain, self._errors),
                kept=kept,
            )
            for loops, kept in ((self.loops, True), (self.overruled, False))
            for loop in loops
            for drifted in (self._chain[loop.start].between(self._chain[loop.end]),)
        ]

    def bend(self, poses: Sequence[Pose]) -> tuple[float, int]:
        """Return ``worst_bend`` of the chain by the keyframes' final poses."""
        return worst_bend(poses, self._chain, self._errors)

    def _drop_overruled(self) -> None:
        """Leave out the loops that the others contradict, until all that are left agree."""
        while dropped := [loop for loop in self.loops if is_overruled(loop, self.poses)]:
            self.overruled += dropped
            self.loops = [loop for loop in self.loops if loop not in dropped]
            self.poses = optimize(self.poses, self.edges + self.loops)

    def _is_new(self, loop: Edge) -> bool:
        """Whether a loop's pose differs from the present poses by more than _NOVELTY."""
        known = self.poses[loop.start].between(self.poses[loop.end])
        return not close(known, loop.pose, _NOVELTY)

    def _places(self, index: int) -> list[tuple[int, float]]:
        """Return old keyframes to match, each with the distance over which drift may have grown."""
        travel = self._graph_distances(index)
        here = np.array(self.poses[index][:2])
        old = np.flatnonzero(self._travelled[: index + 1] < self._travelled[index] - _MIN_TRAVEL)
        if not len(old):
            return []
        apart = np.hypot(*(np.array([self.poses[i][:2] for i in old]) - here).T)
        reachable = apart < _NEAR + np.minimum(_DRIFT * travel[old], _WIDEST)
        # Each visit to the neighbourhood is represented by its nearest keyframe.
        old, apart = old[reachable], apart[reachable]
        if not len(old):
            return []
        visits = np.split(np.arange(len(old)), np.flatnonzero(np.diff(old) > 1) + 1)
        nearest = [visit[int(np.argmin(apart[visit]))] for visit in visits]
        nearest.sort(key=lambda i: float(apart[i]))
        return [(int(old[i]), float(travel[old[i]])) for i in nearest[:_MAX_PLACES]]

    def _graph_distances(self, index: int) -> NDArray[np.float64]:
        """Return each keyframe's distance, m, to ``index`` along the graph, loops included."""
        way = self._travelled
        links = [(i, i + 1, way[i + 1] - way[i]) for i in range(len(way) - 1)]
        links += [(loop.start, loop.end, 0.5) for loop in self.loops]
        start, end, length = zip(*links, strict=True)
        size = len(way)
        graph = coo_matrix((np.maximum(length, 1e-6), (start, end)), (size, size))
        return np.asarray(dijkstra(graph.tocsr(), directed=False, indices=index))

    def _match_place(self, index: int, place: int, travel: float) -> _Candidate | None:
        """Match the stretch that ends in a keyframe with the stretch round an old one."""
        here, there = self.poses[index], self.poses[place]
        stretch = range(index - _STRETCH, index + 1)
        old = range(max(0, place - _STRETCH), min(len(self._frames), place + _STRETCH + 1))
        source = join((here.between(self.poses[i]), self._frames[i]) for i in stretch)
        target = join((there.between(self.poses[i]), self._frames[i]) for i in old)
        guess = there.between(here)
        window = 0.5 + min(_DRIFT * travel, _WIDEST)
        turn_window = math.radians(5.0) + min(_TURN_DRIFT * travel, _WIDEST_TURN)
        peak = search(source.points, target.points, guess, window, turn_window)
        if peak.score < _MIN_SCORE or peak.runner_up > _DISTINCT * peak.score:
            return None
        found = align(source.points, target, peak.pose)
        if found is None or found.share < _MIN_SHARE:
            return None
        edge = Edge(place, index, found.pose, found.information)
        if strain(edge, self._chain, self._errors) > MOST_STRAIN:
            return None
        return _Candidate(edge, travel)

    def _confirm(self, candidate: _Candidate) -> list[Edge]:
        """Return the loops accepted now: the candidate and pending ones that it confirms."""
        edge = candidate.edge
        if candidate.travel < _TRUSTED_TRAVEL:
            return [edge]
        confirming = [
            other
            for other in self._pending
            if 0.0 < self._travelled[edge.end] - self._travelled[other.edge.end] < _CONFIRM_WITHIN
            and self._is_consistent(edge, other.edge)
        ]
        if not confirming:
            self._pending.append(candidate)
            return []
        self._pending = [other for other in self._pending if other not in confirming]
        return [edge, *(other.edge for other in confirming)]

    def _is_consistent(self, edge: Edge, other: Edge) -> bool:
        """Whether the cycle of two loops and the graph between them closes within _AGREEMENT."""
        old = self.poses[other.start].between(self.poses[edge.start])
        new = self.poses[other.end].between(self.poses[edge.end])
        return close(old.compose(edge.pose), other.pose.compose(new), _AGREEMENT)
