"""A robot that cannot record continues and reports it."""

from __future__ import annotations

import os
import signal
import subprocess
import time
from pathlib import Path

import msgspec
import pytest

from robot_agent.config import AgentConfig, RecorderSettings, format_config
from robot_agent.messages.events import Tick
from robot_agent.recording import recorder as recorder_module
from robot_agent.recording.recorder import Recorder
from robot_agent.recording.run_files import OneFile
from robot_agent.recording.run_header import RunHeader
from tools.deploy.child_program import environment, program


def test_folder_that_cannot_be_made_is_reported_and_the_agent_continues(tmp_path: Path) -> None:
    (tmp_path / "in_the_way").touch()
    folder = str(tmp_path / "in_the_way" / "runs")
    told = words_of_an_agent(tmp_path, RecorderSettings(folder=folder))
    assert any(f"error: recorder: {folder}: recording stopped: " in line for line in told)


def test_full_disk_is_reported_and_the_agent_continues(tmp_path: Path) -> None:
    told = words_of_an_agent(tmp_path, RecorderSettings(), "--record", "/dev/full")
    assert any("error: recorder: /dev/full: recording stopped: No space" in line for line in told)


def test_disk_that_hangs_is_told_while_records_wait(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.setattr(recorder_module, "HANG_S", 0.05)
    pipe = tmp_path / "run.mcap"
    os.mkfifo(pipe)  # opening it waits for a reader that does not come
    header = RunHeader("r1", "lab", 1, "1", 0)
    recorder = Recorder(OneFile(pipe), header, close_wait=0.05)
    give_up = time.monotonic() + 5.0
    while not recorder.trouble and time.monotonic() < give_up:
        recorder.record_event(Tick(1.0))
        time.sleep(0.005)
    assert recorder.trouble.startswith(f"{pipe}: the disk hangs")
    assert recorder.lost == 0
    recorder.close()


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
