"""Settings of perception that depend on the site or the team, with the team's colour."""

from __future__ import annotations

from typing import Annotated

import msgspec

from robot_agent.perception.color_settings import ColorSettings
from robot_agent.perception.silhouette import NAMED, Corners, Silhouettes, rectangle
from robot_agent.perception.visibility import VISIBILITY, VISIBILITY_MARGIN


class PerceptionSettings(msgspec.Struct, frozen=True, kw_only=True, forbid_unknown_fields=True):
    """Detection range, reflectors, and when a stranger is an intruder; m and s."""

    detection_range: Annotated[
        float,
        msgspec.Meta(
            ge=VISIBILITY + VISIBILITY_MARGIN,  # so that tracks exist before they are in range
            description="Distance up to which laser points may be a robot or a person",
            extra={"unit": "m"},
        ),
    ] = 4.0
    reflecting_bands: Annotated[
        bool, msgspec.Meta(description="Teammates wear reflecting tape at the laser's height")
    ] = False
    silhouettes: Annotated[
        tuple[str | Corners, ...],
        msgspec.Meta(
            min_length=1,
            max_length=8,
            description="What teammates look like at the laser's height: body, cut_corners, "
            "housing, or corners [[x, y], ...] in m, counter-clockwise",
        ),
    ] = NAMED
    intruder_distance: Annotated[
        float,
        msgspec.Meta(
            gt=0.0,
            description="Distance from the border within which a stranger is an intruder",
            extra={"unit": "m"},
        ),
    ] = 2.0
    intruder_time: Annotated[
        float,
        msgspec.Meta(
            gt=0.0,
            description="Time a stranger stays there before it is reported",
            extra={"unit": "s"},
        ),
    ] = 3.0
    color: ColorSettings = ColorSettings()

    def __post_init__(self) -> None:
        Silhouettes.admitted(self.silhouettes, rectangle(1.0, 1.0))  # raises ValueError
