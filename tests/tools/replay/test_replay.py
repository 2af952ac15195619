"""Convert, record, replay: the same events give the same effects."""

import gzip
from pathlib import Path

import numpy as np
import pytest

from maps.map_folder import MapFolder, load_map_folder
from robot_agent.config import find_map, parse_config
from robot_agent.messages.effects import Publish
from robot_agent.recording.recording_writer import Gap, RecordingWriter, Reference
from tools.benchmark.recordings import record_lockstep
from tools.localize.localize import LocalizeOptions, localize_steps
from tools.logs.carmen import CarmenLog, read_carmen
from tools.logs.recorded_scans import recorded_scans
from tools.logs.recording import read_recording
from tools.replay.carmen_devices import LEAD_IN_S, moments, padded_ranges
from tools.replay.carmen_recording import convert
from tools.replay.replay import Replay, report_lines

SCANS = 40


@pytest.fixture(scope="module")
def log(data_folder: Path, tmp_path_factory: pytest.TempPathFactory) -> CarmenLog:
    """The first scans of the Intel log."""
    rows = gzip.decompress((data_folder / "logs/intel-corrected.log.gz").read_bytes()).splitlines()
    ends = [number for number, row in enumerate(rows) if row.startswith(b"FLASER")]
    path = tmp_path_factory.mktemp("log") / "intel.log"
    path.write_bytes(b"\n".join(rows[: ends[SCANS - 1] + 1]) + b"\n")
    return read_carmen(path)


@pytest.fixture(scope="module")
def intel_lab() -> MapFolder:
    return load_map_folder(find_map("intel_lab", Path()))


@pytest.fixture(scope="module")
def converted(
    log: CarmenLog, intel_lab: MapFolder, tmp_path_factory: pytest.TempPathFactory
) -> Path:
    path = tmp_path_factory.mktemp("recording") / "intel.mcap"
    assert convert(log, intel_lab, path).scans == SCANS
    return path


@pytest.fixture(scope="module")
def recorded(tmp_path_factory: pytest.TempPathFactory) -> Path:
    """Record twenty seconds of a patrolling robot on the bench."""
    folder = load_map_folder(find_map("paper_lab", Path()))
    return record_lockstep(folder, 20.0, tmp_path_factory.mktemp("recording"))


def test_moments_contain_every_scan_without_gaps(log: CarmenLog) -> None:
    found = moments(log)
    scans = [moment.scan for moment in found if moment.scan is not None]
    assert scans == log.scans
    times = np.array([moment.t for moment in found])
    assert (np.diff(times) > 0).all()
    assert np.diff(times).max() < 0.151
    first = next(moment for moment in found if moment.scan is not None)
    assert first.t == pytest.approx(log.scans[0].t - log.odometry[0][0] + LEAD_IN_S)
    assert first.odometry == log.scans[0].odometry


def test_missing_last_beam_is_padded(log: CarmenLog) -> None:
    padded = padded_ranges(log.scans[0])
    assert padded.size == 181
    assert padded[-1] == np.inf


def test_converted_bytes_decode_to_the_log(log: CarmenLog, converted: Path) -> None:
    recording = read_recording(converted)
    config = parse_config(recording.header.configuration, "recording")
    steps = list(recorded_scans(recording, config))
    assert len(steps) == SCANS
    for step, scan in zip(steps, log.scans, strict=True):
        assert step.reference is not None
        assert step.reference == pytest.approx(scan.reference)
        assert step.points == pytest.approx(scan.points(), abs=0.001), "millimetres on the wire"
    # Odometry went through the robot's counters: 0.84 mm and 0.09 degrees a step, wrapping.
    driven = steps[0].odometry.between(steps[-1].odometry)
    logged = log.scans[0].odometry.between(log.scans[-1].odometry)
    assert (driven.x, driven.y) == pytest.approx((logged.x, logged.y), abs=0.01)
    assert driven.theta == pytest.approx(logged.theta, abs=0.003)


