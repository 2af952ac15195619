"""A verdict on a built map: do the scans that it was made of agree with it?

Walls of a folded map or of a false loop stand where other scans saw free floor: beams cross them,
or end far from any wall. What rests on the odometry alone has nothing to speak for it.
"""

from __future__ import annotations

import math
from collections.abc import Sequence
from dataclasses import dataclass
from enum import StrEnum

import numpy as np

from localization.matching import Matching
from maps.occupancy_map import OccupancyMap
from maps.pose import Pose
from tools.mapping.map_build import PosedScan
from tools.mapping.slam.loop_check import MOST_STRAIN, CheckedLoop

LEAST_FIT = 0.7  # of a scan, by the localizer's measure; less contradicts the map
MOST_CROSSING = 0.25  # share of a scan's beams through mapped walls, likewise
STEP = 0.5  # m between scans looked at
DOUBTFUL_SHARE = 0.02  # of the scans that contradict, above which a map is doubtful
FAILED_SHARE = 0.13
"""Likewise, failed: as many times the former as the folded synthetic maps, of which 85 % and more
contradict (the data's robots turned by hand, at their raw odometry), are times this."""
ODOMETRY_ALONE = 3.0  # m in one piece without a matched scan, above which a map is doubtful
OVERRULED_SHARE = 0.05  # of the loops that the others contradict, above which a map is doubtful
_BEAMS = 180


class Grade(StrEnum):
    """How far a built map can be trusted."""

    GOOD = "good"
    DOUBTFUL = "doubtful"
    FAILED = "failed"


@dataclass(frozen=True, slots=True)
class Verdict:
    """Grade of a map, why, and where."""

    grade: Grade
    reasons: list[str]
    places: list[Pose]
    """map_from_laser where scans or loops contradict the map, or odometry alone gave the pose."""

    def __str__(self) -> str:
        return f"{self.grade}: {'; '.join(self.reasons)}"


def judge(
    occupancy: OccupancyMap,
    scans: Sequence[PosedScan],
    max_range: float,
    unmatched: Sequence[tuple[Pose, float]] = (),
    loops: Sequence[CheckedLoop] = (),
    bend: tuple[float, Pose] | None = None,
) -> Verdict:
    """Return the verdict on a map of scans.

    max_range: of the beams in it, m. unmatched: pieces of the way where no scan was matched, each
    with its middle (map_from_laser) and its length, m. loops: closed in finding the poses. bend: by
    how many standard deviations of its errors the way was bent by them at most, and where.
    """
    looked_at = contradicting = 0
    places: list[Pose] = []
    check, last = Matching(occupancy, _BEAMS).check, None
    for scan in scans:
        if last is not None and math.dist(last[:2], scan.reference[:2]) < STEP:
            continue
        last = scan.reference
        ranges, angles = scan.beams()
        used = ranges < max_range
        ends = ranges[used, np.newaxis] * np.column_stack((np.cos(angles), np.sin(angles)))[used]
        fit = check.fit(scan.reference, ends)
        if fit is None:
            continue
        looked_at += 1
        crossing = check.wall_crossing(scan.reference, ends)
        if fit.fit_without_dynamic < LEAST_FIT or crossing > MOST_CROSSING:
            contradicting += 1
            places.append(scan.reference)
    share = contradicting / max(looked_at, 1)
    reasons = [f"{contradicting} of {looked_at} scans contradict the map"]
    long = [(pose, length) for pose, length in unmatched if length > ODOMETRY_ALONE]
    if long:
        most = max(length for _, length in long)
        reasons.append(f"{len(long)} stretches of up to {most:.1f} m rest on odometry alone")
    overruled = [loop.pose for loop in loops if not loop.kept]
    if overruled:
        reasons.append(f"{len(overruled)} of {len(loops)} loops contradict the others")
    bent = [] if bend is None or bend[0] <= MOST_STRAIN else [bend[1]]
    if bend is not None and bent:
        reasons.append(f"loops bend the way by {bend[0]:.1f} sigma of its errors")
    contested = len(overruled) > OVERRULED_SHARE * len(loops)
    grade = Grade.GOOD
    if long or bent or contested or share > DOUBTFUL_SHARE:
        grade = Grade.DOUBTFUL
    if not looked_at or share > FAILED_SHARE:
        grade = Grade.FAILED
    return Verdict(grade, reasons, [*places, *(pose for pose, _ in long), *overruled, *bent])
