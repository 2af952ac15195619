"""Bad input to the command line: one line with file and remedy, status 1 or 2, no traceback."""

import os
import shutil
from pathlib import Path

import pytest

from robot_agent.config import find_map, parse_config
from tools.cli import COMMANDS, main


def run(capsys: pytest.CaptureFixture[str], *words: str) -> tuple[int, str, str]:
    """Run the command in this process; return status, standard output, standard error."""
    try:
        status = main(list(words))
    except SystemExit as error:
        status = int(error.code or 0)
    captured = capsys.readouterr()
    return status, captured.out, captured.err


def complaint(capsys: pytest.CaptureFixture[str], *words: str) -> str:
    """Run a command that must fail with one line on standard error; return that line."""
    status, out, err = run(capsys, *words)
    assert status in (1, 2, os.EX_CONFIG)
    assert out == ""
    lines = err.strip().splitlines()
    assert len(lines) == 1, err
    return lines[0]


@pytest.mark.parametrize("command", COMMANDS)
def test_every_command_has_help(command: str, capsys: pytest.CaptureFixture[str]) -> None:
    status, out, _ = run(capsys, command, "--help")
    assert status == 0
    assert "usage: patrol " + command in out


def test_unknown_commands_and_options_are_usage_errors(capsys: pytest.CaptureFixture[str]) -> None:
    assert run(capsys, "dance")[0] == 2
    assert run(capsys, "bench", "--dance")[0] == 2
    assert run(capsys)[0] == 2


def test_missing_map_image_is_one_error(tmp_path: Path, capsys: pytest.CaptureFixture[str]) -> None:
    shutil.copytree(find_map("paper_lab", tmp_path), tmp_path / "lab")
    (tmp_path / "lab" / "map.pgm").unlink()
    line = complaint(capsys, "map", "show", str(tmp_path / "lab"), "-o", str(tmp_path / "x.png"))
    assert "map.pgm" in line
    line = complaint(capsys, "bench", "--map", str(tmp_path / "lab"), "--duration", "1")
    assert "map.pgm" in line


def test_border_through_a_wall_fails_the_check(
    tmp_path: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    shutil.copytree(find_map("paper_lab", tmp_path), tmp_path / "lab")
    border = tmp_path / "lab" / "border.toml"
    border.write_text(border.read_text().replace("[3.95, 13.75]", "[3.95, 16.50]"))
    status, out, _ = run(capsys, "map", "check", str(tmp_path / "lab"))
    assert status == 1
    assert "runs through a wall at" in out


def test_good_map_passes(capsys: pytest.CaptureFixture[str]) -> None:
    for border in ("border", "open"):
        status, out, _ = run(capsys, "map", "check", "paper_lab", "--border", border)
        assert status == 0, out
    assert run(capsys, "map", "check", "intel_lab")[0] == 0


def test_unknown_border_is_one_error(capsys: pytest.CaptureFixture[str]) -> None:
    assert "nowhere.toml" in complaint(capsys, "bench", "--border", "nowhere")


def test_unknown_nested_configuration_key_is_one_error(
    tmp_path: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    path = tmp_path / "robot.toml"
    path.write_text("[localization.health]\nlost_bellow = 0.2\n")
    line = complaint(capsys, "agent", str(path))
    assert line.startswith(f"patrol agent: {path}: localization.health.lost_bellow: unknown key")


def test_print_config_is_the_effective_configuration(
    tmp_path: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    path = tmp_path / "robot.toml"
    path.write_text('[robot]\nname = "scout"\n')
    status, out, _ = run(capsys, "agent", str(path), "--print-config")
    assert status == 0
    config = parse_config(out.encode(), "printed")
    assert config.robot.name == "scout"
    assert "max_speed" in out


def test_list_settings_needs_no_configuration(capsys: pytest.CaptureFixture[str]) -> None:
    status, out, _ = run(capsys, "agent", "--list-settings")
    assert status == 0
    assert out.splitlines()[-1].endswith(" settings")


@pytest.mark.parametrize("command", ["convert", "localize", "map build"])
def test_file_that_is_no_log_is_one_error(
    command: str, tmp_path: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    path = tmp_path / "poem.log"
    path.write_text("Roses are red\n")
    options = {
        "convert": ("-o", str(tmp_path / "x.mcap")),
        "localize": ("--map", "paper_lab"),
        "map build": ("-o", str(tmp_path / "x")),
    }[command]
    line = complaint(capsys, *command.split(), str(path), *options)
    assert "poem.log: line 1: no FLASER or ROBOTLASER1 line" in line


def test_file_that_is_no_recording_is_one_error(
    tmp_path: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    path = tmp_path / "x.mcap"
    path.write_text("no recording")
    assert "x.mcap: is not an MCAP file" in complaint(capsys, "replay", str(path))
    assert "y.mcap: cannot be read" in complaint(capsys, "replay", str(tmp_path / "y.mcap"))


def test_unwritable_output_is_one_error(
    data_folder: Path, tmp_path: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    log = str(data_folder / "logs/seattle-corrected.log.gz")
    target = str(tmp_path / "no" / "such" / "x.mcap")
    line = complaint(capsys, "convert", log, "-o", target, "--map", "intel_lab")
    assert target in line