def test_converted_log_localizes(converted: Path, intel_lab: MapFolder) -> None:
    recording = read_recording(converted)
    config = parse_config(recording.header.configuration, "recording")
    result = localize_steps(
        "intel", list(recorded_scans(recording, config)), intel_lab, LocalizeOptions()
    )
    position = result.summary["position_m"]
    assert isinstance(position, dict)
    assert position["median"] < 0.05
    assert result.summary["lost_share"] == 0.0


@pytest.mark.parametrize("which", ["converted", "recorded"])
def test_replay_is_identical(which: str, request: pytest.FixtureRequest) -> None:
    result = Replay(read_recording(request.getfixturevalue(which))).run()
    assert result.difference is None
    assert result.events > 100
    assert result.bytes_sent > 100
    assert any("replayed" in line for line in report_lines(result))


def test_border_of_a_bench_is_recorded(tmp_path: Path) -> None:
    folder = load_map_folder(find_map("intel_lab", Path()), "open")
    result = Replay(read_recording(record_lockstep(folder, 6.0, tmp_path))).run()
    assert result.difference is None
    assert result.decisions > 0


def test_replay_compares_with_the_reference(converted: Path) -> None:
    result = Replay(read_recording(converted)).run()
    assert len(result.position_errors) == SCANS
    assert np.median(result.position_errors) < 0.05


def test_replay_ends_at_until(recorded: Path) -> None:
    assert Replay(read_recording(recorded)).run(until=5.0).duration <= 5.0


def rewrite(source: Path, target: Path, change: dict[int, object]) -> None:
    """Copy a recording with items replaced by their number; None leaves one out."""
    recording = read_recording(source)
    t = 0.0
    with target.open("wb") as file:
        writer = RecordingWriter(file, recording.header)
        for number, original in enumerate(recording.items()):
            item = change.get(number, original)
            t = getattr(original, "t", t)
            if item is None:
                continue
            if isinstance(item, Gap):
                writer.write_gap(item)
            elif isinstance(item, Reference):
                writer.write_reference(item.t, item.pose)
            elif hasattr(item, "t"):
                writer.write_event(item)
            else:
                writer.write_effect(t, item)  # type: ignore[arg-type]
        writer.finish()


def test_a_changed_byte_is_found_and_named(recorded: Path, tmp_path: Path) -> None:
    items = list(read_recording(recorded).items())
    number = next(
        i
        for i, item in enumerate(items)
        if i > 500 and isinstance(item, Publish) and item.stream == "decision"
    )
    payload = items[number].payload.replace(b'"direction":', b'"direction":1')
    rewrite(recorded, tmp_path / "changed.mcap", {number: Publish("decision", payload)})
    result = Replay(read_recording(tmp_path / "changed.mcap")).run()
    assert result.difference is not None
    assert result.difference.startswith("different at ")
    assert "recorded: Publish(stream='decision'" in result.difference


def test_a_missing_effect_is_found(recorded: Path, tmp_path: Path) -> None:
    items = list(read_recording(recorded).items())
    number = next(i for i, item in enumerate(items) if i > 500 and isinstance(item, Publish))
    rewrite(recorded, tmp_path / "missing.mcap", {number: None})
    assert Replay(read_recording(tmp_path / "missing.mcap")).run().difference is not None


def test_a_gap_ends_the_comparison(recorded: Path, tmp_path: Path) -> None:
    rewrite(recorded, tmp_path / "gap.mcap", {600: Gap(1.0, 3)})
    difference = Replay(read_recording(tmp_path / "gap.mcap")).run().difference
    assert difference is not None
    assert "lost 3 records" in difference


def test_truncated_recording_replays_its_complete_part(recorded: Path, tmp_path: Path) -> None:
    cut = tmp_path / "cut.mcap"
    cut.write_bytes(recorded.read_bytes()[: recorded.stat().st_size * 4 // 5])
    recording = read_recording(cut)
    result = Replay(recording).run()
    assert result.difference is None
    assert result.events > 50
    assert recording.truncated is not None
