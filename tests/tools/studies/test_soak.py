"""A short soak: random faults, the person's visits, recordings rotated and deleted."""

import json
from pathlib import Path

import pytest

from maps.map_folder import load_map_folder
from robot_agent.config import find_map
from tools.bench.bench_fault import BenchFault, FaultKind
from tools.simulation.world import Contact
from tools.studies import soak
from tools.studies.soak import Soak, SoakHour, SoakLog, random_faults, recording_sizes, slope


def test_faults_are_of_every_kind_and_reproducible():
    faults = random_faults(2, 20_000.0, 200.0, seed=3)
    assert faults == random_faults(2, 20_000.0, 200.0, seed=3)
    assert {fault.kind for fault in faults} == set(FaultKind)
    assert {fault.robot for fault in faults} == {"robot1", "robot2"}
    assert all(60.0 < fault.start < fault.end for fault in faults)


def test_slope_of_points_on_a_line_is_the_lines():
    assert slope([(1.0, 5.0), (2.0, 7.0), (3.0, 9.0)]) == pytest.approx(2.0)
    assert slope([(1.0, 5.0)]) is None


def test_stuck_robot_is_released_by_a_person_and_recordings_rotate(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.setattr(soak, "HOUR_S", 10.0)
    monkeypatch.setattr(soak, "KEEP_MB", 1.4)
    faults = [BenchFault("robot1", FaultKind.STUCK, 14.0, 19.0)]
    monkeypatch.setattr(soak, "random_faults", lambda *_: faults)
    folder = load_map_folder(find_map("paper_lab", Path.cwd()))
    run = Soak(folder, 1, 1, 80.0, 600.0, tmp_path)
    rows, speeds = [], []
    for row in run.hours():
        rows.append(row)
        speeds.append(run.fleet.robots[0].rig.base.velocity[0])
    assert [row.contacts for row in rows] == [0] * 8
    assert rows[-1].latched == 1
    assert rows[-1].records_lost == 0
    assert speeds[1] < 0.1 < max(speeds[4:]), "patrols again after the person came"
    assert not list(tmp_path.glob("robot1-000001-*"))


def test_empty_battery_is_exchanged(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr(soak, "HOUR_S", 30.0)
    monkeypatch.setattr(soak, "random_faults", lambda *_: [])
    folder = load_map_folder(find_map("paper_lab", Path.cwd()))
    run = Soak(folder, 1, 1, 60.0, 600.0, tmp_path)
    base = run.fleet.robots[0].rig.base
    base.battery.volts = 10.9
    rows, speeds = [], []
    for row in run.hours():
        rows.append(row)
        speeds.append(base.velocity[0])
    assert [row.batteries for row in rows] == [1, 1]
    assert base.battery.volts > 12.9
    assert rows[-1].latched == 0
    assert max(speeds) > 0.1, "patrols with the full battery"


def test_rows_and_summary_are_on_disk_after_each_hour(tmp_path: Path) -> None:
    path = tmp_path / "soak.jsonl"
    path.write_text("of an earlier run\n")
    log = SoakLog(path)
    for hour in (1.0, 2.0, 3.0):
        log.add(row(hour, memory_mb=100.0 + hour, touched=(f"{hour} s: robot1, a wall",)))
        lines = [json.loads(line) for line in path.read_text().splitlines()]
        assert [line["hour"] for line in lines] == [float(n) for n in range(1, len(lines) + 1)]
        summary = json.loads((tmp_path / "soak.summary.json").read_text())
        assert summary["hour"] == hour
        assert len(summary["touched"]) == len(lines)
    assert summary["memory_slope_mb_per_hour"] == pytest.approx(1.0)
    assert summary["times_real_time"] == 14.4


def row(hour: float, **changed: object) -> SoakHour:
    values: dict[str, object] = dict.fromkeys(SoakHour.__dataclass_fields__, 0)
    return SoakHour(**values | {"hour": hour, "wall_s": 250.0 * hour, "touched": ()} | changed)  # type: ignore[arg-type]


@pytest.mark.parametrize(("dead", "blind"), [(0, 1), (1, 1), (2, 0)])
def test_contact_counts_as_blind_only_if_an_agent_of_its_robots_is_dead(
    tmp_path: Path, dead: int, blind: int
) -> None:
    folder = load_map_folder(find_map("paper_lab", Path.cwd()))
    run = Soak(folder, 3, 1, 1.0, 600.0, tmp_path)
    bodies = [robot.rig.body.index for robot in run.fleet.robots]
    run._dead_until[dead] = run.fleet.t + 1.0
    run.fleet.world.contact_log.append(Contact(bodies[0], bodies[1]))
    run._count_contacts()
    assert (run._contacts_seen, run._contacts_blind) == (1, blind)


def test_recording_deleted_while_sizes_are_read_is_left_out(tmp_path: Path) -> None:
    (tmp_path / "kept.mcap").write_bytes(b"12345")
    (tmp_path / "gone.mcap").symlink_to(tmp_path / "deleted")  # listed, and not there any more
    assert recording_sizes(tmp_path) == [5]
