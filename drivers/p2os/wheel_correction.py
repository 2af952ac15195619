"""Corrects the odometry that the base counts by the calibrated wheels."""

from __future__ import annotations

import math
from dataclasses import replace

from drivers.p2os.base_state import BaseState
from drivers.p2os.settings import BaseSettings


class WheelCorrection:
    """Way of each wheel by ``base.wheel_scale``, turns by ``base.track``; without both, as counted.

    The base integrates its pose with the vendor's wheels and track. From one report to the next the
    ways of the wheels follow from way and turn, are scaled, and integrated again, on an arc.
    """

    def __init__(self, settings: BaseSettings) -> None:
        self._scale = settings.wheel_scale
        self._track = settings.track
        self._counted: BaseState | None = None
        self._corrected: BaseState | None = None

    def corrected(self, counted: BaseState, turn: float) -> BaseState:
        """Return a report with pose and speeds corrected.

        turn: of the model, rad/s per m/s of half the wheels' speed difference.
        """
        if self._scale is None and self._track is None:
            return counted
        scale = self._scale or (1.0, 1.0)
        track = 2.0 / turn if self._track is None else self._track
        v_left, v_right = scale[0] * counted.v_left, scale[1] * counted.v_right
        before, last = self._counted, self._corrected
        x, y, theta = counted.x, counted.y, counted.theta
        if before is not None and last is not None:
            way, turned = _way(before, counted), counted.theta - before.theta
            left, right = scale[0] * (way - turned / turn), scale[1] * (way + turned / turn)
            way, turned = 0.5 * (left + right), (right - left) / track
            middle = last.theta + 0.5 * turned
            x, y = last.x + way * math.cos(middle), last.y + way * math.sin(middle)
            theta = last.theta + turned
        self._counted = counted
        self._corrected = replace(
            counted,
            x=x,
            y=y,
            theta=theta,
            v=0.5 * (v_left + v_right),
            w=(v_right - v_left) / track,
            v_left=v_left,
            v_right=v_right,
        )
        return self._corrected


def _way(before: BaseState, after: BaseState) -> float:
    """Return the way driven between two reports, m; negative backwards."""
    middle = 0.5 * (before.theta + after.theta)
    return (after.x - before.x) * math.cos(middle) + (after.y - before.y) * math.sin(middle)
