"""Messages to the page: the changes since its last message as JSON.

Lengths in m, angles in rad, scans in cm and particles in cm and mrad (integers). Text from the
network is cut to ``TEXT_SHOWN`` here, and the page sets it as text only, never as markup.
"""

from __future__ import annotations

from collections.abc import Callable, Sequence
from functools import partial
from typing import Any

import msgspec
import numpy as np

from maps.place_words import PlaceWords
from robot_agent.messages.foxglove import LaserScan, PosesInFrame, SceneEntity, planar_pose
from robot_agent.messages.streams import ACTIONS, DecisionPayload, DeviceStatus, StatusPayload
from tools.monitor.alarm_board import Alarm
from tools.monitor.history import HistorySample
from tools.monitor.reason import turn_words, why
from tools.monitor.robot_state import RobotState
from tools.monitor.watch import Watch

TEXT_SHOWN = 200
BEAMS_SHOWN = 1000
PARTICLES_SHOWN = 500
TRACKS_SHOWN = 50
FARTHEST = 1e4  # m; larger values are clipped
_FIRST_SAMPLES = 30_000
"""Most samples of history sent to a new page, all robots together."""


def robot_message(watch: Watch, robot: RobotState, since: int) -> dict[str, Any]:
    """Return a robot's summary and the streams that changed since the team's version ``since``.

    A part that cannot be made is left out.
    """
    now = watch.now
    message: dict[str, Any] = {
        "id": robot.id,
        "team": robot.team,
        "name": robot.robot,
        "online": robot.online,
        "heard": robot.last_heard,
        "malformed": robot.malformed,
        "why": _text(watch.site.words.explained(watch.made(robot, partial(why, robot, now)) or "")),
        "turned": _text(watch.made(robot, partial(turn_words, robot, now)) or ""),
    }
    events: Callable[[RobotState], Any] = partial(_events, watch.site.words)
    for stream, make in (*_PARTS.items(), ("event", events)):
        if robot.versions.get(stream, 0) > since and stream in robot.payloads:
            part = watch.made(robot, partial(_encoded, make, robot))
            if part is not None:
                message[stream] = part
    return message


def _encoded(make: Callable[[RobotState], Any], robot: RobotState) -> msgspec.Raw:
    return msgspec.Raw(msgspec.json.encode(make(robot)))


def _text(words: str) -> str:
    return words[:TEXT_SHOWN]


def _pose(robot: RobotState) -> list[float]:
    x, y, theta = robot.poses[-1][1]
    return [round(x, 3), round(y, 3), round(theta, 4), round(robot.poses[-1][0], 3)]


def _decision(robot: RobotState) -> dict[str, Any]:
    decision = robot.decision
    assert isinstance(decision, DecisionPayload)
    neighbor = decision.neighbor
    return {
        "action": _text(decision.action),
        "direction": decision.direction,
        "border": decision.distance_from_border,
        "way": decision.way_to_border,
        "abscissa": decision.abscissa,
        "neighbor": decision.distance_from_neighbor,
        "neighborAt": None if neighbor is None else [neighbor.x, neighbor.y],
        "gamma": decision.gamma,
        "degrees": [decision.degrees.get(action, 0.0) for action in ACTIONS],
        "winner": _text(decision.winner),
        "runnerUp": _text(decision.runner_up),
        "requested": [decision.requested.v, decision.requested.w],
        "command": [decision.command.v, decision.command.w],
        "gate": None if decision.gate_reason is None else _text(decision.gate_reason),
        "blocked": decision.blocked,
        "holding": decision.holding,
        "override": None if decision.override is None else _text(decision.override),
        "heldBy": None
        if decision.held_by is None
        else [_text(decision.held_by.source), decision.held_by.x, decision.held_by.y],
    }


