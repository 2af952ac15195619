"""Outputs on the command line: what cannot be written is refused before the work."""

from __future__ import annotations

import argparse
import json
import subprocess
import sys
from pathlib import Path

import pytest

from tests.tools.command_actions import command_actions
from tools.cli import COMMANDS, main
from tools.output_path import output_file, output_folder, output_path

READ = {"--config", "--relations", "--keys", "--forward-keys", "--play", "--program"}
"""Options with the path of something that is read."""
CHECKED_BY_ITSELF = {("agent", "--record"), ("install", "--root")}

AS_NOBODY = """
import argparse, os
from tools.output_path import output_file
if os.geteuid() == 0:  # who may write everywhere
    os.setuid(65534)
try:
    output_file("/usr/new.json")
except argparse.ArgumentTypeError as error:
    print(error)
"""


@pytest.fixture
def taken(tmp_path: Path) -> Path:
    """Make a folder and a file."""
    (tmp_path / "folder").mkdir()
    (tmp_path / "file").write_text("kept")
    return tmp_path


@pytest.mark.parametrize("name", ["file", "new", "folder/new", "new/newer/out.json"])
def test_a_file_may_be_new_or_be_replaced_and_so_may_its_folders(taken: Path, name: str) -> None:
    assert output_file(str(taken / name)) == taken / name


@pytest.mark.parametrize("name", ["folder", "new/newer"])
def test_a_folder_may_be_new(taken: Path, name: str) -> None:
    assert output_folder(str(taken / name)) == taken / name
    assert output_path(str(taken / name)) == taken / name


def test_a_device_is_a_file() -> None:
    assert output_file("/dev/null") == Path("/dev/null")


@pytest.mark.parametrize(
    ("parse", "name", "why"),
    [
        (output_file, "folder", "is a folder"),
        (output_file, "file/out.json", "is no folder"),
        (output_folder, "file", "is no folder"),
        (output_folder, "file/new", "is no folder"),
        (output_path, "file/new", "is no folder"),
    ],
)
def test_what_cannot_be_written_is_refused(taken: Path, parse, name: str, why: str) -> None:
    with pytest.raises(argparse.ArgumentTypeError, match=why):
        parse(str(taken / name))


def test_a_folder_without_rights_is_refused() -> None:
    words = [sys.executable, "-P", "-c", AS_NOBODY]
    told = subprocess.run(words, capture_output=True, text=True, timeout=60)
    assert told.stdout == "'/usr' cannot be written to: check its rights\n", told.stderr


def test_a_run_of_years_is_not_begun_for_an_output_that_cannot_be(
    taken: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    with pytest.raises(SystemExit) as ended:
        main(["bench", "--duration", "1e8", "--json", str(taken / "file" / "out.json")])
    assert ended.value.code == 2
    (line,) = capsys.readouterr().err.splitlines()
    assert "--json" in line
    assert str(taken / "file") in line


def test_a_fit_is_not_begun_for_a_configuration_that_is_none(
    taken: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    words = ["calibrate", "odometry", str(taken / "no.mcap"), "--robot", str(taken / "file")]
    assert main(words) == 1
    (line,) = capsys.readouterr().err.splitlines()
    assert str(taken / "file") in line
    assert "TOML" in line


def test_missing_folders_are_made(tmp_path: Path) -> None:
    out = tmp_path / "new" / "newer" / "out.json"
    assert main(["bench", "--sensing", "ideal", "--duration", "1", "--json", str(out)]) == 0
    assert json.loads(out.read_text())["robots"] == 3


@pytest.mark.parametrize("command", COMMANDS)
def test_no_command_takes_an_output_unchecked(command: str) -> None:
    for action in command_actions(command):
        if action.type is Path and action.option_strings:
            name = action.option_strings[0]
            assert name in READ or (command, name) in CHECKED_BY_ITSELF, name
