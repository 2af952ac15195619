"""Builder of telemetry payloads from the agent's state, each stream at its own rate.

Rates follow the events' times, so that a replay publishes the same payloads.
"""

from __future__ import annotations

import math
from collections.abc import Sequence
from typing import Any

import numpy as np

from drivers.p2os.base_state import BaseState
from drivers.p2os.session import SessionState
from drivers.scan import Scan
from drivers.scanner import DOWN, STREAMING
from localization.health import Health
from maps.map_folder import MapFolder
from maps.map_identity import HASH_SHOWN, identity
from maps.pose import Pose
from robot_agent.messages.events import LinkName
from robot_agent.messages.foxglove import (
    Log,
    PoseInFrame,
    SceneUpdate,
    Timestamp,
    laser_scan,
    pose3,
    poses_in_frame,
    timestamp_at,
    track_entity,
)
from robot_agent.messages.notice import Notice
from robot_agent.messages.streams import (
    BodyPayload,
    CameraReport,
    DecisionPayload,
    DeviceStatus,
    HeldBy,
    IntruderPayload,
    LocalizationStatus,
    Payload,
    PlanarPose,
    StatusPayload,
    Twist,
    Velocity,
)
from robot_agent.motion.gate import GateDecision
from robot_agent.motion.gate_reason import GateReason
from robot_agent.motion.holding_obstacle import HoldingObstacle
from robot_agent.patrol.patrol import PatrolDecision
from robot_agent.perception.intruders import Intruder
from robot_agent.perception.track import Track
from robot_agent.report.agent_state import AgentState
from robot_agent.report.device_watch import DeviceWatch
from robot_agent.report.health_summary import HealthSummary

STATUS_PERIOD_S = 0.5
SCAN_PERIOD_S = 0.2
PARTICLES_PERIOD_S = 0.5
INTRUDER_PERIOD_S = 1.0
PARTICLES_SHOWN = 200


class RateLimit:
    """Rate limiter: at most one payload per period."""

    def __init__(self, period: float) -> None:
        """period: s."""
        self._period = period
        self._next = -math.inf

    def due(self, t: float) -> bool:
        """Return whether a payload is due at t; if so, the next one is due a period later."""
        if t < self._next:
            return False
        self._next = t + self._period
        return True


class LinkReport:
    """State of one link besides its session: whether it is open, bytes received.

    reason: why it is not open. last_heard: time of the latest complete measurement, None before.
    """

    def __init__(self) -> None:
        self.up = False
        self.reason = "not opened yet"
        self.bytes_received = 0
        self.last_heard: float | None = None

    def opened(self) -> None:
        """Record that the port is open."""
        self.up, self.reason = True, ""

    def lost(self, reason: str) -> None:
        """Record that the port is not open, with the reason."""
        self.up, self.reason = False, reason