def _status(robot: RobotState) -> dict[str, Any]:
    status = robot.status
    assert isinstance(status, StatusPayload)
    localization = status.localization
    body = status.body
    return {
        "body": None
        if body is None
        else {"front": body.front, "rear": body.rear, "halfWidth": body.half_width},
        "laserAt": None if body is None else [body.laser_x, body.laser_y, body.laser_theta],
        "uptime": status.uptime,
        "health": _text(status.health),
        "battery": status.battery,
        "motors": status.motors_enabled,
        "stalled": status.stalled,
        "bumpers": status.bumpers,
        "base": _device(status.base, robot.rates.get("base")),
        "laser": _device(status.laser, robot.rates.get("laser")),
        "skew": robot.skew,
        "localization": {
            "health": _text(localization.health),
            "pose": None if localization.pose is None else list(_xyt(localization.pose)),
            "covariance": localization.covariance[:9],
            "particles": localization.particle_count,
            "effective": localization.effective_sample_size,
            "likelihood": localization.likelihood,
        },
    }


def _xyt(pose: Any) -> tuple[float, float, float]:
    return pose.x, pose.y, pose.theta


def _device(device: DeviceStatus, rate: float | None) -> dict[str, Any]:
    return {
        "state": _text(device.state),
        "up": device.link_up,
        "reason": _text(device.link_reason),
        "trouble": _text(device.trouble),
        "happened": _text(device.happened),
        "good": device.packets_good,
        "bad": device.packets_bad,
        "discarded": device.bytes_discarded,
        "received": device.bytes_received,
        "heard": device.last_heard,
        "rate": rate,
    }


def _scan(robot: RobotState) -> dict[str, Any] | None:
    scan = robot.scan
    assert isinstance(scan, LaserScan)
    at = robot.pose_at(scan.timestamp)
    if at is None:
        return None
    ranges = np.array(scan.ranges[:BEAMS_SHOWN])
    beams = max(len(scan.ranges) - 1, 1)
    return {
        "at": [round(value, 4) for value in at],
        "start": scan.start_angle,
        "step": (scan.end_angle - scan.start_angle) / beams,
        "ranges": (100.0 * np.clip(ranges, 0.0, FARTHEST)).astype(int).tolist(),
    }


def _particles(robot: RobotState) -> list[int]:
    particles = robot.particles
    assert isinstance(particles, PosesInFrame)
    rows = np.array([planar_pose(pose) for pose in particles.poses[:PARTICLES_SHOWN]])
    scaled = np.clip(rows.reshape(-1, 3), -FARTHEST, FARTHEST) * (100.0, 100.0, 1000.0)
    flat: list[int] = scaled.astype(int).ravel().tolist()
    return flat


def _tracks(robot: RobotState) -> list[dict[str, Any]]:
    scene = robot.tracks
    assert scene is not None
    return [_track(entity) for entity in scene.entities[:TRACKS_SHOWN] if entity.cylinders]


def _track(entity: SceneEntity) -> dict[str, Any]:
    cylinder = entity.cylinders[0]
    heading, speed = 0.0, 0.0
    if entity.arrows:
        heading = planar_pose(entity.arrows[0].pose).theta
        speed = entity.arrows[0].shaft_length
    return {
        "id": _text(entity.id),
        "kind": _text(track_kind(entity)),
        "x": cylinder.pose.position.x,
        "y": cylinder.pose.position.y,
        "size": cylinder.size.x,
        "heading": heading,
        "speed": speed,
    }


def track_kind(entity: SceneEntity) -> str:
    """Return a track's kind: as its metadata states, by default teammate or stranger."""
    facts = {pair.key: pair.value for pair in entity.metadata}
    if "kind" in facts:
        return facts["kind"]
    return "teammate" if facts.get("teammate") == "true" else "stranger"


def _process(robot: RobotState) -> dict[str, Any]:
    process = robot.process
    assert process is not None
    return {
        "cpu": process.cpu,
        "memory": process.memory_mb,
        "late": process.lateness_max,
        "dropped": process.telemetry_dropped,
        "lost": process.recorder_lost,
    }


