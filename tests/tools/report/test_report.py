"""Page and numbers of a short run of two robots, one with a silent laser for a while."""

from __future__ import annotations

import json
import re
import shutil
from contextlib import closing
from dataclasses import replace
from pathlib import Path
from xml.etree import ElementTree

import numpy as np
import pytest

from maps.map_folder import load_map_folder
from maps.pose import Pose
from maps.zone_file import ZONES_FILE
from robot_agent.config import find_map
from tools.bench.bench_fault import parse_fault
from tools.bench.fleet import Fleet
from tools.bench.fleet_recorder import FleetRecorder
from tools.cli import main
from tools.report.alignment import AlignmentError, align
from tools.report.incidents import override_times
from tools.report.numbers import numbers
from tools.report.page import figures_alone, page
from tools.report.recorded_zones import zones_here
from tools.report.run_log import RunLog, read_run
from tools.report.team import Team

DURATION_S = 34.0


@pytest.fixture(scope="module")
def recordings(tmp_path_factory: pytest.TempPathFactory) -> list[Path]:
    """Record two robots that meet on the paper's border; robot1's laser is silent for 3 s."""
    folder = load_map_folder(find_map("paper_lab", Path()))
    with closing(FleetRecorder(folder, tmp_path_factory.mktemp("run"))) as recorder:
        fleet = Fleet(
            *(folder, 2, 3),
            starts=[Pose(8.0, 3.76, 0.0), Pose(14.0, 3.76, 3.14)],
            observer=recorder.observe,
            faults=[parse_fault("robot1:blind@25-28")],
        )
        while fleet.t < DURATION_S:
            fleet.step()
        fleet.shut_down()
    return recorder.paths


@pytest.fixture(scope="module")
def report(recordings: list[Path], tmp_path_factory: pytest.TempPathFactory) -> Path:
    target = tmp_path_factory.mktemp("report")
    assert main(["report", *map(str, recordings), "-o", str(target)]) == 0
    return target


@pytest.fixture
def runs(recordings: list[Path]) -> list[RunLog]:
    return [read_run(path) for path in recordings]


def test_page_is_self_contained(report: Path) -> None:
    text = (report / "report.html").read_text()
    for word in ('src="', "<script", "@import", "url(h", "<link "):
        assert word not in text
    assert text.count("<figure>") >= 9
    for title in ("Action selection", "Meetings", "Idleness along the border", "Safety gate"):
        assert f"<h2>{title}</h2>" in text
    assert "laser silent" in text
    start = text.index("<svg")
    ElementTree.fromstring(text[start : text.index("</svg>") + 6])


def test_numbers_equal_those_of_the_run(report: Path) -> None:
    found = json.loads((report / "report.json").read_text())
    assert found["duration_s"] == pytest.approx(DURATION_S, abs=0.2)
    assert [robot["robot"] for robot in found["robots"]] == ["robot1", "robot2"]
    assert len(found["meetings"]) == 1
    assert found["meetings"][0]["robots"] == ["robot1", "robot2"]
    assert found["closest_m"] == found["meetings"][0]["closest_m"] < 2.0
    for robot in found["robots"]:
        assert robot["border_distance_m"]["p99"] < 0.2
        assert sum(robot["action_share"].values()) == pytest.approx(1.0)
        assert 0.0 < robot["localization"]["bound_m"]["median"] < 0.3
        assert robot["ended_in_order"]
        assert robot["truncated"] is None


def test_turns_are_told_with_their_cause(report: Path) -> None:
    found = json.loads((report / "report.json").read_text())
    assert [robot["turns"]["teammate"] for robot in found["robots"]] == [1, 1]
    assert [robot["overrides"] for robot in found["robots"]] == [{}, {}]
    assert "from a teammate ahead" in (report / "report.html").read_text()


def test_overrides_are_told_with_their_times(runs: list[RunLog]) -> None:
    [run, _other] = runs
    run.override = ["wait" if 5.0 <= t < 7.0 else "" for t in run.decision_t]
    [(reason, (times, seconds))] = override_times(run).items()
    assert (reason, times) == ("wait", 1)
    assert seconds == pytest.approx(2.0, abs=0.2)


def test_fault_is_an_incident_with_time_and_reaction(report: Path) -> None:
    found = json.loads((report / "report.json").read_text())
    (incident,) = found["incidents"]
    assert (incident["robot"], incident["what"]) == ("robot1", "laser silent")
    assert incident["start"] == pytest.approx(25.0, abs=0.3)
    assert 28.0 < incident["end"] < 29.5, "a silent laser is polled once a second"
    assert 0.0 < incident["stopped_after_s"] < 0.6
    assert 0.0 < incident["moved_after_s"] < 2.0