class TelemetryBuilder:
    """Builds the payloads for the operator and the recording from an agent's state."""

    def __init__(
        self,
        robot: str,
        team: str,
        folder: MapFolder,
        state: AgentState,
        health: HealthSummary,
        start_wall_ns: int,
    ) -> None:
        """Start with all links down.

        robot, team: names in the payloads. folder: the map, perhaps without a border.
        start_wall_ns: wall clock at agent time 0, ns since 1970.
        """
        self._robot = robot
        self._team = team
        self._border = folder.border
        self._map_hash, self._border_hash = (text[:HASH_SHOWN] for text in identity(folder.files))
        self._state = state
        self._health = health
        self._start_wall_ns = start_wall_ns
        self._status_rate = RateLimit(STATUS_PERIOD_S)
        self._scan_rate = RateLimit(SCAN_PERIOD_S)
        self._particles_rate = RateLimit(PARTICLES_PERIOD_S)
        self.links: dict[LinkName, LinkReport] = {"base": LinkReport(), "laser": LinkReport()}
        self.devices: dict[LinkName, DeviceWatch] = {
            "base": DeviceWatch("base", SessionState.READY, SessionState.DOWN),
            "laser": DeviceWatch("laser", STREAMING, DOWN),
        }
        self._intruder_rate = RateLimit(INTRUDER_PERIOD_S)
        self._last_words: dict[str, str] = {}

    def on_bytes(self, link: LinkName, t: float, data: bytes, *, understood: bool) -> None:
        """Count bytes that arrived on a link at t; understood: they completed a measurement."""
        report = self.links[link]
        report.bytes_received += len(data)
        if understood:
            report.last_heard = t

    def on_time(self, t: float) -> list[tuple[str, Payload]]:
        """Return the status payload if due at t."""
        return [("status", self._status(t))] if self._status_rate.due(t) else []

    def on_scan(self, t: float, scan: Scan) -> list[tuple[str, Payload]]:
        """Return the payloads of scan, tracks and particles that are due at t."""
        stamp = self._stamp(t)
        payloads: list[tuple[str, Payload]] = []
        if self._scan_rate.due(t):
            payloads.append(("scan", self._scan(scan)))
            payloads.append(("tracks", self._tracks(stamp)))
        if self._state.pose_tracker.localizer.estimate is not None and self._particles_rate.due(t):
            payloads.append(("particles", self._particles(stamp)))
        return payloads

    def on_decision(
        self,
        t: float,
        pose: Pose,
        decision: PatrolDecision,
        requested: tuple[float, float],
        gate: GateDecision,
        neighbor: Track | None,
        held_by: HoldingObstacle | None = None,
    ) -> list[tuple[str, Payload]]:
        """Return the pose and decision payloads of one control step.

        pose: map_from_base. requested: (v m/s, w rad/s) before the gate. neighbor: the closest
        teammate, None without one. held_by: None unless the gate cut the request for an obstacle.
        """
        stamp = self._stamp(t)
        payload = DecisionPayload(
            timestamp=stamp,
            robot=self._robot,
            action=decision.action,
            direction=decision.direction,
            distance_from_border=decision.distance_from_border,
            way_to_border=_finite(decision.way_to_border),
            abscissa=decision.abscissa,
            distance_from_neighbor=_finite(decision.distance_from_neighbor),
            neighbor=_bearing_pose(pose, neighbor),
            **self._on_border(neighbor),
            gamma=decision.gamma,
            degrees={str(action): degree for action, degree in decision.degrees.items()},
            winner=decision.raw_winner,
            runner_up=decision.runner_up,
            pose=PlanarPose(*pose),
            velocity=Velocity(*decision.velocity),
            requested=Twist(*requested),
            command=Twist(gate.v, gate.w),
            gate_reason=None if gate.reason is GateReason.NONE else str(gate.reason),
            blocked=decision.blocked,
            holding=decision.holding,
            held_by=_place_of(held_by, pose),
            override=decision.override,
            turn=decision.turn,
        )
        in_frame = PoseInFrame(timestamp=stamp, frame_id="map", pose=pose3(pose))
        return [("pose", in_frame), ("decision", payload)]

    def on_intruder(
        self, t: float, intruder: Intruder, *, scan: Sequence[float] = (), picture: str = ""
    ) -> list[tuple[str, Payload]]:
        """Return the payload of an intruder, with evidence if given.

        scan: x, y, x, y, ..., m, map frame; picture: JPEG in base64.
        """
        payload = IntruderPayload(
            timestamp=self._stamp(t),
            robot=self._robot,
            number=intruder.number,
            x=round(intruder.x, 3),
            y=round(intruder.y, 3),
            abscissa=round(intruder.abscissa, 3),
            distance=round(intruder.distance, 3),
            closest=round(intruder.closest, 3),
            first_seen=self._stamp(intruder.first_seen),
            last_seen=self._stamp(intruder.last_seen),
            scan=list(scan),
            picture=picture,
        )
        return [("intruder", payload)]

    def on_intruders(self, t: float, known: Sequence[Intruder]) -> list[tuple[str, Payload]]:
        """Return the payloads of the intruders still seen, if due at t."""
        fresh = [each for each in known if t - each.last_seen < INTRUDER_PERIOD_S]
        if not fresh or not self._intruder_rate.due(t):
            return []
        return [payload for each in fresh for payload in self.on_intruder(t, each)]

    def on_notice(self, notice: Notice) -> list[tuple[str, Payload]]:
        """Return the event of a notice; nothing if its text equals the last one of its part."""
        if self._last_words.get(notice.part) == notice.words:
            return []
        self._last_words[notice.part] = notice.words
        stamp = self._stamp(notice.t)
        log = Log(timestamp=stamp, level=notice.level, message=notice.words, name=notice.part)
        return [("event", log)]

    def _stamp(self, t: float) -> Timestamp:
        return timestamp_at(t, self._start_wall_ns)

    def _status(self, t: float) -> StatusPayload:
        base = self._state.pose_tracker.odometry.latest
        return StatusPayload(
            timestamp=self._stamp(t),
            robot=self._robot,
            team=self._team,
            uptime=t,
            health=self._health.health(),
            map_hash=self._map_hash,
            border_hash=self._border_hash,
            body=self._body(),
            battery=None if base is None else base.battery,
            motors_enabled=base is not None and base.motors_enabled,
            stalled=base is not None and (base.stall_left or base.stall_right),
            bumpers=_bumpers(base),
            base=self._device(t, "base"),
            laser=self._device(t, "laser"),
            camera=self._camera(t),
            degraded=self._health.degraded(t),
            localization=self._localization(),
        )

    def _body(self) -> BodyPayload:
        body, mount = self._state.base.model.body, self._state.laser_mount
        return BodyPayload(body.front, body.rear, 0.5 * body.width, *mount)

    def _device(self, t: float, link: LinkName) -> DeviceStatus:
        session = self._state.base if link == "base" else self._state.laser
        report = self.links[link]
        counters = session.framer.counters
        return DeviceStatus(
            state=session.state,
            trouble=session.trouble or "",
            counters=self.devices[link].counters(session),
            link_up=report.up,
            link_reason=report.reason,
            packets_good=counters.good,
            packets_bad=counters.bad_checksum,
            bytes_discarded=counters.discarded_bytes,
            bytes_received=report.bytes_received,
            last_heard=None if report.last_heard is None else round(t - report.last_heard, 3),
        )

    def _camera(self, t: float) -> CameraReport | None:
        camera = self._state.perception.camera
        if not camera.exists:
            return None
        latest = camera.latest
        return CameraReport(
            state=camera.state(t),
            link_reason=camera.reason,
            pictures=camera.pictures,
            bands=0 if latest is None else len(latest.blobs),
            last_heard=None if latest is None else round(t - latest.t, 3),
        )

    def _on_border(self, neighbor: Track | None) -> dict[str, Any]:
        """Return the payload fields of the neighbor's border coordinates and their sigmas."""
        border = self._border
        if neighbor is None or border is None:
            return {}
        foot = border.project(neighbor.x, neighbor.y)
        tangent = np.array(foot.tangent)
        normal = np.array((-tangent[1], tangent[0]))
        P = neighbor.covariance
        return {
            "neighbor_border_distance": foot.distance,
            "neighbor_abscissa": foot.abscissa,
            "neighbor_sigma": [
                math.sqrt(float(normal @ P @ normal)),
                math.sqrt(float(tangent @ P @ tangent)),
            ],
        }

    def _localization(self) -> LocalizationStatus:
        estimate = self._state.pose_tracker.localizer.estimate
        if estimate is None:
            return LocalizationStatus(health=Health.LOST)
        return LocalizationStatus(
            health=estimate.health,
            pose=PlanarPose(*estimate.pose),
            covariance=estimate.covariance.ravel().tolist(),
            particle_count=estimate.particle_count,
            effective_sample_size=estimate.effective_sample_size,
            likelihood=estimate.likelihood,
        )

    def _scan(self, scan: Scan) -> Payload:
        return laser_scan(
            self._stamp(scan.t), "laser", scan.angle_min, scan.angle_increment, scan.ranges
        )

    def _tracks(self, stamp: Timestamp) -> Payload:
        perception = self._state.perception
        intruders = (
            {each.track for each in perception.intruders.known} if perception.intruders else set()
        )
        return SceneUpdate(
            entities=[
                track_entity(
                    stamp,
                    track.id,
                    (track.x, track.y),
                    (track.vx, track.vy),
                    kind="intruder" if track.id in intruders else track.kind,
                    probability=max(
                        track.probabilities.teammate,
                        track.probabilities.stranger,
                        track.probabilities.unknown,
                    ),
                )
                for track in perception.tracker.tracks
            ]
        )

    def _particles(self, stamp: Timestamp) -> Payload:
        particles = self._state.pose_tracker.localizer.particles
        step = math.ceil(len(particles) / PARTICLES_SHOWN)
        return poses_in_frame(stamp, "map", np.asarray(particles[::step], dtype=np.float64))


def _finite(value: float) -> float | None:
    return value if math.isfinite(value) else None


def _bearing_pose(pose: Pose, neighbor: Track | None) -> PlanarPose | None:
    """Return the teammate's position, with its bearing from the robot as theta; map frame."""
    if neighbor is None:
        return None
    x, y = neighbor.x, neighbor.y
    return PlanarPose(x, y, math.atan2(y - pose.y, x - pose.x))


def _place_of(obstacle: HoldingObstacle | None, pose: Pose) -> HeldBy | None:
    """Return an obstacle's source and position in the map frame; pose: map_from_base."""
    if obstacle is None:
        return None
    c, s = math.cos(pose.theta), math.sin(pose.theta)
    x = pose.x + c * obstacle.x - s * obstacle.y
    y = pose.y + s * obstacle.x + c * obstacle.y
    return HeldBy(obstacle.source, round(x, 3), round(y, 3))


def _bumpers(base: BaseState | None) -> int:
    return 0 if base is None else base.front_bumpers | base.rear_bumpers << 8
