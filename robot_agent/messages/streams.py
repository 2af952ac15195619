"""The telemetry streams: payloads, rates and schemas.

A payload is JSON. The same bytes go to the operator and to the recording. Payloads are built by the
agent, so they contain nothing that a replay could not reproduce (no counters of the recorder or of
the network). Absent values are left out of the JSON, never null; no field may be inf or nan, and
every field is bounded (``maps.input_limits``): what exceeds its bound is no payload.

======== ========================================== ===== ============================
stream   content                                    Hz    schema
======== ========================================== ===== ============================
status   battery, links, localization, health       2     patrol.Status
decision inputs, degrees, winner, velocities, gate  10    patrol.Decision
pose     robot in ``map``; only once localized      10    foxglove.PoseInFrame
scan     laser in ``laser``                         5     foxglove.LaserScan
particles particles in ``map``                      2     foxglove.PosesInFrame
tracks   teammates and strangers in ``map``         5     foxglove.SceneUpdate
intruder a stranger that stays near the border      1     patrol.Intruder
event    log messages                               each  foxglove.Log
======== ========================================== ===== ============================

Two more come from the process that runs the agent and cannot be compared in a replay: ``process``
(1 Hz, patrol.Process: load, lateness, losses) and ``process_log`` (each, foxglove.Log: failures of
recorder and telemetry, sent to the operator as ``event``).
"""

from __future__ import annotations

from dataclasses import dataclass
from typing import Annotated, Any

import msgspec
from msgspec import Meta

from maps.input_limits import MAX_BEAMS, MAX_PARTS, MAX_PICTURE_TEXT
from robot_agent.messages.bounded_fields import Count, Number, Text, Word
from robot_agent.messages.foxglove import (
    LaserScan,
    Log,
    PoseInFrame,
    PosesInFrame,
    SceneUpdate,
    Timestamp,
)
from robot_agent.messages.viewer_schema import viewer_schema

ACTIONS = (
    "reach_frontier",
    "keep_going",
    "patrol_clockwise",
    "patrol_counter_clockwise",
    "avoid_teammate",
)
"""Names of the actions, as viewers list them (those of ``patrol.actions.Action``)."""


class PayloadError(ValueError):
    """Bytes that are not a valid payload of their stream."""


class Velocity(msgspec.Struct, frozen=True):
    """A velocity vector in the map frame."""

    x: Annotated[Number, Meta(description="m/s")]
    y: Annotated[Number, Meta(description="m/s")]


class Twist(msgspec.Struct, frozen=True):
    """A velocity of the base in its own frame."""

    v: Annotated[Number, Meta(description="forward (m/s)")]
    w: Annotated[Number, Meta(description="counter-clockwise (rad/s)")]


class PlanarPose(msgspec.Struct, frozen=True):
    """A pose in the map frame."""

    x: Annotated[Number, Meta(description="m")]
    y: Annotated[Number, Meta(description="m")]
    theta: Annotated[Number, Meta(description="rad, counter-clockwise from +x")]


class DeviceStatus(msgspec.Struct, frozen=True, kw_only=True):
    """A device, its session and its line; counters run from the agent's start."""

    state: Annotated[Word, Meta(description="state of the session, e.g. ready")]
    link_up: Annotated[bool, Meta(description="whether the port is open")]
    link_reason: Annotated[Text, Meta(description="why the port is not open")] = ""
    trouble: Annotated[Text, Meta(description="the session's trouble with its remedy")] = ""
    counters: Annotated[
        dict[Word, Count],
        Meta(
            max_length=MAX_PARTS,
            description="what happened in the session, how often; not yet: absent",
        ),
    ] = {}
    packets_good: Count
    packets_bad: Annotated[Count, Meta(description="frames whose checksum was wrong")]
    bytes_discarded: Annotated[Count, Meta(description="bytes outside any frame")]
    bytes_received: Count
    last_heard: Annotated[
        Number | None, Meta(description="age of the last good packet (s); absent if none yet")
    ] = None

    @property
    def happened(self) -> str:
        """The counters as words for people, "3 naks, 1 timeouts"; empty if there are none."""
        return ", ".join(f"{n} {name.replace('_', ' ')}" for name, n in self.counters.items())


