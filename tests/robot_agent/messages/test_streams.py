from __future__ import annotations

import json
import math
from typing import Any

import numpy as np
import pytest

from maps.pose import Pose
from robot_agent.messages.foxglove import (
    Log,
    PoseInFrame,
    SceneUpdate,
    Timestamp,
    laser_scan,
    planar_pose,
    pose3,
    poses_in_frame,
    timestamp_at,
    track_entity,
)
from robot_agent.messages.log_level import LogLevel
from robot_agent.messages.streams import (
    ACTIONS,
    STREAMS,
    DecisionPayload,
    DeviceStatus,
    IntruderPayload,
    LocalizationStatus,
    Payload,
    PayloadError,
    PlanarPose,
    ProcessPayload,
    StatusPayload,
    Twist,
    Velocity,
    decode,
    encode,
    key_of,
)
from robot_agent.messages.viewer_schema import viewer_schema
from robot_agent.patrol.actions import Action
from robot_agent.recording.recording_writer import MESSAGES

NOON = Timestamp(sec=43200, nsec=5000)
DEVICE = DeviceStatus(
    state="ready",
    link_up=True,
    packets_good=10,
    packets_bad=1,
    bytes_discarded=3,
    bytes_received=400,
    last_heard=0.1,
)
PAYLOADS: dict[str, Payload] = {
    "status": StatusPayload(
        timestamp=NOON,
        robot="anna",
        team="north",
        uptime=12.5,
        health="ok",
        battery=12.4,
        motors_enabled=True,
        base=DEVICE,
        laser=DEVICE,
        localization=LocalizationStatus(
            health="localized",
            pose=PlanarPose(1.0, 2.0, 0.5),
            covariance=[0.0] * 9,
            particle_count=500,
        ),
    ),
    "decision": DecisionPayload(
        timestamp=NOON,
        robot="anna",
        action="keep_going",
        direction=-1,
        distance_from_border=0.03,
        abscissa=17.0,
        distance_from_neighbor=1.8,
        neighbor=PlanarPose(2.0, 2.0, 0.1),
        gamma=-0.4,
        degrees=dict.fromkeys(ACTIONS, 0.5),
        winner="keep_going",
        runner_up="patrol_clockwise",
        pose=PlanarPose(1.0, 2.0, 0.5),
        velocity=Velocity(0.1, 0.3),
        requested=Twist(0.35, 0.1),
        command=Twist(0.2, 0.1),
        gate_reason="obstacle",
        way_to_border=0.03,
        blocked=True,
        holding=True,
    ),
    "pose": PoseInFrame(timestamp=NOON, frame_id="map", pose=pose3(Pose(1.0, 2.0, 0.5))),
    "scan": laser_scan(NOON, "laser", -1.5, 0.5, np.array([1.0, math.inf, 2.0])),
    "particles": poses_in_frame(NOON, "map", np.array([[1.0, 2.0, 0.5], [1.1, 2.0, 0.4]])),
    "intruder": IntruderPayload(
        timestamp=NOON,
        robot="robot1",
        number=1,
        x=1.0,
        y=2.0,
        abscissa=12.5,
        distance=0.8,
        closest=0.4,
        first_seen=NOON,
        last_seen=NOON,
        scan=[1.0, 2.0, 1.1, 2.0],
        picture="/9j/4AAQ",
    ),
    "tracks": SceneUpdate(
        entities=[track_entity(NOON, 3, (1.0, 2.0), (0.3, 0.4), kind="teammate", probability=0.9)]
    ),
    "process": ProcessPayload(
        timestamp=NOON,
        robot="anna",
        cpu=0.08,
        memory_mb=101.5,
        events=130,
        lateness_median=0.0004,
        lateness_max=0.012,
        deadline_misses=1,
        longest_pause=0.05,
        recorder_lost=3,
        recorder_trouble="disk full",
        telemetry_dropped=2,
        operator=True,
    ),
    "process_log": Log(timestamp=NOON, level=LogLevel.ERROR, message="disk full", name="recorder"),
    "event": Log(timestamp=NOON, level=LogLevel.WARNING, message="laser silent", name="laser"),
}


def test_there_is_an_example_of_every_stream() -> None:
    assert PAYLOADS.keys() == STREAMS.keys()
    assert all(type(PAYLOADS[name]) is stream.payload for name, stream in STREAMS.items())


@pytest.mark.parametrize("stream", STREAMS)
def test_payload_survives_a_round_trip(stream: str) -> None:
    assert decode(stream, encode(PAYLOADS[stream])) == PAYLOADS[stream]


@pytest.mark.parametrize("stream", STREAMS)
def test_payload_has_no_null(stream: str) -> None:
    assert b"null" not in encode(PAYLOADS[stream])


def test_absent_values_are_left_out() -> None:
    localization = LocalizationStatus(health="lost")
    assert json.loads(encode_any(localization)) == {"health": "lost"}


def encode_any(value: object) -> bytes:
    return encode(value)  # type: ignore[arg-type]


