"""The lies that ``patrol campaign --lies`` tells."""

from __future__ import annotations

import math
from collections.abc import Sequence

from maps.pose import Pose
from tools.campaign.chosen import chosen
from tools.campaign.lie import Lie

LIES = (
    Lie("half-stuck", "after 30 s the right half of the beams stays as it was", "laser_half_stuck"),
    Lie("repeated-scan", "after 30 s the scan stays, with new noise", "repeated_scan"),
    Lie("mirrored", "the laser's beams come in the wrong order", "laser_mirrored"),
    Lie("scaled", "ranges are a tenth too long", "laser_scaled"),
    Lie("turned-3", "the laser is turned by 3 degrees", "laser_turned_3"),
    Lie("off-5cm", "the laser stands 5 cm beside its place", "laser_off_5cm"),
    Lie("fast-clock", "the clock of the base's controller is a tenth fast", "base_clock_fast"),
    Lie("crowd", "20 people and carts walk about the border", strangers=20),
    Lie(
        "blind-corner",
        "two robots come to a corner from both sides",
        starts=(Pose(17.5, 3.75, 0.0), Pose(21.06, 7.3, -math.pi / 2)),
    ),
    Lie("wrong-doors", "12 doors are not as the map has them", "wrong_doors"),
    Lie("steep", "four ramps of 5 degrees lie across the border", "steep"),
)


class LieError(ValueError):
    """A lie of that name does not exist; the message names those that do."""


def chosen_lies(names: Sequence[str]) -> tuple[Lie, ...]:
    """Return the lies of these names, all for none. Raises LieError."""
    return tuple(
        chosen(LIES, names, lambda name, known: LieError(f"{name} is no lie; there are {known}"))
    )
