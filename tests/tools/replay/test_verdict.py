"""The three verdicts of ``patrol replay --check``, and when each is given."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import replace
from pathlib import Path

import msgspec
import pytest

from maps.map_folder import load_map_folder
from robot_agent.config import find_map
from robot_agent.messages.effects import Effect, Publish
from robot_agent.recording.recording_writer import Gap, RecordingWriter
from tools.benchmark.recordings import record_lockstep
from tools.cli import main
from tools.logs.recording import read_recording

OTHER = "numpy AVX9, OpenBLAS Babbage, glibc 1.0, functions 0123456789ab"
Change = Callable[[dict[str, object]], None]


@pytest.fixture(scope="module")
def recorded(tmp_path_factory: pytest.TempPathFactory) -> Path:
    folder = load_map_folder(find_map("paper_lab", Path()))
    return record_lockstep(folder, 8.0, tmp_path_factory.mktemp("recording"))


def rewritten(
    source: Path,
    target: Path,
    change: Change | None = None,
    arithmetic: str | None = None,
    gap_at: int | None = None,
) -> str:
    """Copy a recording with its 20th decision changed, another arithmetic, or a gap."""
    recording = read_recording(source)
    header = recording.header
    if arithmetic is not None:
        header = replace(header, arithmetic=arithmetic)
    decisions = 0
    t = 0.0
    with target.open("wb") as file:
        writer = RecordingWriter(file, header)
        for number, item in enumerate(recording.items()):
            if number == gap_at:
                writer.write_gap(Gap(t, 3))
            if not isinstance(item, Effect):
                t = item.t
                writer.write_event(item)  # type: ignore[arg-type]
                continue
            if isinstance(item, Publish) and item.stream == "decision":
                decisions += 1
                if decisions == 20 and change is not None:
                    fields = msgspec.json.decode(item.payload)
                    change(fields)
                    item = Publish("decision", msgspec.json.encode(fields))
            writer.write_effect(t, item)
        writer.finish()
    return str(target)


def faster_by(difference: float) -> Change:
    def change(fields: dict[str, object]) -> None:
        command = fields["command"]
        assert isinstance(command, dict)
        command["v"] += difference

    return change


def another_action(fields: dict[str, object]) -> None:
    fields["action"] = "avoid_teammate"


def test_identical_on_this_computer_and_on_one_that_rounds_alike_here(
    recorded: Path, tmp_path: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    assert main(["replay", str(recorded), "--check"]) == 0
    out, err = capsys.readouterr()
    assert out.splitlines()[-1].startswith("identical: ")
    assert "may differ" not in err
    other = rewritten(recorded, tmp_path / "other.mcap", arithmetic=OTHER)
    assert main(["replay", other, "--check"]) == 0
    out, err = capsys.readouterr()
    assert out.splitlines()[-1].startswith("identical: ")
    assert OTHER in err
    assert "numbers may differ: a check is by decisions" in err


@pytest.mark.parametrize("arithmetic", [OTHER, ""])
def test_equal_in_decisions_on_another_computer_or_one_that_is_not_told(
    arithmetic: str, recorded: Path, tmp_path: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    other = rewritten(recorded, tmp_path / "other.mcap", faster_by(0.009), arithmetic)
    assert main(["replay", other, "--check"]) == 3
    out, err = capsys.readouterr()
    assert "different at " in out
    assert out.splitlines()[-1].startswith("equal in decisions: ")
    assert "numbers may differ" in err


@pytest.mark.parametrize("change", [faster_by(0.011), another_action])
def test_different_on_another_computer_by_an_action_or_a_command_out_of_bounds(
    change: Change, recorded: Path, tmp_path: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    other = rewritten(recorded, tmp_path / "other.mcap", change, OTHER)
    assert main(["replay", other, "--check"]) == 1
    assert "equal in decisions" not in capsys.readouterr().out


def test_the_last_bit_makes_a_difference_on_this_computer(recorded: Path, tmp_path: Path) -> None:
    changed = rewritten(recorded, tmp_path / "changed.mcap", faster_by(1e-15))
    assert main(["replay", changed, "--check"]) == 1


def test_lost_records_are_no_equality(
    recorded: Path, tmp_path: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    other = rewritten(recorded, tmp_path / "gap.mcap", arithmetic=OTHER, gap_at=600)
    assert main(["replay", other, "--check"]) == 1
    assert "lost 3 records" in capsys.readouterr().out


def test_a_setting_at_its_value_changes_nothing_wherever_it_was_recorded(
    recorded: Path, tmp_path: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    other = rewritten(recorded, tmp_path / "other.mcap", another_action, OTHER)
    seed = read_recording(recorded).header.seed
    assert main(["replay", other, "--set", f"robot.seed={seed}"]) == 0
    out = capsys.readouterr().out
    assert "0 another action, 0 another word of the gate, 0 another command (by up to 0 m/s" in out
