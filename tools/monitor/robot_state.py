"""State of one robot from its telemetry, and its change by a payload."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass, field, replace
from types import MappingProxyType

from maps.pose import Pose, wrap_angle
from robot_agent.messages.foxglove import (
    LaserScan,
    Log,
    PoseInFrame,
    PosesInFrame,
    SceneUpdate,
    Timestamp,
    planar_pose,
)
from robot_agent.messages.streams import (
    DecisionPayload,
    IntruderPayload,
    Payload,
    ProcessPayload,
    StatusPayload,
)
from tools.monitor.sighting import Sighting, sighting_of

POSES_KEPT = 30
"""About 3 s of poses: a scan is drawn at the robot's pose when it was measured."""
EVENTS_KEPT = 20
_INTRUDERS_KEPT = 4
_SOURCE_KEPT_S = 10.0
"""A source that was heard this long ago is still there: robots report many times a second."""
_SOURCES_KEPT = 4
_STAMP_KEPT_S = 0.25
"""A robot whose clock is ahead of the operator's by less has its stamps kept: Zenoh replaces those
more than 0.5 s ahead."""


@dataclass(frozen=True, slots=True)
class HeardEvent:
    """One log entry of a robot; t: operator's monotonic time of reception; wall: s since 1970."""

    t: float
    wall: float
    log: Log


