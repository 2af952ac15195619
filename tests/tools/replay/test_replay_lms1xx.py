"""A recorded run with an LMS 111: replayed, decoded and exported."""

from __future__ import annotations

from contextlib import closing
from pathlib import Path

import pytest

from drivers.lms1xx.settings import LaserSettings
from maps.map_folder import MapFolder, load_map_folder
from robot_agent.config import AgentConfig, find_map
from tools.bench.fleet import Fleet
from tools.bench.fleet_recorder import FleetRecorder
from tools.logs.carmen_writer import recording_to_carmen
from tools.logs.recorded_config import recorded_config
from tools.logs.recorded_scans import recorded_scans
from tools.logs.recording import read_recording
from tools.replay.replay import Replay
from tools.simulation.truth.truth import load_truth

SECONDS = 6.0


@pytest.fixture(scope="module")
def folder() -> MapFolder:
    return load_map_folder(find_map("paper_lab", Path()))


@pytest.fixture(scope="module")
def recorded(folder: MapFolder, tmp_path_factory: pytest.TempPathFactory) -> Path:
    config = AgentConfig(laser=LaserSettings())
    with closing(FleetRecorder(folder, tmp_path_factory.mktemp("recording"))) as recorder:
        fleet = Fleet(
            *(folder, 1, 1, config), observer=recorder.observe, truth=load_truth("lms1xx")
        )
        while fleet.t < SECONDS:
            fleet.step()
        fleet.shut_down()
    return recorder.paths[0]


def test_replay_is_identical(recorded: Path) -> None:
    result = Replay(read_recording(recorded)).run()
    assert result.difference is None
    assert result.decisions > 0


def test_every_scan_is_in_the_recording(recorded: Path) -> None:
    recording = read_recording(recorded)
    config, left_out = recorded_config(recording)
    assert left_out == []
    assert config.laser == LaserSettings()
    steps = list(recorded_scans(recording, config))
    assert len(steps) == pytest.approx(50 * SECONDS, rel=0.1)
    assert max(len(step.points) for step in steps) > 500


def test_carmen_gets_the_half_turn_that_its_logs_have(recorded: Path, tmp_path: Path) -> None:
    target = tmp_path / "run.log"
    scans = recording_to_carmen(read_recording(recorded), target)
    lines = [line for line in target.read_text().splitlines() if line.startswith("FLASER")]
    assert len(lines) == scans
    assert {line.split()[1] for line in lines} == {"361"}
