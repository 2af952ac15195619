"""Loop closing: places seen again, searched for where the drift since may have taken the robot.

A loop is believed when a whole stretch of scans fits an old stretch, fits nowhere else about as
well, and a second stretch farther on says the same of the drift.
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

from maps.pose import Pose
from tools.mapping.slam.alignment import align
from tools.mapping.slam.chain import close
from tools.mapping.slam.cloud import join
from tools.mapping.slam.correlation import search
from tools.mapping.slam.keyframe import Keyframe
from tools.mapping.slam.pose_graph import Edge, optimize

_EVERY = 2  # keyframes; each so many are searched for loops
_STRETCH = 4  # keyframes to each side that make a stretch
_MIN_WAY = 12.0  # m travelled before a place can be seen again
_DRIFT = 0.06  # m per m travelled since the last known place, at most
_TURN_DRIFT = math.radians(0.5)  # rad per m
_NEAR = 2.5  # m; stretches no farther apart see the same, whatever the drift
_WIDEST = 6.0  # m, largest drift searched for
_WIDEST_TURN = math.radians(50.0)
_MAX_PLACES = 3  # searched for each keyframe
_MIN_SCORE = 0.55
_MIN_SHARE = 0.6
_DISTINCT = 0.9  # the largest ratio of the scores of the second best place and the best
_TRUSTED_WAY = 15.0  # m; drift over less needs no second witness
_WITNESSES_WITHIN = 8.0  # m travelled
_AGREEMENT = (0.4, math.radians(4.0))  # m, rad
_SURPRISE = (0.1, math.radians(1.0))  # m, rad


@dataclass(frozen=True, slots=True, eq=False)
class _Candidate:
    edge: Edge
    unknown: float
    """Way over which drift may have grown, m."""


class LoopCloser:
    """Looks for loops along the chain, and keeps the graph up to date as it finds them."""

    def __init__(
        self, frames: Sequence[Keyframe], poses: Sequence[Pose], edges: list[Edge]
    ) -> None:
        self._frames = frames
        self._chain = list(poses)
        self.poses = list(poses)
        """The keyframes' poses, all loops so far considered."""
        self.edges = list(edges)
        self.loops: list[Edge] = []
        """Loops believed."""
        self._pending: list[_Candidate] = []
        steps = [math.dist(a[:2], b[:2]) for a, b in itertools.pairwise(poses)]
        self._way = np.concatenate(([0.0], np.cumsum(steps)))

    def close(self, progress: Callable[[float], None]) -> None:
        """Search the whole chain."""
        for index in range(_STRETCH, len(self._frames), _EVERY):
            found = [
                candidate
                for place in self._places(index)
                if (candidate := self._match(index, *place)) is not None
            ]
            believed = [edge for candidate in found for edge in self._judge(candidate)]
            self.loops += believed
            if any(self._surprises(edge) for edge in believed):
                self.poses = optimize(self.poses, self.edges + self.loops)
            progress(index)
        self.poses = optimize(self.poses, self.edges + self.loops)

    def _surprises(self, loop: Edge) -> bool:
        """Tell whether a loop says something that the poses do not know yet."""
        known = self.poses[loop.start].between(self.poses[loop.end])
        return not close(known, loop.pose, _SURPRISE)

    def _places(self, index: int) -> list[tuple[int, float]]:
        """Return old keyframes to match one with, and the way over which drift may have grown."""
        unknown = self._unknown_way(index)
        here = np.array(self.poses[index][:2])
        old = np.flatnonzero(self._way[: index + 1] < self._way[index] - _MIN_WAY)
        if not len(old):
            return []
        apart = np.hypot(*(np.array([self.poses[i][:2] for i in old]) - here).T)
        reachable = apart < _NEAR + np.minimum(_DRIFT * unknown[old], _WIDEST)
        # Each visit to the neighbourhood is one place: the keyframe nearest of it stands for it.
        old, apart = old[reachable], apart[reachable]
        if not len(old):
            return []
        visits = np.split(np.arange(len(old)), np.flatnonzero(np.diff(old) > 1) + 1)
        nearest = [visit[int(np.argmin(apart[visit]))] for visit in visits]
        nearest.sort(key=lambda i: float(apart[i]))
        return [(int(old[i]), float(unknown[old[i]])) for i in nearest[:_MAX_PLACES]]

    def _unknown_way(self, index: int) -> NDArray[np.float64]:
        """Return, for each keyframe, the way to one along the graph: loops are short cuts."""
        links = [(i, i + 1, self._way[i + 1] - self._way[i]) for i in range(len(self._way) - 1)]
        links += [(loop.start, loop.end, 0.5) for loop in self.loops]
        start, end, length = zip(*links, strict=True)
        size = len(self._way)
        graph = coo_matrix((np.maximum(length, 1e-6), (start, end)), (size, size))
        return np.asarray(dijkstra(graph.tocsr(), directed=False, indices=index))

    def _match(self, index: int, place: int, unknown: float) -> _Candidate | None:
        """Fit the stretch that ends in a keyframe to the stretch round an old one."""
        here, there = self.poses[index], self.poses[place]
        stretch = range(index - _STRETCH, index + 1)
        old = range(max(0, place - _STRETCH), min(len(self._frames), place + _STRETCH + 1))
        source = join((here.between(self.poses[i]), self._frames[i]) for i in stretch)
        target = join((there.between(self.poses[i]), self._frames[i]) for i in old)
        guess = there.between(here)
        window = 0.5 + min(_DRIFT * unknown, _WIDEST)
        turn_window = math.radians(5.0) + min(_TURN_DRIFT * unknown, _WIDEST_TURN)
        peak = search(source.points, target.points, guess, window, turn_window)
        if peak.score < _MIN_SCORE or peak.rival > _DISTINCT * peak.score:
            return None
        found = align(source.points, target, peak.pose)
        if found is None or found.share < _MIN_SHARE:
            return None
        return _Candidate(Edge(place, index, found.pose, found.information), unknown)

    def _judge(self, candidate: _Candidate) -> list[Edge]:
        """Return the loops to believe now: a candidate, and those that waited for its witness."""
        edge = candidate.edge
        if candidate.unknown < _TRUSTED_WAY:
            return [edge]
        witnesses = [
            other
            for other in self._pending
            if 0.0 < self._way[edge.end] - self._way[other.edge.end] < _WITNESSES_WITHIN
            and self._agree(edge, other.edge)
        ]
        if not witnesses:
            self._pending.append(candidate)
            return []
        self._pending = [other for other in self._pending if other not in witnesses]
        return [edge, *(other.edge for other in witnesses)]

    def _agree(self, edge: Edge, other: Edge) -> bool:
        """Tell whether going round by two loops and the graph leads back to the start."""
        old = self.poses[other.start].between(self.poses[edge.start])
        new = self.poses[other.end].between(self.poses[edge.end])
        return close(old.compose(edge.pose), other.pose.compose(new), _AGREEMENT)