@dataclass(frozen=True, slots=True)
class RobotState:
    """One robot's newest telemetry; times in s on the operator's monotonic clock."""

    team: str
    robot: str
    online: bool = False  # its liveliness token is present
    first_seen: float = 0.0  # time of its first payload or liveliness token
    last_heard: float | None = None  # time of its last payload of any stream; None: none yet
    payloads: Mapping[str, Payload] = field(default_factory=lambda: MappingProxyType({}))
    received: Mapping[str, float] = field(default_factory=lambda: MappingProxyType({}))
    versions: Mapping[str, int] = field(default_factory=lambda: MappingProxyType({}))
    version: int = 0  # the team's version at this robot's last change
    malformed: int = 0  # payloads that could not be read
    malformed_at: float | None = None  # time of the last of them
    skew: float | None = None  # s its clock was ahead of the operator's at its last status
    rates: Mapping[str, float] = field(default_factory=lambda: MappingProxyType({}))
    """Rates of ``base`` and ``laser``, 1/s, between the last two statuses."""
    poses: tuple[tuple[float, Pose], ...] = ()  # newest last, with the robot's own time stamps
    last_turn: tuple[float, str] | None = None
    """Time and cause (``turn`` of the decision) of its last turn; None: no turn received."""
    events: tuple[HeardEvent, ...] = ()  # newest last
    intruders: Mapping[int, Sighting] = field(default_factory=lambda: MappingProxyType({}))
    """Last sighting of each intruder by its number, the newest last."""
    source: str | None = None  # the session its last payload came from; None: none yet
    sources: Mapping[str, float] = field(default_factory=lambda: MappingProxyType({}))
    """Last time of each session of late."""
    rivals_at: float | None = None  # time at which an earlier session last spoke again

    @property
    def id(self) -> str:
        """Team and name."""
        return f"{self.team}/{self.robot}"

    @property
    def key_parts(self) -> list[str]:
        """The parts of its telemetry key."""
        return ["patrol", self.team, self.robot]

    @property
    def status(self) -> StatusPayload | None:
        """The newest status."""
        payload = self.payloads.get("status")
        return payload if isinstance(payload, StatusPayload) else None

    @property
    def decision(self) -> DecisionPayload | None:
        """The newest decision."""
        payload = self.payloads.get("decision")
        return payload if isinstance(payload, DecisionPayload) else None

    @property
    def pose(self) -> PoseInFrame | None:
        """The newest pose in the map frame."""
        payload = self.payloads.get("pose")
        return payload if isinstance(payload, PoseInFrame) else None

    @property
    def scan(self) -> LaserScan | None:
        """The newest laser scan."""
        payload = self.payloads.get("scan")
        return payload if isinstance(payload, LaserScan) else None

    @property
    def particles(self) -> PosesInFrame | None:
        """The newest particles."""
        payload = self.payloads.get("particles")
        return payload if isinstance(payload, PosesInFrame) else None

    @property
    def tracks(self) -> SceneUpdate | None:
        """The newest tracks."""
        payload = self.payloads.get("tracks")
        return payload if isinstance(payload, SceneUpdate) else None

    @property
    def process(self) -> ProcessPayload | None:
        """The newest process report."""
        payload = self.payloads.get("process")
        return payload if isinstance(payload, ProcessPayload) else None

    def age(self, stream: str, now: float) -> float | None:
        """Return the age of a stream's newest payload at now, s; None if there is none."""
        received = self.received.get(stream)
        return None if received is None else now - received

    def silence(self, now: float) -> float:
        """Return for how long nothing that can be read was received, s."""
        return now - (self.first_seen if self.last_heard is None else self.last_heard)

    def pose_at(self, stamp: Timestamp) -> Pose | None:
        """Return the pose (map_from_base) at a time stamp of the robot's clock, interpolated.

        Outside the kept poses: the newest one; None if there are none.
        """
        t = seconds(stamp)
        after = next((item for item in self.poses if item[0] >= t), None)
        before = next((item for item in reversed(self.poses) if item[0] <= t), None)
        if before is None or after is None:
            return self.poses[-1][1] if self.poses else None
        span = after[0] - before[0]
        share = (t - before[0]) / span if span > 0.0 else 0.0
        return _between(before[1], after[1], share)

    def with_source(self, source: str, t: float) -> RobotState:
        """Return the state after a payload of a session at t; "" is one that set no time stamp.

        A robot that was started again has a new session once; two sessions that take turns are
        two programs under one name.
        """
        clock_ahead = self.skew is None or self.skew > _STAMP_KEPT_S
        if source == "" and self.source != "" and clock_ahead:
            return self  # perhaps this robot's own, with its stamp replaced
        known = {name: at for name, at in self.sources.items() if t - at < _SOURCE_KEPT_S}
        again = source in known and source != self.source
        kept = dict(sorted({**known, source: t}.items(), key=lambda item: item[1])[-_SOURCES_KEPT:])
        rivals_at = t if again else self.rivals_at
        return replace(self, source=source, sources=kept, rivals_at=rivals_at)

    def with_payload(self, stream: str, payload: Payload, t: float, wall: float) -> RobotState:
        """Return the state after a payload received at t (monotonic) and wall (s since 1970)."""
        updated = replace(
            self,
            last_heard=t,
            payloads={**self.payloads, stream: payload},
            received={**self.received, stream: t},
        )
        if isinstance(payload, StatusPayload):
            skew = seconds(payload.timestamp) - wall
            return replace(updated, skew=skew, rates=_rates(self.status, payload) or self.rates)
        if isinstance(payload, PoseInFrame):
            at = (seconds(payload.timestamp), planar_pose(payload.pose))
            return replace(updated, poses=(*self.poses[-POSES_KEPT + 1 :], at))
        if isinstance(payload, DecisionPayload) and payload.turn is not None:
            return replace(updated, last_turn=(t, payload.turn))
        if isinstance(payload, IntruderPayload):
            sighting = sighting_of(payload, wall)
            if payload.picture and not sighting.picture:
                updated = updated.with_malformed(t)
            return replace(updated, intruders=self._with_sighting(payload.number, sighting))
        if isinstance(payload, Log):
            event = HeardEvent(t, wall, payload)
            return replace(updated, events=(*self.events[-EVENTS_KEPT + 1 :], event))
        return updated

    def with_malformed(self, t: float) -> RobotState:
        """Return the state after a payload, or a picture in one, that cannot be used."""
        return replace(self, malformed=self.malformed + 1, malformed_at=t)

    def _with_sighting(self, number: int, sighting: Sighting) -> Mapping[int, Sighting]:
        known = dict(self.intruders)
        before = known.pop(number, None)
        known[number] = sighting.after(before)
        return dict(list(known.items())[-_INTRUDERS_KEPT:])


def seconds(stamp: Timestamp) -> float:
    """Return a time stamp in s."""
    return stamp.sec + 1e-9 * stamp.nsec


def _between(a: Pose, b: Pose, share: float) -> Pose:
    turn = wrap_angle(b.theta - a.theta)
    return Pose(
        a.x + share * (b.x - a.x),
        a.y + share * (b.y - a.y),
        wrap_angle(a.theta + share * turn),
    )


def _rates(before: StatusPayload | None, after: StatusPayload) -> Mapping[str, float] | None:
    """Return the rates, 1/s, between two statuses; None for the first and after a restart."""
    if before is None or after.uptime <= before.uptime:
        return None
    elapsed = after.uptime - before.uptime
    return {
        name: max(now.packets_good - then.packets_good, 0) / elapsed
        for name, then, now in (
            ("base", before.base, after.base),
            ("laser", before.laser, after.laser),
        )
    }
