"""Where the robot stands when its agent starts."""

from __future__ import annotations

from typing import Annotated

import msgspec


class StartPose(msgspec.Struct, frozen=True, kw_only=True, forbid_unknown_fields=True):
    """``map_from_base`` when the agent starts, and how sure that is."""

    x: float
    """m"""
    y: float
    """m"""
    theta: float
    """rad"""
    sigma_xy: Annotated[float, msgspec.Meta(gt=0.0, le=5.0)] = 0.2
    """Standard deviation of x and of y, m."""
    sigma_theta: Annotated[float, msgspec.Meta(gt=0.0, le=3.2)] = 0.15
    """Standard deviation of theta, rad."""