def _events(words: PlaceWords, robot: RobotState) -> list[list[Any]]:
    return [
        [
            round(event.wall, 1),
            event.log.level,
            _text(event.log.name),
            words.explained(_text(event.log.message)),
        ]
        for event in robot.events
    ]


_PARTS: dict[str, Callable[[RobotState], Any]] = {
    "pose": _pose,
    "decision": _decision,
    "status": _status,
    "scan": _scan,
    "particles": _particles,
    "tracks": _tracks,
    "process": _process,
}


def alarm_message(alarm: Alarm) -> dict[str, Any]:
    """Return one alarm for the page, times in s since 1970, places in m in the map frame."""
    sighting = alarm.sighting
    place = alarm.place if sighting is None else sighting.place
    return {
        "number": alarm.number,
        "robot": alarm.robot,
        "kind": alarm.kind,
        "severity": alarm.severity.name.lower(),
        "text": _text(alarm.text),
        "raised": round(alarm.raised_wall, 1),
        "cleared": None if alarm.cleared_wall is None else round(alarm.cleared_wall, 1),
        "acknowledged": alarm.acknowledged,
        "by": alarm.acknowledged_by,
        "place": None if place is None else [round(at, 2) for at in place],
        "seen": None if sighting is None else round(sighting.wall, 1),
        "picture": 0 if sighting is None else len(sighting.picture),
    }


def page_samples(samples: Sequence[HistorySample]) -> list[list[float]]:
    """Return a robot's samples for the page: wall time, x, y, distance, action."""
    return [
        [round(s.wall, 1), round(s.x, 2), round(s.y, 2), round(s.distance, 3), s.action]
        for s in samples
    ]


class PageFeed:
    """The messages of one page: tracks what was already sent to it."""

    def __init__(self, watch: Watch) -> None:
        """Start with nothing sent: the first message holds everything."""
        self._watch = watch
        self._version = 0
        self._shown: list[str] = []
        self._why: dict[str, str] = {}
        self._alarms: tuple[int, int] | None = None
        self._samples: dict[str, int] = {}
        self._covered_at = float("-inf")

    def message(self, extra: dict[str, Any]) -> bytes:
        """Return the next message as JSON, with ``extra`` in it, and count it as sent."""
        watch = self._watch
        message: dict[str, Any] = {"now": watch.now, "wall": watch.wall, **extra}
        newest = self._version
        robots = []
        for robot in watch.robots:
            part = robot_message(watch, robot, self._version)
            samples = self._new_samples(robot.id)
            if samples:
                part["history"] = samples
            if robot.version > self._version or samples or self._why.get(robot.id) != part["why"]:
                robots.append(part)
            self._why[robot.id] = part["why"]
            newest = max(newest, robot.version)
        self._version = newest
        message["robots"] = robots
        shown = [robot.id for robot in watch.robots]
        if shown != self._shown:
            message["shown"] = self._shown = shown
            for gone in (self._why.keys() | self._samples.keys()) - set(shown):
                self._why.pop(gone, None)
                self._samples.pop(gone, None)
        board = watch.alarms
        if self._alarms != (id(board), board.version):
            self._alarms = (id(board), board.version)
            message["alarms"] = [alarm_message(alarm) for alarm in board.alarms()]
        coverage = watch.coverage
        if coverage is not None and watch.now - self._covered_at >= 1.0:
            self._covered_at = watch.now
            message["coverage"] = {
                "idle": coverage.idle(watch.now).astype(int).tolist(),
                "seen": coverage.seen().astype(int).tolist(),
                "average": round(coverage.average(watch.now), 1),
                "worst": round(coverage.worst(watch.now), 1),
            }
        return msgspec.json.encode(message)

    def _new_samples(self, robot: str) -> list[list[float]]:
        history = self._watch.histories.get(robot)
        if history is None:
            return []
        limit = _FIRST_SAMPLES // max(len(self._watch.robots), 1)
        samples = history.since(self._samples.get(robot, 0), limit)
        self._samples[robot] = history.count
        return page_samples(samples)