class LocalizationStatus(msgspec.Struct, frozen=True, kw_only=True, omit_defaults=True):
    """The particle filter's own view of how well it knows the pose."""

    health: Annotated[Text, Meta(description="localized, unsure or lost")]
    pose: PlanarPose | None = None
    covariance: Annotated[
        list[Number],
        Meta(max_length=9, description="of x, y, theta, row by row, 9 values (m, rad); or none"),
    ] = []
    particle_count: Count = 0
    effective_sample_size: Number = 0.0
    likelihood: Annotated[Number, Meta(description="mean per beam, 0 to 1")] = 0.0


class CameraReport(msgspec.Struct, frozen=True, kw_only=True, omit_defaults=True):
    """The camera as the agent hears of it."""

    state: Annotated[Word, Meta(description="down, silent, dark, glare, covered or clear")]
    link_reason: Annotated[Text, Meta(description="why there are no pictures")] = ""
    pictures: Annotated[Count, Meta(description="looked at")] = 0
    bands: Annotated[Count, Meta(description="in the latest picture")] = 0
    last_heard: Annotated[Number | None, Meta(description="age of the latest picture (s)")] = None


class IntruderPayload(msgspec.Struct, frozen=True, kw_only=True, omit_defaults=True):
    """A stranger near the border: first when reported, then again as it is seen further."""

    timestamp: Timestamp
    robot: Word
    number: Annotated[Count, Meta(description="of the intruder, from 1; the same in every update")]
    x: Annotated[Number, Meta(description="m, map frame")]
    y: Annotated[Number, Meta(description="m, map frame")]
    abscissa: Annotated[Number, Meta(description="place along the border (m)")]
    distance: Annotated[Number, Meta(description="from the border (m)")]
    closest: Annotated[Number, Meta(description="least distance from the border so far (m)")]
    first_seen: Timestamp
    last_seen: Timestamp
    scan: Annotated[
        list[Number],
        Meta(
            max_length=2 * MAX_BEAMS,
            description="evidence: laser points near it, x y x y... (m, map frame); or none",
        ),
    ] = []
    picture: Annotated[
        str,
        Meta(
            max_length=MAX_PICTURE_TEXT,
            description="evidence: cut-out of the camera's picture (JPEG, base64); or none",
        ),
    ] = ""


class BodyPayload(msgspec.Struct, frozen=True):
    """The robot's size and its laser's place, by its model, in base_link."""

    front: Annotated[Number, Meta(description="m from the axle")]
    rear: Annotated[Number, Meta(description="m from the axle")]
    half_width: Annotated[Number, Meta(description="m")]
    laser_x: Annotated[Number, Meta(description="m")]
    laser_y: Annotated[Number, Meta(description="m")]
    laser_theta: Annotated[Number, Meta(description="rad")]


class StatusPayload(msgspec.Struct, frozen=True, kw_only=True, omit_defaults=True):
    """Whether this robot is well: power, devices, localization."""

    timestamp: Timestamp
    robot: Word
    team: Word
    uptime: Annotated[Number, Meta(description="time since the agent's start (s)")]
    health: Annotated[
        Text, Meta(description="ok, or the first thing that keeps it from patrolling")
    ]
    map_hash: Annotated[Word, Meta(description="of the map's files, shortened; empty: unknown")] = (
        ""
    )
    border_hash: Annotated[Word, Meta(description="of its border, shortened; empty: none")] = ""
    body: BodyPayload | None = None
    battery: Annotated[Number | None, Meta(description="V; absent until the base reports")] = None
    motors_enabled: bool = False
    stalled: bool = False
    bumpers: Annotated[Count, Meta(description="pressed segments, front low byte, rear high")] = 0
    base: DeviceStatus
    laser: DeviceStatus
    camera: CameraReport | None = None
    degraded: Annotated[
        list[Text], Meta(max_length=MAX_PARTS, description="what the robot has to do without")
    ] = []
    localization: LocalizationStatus


