"""A short soak: random faults, persons who help, recordings that make room."""

from pathlib import Path

import pytest

from maps.map_folder import load_map_folder
from robot_agent.config import find_map
from tools import soak
from tools.bench.bench_fault import BenchFault, FaultKind
from tools.soak import Soak, random_faults, slope


def test_faults_are_of_every_kind_and_reproducible():
    faults = random_faults(2, 20_000.0, 200.0, seed=3)
    assert faults == random_faults(2, 20_000.0, 200.0, seed=3)
    assert {fault.kind for fault in faults} == set(FaultKind)
    assert {fault.robot for fault in faults} == {"robot1", "robot2"}
    assert all(60.0 < fault.start < fault.end for fault in faults)


def test_slope_of_a_line():
    assert slope([(1.0, 5.0), (2.0, 7.0), (3.0, 9.0)]) == pytest.approx(2.0)
    assert slope([(1.0, 5.0)]) is None


def test_a_robot_stuck_for_long_is_helped_and_recordings_rotate(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.setattr(soak, "HOUR_S", 20.0)
    monkeypatch.setattr(soak, "KEEP_MB", 0.7)
    faults = [BenchFault("robot1", FaultKind.STUCK, 14.0, 19.0)]
    monkeypatch.setattr(soak, "random_faults", lambda *_: faults)
    folder = load_map_folder(find_map("paper_lab", Path.cwd()))
    run = Soak(folder, 1, 1, 80.0, 600.0, tmp_path)
    rows, speeds = [], []
    for row in run.hours():
        rows.append(row)
        speeds.append(run.fleet.robots[0].rig.base.velocity[0])
    assert [row.contacts for row in rows] == [0, 0, 0, 0]
    assert rows[-1].latched == 1
    assert rows[-1].records_lost == 0
    assert speeds[0] < 0.1 < max(speeds[2:]), "patrols again after the person came"
    assert "robot1-20000101T000000Z.mcap" not in {path.name for path in tmp_path.iterdir()}
