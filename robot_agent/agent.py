"""The agent: a pure function of configuration, map, seed and the events so far.

``Agent.handle(event)`` does no I/O, reads no clock and starts no thread; the caller delivers the
bytes and carries out the effects. The same event list gives the same effects, bit for bit.
"""

from __future__ import annotations

import math

import msgspec
import numpy as np
from numpy.typing import NDArray

from drivers.p2os.base_state import BaseState
from drivers.p2os.model import RobotModel
from drivers.p2os.motor_watch import MotorState
from drivers.p2os.session import P2osSession
from drivers.scan import Scan
from drivers.scanner import ScannerSession, look_period, scanner_session
from localization.health import Health
from localization.localizer import Localizer
from localization.settings import MotionNoise
from maps.approach_field import BodySize
from maps.map_folder import MapFolder
from maps.pose import Pose
from robot_agent.config import AgentConfig
from robot_agent.messages.effects import Effect, TakePicture
from robot_agent.messages.events import (
    BlobsSeen,
    BytesReceived,
    DeviceName,
    Event,
    LinkDown,
    LinkName,
    LinkUp,
    OperatorKey,
    PictureTaken,
    Shutdown,
    Tick,
)
from robot_agent.messages.log_level import LogLevel
from robot_agent.messages.notice import Notice
from robot_agent.messages.outbox import Outbox, published
from robot_agent.motion.footprint import Footprint
from robot_agent.motion.gate import GateDecision, GateInputs, SafetyGate
from robot_agent.motion.gate_hold import (
    begins_hold,
    held_by_obstacle,
    pinned_by_obstacle,
)
from robot_agent.motion.gate_reason import STANDING, GateReason
from robot_agent.motion.gate_settings import gate_limits
from robot_agent.motion.heading_loop import HeadingLoop
from robot_agent.motion.holding_obstacle import HoldingObstacle, holding_obstacle
from robot_agent.motion.obstacle_points import NO_OBSTACLES, ObstaclePoints
from robot_agent.motion.recovery_turn import RecoveryTurn
from robot_agent.motion.sensor_freshness import SensorFreshness
from robot_agent.motion.teleop import Teleop
from robot_agent.motion.unpinning import UnpinningManoeuvre
from robot_agent.obstacles.own_parts_watch import OwnPartsWatch
from robot_agent.obstacles.surroundings import Surroundings
from robot_agent.patrol.common_clock import common_clock
from robot_agent.patrol.patrol import Patrol, PatrolDecision
from robot_agent.perception.perception import NewIntruder, Perception
from robot_agent.perception.scan_points import ScanProjector
from robot_agent.perception.silhouette import body_corners
from robot_agent.pose.pose_memory import PoseMemory
from robot_agent.pose.pose_tracker import PoseTracker
from robot_agent.report.health_summary import HealthSummary
from robot_agent.report.notices import (
    gate_notice,
    intruder_notice,
    laser_health_notice,
    override_notice,
    own_parts_notice,
    scale_notice,
    travel_notice,
    way_notice,
)
from robot_agent.report.telemetry_builder import TelemetryBuilder


