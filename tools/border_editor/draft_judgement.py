"""What is right and wrong with a border that is being drawn, as ``patrol map check`` judges it."""

from __future__ import annotations

import math

import msgspec
import numpy as np

from maps.border import BorderError
from maps.clearance import border_clearance
from maps.occupancy_map import OccupancyMap
from robot_agent.patrol.settings import PatrolSettings
from tools.border_editor.border_draft import BorderDraft

ROBOT_NEEDS_M = 2.5
"""m of border for each robot: 20 robots on 51 m were tried (tools/bench/patrol_in_rough.md)."""
_SHOWN_STEP = 5  # of the 0.01 m steps of a clearance, drawn on the page


class ShownStretch(msgspec.Struct, frozen=True):
    """A stretch of the line to draw; ok: whether it keeps its clearance. points: m, map frame."""

    ok: bool
    points: list[tuple[float, float]]


class Judgement(msgspec.Struct, frozen=True, kw_only=True):
    """The judgement of a draft.

    error: why it is no border yet, for people; empty if it is one. faults: what a check finds, for
    people; empty if robots can patrol it. length, clearance, radius (tightest turn; None: no turn)
    in m; robots: for how many there is room.
    """

    error: str = ""
    faults: list[str] = []
    line: list[ShownStretch] = []
    length: float | None = None
    clearance: float | None = None
    radius: float | None = None
    robots: int = 0

    @property
    def ok(self) -> bool:
        """Whether robots can patrol it."""
        return not self.error and not self.faults


def judge(occupancy: OccupancyMap, draft: BorderDraft, needed: float) -> Judgement:
    """Judge a draft on a map; needed: clearance, m, that robots need."""
    try:
        border = draft.border()
    except BorderError as error:
        return Judgement(error=str(error).removeprefix("this border: "))
    room = border_clearance(occupancy, border)
    faults = [str(stretch) for stretch in room.narrow_stretches(needed)]
    for place, what in (
        (room.first_outside, "leaves the map"),
        (room.first_unknown, "enters unknown space"),
        (room.first_occupied, "runs through a wall"),
    ):
        if place is not None:
            faults.append(f"{what} at {place}")
    tightest = PatrolSettings().turning_radius
    if border.tightest_radius < tightest:
        radius = f"{border.tightest_radius:.2f} m"
        faults.append(f"turns with a radius of {radius}, at least {tightest:g} m needed")
    keeps = room.distances >= needed
    parts = np.split(np.arange(len(keeps)), np.flatnonzero(np.diff(keeps)) + 1)
    return Judgement(
        faults=faults,
        line=[
            ShownStretch(
                ok=bool(keeps[part[0]]),
                points=[
                    (round(x, 3), round(y, 3))
                    for x, y in room.points[[*part[::_SHOWN_STEP], part[-1]]].tolist()
                ],
            )
            for part in parts
        ],
        length=border.length,
        clearance=room.minimum,
        radius=None if math.isinf(border.tightest_radius) else border.tightest_radius,
        robots=int(border.length / ROBOT_NEEDS_M),
    )
