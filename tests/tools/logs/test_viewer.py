"""Recordings read by the standard reader and checked with the schemas of the viewer's library."""

from __future__ import annotations

import json
from collections import Counter
from pathlib import Path
from typing import Any

import pytest
from mcap.reader import make_reader

from maps.map_folder import load_map_folder
from robot_agent.config import find_map
from robot_agent.messages.foxglove import SceneUpdate, timestamp_at, track_entity
from robot_agent.messages.streams import STREAMS, encode
from tools.benchmark.recordings import record_lockstep

NESTED = {
    "timestamp": "Timestamp",
    "lifetime": "Duration",
    "pose": "Pose",
    "poses": "Pose",
    "position": "Vector3",
    "orientation": "Quaternion",
    "size": "Vector3",
    "color": "Color",
    "entities": "SceneEntity",
    "metadata": "KeyValuePair",
    "arrows": "ArrowPrimitive",
    "cylinders": "CylinderPrimitive",
}
"""Which of the viewer's messages each field of ours holds."""


@pytest.fixture(scope="module")
def recording(tmp_path_factory: pytest.TempPathFactory) -> Path:
    folder = load_map_folder(find_map("paper_lab", Path()))
    return record_lockstep(folder, 6.0, tmp_path_factory.mktemp("viewer"))


def test_standard_reader_reads_every_message(recording: Path) -> None:
    counts: Counter[str] = Counter()
    with recording.open("rb") as file:
        reader = make_reader(file, validate_crcs=True)
        summary = reader.get_summary()
        for schema, channel, message in reader.iter_messages():
            counts[channel.topic] += 1
            if channel.message_encoding == "json":
                assert schema is not None
                assert schema.encoding == "jsonschema"
                json.loads(message.data)
    assert summary is not None
    assert summary.statistics is not None
    assert sum(counts.values()) == summary.statistics.message_count
    assert {"base/rx", "laser/rx", "base/tx", "tick", "link", "decision", "status"} <= set(counts)


def viewer_message(name: str, content: dict[str, Any]) -> Any:
    """Build the viewer's own message of that name; it refuses fields and types it does not know."""
    messages = pytest.importorskip("foxglove.messages", reason="the viewer's library is not here")
    fields = {}
    for key, value in content.items():
        if key == "level":
            value = next(v for v in _levels(messages) if v.value == value)
        elif key in NESTED and isinstance(value, list):
            value = [viewer_message(NESTED[key], item) for item in value]
        elif key in NESTED:
            value = viewer_message(NESTED[key], value)
        fields[key] = value
    return getattr(messages, name)(**fields)


def _levels(messages: Any) -> list[Any]:
    level = messages.LogLevel
    return [level.Unknown, level.Debug, level.Info, level.Warning, level.Error, level.Fatal]


def test_payloads_are_the_viewers_own_messages(recording: Path) -> None:
    kinds = {name: s.schema_name for name, s in STREAMS.items() if "foxglove." in s.schema_name}
    built: Counter[str] = Counter()
    with recording.open("rb") as file:
        for _schema, channel, message in make_reader(file).iter_messages(list(kinds)):
            kind = kinds[channel.topic].removeprefix("foxglove.")
            viewer_message(kind, json.loads(message.data)).encode()
            built[channel.topic] += 1
    assert set(built) >= {"pose", "scan", "particles", "tracks", "event"}


def test_a_track_is_the_viewers_own_entity() -> None:
    stamp = timestamp_at(12.5)
    track = track_entity(stamp, 3, (1.0, 2.0), (0.3, 0.0), kind="teammate", probability=0.9)
    ours = json.loads(encode(SceneUpdate(entities=[track])))
    assert len(viewer_message("SceneUpdate", ours).encode()) > 50


def test_invalid_payload_is_refused() -> None:
    with pytest.raises(TypeError):
        viewer_message("Log", {"message": "x", "nmae": "y"})
    with pytest.raises(TypeError):
        viewer_message("LaserScan", {"ranges": "far"})


def test_viewer_accepts_every_schema(recording: Path, tmp_path: Path) -> None:
    foxglove = pytest.importorskip("foxglove", reason="the viewer's library is not here")
    with recording.open("rb") as file:
        summary = make_reader(file).get_summary()
    assert summary is not None
    context = foxglove.Context()
    writer = foxglove.open_mcap(tmp_path / "copy.mcap", context=context)
    for channel in summary.channels.values():
        if channel.message_encoding != "json":
            continue
        schema = json.loads(summary.schemas[channel.schema_id].data)
        taken = foxglove.Channel(channel.topic, schema=schema, context=context)
        assert taken.message_encoding == "json"
        assert taken.schema().encoding == "jsonschema"
    writer.close()
