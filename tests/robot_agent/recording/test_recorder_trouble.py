"""A robot that cannot record continues and reports it."""

from __future__ import annotations

import signal
import subprocess
from pathlib import Path

import msgspec

from robot_agent.config import AgentConfig, RecorderSettings, format_config
from tools.deploy.child_program import environment, program


def test_folder_that_cannot_be_made_is_reported_and_the_agent_continues(tmp_path: Path) -> None:
    (tmp_path / "in_the_way").touch()
    folder = str(tmp_path / "in_the_way" / "runs")
    told = words_of_an_agent(tmp_path, RecorderSettings(folder=folder))
    assert any(f"error: recorder: {folder}: recording stopped: " in line for line in told)


def test_full_disk_is_reported_and_the_agent_continues(tmp_path: Path) -> None:
    told = words_of_an_agent(tmp_path, RecorderSettings(), "--record", "/dev/full")
    assert any("error: recorder: /dev/full: recording stopped: No space" in line for line in told)


def words_of_an_agent(folder: Path, recorder: RecorderSettings, *options: str) -> list[str]:
    """Start an agent, end it once it tells about its recorder; return what it told."""
    config = folder / "robot1.toml"
    defaults = AgentConfig()
    nowhere = str(folder / "no_port")
    settings = msgspec.structs.replace(
        defaults,
        base=msgspec.structs.replace(defaults.base, url=nowhere),
        laser=msgspec.structs.replace(defaults.laser, url=nowhere),
        recorder=recorder,
    )
    config.write_text(format_config(settings))
    told: list[str] = []
    with subprocess.Popen(
        program("tools.cli", "agent", str(config), *options),
        env=environment(),
        stderr=subprocess.PIPE,
        text=True,
    ) as agent:
        assert agent.stderr is not None
        for line in agent.stderr:
            told.append(line)
            if "recorder" in line:
                break
        assert agent.poll() is None
        agent.send_signal(signal.SIGTERM)
        told += agent.stderr.readlines()
    assert agent.returncode == 0
    return told


def test_existing_file_is_refused_before_the_robot_starts(tmp_path: Path) -> None:
    config, recording = tmp_path / "robot1.toml", tmp_path / "run.mcap"
    config.write_text(format_config(AgentConfig()))
    recording.write_bytes(b"yesterday")
    agent = subprocess.run(
        program("tools.cli", "agent", str(config), "--record", str(recording)),
        env=environment(),
        capture_output=True,
        text=True,
        check=False,
    )
    assert agent.returncode == 1
    assert agent.stderr.splitlines() == [
        f"patrol agent: {recording} exists, and recordings are never overwritten; "
        "give another name or move it"
    ]
    assert recording.read_bytes() == b"yesterday"
