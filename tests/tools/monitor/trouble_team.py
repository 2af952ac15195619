"""Telemetry of a patrolling team of which some are in trouble, and a stranger; any size.

Robot 3 is blind (its laser unplugged), robot 5 is away (out of reach of the network), robot 7 dead
(its computer hangs), robot 2 reports an intruder with a picture, robot 4 patrols on another map.
"""

from __future__ import annotations

import base64
import math
from collections.abc import Iterator
from pathlib import Path

import cv2
import numpy as np

from maps.border import Border
from maps.pose import Pose
from maps.zone_file import load_zones
from robot_agent.config import find_map
from robot_agent.messages.foxglove import (
    Log,
    PoseInFrame,
    SceneUpdate,
    laser_scan,
    pose3,
    poses_in_frame,
    timestamp_at,
    track_entity,
)
from robot_agent.messages.log_level import LogLevel
from robot_agent.messages.streams import (
    ACTIONS,
    IntruderPayload,
    Payload,
    PlanarPose,
    Twist,
    encode,
)
from tests.tools.monitor.agent_recordings import FOLDER, START
from tests.tools.monitor.reports import decision, device, status
from tools.monitor.site import Site
from tools.monitor.team_recorder import TeamRecorder

TROUBLE_AT = 40.0
"""s after the start at which all trouble begins."""
SPEED = 0.35  # m/s
BLIND, AWAY, DEAD, WITNESS, ELSEWHERE = 3, 5, 7, 2, 4
STEP = 0.2  # s between two of a robot's decisions
INTRUDER = (9.5, 14.6)  # m, map frame


def place_at(border: Border, robot: int, robots: int, t: float) -> tuple[float, Pose]:
    """Return s and pose of a robot that patrols clockwise at t, evenly spaced."""
    s = (border.length * (robot - 0.5) / robots + SPEED * t) % border.length
    point = border.at(s)
    return s, Pose(point.x, point.y, math.atan2(point.ty, point.tx))


def team_payloads(robots: int, seconds: float) -> Iterator[tuple[float, str, Payload]]:
    """Yield time (s from the start), telemetry key and payload, in order of time."""
    assert FOLDER.border is not None
    for step in range(round(seconds / STEP)):
        t = STEP * step
        for robot in range(1, robots + 1):
            key = f"patrol/north/robot{robot}"
            for stream, payload in robot_payloads(FOLDER.border, robot, robots, t, step):
                yield t, f"{key}/{stream}", payload


def robot_payloads(
    border: Border, robot: int, robots: int, t: float, step: int
) -> Iterator[tuple[str, Payload]]:
    """Yield streams and payloads of one robot at t."""
    trouble = t >= TROUBLE_AT
    if trouble and robot in (AWAY, DEAD):
        return
    blind = trouble and robot == BLIND
    stands = t if not blind else TROUBLE_AT
    s, at = place_at(border, robot, robots, stands)
    stamp, wall = timestamp_at(START + t), START + t
    action = "avoid_teammate" if robot % 3 == 0 else "keep_going"
    yield "pose", PoseInFrame(timestamp=stamp, frame_id="map", pose=pose3(at))
    yield (
        "decision",
        decision(
            wall,
            robot=f"robot{robot}",
            action=action,
            distance_from_border=0.02 + 0.01 * (robot % 4),
            abscissa=s,
            degrees={name: 0.8 if name == action else 0.15 for name in ACTIONS},
            winner=action,
            pose=PlanarPose(*at),
            command=Twist(0.0 if blind else SPEED, 0.0),
            gate_reason="stale_laser" if blind else None,
        ),
    )
    if blind and step % 10 == 0:
        words = Log(
            timestamp=stamp, level=LogLevel.ERROR, message="none for 0.4 s", name="trust.laser"
        )
        yield "event", words
    if step % 3 == 0:
        yield (
            "status",
            robot_status(robot, t, blind=blind, elsewhere=trouble and robot == ELSEWHERE),
        )
        spread = np.random.default_rng(robot).normal(0.0, (0.03, 0.03, 0.02), (60, 3))
        yield "particles", poses_in_frame(stamp, "map", np.array(at) + spread)
    if not blind:
        ranges = np.full(91, 2.5) + 0.3 * np.sin(np.arange(91) / 7.0 + robot)
        yield "scan", laser_scan(stamp, "laser", -math.pi / 2, math.pi / 90, ranges)
    if trouble and robot == WITNESS and t < TROUBLE_AT + 5.0:
        entity = track_entity(stamp, 7, INTRUDER, (0.0, 0.0), kind="intruder", probability=0.9)
        yield "tracks", SceneUpdate(entities=[entity])
        if step % 5 == 0:
            yield "intruder", intruder(t)


def robot_status(robot: int, t: float, *, blind: bool, elsewhere: bool) -> Payload:
    """Return the status of a robot that is well, or has its trouble."""
    map_hash, border_hash = Site(FOLDER).hashes
    unplugged = device("down", link_up=False, link_reason="unplugged")
    return status(
        START + t,
        robot=f"robot{robot}",
        uptime=100.0 + t,
        health="laser" if blind else "ok",
        battery=12.9 - 0.02 * robot,
        laser=unplugged if blind else device("streaming", packets_good=int(1000 + 10 * t)),
        base=device("ready", packets_good=int(1000 + 10 * t)),
        map_hash="another map" if elsewhere else map_hash,
        border_hash=border_hash,
    )


def intruder(t: float) -> IntruderPayload:
    """Return the report of the intruder, with a picture."""
    stamp = timestamp_at(START + t)
    return IntruderPayload(
        timestamp=stamp,
        robot=f"robot{WITNESS}",
        number=1,
        x=INTRUDER[0],
        y=INTRUDER[1],
        abscissa=5.5,
        distance=0.9,
        closest=0.8,
        first_seen=timestamp_at(START + TROUBLE_AT),
        last_seen=stamp,
        picture=base64.b64encode(picture()).decode(),
    )


def picture() -> bytes:
    """Return a picture of somebody, JPEG."""
    image = np.full((90, 120, 3), (120, 110, 100), np.uint8)
    cv2.rectangle(image, (50, 35), (70, 85), (40, 40, 160), -1)
    cv2.circle(image, (60, 25), 10, (150, 180, 220), -1)
    return cv2.imencode(".jpg", image)[1].tobytes()


def trouble_recording(path: Path, robots: int, seconds: float) -> Path:
    """Write a monitor's recording of the team."""
    recorder = TeamRecorder(path, FOLDER, "border", load_zones(find_map(FOLDER.name, Path())))
    for t, key, payload in team_payloads(robots, seconds):
        recorder.on_payload(key, encode(payload), START + t)
    recorder.close()
    assert not recorder.lost
    return path
