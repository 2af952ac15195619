"""The watch for the robot's own parts in the laser's view, as a mast or the paddles of a gripper.

A thing near the robot, with a jump of the ranges at its edges, moves through the beams as
the robot turns. One whose edges stay in their beams turns with the robot. Only turns in place are
evidence, as a robot may drive round a pillar, and they must have taken a while, as a teammate may
pass at the rate of the turn.
"""

from __future__ import annotations

import math
from dataclasses import dataclass, field

import numpy as np
from numpy.typing import NDArray

from drivers.scan import Scan, Special
from maps.pose import Pose

Sectors = tuple[tuple[float, float], ...]
"""First and last direction of each, rad, laser frame."""
STEP = math.radians(5.0)  # of turning between two looks; all values of this file are ours
ENOUGH = 4  # headings, STEP apart, at which a part was in its place
_LIKELY = 2  # headings likewise, of a part beside one that is sure
ENOUGH_S = 10.0  # s, likewise
_FARTHEST = 0.8  # m from the laser; own parts are nearer
_JUMP = 0.1  # m between the ranges of neighbouring beams, at an edge
_EDGE = math.radians(2.0)  # of an edge that has not moved: mixed pixels are now in, now out
_TOLERANCE = 0.03  # m of a range that has not changed: several counts and standard deviations
_IN_PLACE = 0.03  # m driven since the last look; farther is an arc
_MOST = 8  # things near the robot; more are ribs or bars, whose edges cannot be told apart
_MARGIN = math.radians(1.0)  # to each side of a sector


@dataclass(slots=True)
class _Part:
    """A near thing: its edges, rad, laser frame, and range, m; since when, s, at what headings."""

    first: float
    last: float
    range: float
    since: float
    headings: set[int] = field(default_factory=set)

    def is_at(self, other: _Part) -> bool:
        """Return whether another look shows it in the same place."""
        return (
            abs(self.first - other.first) <= _EDGE
            and abs(self.last - other.last) <= _EDGE
            and abs(self.range - other.range) <= _TOLERANCE
        )


class OwnPartsWatch:
    """Finds the sectors in which the laser sees its own robot; those found are kept."""

    def __init__(self) -> None:
        """Start without scans."""
        self.restart()

    def restart(self) -> None:
        """Forget everything: the laser's line was opened."""
        self.sectors: Sectors = ()
        self.places: NDArray[np.float64] = np.empty((0, 2))
        """(n, 2) m, laser frame, of the returns in the sectors, when they were found."""
        self._parts: list[_Part] = []
        self._looked_at: Pose | None = None  # odom_from_base of the last look

    def update(self, t: float, odometry: Pose, scan: Scan) -> bool:
        """Take in a scan at t and odom_from_base; return whether the sectors have changed."""
        moved = Pose(0.0, 0.0, 0.0)
        if self._looked_at is not None:
            moved = self._looked_at.between(odometry)
            if abs(moved.theta) < STEP:
                return False
        self._looked_at = odometry
        heading = round(odometry.theta % math.tau / STEP)
        in_place = math.hypot(moved.x, moved.y) < _IN_PLACE
        self._look(t, scan, heading if in_place else None)
        return self._find(t, scan)

    def _look(self, t: float, scan: Scan, heading: int | None) -> None:
        """Keep the parts that are in their places, and begin with the others of this scan."""
        seen = _near_things(t, scan)
        if len(seen) > _MOST:
            seen = []
        for number, thing in enumerate(seen):
            part = next((part for part in self._parts if part.is_at(thing)), thing)
            if heading is not None:
                part.headings.add(heading)
            seen[number] = part
        self._parts = seen

    def _find(self, t: float, scan: Scan) -> bool:
        """Add the new own parts; with one that is sure, all that are likely: the robot may stop."""
        new = [part for part in self._parts if not self._has(part)]
        if not any(len(part.headings) >= ENOUGH and t - part.since >= ENOUGH_S for part in new):
            return False
        for part in new:
            if len(part.headings) >= _LIKELY:
                self.places = np.concatenate((self.places, _places(part, scan)))
                sector = (part.first - _MARGIN, part.last + _MARGIN)
                self.sectors = _joined([*self.sectors, sector])
        return True

    def _has(self, part: _Part) -> bool:
        return any(first <= part.first and part.last <= last for first, last in self.sectors)


def _places(part: _Part, scan: Scan) -> NDArray[np.float64]:
    """Return a scan's returns (n, 2), m, laser frame, between the edges of a part."""
    angles = scan.angles
    inside = (angles > part.first) & (angles < part.last) & (scan.ranges < _FARTHEST)
    at, ranges = angles[inside], scan.ranges[inside, None]
    return np.asarray(ranges * np.column_stack((np.cos(at), np.sin(at))))


def _near_things(t: float, scan: Scan) -> list[_Part]:
    """Return the near things of a scan with a jump at one edge, a jump or a cut at the other.

    The end of the view and an ignored sector cut whatever passes there, always at the same beam.
    """
    ranges, angles = scan.ranges, scan.angles
    near = np.concatenate(([False], ranges < _FARTHEST, [False]))
    if not near.any():
        return []
    with np.errstate(invalid="ignore"):  # no return after no return
        jumps = np.concatenate(([True], ~(np.abs(np.diff(ranges)) < _JUMP), [True]))
    ignored = np.concatenate(([True], scan.specials == Special.IGNORED, [True]))
    cuts = ignored[:-1] | ignored[1:]
    begins = np.flatnonzero(near[1:-1] & (jumps[:-1] | ~near[:-2]))
    ends = np.flatnonzero(near[1:-1] & (jumps[1:] | ~near[2:]))
    return [
        _Part(float(angles[a]), float(angles[b]), float(ranges[a : b + 1].min()), t)
        for a, b in zip(begins.tolist(), ends.tolist(), strict=True)
        if jumps[a] and jumps[b + 1] and not (cuts[a] and cuts[b + 1])
    ]


def _joined(sectors: list[tuple[float, float]]) -> Sectors:
    """Return sectors in order, those as one that overlap."""
    joined: list[tuple[float, float]] = []
    for first, last in sorted(sectors):
        if joined and first <= joined[-1][1]:
            before = joined.pop()
            first, last = before[0], max(last, before[1])
        joined.append((first, last))
    return tuple(joined)
