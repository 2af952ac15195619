"""The agent: a pure function of configuration, map, seed and the events so far.

``Agent.handle(event)`` does no I/O, reads no clock and starts no thread; whoever calls it delivers
bytes and carries out the effects. The same event list gives the same effects, bit for bit.
"""

from __future__ import annotations

import math
from collections.abc import Iterator

import numpy as np
from numpy.typing import NDArray

from drivers.lms200.scan import Scan
from drivers.lms200.session import Lms200Session
from drivers.lms200.session import SessionState as LaserState
from drivers.p2os.base_state import BaseState
from drivers.p2os.model import load_model
from drivers.p2os.motor_watch import MotorState
from drivers.p2os.session import P2osSession, SessionState
from drivers.requests import Request, Write
from localization.health import Health
from localization.localizer import Localizer
from maps.map_folder import MapFolder
from maps.pose import Pose, wrap_angle
from robot_agent.camera_watch import CameraWatch
from robot_agent.config import AgentConfig
from robot_agent.effects import ChangeBaud, Effect, Publish, Send, TakePicture
from robot_agent.events import (
    TICK_S,
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
from robot_agent.evidence import cut_out, points_near
from robot_agent.foxglove import LogLevel
from robot_agent.known_walls import KnownWalls
from robot_agent.motion.deadline_watch import DeadlineWatch
from robot_agent.motion.frozen_watch import FrozenWatch
from robot_agent.motion.gate import GateDecision, GateInputs, SafetyGate
from robot_agent.motion.gate_hold import STOPPING, held_by_obstacle, pinned_by_obstacle
from robot_agent.motion.gate_reason import LATCHED, GateReason
from robot_agent.motion.heading_loop import HeadingLoop
from robot_agent.motion.recovery_turn import RecoveryTurn
from robot_agent.motion.trust import (
    BASE,
    FROZEN_BASE,
    FROZEN_LASER,
    LASER,
    LEAST_RETURNS,
    POSE,
    SONAR,
    TrustWatch,
)
from robot_agent.obstacles import Obstacles
from robot_agent.odometry_history import OdometryHistory
from robot_agent.patrol.actions import Action
from robot_agent.patrol.patrol import Patrol, PatrolDecision
from robot_agent.perception.intruders import Intruder, Intruders
from robot_agent.perception.pose_sigma import PoseSigma
from robot_agent.perception.tracker import TeammateTracker
from robot_agent.pose_memory import PoseMemory
from robot_agent.reports import Reports
from robot_agent.scan_points import ScanProjector, hits, move_points
from robot_agent.sonar_obstacles import SonarObstacles
from robot_agent.streams import Payload, encode
from robot_agent.teleop import Teleop
from robot_agent.turning_room import turning_room

_JUST_SEEN = 0.6  # s since a teammate was seen that is taken to be there
_NEAR = 2.5  # m; teammates farther off are no obstacle yet
PAUSE_S = 0.3
"""A process held up for longer finds bytes in its ports whose age it cannot tell."""
OLD_BYTES_S = 0.15
"""So long after a pause reports and scans may have come from these buffers, and are left out."""

_LASER_BLIND = 1.0  # s without a scan after which nobody is seen any more
_REMEDY = "look at the robot, then switch its motors off and on by its MOTORS button"

_LEVELS = {
    Health.LOCALIZED: LogLevel.INFO,
    Health.UNSURE: LogLevel.WARNING,
    Health.LOST: LogLevel.ERROR,
}


class Agent:
    """One robot's whole onboard reasoning."""

    def __init__(
        self,
        config: AgentConfig,
        folder: MapFolder,
        start_wall_ns: int = 0,
        *,
        publishes: bool = True,
    ) -> None:
        """Build every stage; nothing happens before the first event.

        A folder without a border gives an agent that localizes and sees, but never moves. An agent
        that publishes nothing decides and sends the same, in less time: for benches.
        """
        rng = np.random.default_rng(config.robot.seed)
        model = load_model(config.base.model)
        self.config = config
        self.base = P2osSession(config.base)
        self.laser = Lms200Session(config.laser)
        self.odometry = OdometryHistory()
        self.localizer = Localizer(config.localization, folder.map, rng)
        self.tracker = TeammateTracker(config.perception, folder.map, config.camera)
        self.border = folder.border
        self.camera = CameraWatch(config.camera)
        self.intruders = Intruders(config.perception, folder.border) if folder.border else None
        self._pictured: Intruder | None = None
        self.patrol = (
            Patrol(config.patrol, folder.border, rng, folder.approach_field)
            if folder.border
            else None
        )
        self.heading_loop = HeadingLoop(config.heading)
        self.teleop = Teleop(config.teleop) if config.teleop.enabled else None
        self.recovery = RecoveryTurn(config.recovery)
        self.deadline = DeadlineWatch()
        self._trust = TrustWatch()
        self._frozen_base = FrozenWatch(FROZEN_BASE)
        self._frozen_laser = FrozenWatch(FROZEN_LASER)
        self._last_tick = math.inf
        self._old_until = -math.inf  # s: bytes that arrive before had waited for us
        self.gate = SafetyGate(config.gate)
        self.reports = Reports(self, start_wall_ns)
        self.decision: PatrolDecision | None = None
        self.gate_decision: GateDecision | None = None
        self.gate_stops = 0
        self._projector = ScanProjector(Pose(*(config.laser.mount or model.laser_mount)))
        self._obstacles = Obstacles()
        self._known_walls = KnownWalls(folder.map, config.gate)
        self._sonar_obstacles = SonarObstacles(model)
        self._memory = PoseMemory(config.memory)
        self._to_recall = config.remembered
        self._pose_trusted = False
        self._ending = False
        self._now = 0.0  # s: what is handled late happens now
        self._publishes = publishes
        self._effects: list[Effect] = []
        if config.start is None:
            self.localizer.start_anywhere()
        else:
            start = config.start
            self.localizer.start_at(
                Pose(start.x, start.y, start.theta), start.sigma_xy, start.sigma_theta
            )

    def handle(self, event: Event) -> list[Effect]:
        """Take one event; return what to do about it, in order."""
        self._effects = []
        self._now = max(self._now, event.t)
        match event:
            case BytesReceived(t, "base", data):
                self._take_base_bytes(t, data)
            case BytesReceived(t, "laser", data):
                self._take_laser_bytes(t, data)
            case Tick(t):
                self._tick(t)
            case BlobsSeen():
                self._take_blobs(event)
            case PictureTaken():
                self._take_picture(event)
            case LinkUp(t, link):
                self._link_up(t, link)
            case LinkDown(t, link, reason):
                self._link_down(t, link, reason)
            case OperatorKey() if self.teleop is not None:
                self.teleop.press(event)
            case Shutdown(t):
                self._ending = True
                self._remember(t, at_once=True)
                self.base.shut_down(t)
                self.laser.shut_down(t)
        self._carry_out("base", self.base.take_requests())
        self._carry_out("laser", self.laser.take_requests())
        return self._effects

    # --- input -------------------------------------------------------------------------------

    def _tick(self, t: float) -> None:
        """Do what time alone asks for."""
        self._take_pause(t, t - self._last_tick - TICK_S)
        self._last_tick = t
        self.base.tick(t)
        self.laser.tick(t)
        self._miss_streams(t)
        self._tell_degraded(t)
        if self._publishes:
            self._publish(self.reports.on_time(t))

    def _take_base_bytes(self, t: float, data: bytes) -> None:
        """Decode base reports; each is one control step."""
        states = self.base.feed(data, t)
        self.reports.hear("base", t, data, understood=bool(states))
        if t < self._old_until:
            return
        if states:
            self._recall(t)
        for state in states:
            self.odometry.add(state)
            self._frozen_base.take((state.x, state.y, state.theta), moving=_is_moving(state))
            if not self._frozen_base.frozen:
                self._trust.well(BASE, t)
            if state.sonar:
                self._trust.well(SONAR, t)
            at_report = Pose(state.x, state.y, state.theta)
            self._sonar_obstacles.hear(state, at_report, self.base.model)
            self._listen_behind(t, at_report)
            self._control_step(t, state)
        if states:
            self._remember(t)

    def _take_laser_bytes(self, t: float, data: bytes) -> None:
        """Decode scans and look at each."""
        scans = self.laser.feed(data, t)
        self.reports.hear("laser", t, data, understood=bool(scans))
        if t < self._old_until:
            return
        for scan in scans:
            if self._shows_the_world(scan):
                self._trust.well(LASER, t)
                self._look(t, scan)

    def _take_pause(self, t: float, lag: float) -> None:
        """After a pause of the whole process, what comes first is old: nobody knows how old."""
        self.deadline.note(t, lag)
        if lag > PAUSE_S:
            self._old_until = t + OLD_BYTES_S

    def _shows_the_world(self, scan: Scan) -> bool:
        """Tell a scan from that of a laser that is blind, or shows the same for ever."""
        base = self.odometry.latest
        moving = base is not None and _is_moving(base)
        self._frozen_laser.take(scan.ranges.tobytes(), moving=moving)
        returns = float(np.isfinite(scan.ranges).mean())
        return returns >= LEAST_RETURNS and not self._frozen_laser.frozen

    def _look(self, t: float, scan: Scan) -> None:
        """Take in one scan: obstacles, pose, teammates."""
        odometry = self.odometry.at(scan.t)
        if odometry is None:
            return  # nobody knows where the robot was when this was measured
        # 1. What stands in the way, wherever the map says we are.
        points = self._projector.points(scan, *self.odometry.twist_at(scan.t))
        self._obstacles.see(scan.t, odometry, points)
        if self.teleop is not None:
            if self._publishes:
                self._publish(self.reports.on_scan(t, scan))
            return  # there is no map to find a place in
        # 2. Where the robot was.
        estimate = self.localizer.update(
            scan.t, odometry, points, self._on_teammates(scan.t, odometry, points)
        )
        self._trust_pose(estimate.health)
        self._say(t, "localization", estimate.health, _LEVELS[estimate.health])
        # 3. Who else is there.
        if estimate.health is not Health.LOST:
            reflectors = None if scan.reflectors is None else scan.reflectors[hits(scan)]
            sigma = PoseSigma.of(estimate.covariance)
            self.tracker.update(scan.t, estimate.pose, points, reflectors, sigma)
        if estimate.health is Health.LOCALIZED:
            self._watch_intruders(t, scan.t, estimate.pose, points)
        if self._publishes:
            self._publish(self.reports.on_scan(t, scan))

    def _take_blobs(self, event: BlobsSeen) -> None:
        """Take in what a picture shows of the team's colour."""
        self.camera.hear(event)
        pose = self.localized_pose_at(event.taken)
        if pose is not None and event.sight == "clear":
            self.tracker.see_bands(event.taken, pose, event.blobs)

    def _listen_behind(self, t: float, odometry: Pose) -> None:
        """Let the sonars keep up teammates whom the laser does not see."""
        pose = self.localized_pose_at(t)
        if pose is not None and self.tracker.awaits_echo(t):
            self.tracker.hear(t, pose, self._sonar_obstacles.around(t, odometry))

    def _watch_intruders(
        self, t: float, scanned: float, pose: Pose, points: NDArray[np.float64]
    ) -> None:
        """Report strangers who stay near the border: once, then what has changed."""
        if self.intruders is None:
            return
        for new in self.intruders.update(scanned, self.tracker.tracks):
            words = (
                f"intruder {new.number} at ({new.x:.1f}, {new.y:.1f}), {new.distance:.1f} m from "
                f"the border at s = {new.abscissa:.1f} m"
            )
            self._say(t, "intruder", words, LogLevel.WARNING)
            near = points_near(points, pose, (new.x, new.y))
            self._publish(self.reports.on_intruder(t, new, scan=near))
            if self.camera.state(t) == "clear":
                self._pictured = new
                self._effects.append(TakePicture())
        if self._publishes:
            self._publish(self.reports.on_intruders(t, self.intruders.known))

    def _take_picture(self, event: PictureTaken) -> None:
        """Add a picture to the report of the intruder it was taken of."""
        intruder, self._pictured = self._pictured, None
        pose = self.localized_pose_at(event.taken)
        if intruder is None or pose is None:
            return
        place = (intruder.x, intruder.y)
        picture = cut_out(event.jpeg, self.config.camera, pose, place)
        if picture:
            self._publish(self.reports.on_intruder(event.t, intruder, picture=picture))

    def _on_teammates(
        self, t: float, odometry: Pose, points: NDArray[np.float64]
    ) -> NDArray[np.bool_] | None:
        """Return (n,) which points end on tracked people and teammates, if the pose is known."""
        estimate = self.localizer.estimate
        if estimate is None or estimate.health is not Health.LOCALIZED:
            return None
        return self.tracker.covered(t, estimate.pose_at(odometry), points)

    # --- pose over restarts --------------------------------------------------------------------

    def _recall(self, t: float) -> None:
        """At the first base report, start from the remembered pose if the odometer agrees."""
        remembered, counters = self._to_recall, self.base.odometer_found
        if remembered is None or counters is None:
            return
        self._to_recall = None
        start = remembered.carried_to(
            counters, self.base.model.conversion.distance, self.config.memory.reach
        )
        if start is None:
            words = "not believed: the odometer does not go on from it"
            self._say(t, "memory", f"remembered pose {words}", LogLevel.WARNING)
            return
        self.localizer.start_at(*start)
        self._say(t, "memory", "starts from the remembered pose", LogLevel.INFO)

    def _remember(self, t: float, *, at_once: bool = False) -> None:
        """Note the pose for the next start, when it is time or at once."""
        state = self.odometry.latest
        if state is None:
            return
        note = self._memory.note(
            t,
            self.localizer.estimate,
            Pose(state.x, state.y, wrap_angle(state.theta)),
            self.base.odometer_counters,
            at_once=at_once,
        )
        if note is not None:
            self._effects.append(note)

    # --- one control step ----------------------------------------------------------------------

    def _control_step(self, t: float, state: BaseState) -> None:
        """Decide and act, once per base report; t: its arrival, s."""
        self.deadline.note(self._now, self._now - t)
        if self.teleop is not None and not self._ending:
            gate = self._drive(t, self.teleop.wish(t), self._gate_inputs(t, state, limited=True))
            self._note_gate(t, gate)
            return
        if self.patrol is None or self._ending:
            self.base.drive(t, 0.0, 0.0)
            return
        pose = self._pose_now(t)
        if pose is None:
            self._look_around(t, state)
            return
        if self.recovery.end():
            self._say(t, "recovery", "goes on: the pose is known", LogLevel.INFO)
        # 1. Decide: closest teammate, action, velocity in the map.
        track = self.tracker.closest(t, pose)
        teammate = None if track is None else (track.x, track.y)
        decision = self.patrol.step(t, pose, teammate, held=held_by_obstacle(self.gate_decision))
        # 2. Act: turn that velocity into wheel speeds.
        wish = self.heading_loop.command(
            t,
            decision.velocity,
            pose.theta,
            decision.curvature,
            pinned=pinned_by_obstacle(self.gate_decision),
        )
        # 3. Gate: nothing moves the robot but what leaves here.
        gate = self._drive(t, wish, self._gate_inputs(t, state))
        # 4. Tell.
        self._note_gate(t, gate)
        if decision.blocked:
            self._say(t, "patrol", _blocked_words(decision), LogLevel.WARNING)
        self.decision = decision
        if self._publishes:
            self._publish(self.reports.on_decision(t, pose, decision, wish, gate, track))

    def _look_around(self, t: float, state: BaseState) -> None:
        """Stand, and turn slowly where that is clear, until the pose is known."""
        wish = self.recovery.wish(t)
        gate = self._drive(t, wish, self._gate_inputs(t, state, limited=True))
        if wish != (0.0, 0.0):
            self._note_gate(t, gate)
            self._say(t, "recovery", "turns to look around", LogLevel.WARNING)

    def _drive(self, t: float, wish: tuple[float, float], inputs: GateInputs) -> GateDecision:
        """Let the gate have its say and the base have the rest."""
        gate = self.gate.permit(self._now, wish, inputs)
        if gate.reason is GateReason.MOTORS_OFF and wish != (0.0, 0.0):
            self.base.enable_motors(t)  # all else permits motion
        self.base.drive(t, gate.v, gate.w)
        return gate

    def _miss_streams(self, t: float) -> None:
        """Raise an alarm for each stream that is missed, and end it when the stream is back."""
        for stream, well in self._trust.changes(t):
            words = "is back" if well else f"none for {stream.max_age:g} s: {stream.reaction}"
            level = LogLevel.INFO if well else stream.level
            self._say(t, f"trust.{stream.name}", f"{stream.what}: {words}", level)

    def _trust_pose(self, health: Health) -> None:
        """Trust the pose once localized, until lost: unsure alone gives no trust and takes none."""
        if health is Health.LOCALIZED:
            self._pose_trusted = True
            self._trust.well(POSE, self._now)
        elif health is Health.LOST:
            self._pose_trusted = False

    def localized_pose_at(self, t: float) -> Pose | None:
        """Return map_from_base at t, which may be past, while localized; None else."""
        estimate = self.localizer.estimate
        odometry = self.odometry.at(t)
        if estimate is None or odometry is None or estimate.health is not Health.LOCALIZED:
            return None
        return estimate.pose_at(odometry)

    def _pose_now(self, t: float) -> Pose | None:
        """Return map_from_base at t: the last estimate carried forward by odometry.

        None while the pose is not to be trusted.
        """
        estimate = self.localizer.estimate
        odometry = self.odometry.at(t)
        if estimate is None or odometry is None or not self._pose_trusted:
            return None
        return estimate.pose_at(odometry)

    def _gate_inputs(self, t: float, state: BaseState, *, limited: bool = False) -> GateInputs:
        odometry = self.odometry.at(t)
        estimate = self.localizer.estimate
        # A report that waited so long that nobody knows where the robot is now (the process was
        # stopped for a while) is none: the gate denies.
        unknown = odometry is None or self._frozen_base.frozen
        return GateInputs(
            base_time=None if unknown else state.t,
            scan_time=self._obstacles.seen_at,
            health=None if estimate is None else estimate.health,
            motors_enabled=state.motors_enabled,
            stop_button=state.stop_button or self.base.motors is MotorState.STOP_BUTTON,
            stalled=state.stall_left or state.stall_right,
            bumpers=state.front_bumpers | state.rear_bumpers,
            battery=state.battery,
            obstacles=np.empty((0, 2)) if odometry is None else self._around(t, odometry),
            v=state.v,
            w=state.w,
            overloaded=self.deadline.overloaded(self._now),
            limited=limited,
        )

    def _around(self, t: float, odometry: Pose) -> NDArray[np.float64]:
        """Return (n, 2) m in base_link: what is seen about the robot, and what must be there."""
        return np.concatenate(
            (
                self._obstacles.around(odometry),
                self._sonar_obstacles.around(t, odometry),
                *self._known_obstacles(t, odometry),
            )
        )

    def _known_obstacles(self, t: float, odometry: Pose) -> Iterator[NDArray[np.float64]]:
        """Yield points (n, 2), base_link, of what no sensor shows, while the pose is known."""
        estimate = self.localizer.estimate
        if estimate is None or estimate.health is not Health.LOCALIZED:
            return
        pose = estimate.pose_at(odometry)
        yield self._known_walls.behind(pose)
        near = [
            (track.x, track.y)
            for track in self.tracker.tracks
            if track.teammate
            and t - track.last_seen <= _JUST_SEEN
            and math.hypot(track.x - pose.x, track.y - pose.y) < _NEAR
        ]
        if near:
            yield turning_room(move_points(np.array(near), pose.inverse()))

    def _note_gate(self, t: float, gate: GateDecision) -> None:
        """Count and tell when the gate begins to hold the robot."""
        before = self.gate_decision
        if gate.reason in STOPPING and (before is None or before.reason not in STOPPING):
            self.gate_stops += 1
        if gate.reason in STOPPING:
            remedy = f" ({_REMEDY})" if gate.reason in LATCHED else ""
            self._say(t, "gate", f"holds the robot: {gate.reason}{remedy}", LogLevel.WARNING)
        else:
            self._say(t, "gate", "lets the robot move", LogLevel.INFO)
        self.gate_decision = gate

    # --- links and output --------------------------------------------------------------------

    def _link_up(self, t: float, link: DeviceName) -> None:
        if link == "camera":
            self.camera.opened(t)
            self._say(t, "camera", "pictures come", LogLevel.INFO)
            return
        self.reports.links[link].opened()
        self._session(link).link_up(t)
        self._say(t, link, "port open", LogLevel.INFO)

    def _link_down(self, t: float, link: DeviceName, reason: str) -> None:
        if link == "camera":
            self.camera.lost(reason)
            self._say(t, "camera", reason, LogLevel.ERROR)
            return
        self.reports.links[link].lost(reason)
        self._session(link).link_down(t)
        self._say(t, link, reason, LogLevel.ERROR)

    def _session(self, link: LinkName) -> P2osSession | Lms200Session:
        return self.base if link == "base" else self.laser

    def _say(self, t: float, part: str, words: str, level: LogLevel) -> None:
        if self._publishes:
            self._publish(self.reports.on_news(t, part, words, level))

    def _publish(self, payloads: list[tuple[str, Payload]]) -> None:
        self._effects += [Publish(stream, encode(payload)) for stream, payload in payloads]

    def _carry_out(self, link: LinkName, requests: list[Request]) -> None:
        """Turn a session's requests into effects."""
        for request in requests:
            if isinstance(request, Write):
                self._effects.append(Send(link, request.data))
            else:
                self._effects.append(ChangeBaud(link, request.baud))

    def obstacles_around(self, odometry: Pose) -> NDArray[np.float64]:
        """Return what the latest scan saw near the robot, (n, 2) m, in base_link."""
        return self._obstacles.around(odometry)

    def degraded(self, t: float) -> list[str]:
        """Return what the robot has to do without at t, s, in words; nothing when all is well."""
        troubles = [self.camera.trouble(t)]
        seen = self._obstacles.seen_at
        if seen is None or t - seen > _LASER_BLIND:
            troubles.append("laser blind: nobody is seen, the robot stands")
        return [words for words in troubles if words]

    def _tell_degraded(self, t: float) -> None:
        words = "; ".join(self.degraded(t))
        level = LogLevel.WARNING if words else LogLevel.INFO
        if words or self.reports.has_spoken("perception"):
            self._say(t, "perception", words or "all senses work", level)

    def health(self) -> str:
        """Return "ok", or the first thing that keeps the robot from patrolling."""
        if self.base.state is not SessionState.READY:
            return f"base {self.base.state}"
        if self.laser.state is not LaserState.STREAMING:
            return f"laser {self.laser.state}"
        if self.teleop is not None:
            return "driven by keys"
        estimate = self.localizer.estimate
        if estimate is None or not self._pose_trusted:
            return "not localized"
        if estimate.health is not Health.LOCALIZED:
            return f"localization {estimate.health}"
        if self.gate_decision is not None and self.gate_decision.reason in STOPPING:
            return f"gate: {self.gate_decision.reason}"
        return "ok"


def _is_moving(state: BaseState) -> bool:
    """Tell whether a base says that it moves, faster than its counters' resolution."""
    return abs(state.v) > 0.05 or abs(state.w) > 0.1


def _blocked_words(decision: PatrolDecision) -> str:
    turned = ", turns back" if decision.action is Action.KEEP_GOING else ""
    return f"unknown object near s = {decision.abscissa:.1f} m holds the robot{turned}"