class Agent:
    """One robot's control stack: drivers, localization, perception, patrol, gate, telemetry."""

    def __init__(
        self,
        config: AgentConfig,
        folder: MapFolder,
        start_wall_ns: int = 0,
        *,
        publishes: bool = True,
    ) -> None:
        """Build every stage; emits no effect before the first event.

        folder: the map; without a border in it the agent localizes and tracks, but never moves.
        publishes: whether telemetry is published. Without, the agent sends the same bytes to the
        devices in less time (for benches). Raises RulesError for an unusable rule file and
        BorderError for a border with too tight turns.
        """
        rng = np.random.default_rng(config.robot.seed)
        self.config = config
        self.border = folder.border
        self.outbox = Outbox()
        self.publishes = publishes
        self.health_summary = HealthSummary(self)
        self.telemetry = TelemetryBuilder(
            config.robot.name,
            config.robot.team,
            folder,
            self,
            self.health_summary,
            start_wall_ns,
        )
        # Devices.
        self.base = P2osSession(config.base)
        self.laser = scanner_session(config.laser)
        # State estimation.
        self.freshness = SensorFreshness()
        self.localizer = Localizer(config.localization, folder.map, rng)
        self.pose_tracker = PoseTracker(
            self.localizer,
            PoseMemory(config.memory),
            self.base,
            self.outbox,
            start=config.start,
            remembered=config.remembered,
        )
        self.odometry = self.pose_tracker.odometry
        self.perception = Perception(
            *(config.perception, config.camera, folder),
            body_corners(self.base.model.body),
            config.laser.housing,
        )
        self.own_parts = OwnPartsWatch()
        # Decision and control.
        clock = common_clock(start_wall_ns, config.patrol.clock_drift)
        self.patrol = (
            Patrol(config.patrol, folder.border, rng, clock=clock) if folder.border else None
        )
        self._folder = folder
        self._use_model(self.base.model)
        self.heading_loop = HeadingLoop()
        self.unpinning = UnpinningManoeuvre()
        self.teleop = Teleop() if config.teleop.enabled else None
        self.recovery = RecoveryTurn()
        self.decision: PatrolDecision | None = None
        self.gate_decision: GateDecision | None = None
        self.gate_stops = 0
        self.warnings: dict[str, str] = {}
        """Words of the present warnings and errors by part; empty while all is well."""
        self._look_period = look_period(config.laser)
        self._next_look = -math.inf  # s; the first scan after it is used for more than obstacles
        self._obstacles = NO_OBSTACLES  # of the last gate decision
        self._ending = False
        self._was_degraded = False
        self._now = 0.0  # latest event time so far, at which events handled late are judged

    def handle(self, event: Event) -> list[Effect]:
        """Process one event; return its effects in the order to carry them out."""
        self._now = max(self._now, event.t)
        match event:
            case BytesReceived(t, "base", data):
                self._on_base_bytes(t, data)
            case BytesReceived(t, "laser", data):
                self._on_laser_bytes(t, data)
            case Tick(t):
                self._tick(t)
            case BlobsSeen():
                self.perception.on_blobs(event, self.pose_tracker.localized_pose_at(event.taken))
            case PictureTaken():
                self._on_picture(event)
            case LinkUp(t, link):
                self._link_up(t, link)
            case LinkDown(t, link, reason):
                self._link_down(t, link, reason)
            case OperatorKey() if self.teleop is not None:
                self.teleop.press(event)
            case Shutdown(t):
                self._shut_down(t)
        self.outbox.request("base", self.base.pop_requests())
        self.outbox.request("laser", self.laser.pop_requests())
        return self._pop_effects()

    def _use_model(self, model: RobotModel) -> None:
        """Build what depends on the robot's geometry; every stage takes it from this one model."""
        config = self.config
        self._model = model
        self._limits = gate_limits(config.gate, model, config.laser.scan_period)
        self.localizer.use_noise(MotionNoise(**msgspec.structs.asdict(model.odometry_noise)))
        self._laser_settings = config.laser.mounted(upside_down=model.laser.upside_down)
        laser = self._laser_settings.mounted(
            upside_down=model.laser.upside_down, ignore=model.laser.ignore
        )
        self.laser.remount(laser)
        self.laser_mount = Pose(*(laser.mount or model.laser_mount))
        self._projector = ScanProjector(self.laser_mount, laser.ignored, Footprint(self._limits))
        self._forget_own_parts()
        self.surroundings = Surroundings(
            self._projector,
            self._limits,
            model,
            self._folder.map,
            self.perception.tracker.unexplained,
        )
        middle = 0.5 * (model.body.front - model.body.rear)
        self.perception.use_body(body_corners(model.body), self.laser_mount.x - middle)
        self.gate = SafetyGate(self._limits)
        if self.patrol is not None:
            size = BodySize(model.body.corner_reach, 0.5 * model.body.width)
            self.patrol.use_approach_field(self._folder.approach_field_of(size))

    def _forget_own_parts(self) -> None:
        self.own_parts.restart()
        self.own_parts_stand_out = False
        """Whether the laser sees parts of the robot that stand out of its footprint."""
        self._projector.hide(())

    @property
    def scan_seen_at(self) -> float | None:
        """Measurement time of the latest accepted scan; None before the first."""
        return self.surroundings.seen_at

    @property
    def scan_heard_at(self) -> float | None:
        """Arrival of the latest scan, accepted or not; None before the first."""
        return self.telemetry.links["laser"].last_heard

    def _pop_effects(self) -> list[Effect]:
        """Return the queued effects; a notice becomes a log event if its text has changed."""
        effects: list[Effect] = []
        for item in self.outbox.pop_all():
            if not isinstance(item, Notice):
                effects.append(item)
                continue
            self._note(item)
            if self.publishes:
                effects += published(self.telemetry.on_notice(item))
        return effects

    def _note(self, notice: Notice) -> None:
        """Keep a warning until its part reports something better."""
        if notice.level >= LogLevel.WARNING:
            self.warnings[notice.part] = notice.words
        else:
            self.warnings.pop(notice.part, None)

    # --- input -------------------------------------------------------------------------------

    def _tick(self, t: float) -> None:
        """Run what depends on time alone: timeouts, alarms, periodic telemetry."""
        self.freshness.tick(t)
        self.base.tick(t)
        self.laser.tick(t)
        self._expire(t)
        if not self._ending:  # else all falls silent as it should
            self.outbox.add(*self.freshness.changes(t))
            self._tell_of_devices(t)
            self._log_degraded(t)
        if self.publishes:
            self.outbox.publish(self.telemetry.on_time(t))

    def _tell_of_devices(self, t: float) -> None:
        """Tell people what the sessions wait for, their troubles and what happened in them."""
        identity, watches = self.base.identity, self.telemetry.devices
        base = None if identity is None else f"{identity.subclass} {identity.name}"
        self.outbox.add(*watches["base"].notices(t, self.base, base))
        self.outbox.add(*watches["laser"].notices(t, self.laser, self.laser.identity))
        health = laser_health_notice(t, self.laser.health, warned="laser.health" in self.warnings)
        if health is not None:
            self.outbox.add(health)

    def _log_degraded(self, t: float) -> None:
        words = "; ".join(self.health_summary.degraded(t))
        level = LogLevel.WARNING if words else LogLevel.INFO
        self._was_degraded = self._was_degraded or bool(words)
        if self._was_degraded:
            self.outbox.add(Notice(t, "perception", words or "all senses work", level))

    def _on_picture(self, event: PictureTaken) -> None:
        """Publish a picture of an intruder as evidence."""
        pose = self.pose_tracker.localized_pose_at(event.taken)
        evidence = self.perception.on_picture(event, pose)
        if evidence is not None and self.publishes:
            intruder, picture = evidence
            self.outbox.publish(self.telemetry.on_intruder(event.t, intruder, picture=picture))

    def _on_base_bytes(self, t: float, data: bytes) -> None:
        """Decode base reports and run one control step for each."""
        states = self.base.feed(data, t)
        self.telemetry.on_bytes("base", t, data, understood=bool(states))
        if self.freshness.is_old(t):
            return
        if states and self.base.model is not self._model:
            self._use_model(self.base.model)
        if states:
            self.pose_tracker.recall(t)
        for state in states:
            at_report = Pose(state.x, state.y, state.theta)
            self.odometry.add(state)
            self.freshness.on_base_report(t, state)
            localized = self.pose_tracker.localized_pose_at(state.t)
            self.surroundings.on_sonar(state, at_report, localized)
            self._track_by_sonar(t, at_report, localized)
            self._control_step(t, state)
        if states:
            self.pose_tracker.remember(t)
            self._tell_of_base(t)

    def _tell_of_base(self, t: float) -> None:
        """Tell people of bumpers that the base lacks."""
        missing = self.base.missing_bumpers
        if missing is not None:
            self.outbox.add(Notice(t, "bumpers", missing, LogLevel.INFO))

    def _track_by_sonar(self, t: float, odometry: Pose, localized: Pose | None) -> None:
        """Update teammate tracks outside the laser's view by sonar.

        odometry: odom_from_base; localized: map_from_base, None unless localized.
        """
        if localized is not None and self.perception.tracker.needs_echoes(t):
            echoes = self.surroundings.echoes(t, odometry)
            self.perception.tracker.on_echoes(t, localized, echoes)

    def _on_laser_bytes(self, t: float, data: bytes) -> None:
        """Decode scans and process each one that is accepted."""
        scans = self.laser.feed(data, t)
        self.telemetry.on_bytes("laser", t, data, understood=bool(scans))
        if self.freshness.is_old(t):
            return
        for scan in scans:
            if self.freshness.accept_scan(t, scan, self.odometry.latest):
                self._look(t, scan)
        self._expire(t)

    def _look(self, t: float, scan: Scan) -> None:
        """Take in one scan: obstacles, pose, teammates."""
        odometry = self.odometry.at(scan.t)
        if odometry is None:
            return  # nobody knows where the robot was when this was measured
        # 1. What stands in the way, wherever the map says we are.
        self._watch_own_parts(t, odometry, scan)
        scan = self._projector.without_body(scan)
        points = self.surroundings.on_scan(scan, odometry, self.odometry)
        if scan.t < self._next_look:
            return  # a fast scanner's: the place and the others are looked for less often
        self._next_look = scan.t + self._look_period
        known = self.perception.tracked_points(scan.t, self.localizer.estimate, odometry, points)
        self._watch_travel(t, scan.t, odometry, points if known is None else points[~known])
        if self.teleop is None:  # else there is no map to find a place in
            # 2. Where the robot was.
            estimate = self.pose_tracker.update(t, scan.t, odometry, points, known)
            if estimate.health is Health.LOCALIZED:
                self.freshness.on_localized(self._now)
            self.surroundings.on_located_scan(
                scan.t, odometry, self.pose_tracker.localized_pose_at(scan.t), points
            )
            # 3. Who else is there.
            new = self.perception.update(t, scan, estimate, points)
            if estimate.health is Health.LOCALIZED:
                self._report_intruders(t, new)
        # 4. Tell.
        if self.publishes:
            self.outbox.publish(self.telemetry.on_scan(t, scan))

    def _watch_own_parts(self, t: float, odometry: Pose, scan: Scan) -> None:
        """Look for parts of the robot in the laser's view; they hide what is behind them."""
        if self.pose_tracker.travel.fault is not None:
            return  # a scan that repeats turns with the robot as well
        if self.own_parts.update(scan.t, odometry, scan):
            self._projector.hide(self.own_parts.sectors)
            self.own_parts_stand_out = self._projector.stand_out(self.own_parts.places)
        sectors, stand_out = self.own_parts.sectors, self.own_parts_stand_out
        self._tell(own_parts_notice(t, self._laser_settings, sectors, stand_out=stand_out))

    def _watch_travel(
        self, t: float, scanned: float, odometry: Pose, points: NDArray[np.float64]
    ) -> None:
        """Compare the motion that scans show with the one that the wheels count.

        points: without those on tracked bodies; a teammate ahead at the same speed seems to stand.
        """
        report = self.odometry.latest
        if report is not None and (report.stall_left or report.stall_right):
            self.pose_tracker.travel.forget_scan()
        travel = self.pose_tracker.travel
        travel.update(scanned, odometry, points)
        self._tell(
            travel_notice(
                t,
                travel,
                held=self.gate_decision is not None and self.gate_decision.reason in STANDING,
                warned="laser.mount" in self.warnings,
            ),
            scale_notice(t, travel.scale.off, warned="base.wheel_scale" in self.warnings),
        )

    def _tell(self, *notices: Notice | None) -> None:
        """Report the notices that there are."""
        for notice in notices:
            if notice is not None:
                self.outbox.add(notice)

    def _report_intruders(self, t: float, new: list[NewIntruder]) -> None:
        """Publish each new intruder with its evidence, then updates of the known ones."""
        for each in new:
            self.outbox.add(intruder_notice(t, each.intruder))
            if self.publishes:
                self.outbox.publish(self.telemetry.on_intruder(t, each.intruder, scan=each.scan))
            if each.needs_picture:
                self.outbox.add(TakePicture())
        if self.publishes and self.perception.intruders is not None:
            self.outbox.publish(self.telemetry.on_intruders(t, self.perception.intruders.known))

    # --- one control step ----------------------------------------------------------------------

    def _control_step(self, t: float, state: BaseState) -> None:
        """Decide and act, once per base report; t: its arrival, s."""
        self.freshness.deadline.update(self._now, self._now - t)
        if self.teleop is not None and not self._ending:
            gate = self._drive(
                t, self.teleop.requested(t), self._gate_inputs(t, state, limited=True)
            )
            self._on_gate_decision(t, gate)
            return
        if self.patrol is None or self._ending:
            self.base.drive(t, 0.0, 0.0)
            return
        pose = self.pose_tracker.trusted_pose_at(t)
        if pose is None:
            self._look_around(t, state)
            return
        if self.recovery.end():
            self.outbox.add(Notice(t, "recovery", "goes on: the pose is known", LogLevel.INFO))
        # 1. Decide: closest teammate, action, velocity in the map.
        track = self.perception.tracker.closest(t, pose)
        teammate = None if track is None else (track.x, track.y)
        decision = self.patrol.step(t, pose, teammate, held=held_by_obstacle(self.gate_decision))
        # 2. Act: turn that velocity into wheel speeds, or free a robot that obstacles pin.
        pinned = pinned_by_obstacle(self.gate_decision)
        unpinning = self.unpinning.step(t, self.heading_loop.turn, pinned=pinned)
        requested = self.heading_loop.command(
            t, decision.velocity, pose.theta, decision.curvature, unpinning
        )
        # 3. Gate: nothing moves the robot but what leaves here.
        gate = self._drive(t, requested, self._gate_inputs(t, state))
        # 4. Tell.
        self._on_gate_decision(t, gate)
        self._tell(
            override_notice(t, decision, self.decision), way_notice(t, decision, self.decision)
        )
        self.decision = decision
        if self.publishes:
            held_by = self._held_by(requested, gate)
            told = self.telemetry.on_decision(t, pose, decision, requested, gate, track, held_by)
            self.outbox.publish(told)

    def _held_by(
        self, requested: tuple[float, float], gate: GateDecision
    ) -> HoldingObstacle | None:
        """Return the obstacle for which the gate cut requested (v m/s, w rad/s).

        None if the gate gave another reason, or if no single obstacle blocks that command.
        """
        if gate.reason is not GateReason.OBSTACLE:
            return None
        return holding_obstacle(self._limits, requested, self._obstacles)

    def _look_around(self, t: float, state: BaseState) -> None:
        """Run the recovery behavior (wait, then turn in place) until the pose is known."""
        requested = self.recovery.requested(t)
        gate = self._drive(t, requested, self._gate_inputs(t, state, limited=True))
        if requested != (0.0, 0.0):
            self._on_gate_decision(t, gate)
            if (gate.v, gate.w) != (0.0, 0.0):
                self.outbox.add(Notice(t, "recovery", "turns to look around", LogLevel.WARNING))

    def _drive(self, t: float, requested: tuple[float, float], inputs: GateInputs) -> GateDecision:
        """Send the base what the gate permits of requested (v m/s, w rad/s); return that."""
        gate = self.gate.permit(self._now, requested, inputs)
        if gate.reason is GateReason.MOTORS_OFF and requested != (0.0, 0.0):
            self.base.enable_motors(t)  # the only reason left to deny motion
        self.base.drive(t, gate.v, gate.w)
        return gate

    def _expire(self, t: float) -> None:
        """Stop at once, between two reports, when the inputs of the last command are stale."""
        report_time = self.freshness.report_time(self.odometry.latest)
        scan_time = self.freshness.scan_time(self.surroundings.seen_at)
        gate = self.gate.expire(self._now, report_time, scan_time)
        if gate is not None and not self._ending:
            self.base.drive(t, gate.v, gate.w)
            self._on_gate_decision(t, gate)

    def _gate_inputs(self, t: float, state: BaseState, *, limited: bool = False) -> GateInputs:
        odometry = self.odometry.at(t)
        self._obstacles = NO_OBSTACLES if odometry is None else self._obstacles_at(t, odometry)
        return GateInputs(
            # A report older than the odometry history (the process was paused) counts as missing,
            # so that the gate denies motion.
            base_time=None if odometry is None else self.freshness.report_time(state),
            scan_time=self.freshness.scan_time(self.surroundings.seen_at),
            health=self.pose_tracker.health,
            motors_enabled=state.motors_enabled,
            stop_button=state.stop_button or self.base.motors is MotorState.STOP_BUTTON,
            stalled=state.stall_left or state.stall_right,
            bumpers=state.front_bumpers | state.rear_bumpers,
            battery=state.battery,
            obstacles=self._obstacles.points,
            v=state.v,
            w=state.w,
            views=self.surroundings.views(t),
            body_known=self.base.model_trouble is None,
            charging=state.charging,
            overloaded=self.freshness.deadline.overloaded(self._now),
            # Driven by keys the robot may move on, for the recording to calibrate by.
            laser_denied=self.teleop is None
            and (self.pose_tracker.travel.fault is not None or self.own_parts_stand_out),
            unproven=not self.pose_tracker.travel.confirmed,
            limited=limited,
        )

    def _obstacles_at(self, t: float, odometry: Pose) -> ObstaclePoints:
        localized = self.pose_tracker.localized_pose_at(t)
        tracks = self.perception.tracker.tracks
        return self.surroundings.around(t, odometry, localized, tracks)

    def _on_gate_decision(self, t: float, gate: GateDecision) -> None:
        """Count and log the moment when the gate begins or ceases to hold the robot."""
        self.gate_stops += begins_hold(self.gate_decision, gate)
        self.outbox.add(gate_notice(t, gate))
        self.gate_decision = gate

    # --- links and end -------------------------------------------------------------------------

    def _link_up(self, t: float, link: DeviceName) -> None:
        if self._ending:
            return  # no session is opened any more
        if link == "camera":
            self.perception.camera.opened(t)
            self.outbox.add(Notice(t, "camera", "pictures come", LogLevel.INFO))
            return
        self.telemetry.links[link].opened()
        self._session(link).link_up(t)
        if link == "laser":
            self.pose_tracker.travel.restart()
            self._forget_own_parts()
        self.outbox.add(Notice(t, link, "port open", LogLevel.INFO))

    def _link_down(self, t: float, link: DeviceName, reason: str) -> None:
        if self._ending:
            return  # a device closes its connection after the last command: no fault
        if link == "camera":
            self.perception.camera.lost(reason)
        else:
            self.telemetry.links[link].lost(reason)
            self._session(link).link_down(t)
        self.outbox.add(Notice(t, link, reason, LogLevel.ERROR))

    def _session(self, link: LinkName) -> P2osSession | ScannerSession:
        return self.base if link == "base" else self.laser

    def _shut_down(self, t: float) -> None:
        """Save the pose, stop the robot and close the device sessions."""
        self._ending = True
        self.pose_tracker.remember(t, at_once=True)
        self.base.shut_down(t)
        self.laser.shut_down(t)