class HeldBy(msgspec.Struct, frozen=True):
    """The obstacle for which the gate cut a command."""

    source: Annotated[
        Word,
        Meta(description="laser, remembered, sonar, map_wall, teammate_room or person_room"),
    ]
    x: Annotated[Number, Meta(description="m, map frame")]
    y: Annotated[Number, Meta(description="m, map frame")]


class DecisionPayload(msgspec.Struct, frozen=True, kw_only=True, omit_defaults=True):
    """One control step: what was seen, what was chosen, what was let through."""

    timestamp: Timestamp
    robot: Word
    action: Annotated[Word, Meta(description="action in force")]
    direction: Annotated[int, Meta(ge=-1, le=1, description="+1 clockwise, -1 counter-clockwise")]
    distance_from_border: Annotated[Number, Meta(description="m")]
    way_to_border: Annotated[
        Number | None, Meta(description="m, round walls; absent if there is no way")
    ] = None
    abscissa: Annotated[Number, Meta(description="place along the border (m)")]
    distance_from_neighbor: Annotated[
        Number | None, Meta(description="m; absent if no teammate is near")
    ] = None
    neighbor: Annotated[
        PlanarPose | None, Meta(description="nearest teammate, theta its bearing")
    ] = None
    neighbor_border_distance: Annotated[
        Number | None, Meta(description="of the neighbor from the border (m)")
    ] = None
    neighbor_abscissa: Annotated[
        Number | None, Meta(description="of the neighbor along the border (m)")
    ] = None
    neighbor_sigma: Annotated[
        list[Number],
        Meta(
            max_length=2,
            description="one sigma of those: distance from the border, abscissa (m); or none",
        ),
    ] = []
    gamma: Annotated[Number, Meta(description="neighbor state, -1 left to +1 right")] = 0.0
    degrees: Annotated[
        dict[Word, Number],
        Meta(
            max_length=MAX_PARTS,
            description="degree of activation of each action, 0 to 1",
            extra_json_schema={"properties": {name: {"type": "number"} for name in ACTIONS}},
        ),
    ]
    winner: Word
    runner_up: Word
    pose: Annotated[PlanarPose, Meta(description="pose the decision was taken at")]
    velocity: Annotated[Velocity, Meta(description="asked for by the action")]
    requested: Annotated[Twist, Meta(description="before the gate")]
    command: Annotated[Twist, Meta(description="after the gate, as sent to the base")]
    gate_reason: Annotated[
        Word | None, Meta(description="why the gate changed the request; absent if it did not")
    ] = None
    held_by: Annotated[
        HeldBy | None, Meta(description="the obstacle, if gate_reason is one; absent else")
    ] = None
    blocked: Annotated[
        bool, Meta(description="gave up waiting for an object on its way, just now")
    ] = False
    holding: Annotated[
        bool,
        Meta(
            description="stands still, caught between an end and a teammate, or a moment in a crowd"
        ),
    ] = False
    override: Annotated[
        Word | None,
        Meta(
            description="the modifier whose proposal is in force: standoff, hold_at_end, blockage, "
            "wait, closing_in or even_gaps; absent while the paper's choice is"
        ),
    ] = None
    turn: Annotated[
        Word | None,
        Meta(
            description="why the robot turned back in this step: teammate, rules (an end), chance, "
            "blockage or even_gaps; absent if it did not"
        ),
    ] = None


