"""Small recordings of robots, for tests of playback."""

from __future__ import annotations

import io
from pathlib import Path

from maps.map_folder import load_map_folder
from robot_agent.config import AgentConfig, find_map, format_config
from robot_agent.messages.effects import Publish
from robot_agent.messages.streams import encode
from robot_agent.recording.recording_writer import RecordingWriter
from robot_agent.recording.run_header import RunHeader
from tests.tools.monitor.reports import decision, pose, status

FOLDER = load_map_folder(find_map("paper_lab", Path()))
START = 1_700_000_000.0


def header_of(name: str, begin: float) -> RunHeader:
    """Return the head of a robot's recording from ``begin`` (s since 1970) on."""
    return RunHeader(
        robot=name,
        team="north",
        seed=1,
        software_version="0.1.0",
        start_wall_ns=round(begin * 1e9),
        configuration=format_config(AgentConfig()).encode(),
        map_files=FOLDER.files,
    )


def agent_recording(name: str, path: Path, begin: float, seconds: float) -> Path:
    """Write a robot's recording from ``begin`` (s since 1970) on: it drives along x at 0.1 m/s."""
    file = io.BytesIO()
    writer = RecordingWriter(file, header_of(name, begin))
    for step in range(round(10 * seconds)):
        t = 0.1 * step
        x = 0.1 * (begin - START + t)
        writer.write_effect(t, Publish("pose", encode(pose(begin + t, x))))
        writer.write_effect(t, Publish("decision", encode(decision(begin + t))))
        if step % 5 == 0:
            writer.write_effect(t, Publish("status", encode(status(begin + t))))
        if step % 50 == 49:
            writer.flush()
    writer.finish()
    path.write_bytes(file.getvalue())
    return path