def test_places_are_told_with_their_zone(report: Path) -> None:
    text = (report / "report.html").read_text()
    found = json.loads((report / "report.json").read_text())
    (meeting,), (incident,) = found["meetings"], found["incidents"]
    assert meeting["zone"] == incident["zone"] == "south corridor"
    assert "laser silent (south corridor)" in text
    assert re.search(r"<td>s = [0-9.]+ m \(south corridor\)</td>", text)
    assert ">north corridor</text>" in text, "drawn on the map"


def test_report_takes_the_zones_of_the_stated_folder(
    recordings: list[Path], tmp_path: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    shutil.copytree(find_map("paper_lab", Path()), tmp_path / "lab")
    (tmp_path / "lab" / ZONES_FILE).write_text(
        "[[zone]]\nname = '$a$ <b>'\npolygon = [[0, 0], [26, 0], [26, 18], [0, 18]]\n"
    )
    words = ["report", str(recordings[0]), "-o", str(tmp_path), "--map"]
    assert main([*words, str(tmp_path / "lab")]) == 0
    assert "laser silent ($a$ &lt;b&gt;)" in (tmp_path / "report.html").read_text()
    assert main([*words, "large_hall"]) == 1
    assert "another map than that of the recordings" in capsys.readouterr().err


def test_map_that_is_not_here_has_no_zones(runs: list[RunLog], tmp_path: Path) -> None:
    team = Team(runs, align(runs))
    assert zones_here(team.folder, tmp_path / "gone") == ()
    assert zones_here(team.folder, find_map("large_hall", Path())) == ()


def test_hostile_texts_of_a_recording_are_escaped(runs: list[RunLog]) -> None:
    hostile = """</title><script>alert('1')</script>"&$x$"""
    for run in runs:
        run.header = replace(run.header, robot=hostile, versions=hostile, source=hostile)
        run.lines = [replace(line, part=hostile, message=hostile) for line in run.lines]
    team = Team(runs, align(runs))
    text = page(team, numbers(team), lambda _: None)
    assert "<script" not in text
    assert text.count("</title>") == 1
    assert text.count("&lt;script&gt;") > 10


def test_figures_can_be_had_alone(runs: list[RunLog], tmp_path: Path) -> None:
    team = Team(runs, align(runs))
    files = figures_alone(team, numbers(team), tmp_path, "pdf")
    assert {"map.pdf", "map-2.pdf", "border.pdf", "idleness.pdf"} <= {path.name for path in files}
    assert set(files) == set(tmp_path.iterdir())
    assert all(path.read_bytes().startswith(b"%PDF") for path in files)


def test_gate_reasons_are_those_of_the_fault(runs: list[RunLog]) -> None:
    team = Team(runs, align(runs))
    held = [reason for reason in runs[0].gate if reason == "stale_laser"]
    assert 28 <= len(held) <= 44, "ten decisions a second, until the next try finds it again"
    assert team.sampled[0].position.shape == (team.t.size, 2)


HOUR_S, DAY_S, YEAR_S = 3600.0, 86400.0, 31_557_600.0


@pytest.mark.parametrize(
    "error", [-7.3, 31.05, HOUR_S, -HOUR_S, DAY_S + 3.5, -DAY_S, 56 * YEAR_S, -56 * YEAR_S]
)
def test_clocks_are_set_by_mutual_sightings(runs: list[RunLog], error: float) -> None:
    set_wall_clocks(runs, error)
    first, second = align(runs, trust_host=False)
    assert first.correction == 0.0
    assert second.how == "mutual sightings"
    assert second.correction == pytest.approx(-error, abs=0.25)
    assert second.residual is not None
    assert second.residual < 0.3
    assert Team(runs, [first, second]).end == pytest.approx(DURATION_S, abs=1.0)


def set_wall_clocks(runs: list[RunLog], error: float) -> None:
    """Let the second robot's wall clock be ahead by an error, s."""
    for run, ahead in zip(runs, (0.0, error), strict=True):
        run.header = replace(run.header, start_wall_ns=2 * 10**18 + round(ahead * 1e9))


@pytest.mark.parametrize(("error", "words"), [(HOUR_S, "3566 s"), (-56 * YEAR_S, "56 years")])
def test_clock_far_from_all_others_that_sightings_do_not_tell_is_refused(
    runs: list[RunLog], error: float, words: str
) -> None:
    set_wall_clocks(runs, error)
    for run in runs:
        run.neighbor[:] = np.nan
    with pytest.raises(
        AlignmentError, match=rf"clock {words} from .*--offset robot2={-error:.0f} if"
    ) as told:
        align(runs, trust_host=False)
    assert "too few mutual sightings" in str(told.value)
    align(runs, {"robot2": -error}, trust_host=False)
    assert runs[0].shift == runs[1].shift == 0.0


def test_wall_clocks_count_where_nobody_was_seen(runs: list[RunLog]) -> None:
    set_wall_clocks(runs, 3.0)
    for run in runs:
        run.neighbor[:] = np.nan
    _first, second = align(runs, trust_host=False)
    assert second.how == "wall clock: too few mutual sightings to correct it"
    assert runs[1].shift == pytest.approx(3.0)


def test_report_of_years_is_refused_before_it_takes_all_memory(runs: list[RunLog]) -> None:
    with pytest.raises(AlignmentError, match="span 56 years, a report at most 3 days"):
        align(runs, {"robot2": 56 * YEAR_S})


def test_robots_whose_sightings_fit_many_offsets_are_not_guessed(runs: list[RunLog]) -> None:
    """Both go to and fro in view of each other: every period fits alike."""
    set_wall_clocks(runs, HOUR_S)
    for run in runs:
        run.decision_t = np.arange(0.0, 600.0, 0.1)
        run.end = 600.0
        swing = np.sin(run.decision_t * 2.0 * np.pi / 20.0)
        run.pose = np.column_stack((swing, np.zeros((swing.size, 2))))
        run.neighbor = run.pose[:, :2]
    with pytest.raises(AlignmentError, match="sightings fit several offsets alike; state"):
        align(runs, trust_host=False)


def test_robot_that_met_only_a_third_one_is_set_by_it(runs: list[RunLog]) -> None:
    """The second recording tells nothing of the first; the third is set first, then tells it."""
    first, second = runs
    third = replace(first, header=replace(first.header, robot="robot3", start_wall_ns=7 * 10**18))
    first.neighbor = np.full_like(first.neighbor, np.nan)
    first.pose = np.full_like(first.pose, 900.0)
    second.header = replace(second.header, source="live", start_wall_ns=6 * 10**18)
    third.header = replace(third.header, source="live")
    align([first, second, third], {"robot3": -7e9}, trust_host=False)
    assert second.shift == pytest.approx(third.shift, abs=0.25)


def test_clocks_of_one_host_are_its_monotonic_clock(runs: list[RunLog]) -> None:
    for run, monotonic in zip(runs, (5_000_000_000, 7_500_000_000), strict=True):
        run.header = replace(run.header, boot="one", start_monotonic_ns=monotonic)
    _first, second = align(runs)
    assert "same host" in second.how
    assert runs[1].shift - runs[0].shift == pytest.approx(2.5)


def test_stated_offset_is_used_and_unknown_robot_is_an_error(runs: list[RunLog]) -> None:
    align(runs, {"robot2": 4.0})
    assert runs[1].shift - runs[0].shift == pytest.approx(4.0)
    with pytest.raises(AlignmentError, match="robots are robot1, robot2"):
        align(runs, {"robot9": 1.0})


def test_truncated_recording_is_reported_up_to_the_cut(
    recordings: list[Path], tmp_path: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    cut = tmp_path / "cut.mcap"
    cut.write_bytes(recordings[0].read_bytes()[:-200_000])
    assert main(["report", str(cut), "-o", str(tmp_path)]) == 0
    assert "readable up to byte" in capsys.readouterr().err
    found = json.loads((tmp_path / "report.json").read_text())
    assert found["incidents"][-1]["what"].startswith("recording breaks off")


def test_invalid_offset_is_refused(recordings: list[Path], tmp_path: Path) -> None:
    assert main(["report", str(recordings[0]), "-o", str(tmp_path), "--offset", "x=y"]) == 1


def test_second_file_of_one_run_is_no_absence_of_the_agent(runs: list[RunLog]) -> None:
    """After an error of the disk a run goes on in a new file, with the same header."""
    first, other = runs
    for run in runs:
        run.header = replace(run.header, boot="one", start_monotonic_ns=5)
    team = Team([first, replace(first), other], align([first, replace(first), other]))
    assert not [incident for incident in team.incidents if "no agent" in incident.what]
    restarted = replace(first, header=replace(first.header, start_monotonic_ns=60 * 10**9))
    team = Team([first, restarted, other], align([first, restarted, other]))
    assert [incident.what for incident in team.incidents if "no agent" in incident.what]