class ProcessPayload(msgspec.Struct, frozen=True, kw_only=True, omit_defaults=True):
    """How the process fared since its last report. Lateness: from an event to its effects."""

    timestamp: Timestamp
    robot: Word
    cpu: Annotated[Number, Meta(description="share of one core, 0 to 1 and above")]
    memory_mb: Annotated[Number, Meta(description="resident memory (MB)")]
    events: Annotated[Count, Meta(description="events handled")]
    lateness_median: Annotated[Number, Meta(description="s")]
    lateness_max: Annotated[Number, Meta(description="s")]
    deadline_misses: Annotated[Count, Meta(description="events done more than 50 ms late")] = 0
    longest_pause: Annotated[Number, Meta(description="longest time without any event (s)")] = 0.0
    recorder_lost: Annotated[
        Count, Meta(description="records the disk had no room or time for")
    ] = 0
    recorder_trouble: Annotated[Text, Meta(description="why nothing is recorded at present")] = ""
    telemetry_dropped: Annotated[Count, Meta(description="payloads no operator took")] = 0
    operator: Annotated[
        bool | None, Meta(description="whether the operator is connected; absent without telemetry")
    ] = None


Payload = (
    StatusPayload
    | DecisionPayload
    | IntruderPayload
    | ProcessPayload
    | PoseInFrame
    | LaserScan
    | PosesInFrame
    | SceneUpdate
    | Log
)


@dataclass(frozen=True, slots=True)
class Stream:
    """One telemetry stream: its name, the payload it carries and that payload's schema name."""

    name: str
    payload: type[Payload]
    schema_name: str

    def json_schema(self) -> dict[str, Any]:
        """Return the JSON Schema of the payload."""
        return viewer_schema(self.payload, self.schema_name)


STREAMS: dict[str, Stream] = {
    stream.name: stream
    for stream in (
        Stream("status", StatusPayload, "patrol.Status"),
        Stream("decision", DecisionPayload, "patrol.Decision"),
        Stream("pose", PoseInFrame, "foxglove.PoseInFrame"),
        Stream("scan", LaserScan, "foxglove.LaserScan"),
        Stream("particles", PosesInFrame, "foxglove.PosesInFrame"),
        Stream("tracks", SceneUpdate, "foxglove.SceneUpdate"),
        Stream("intruder", IntruderPayload, "patrol.Intruder"),
        Stream("event", Log, "foxglove.Log"),
        Stream("process", ProcessPayload, "patrol.Process"),
        Stream("process_log", Log, "foxglove.Log"),
    )
}
PROCESS_STREAMS = frozenset({"process", "process_log"})
"""Streams that come from the process, not from the agent."""

_encoder = msgspec.json.Encoder()
_decoders: dict[str, msgspec.json.Decoder[Payload]] = {
    stream.name: msgspec.json.Decoder(stream.payload) for stream in STREAMS.values()
}


def encode(payload: Payload) -> bytes:
    """Encode a payload as the JSON that goes to the operator and the recording."""
    return _encoder.encode(payload)


def decode(stream: str, data: bytes) -> Payload:
    """Decode a payload of a stream; unknown fields are ignored.

    Raises PayloadError for a stream that does not exist, or bytes that do not fit it or its bounds.
    """
    decoder = _decoders.get(stream)
    if decoder is None:
        raise PayloadError(f"no stream {stream!r}; streams are {', '.join(STREAMS)}")
    try:
        return decoder.decode(modernized(stream, data))
    except (msgspec.DecodeError, UnicodeDecodeError, RecursionError) as error:
        raise PayloadError(f"no payload of stream {stream!r}: {error}") from error


def modernized(stream: str, data: bytes) -> bytes:
    """Return a payload with field names of earlier versions replaced by the present ones."""
    return data.replace(b'"wish":', b'"requested":', 1) if stream == "decision" else data


def key_of(team: str, robot: str, stream: str = "") -> str:
    """Return the telemetry key of a robot's stream, or of the robot itself (its liveliness)."""
    return f"patrol/{team}/{robot}/{stream}" if stream else f"patrol/{team}/{robot}"
