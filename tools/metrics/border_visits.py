"""When the places of a border were visited, by robots at true positions."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from maps.border import Border

VISIT_RADIUS = 0.25
"""m; a place is visited while a robot is within it."""
BORDER_STEP = 0.25
"""m between two places."""
BESIDE_WRECK = 2.0
"""Length of border on each side of a wreck that cannot be driven, m: teammates turn before it."""
_WAY_OVER = 1.0  # s over which a robot's way along the border is taken, so that noise is none
_ALONG = 0.6  # m; places farther along the border than this are not within the radius: on an arc of
# 0.5 m, the tightest, two points 0.5 m apart are 0.52 m apart along it
_STANDS = 0.02  # m driven meanwhile, below which a robot has no way


@dataclass(frozen=True, slots=True, eq=False)
class PlaceVisits:
    """The visits to one place, in order; a stay of a robot within the radius is one.

    arrivals, departures: (k,) s, of each stay; ways: (k,) int8, +1 or -1, the direction along the
    border in which the robot left, 0 if it stood. first, last: s, begin and end of the record.
    """

    arrivals: NDArray[np.float64]
    departures: NDArray[np.float64]
    ways: NDArray[np.int8]
    first: float
    last: float

    @property
    def gaps(self) -> NDArray[np.float64]:
        """Times (k - 1,), s, between two stays, without a robot."""
        return self.arrivals[1:] - self.departures[:-1]

    @property
    def cut(self) -> tuple[float, float]:
        """Times without a robot before the first stay and after the last, s."""
        if not len(self.arrivals):
            whole = self.last - self.first
            return whole, whole
        return float(self.arrivals[0] - self.first), float(self.last - self.departures[-1])


@dataclass(frozen=True, eq=False)
class BorderVisits:
    """When the places of a border were visited.

    t: (n,) s, evenly spaced. abscissae: (places,) m. visited: (n, places), whether a robot was
    within the radius. places: the visits of each. closed: whether the border is.
    """

    t: NDArray[np.float64]
    abscissae: NDArray[np.float64]
    visited: NDArray[np.bool_]
    places: list[PlaceVisits]
    closed: bool

    @property
    def passing(self) -> float:
        """The median stay, s: what a robot that drives past needs for it; 0 without visits."""
        stays = np.concatenate([each.departures - each.arrivals for each in self.places])
        return float(np.median(stays)) if stays.size else 0.0


def border_visits(
    border: Border,
    positions: Sequence[NDArray[np.float64]],
    t: NDArray[np.float64],
    wrecks: Sequence[tuple[float, float]] = (),
) -> BorderVisits:
    """Return all visits of robots at true positions, each (n, 2) m in the map, at times t (n,).

    wrecks: (x, y), m, as for ``visited_places``.
    """
    points = visited_places(border, wrecks)
    places_s, _ = border.project_many(points)
    visited = np.zeros((t.size, len(points)), dtype=bool)
    ways = np.zeros((t.size, len(points)), dtype=np.int8)
    near = NearPlaces(border, points)
    for position in positions:
        s, distance = border.project_many(position)
        sample, place = near.visited(position, s, distance)
        visited[sample, place] = True
        ways[sample, place] = _ways(border, s, t)[sample]
    places = [_place_visits(t, seen, way) for seen, way in zip(visited.T, ways.T, strict=True)]
    return BorderVisits(t, places_s, visited, places, border.closed)


def visited_places(
    border: Border, wrecks: Sequence[tuple[float, float]] = ()
) -> NDArray[np.float64]:
    """Return the places (n, 2), m, map frame, in the order of the border.

    The border beside wrecks, at (x, y) m, is left out, and so are the end points of an open one:
    a robot's front reaches them, but its centre turns half a robot length before.
    """
    points = border.polyline(BORDER_STEP)
    if not border.closed:
        points = points[1:-1]
    for wreck in wrecks:
        points = points[np.hypot(*(points - wreck).T) > BESIDE_WRECK]
    return points


class NearPlaces:
    """Finds the places within the radius of positions, by abscissa first."""

    def __init__(self, border: Border, points: NDArray[np.float64]) -> None:
        """points: (places, 2), m, map frame."""
        s, _ = border.project_many(points)
        laps = (-border.length, 0.0, border.length) if border.closed else (0.0,)
        around = np.concatenate([s + lap for lap in laps])
        self._order = np.argsort(around, kind="stable")
        self._sorted = around[self._order]
        self._points = points

    def visited(
        self, position: NDArray[np.float64], s: NDArray[np.float64], distance: NDArray[np.float64]
    ) -> tuple[NDArray[np.intp], NDArray[np.intp]]:
        """Return the pairs (sample, place) of which the place is within the radius.

        position: (n, 2) m, map frame; s, distance: (n,) its abscissae and distances from the
        border, m.
        """
        close = np.flatnonzero(distance <= VISIT_RADIUS)
        first = np.searchsorted(self._sorted, s[close] - _ALONG)
        last = np.searchsorted(self._sorted, s[close] + _ALONG)
        most = int((last - first).max(initial=0))
        candidates = first[:, None] + np.arange(most)
        row, column = np.nonzero(candidates < last[:, None])
        place = self._order[candidates[row, column]] % max(len(self._points), 1)
        sample = close[row]
        dx, dy = (position[sample] - self._points[place]).T
        here = dx * dx + dy * dy <= VISIT_RADIUS**2
        return sample[here], place[here]


def _ways(border: Border, s: NDArray[np.float64], t: NDArray[np.float64]) -> NDArray[np.int8]:
    """Return (n,) the direction along the border in which a robot drives: +1, -1 or 0.

    s: (n,) its abscissae, m.
    """
    if t.size < 2:
        return np.zeros(t.size, dtype=np.int8)
    span = max(round(_WAY_OVER / float(t[1] - t[0])), 1)
    later = np.minimum(np.arange(t.size) + span, t.size - 1)
    driven = s[later] - s
    if border.closed:
        driven -= border.length * np.round(driven / border.length)
    return np.where(np.abs(driven) < _STANDS, 0, np.sign(driven)).astype(np.int8)


def _place_visits(
    t: NDArray[np.float64], seen: NDArray[np.bool_], way: NDArray[np.int8]
) -> PlaceVisits:
    change = np.diff(np.concatenate(([False], seen, [False])).astype(np.int8))
    begins, ends = np.flatnonzero(change == 1), np.flatnonzero(change == -1) - 1
    return PlaceVisits(t[begins], t[ends], way[ends], float(t[0]), float(t[-1]))
