"""Payloads of a robot without faults, for tests; keyword arguments change their fields."""

from __future__ import annotations

from typing import Any

import msgspec

from maps.pose import Pose
from robot_agent.messages.foxglove import PoseInFrame, pose3, timestamp_at
from robot_agent.messages.streams import (
    ACTIONS,
    DecisionPayload,
    DeviceStatus,
    LocalizationStatus,
    PlanarPose,
    StatusPayload,
    Twist,
    Velocity,
)


def device(state: str, **changes: Any) -> DeviceStatus:
    defaults = DeviceStatus(
        state=state,
        link_up=True,
        packets_good=100,
        packets_bad=0,
        bytes_discarded=0,
        bytes_received=2000,
    )
    return msgspec.structs.replace(defaults, **changes)


def status(t: float, **changes: Any) -> StatusPayload:
    defaults = StatusPayload(
        timestamp=timestamp_at(t),
        robot="anna",
        team="north",
        uptime=100.0 + t,
        health="ok",
        battery=12.8,
        motors_enabled=True,
        base=device("ready"),
        laser=device("streaming"),
        localization=LocalizationStatus(health="localized"),
    )
    return msgspec.structs.replace(defaults, **changes)


def decision(t: float, **changes: Any) -> DecisionPayload:
    defaults = DecisionPayload(
        timestamp=timestamp_at(t),
        robot="anna",
        action="keep_going",
        direction=1,
        distance_from_border=0.02,
        way_to_border=0.02,
        abscissa=3.0,
        degrees=dict.fromkeys(ACTIONS, 0.2),
        winner="keep_going",
        runner_up="patrol_clockwise",
        pose=PlanarPose(1.0, 2.0, 0.0),
        velocity=Velocity(0.35, 0.0),
        requested=Twist(0.35, 0.0),
        command=Twist(0.35, 0.0),
    )
    return msgspec.structs.replace(defaults, **changes)


def pose(t: float, x: float = 1.0, y: float = 2.0, theta: float = 0.0) -> PoseInFrame:
    return PoseInFrame(timestamp=timestamp_at(t), frame_id="map", pose=pose3(Pose(x, y, theta)))
