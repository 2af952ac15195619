"""Configured pose at the start of the agent."""

from __future__ import annotations

from typing import Annotated

import msgspec


class StartPose(msgspec.Struct, frozen=True, kw_only=True, forbid_unknown_fields=True):
    """``map_from_base`` when the agent starts, with standard deviations."""

    x: Annotated[
        float,
        msgspec.Meta(
            description="Place at the start, map frame; without [start] the robot finds itself",
            extra={"unit": "m"},
        ),
    ]
    y: Annotated[
        float, msgspec.Meta(description="Place at the start, map frame", extra={"unit": "m"})
    ]
    theta: Annotated[
        float, msgspec.Meta(description="Heading at the start, map frame", extra={"unit": "rad"})
    ]
    sigma_xy: Annotated[
        float,
        msgspec.Meta(
            gt=0.0,
            le=5.0,
            description="Standard deviation of start.x and of start.y",
            extra={"unit": "m"},
        ),
    ] = 0.2
    sigma_theta: Annotated[
        float,
        msgspec.Meta(
            gt=0.0,
            le=3.2,
            description="Standard deviation of start.theta",
            extra={"unit": "rad"},
        ),
    ] = 0.15