def assert_viewer_reads(schema: dict[str, Any]) -> None:
    """The rules by which stock viewers turn a JSON Schema into a message definition."""
    assert schema["type"] == "object"
    for part in schema["properties"].values():
        if part["type"] == "array":
            part = part["items"]
            assert part["type"] != "array"
        if part["type"] == "object":
            assert_viewer_reads(part)
        else:
            assert part["type"] in ("boolean", "string", "number", "integer")


def test_viewers_can_read_every_schema() -> None:
    schemas = [stream.json_schema() for stream in STREAMS.values()]
    schemas += [viewer_schema(message, name) for message, name in MESSAGES.values()]
    for schema in schemas:
        assert_viewer_reads(schema)


def assert_fits(value: object, schema: dict[str, Any]) -> None:
    """Every value sent is described, every value required is sent, types agree."""
    if schema["type"] == "object":
        assert isinstance(value, dict)
        assert value.keys() <= schema["properties"].keys()
        assert set(schema.get("required", ())) <= value.keys()
        for name, part in value.items():
            assert_fits(part, schema["properties"][name])
    elif schema["type"] == "array":
        assert isinstance(value, list)
        for part in value:
            assert_fits(part, schema["items"])
    else:
        kinds: dict[str, Any] = {
            "boolean": bool,
            "string": str,
            "integer": int,
            "number": (int, float),
        }
        assert isinstance(value, kinds[schema["type"]])


@pytest.mark.parametrize("stream", STREAMS)
def test_payload_fits_its_schema(stream: str) -> None:
    assert_fits(json.loads(encode(PAYLOADS[stream])), STREAMS[stream].json_schema())


FOXGLOVE_REQUIRED = {
    "pose": {"timestamp", "frame_id", "pose"},
    "scan": {
        "timestamp",
        "frame_id",
        "pose",
        "start_angle",
        "end_angle",
        "ranges",
        "intensities",
    },
    "particles": {"timestamp", "frame_id", "poses"},
    "tracks": {"deletions", "entities"},
    "event": {"timestamp", "level", "message", "name", "file", "line"},
}
"""Required fields of the published schemas."""


@pytest.mark.parametrize("stream", FOXGLOVE_REQUIRED)
def test_foxglove_payload_has_every_required_field(stream: str) -> None:
    assert json.loads(encode(PAYLOADS[stream])).keys() == FOXGLOVE_REQUIRED[stream]


def test_scene_entity_has_every_required_field() -> None:
    (entity,) = json.loads(encode(PAYLOADS["tracks"]))["entities"]
    primitives = "arrows cubes spheres cylinders lines triangles texts models"
    head = "timestamp frame_id id lifetime frame_locked metadata"
    assert entity.keys() == {*head.split(), *primitives.split()}
    (arrow,) = entity["arrows"]
    assert arrow["shaft_length"] == pytest.approx(0.5)


def test_beam_without_return_is_zero() -> None:
    scan = json.loads(encode(PAYLOADS["scan"]))
    assert scan["ranges"] == [1.0, 0.0, 2.0]
    assert (scan["start_angle"], scan["end_angle"]) == (-1.5, -0.5)


def test_actions_of_viewers_equal_the_actions() -> None:
    assert set(ACTIONS) == {str(action) for action in Action}
    degrees = STREAMS["decision"].json_schema()["properties"]["degrees"]
    assert set(degrees["properties"]) == set(ACTIONS)


def test_degrees_of_further_actions_survive() -> None:
    content = json.loads(encode(PAYLOADS["decision"]))
    content["degrees"] = {"dock": 0.25}
    payload = decode("decision", json.dumps(content).encode())
    assert isinstance(payload, DecisionPayload)
    assert payload.degrees == {"dock": 0.25}


@pytest.mark.parametrize("theta", [0.0, 1.0, -3.0, math.pi])
def test_planar_pose_survives_the_quaternion(theta: float) -> None:
    assert planar_pose(pose3(Pose(1.0, -2.0, theta))) == pytest.approx((1.0, -2.0, theta))


def test_time_stamp_counts_from_the_wall_clock_of_the_start() -> None:
    assert timestamp_at(1.5) == Timestamp(sec=1, nsec=500_000_000)
    assert timestamp_at(0.000001, 1_700_000_000_999_999_500) == Timestamp(
        sec=1_700_000_001, nsec=500
    )


@pytest.mark.parametrize(
    ("stream", "data"),
    [
        ("status", b""),
        ("status", b"{"),
        ("status", b"\xff\xfe"),
        ("status", b'{"robot": 1}'),
        ("pose", encode(PAYLOADS["status"])),
        ("no such stream", b"{}"),
    ],
)
def test_invalid_payload_raises_payload_error(stream: str, data: bytes) -> None:
    with pytest.raises(PayloadError, match=stream):
        decode(stream, data)


def test_key_of_a_stream_and_of_a_robot() -> None:
    assert key_of("north", "anna", "pose") == "patrol/north/anna/pose"
    assert key_of("north", "anna") == "patrol/north/anna"
