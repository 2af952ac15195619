"""A disk that is full is one line for every command that writes, and what was there stays."""

from __future__ import annotations

import resource
import signal
import subprocess
from collections.abc import Callable, Iterator
from contextlib import contextmanager
from pathlib import Path
from typing import Any

import cv2
import numpy as np
import pytest

from maps.map_folder import load_map_folder
from maps.pose import Pose
from robot_agent.config import find_map
from tools.bench.fleet import Fleet
from tools.bench.fleet_recorder import FleetRecorder
from tools.cli import main
from tools.deploy.child_program import environment, program
from tools.field.field_row import Outcome

BEFORE = b"what was there before"
PAPER_LAB = find_map("paper_lab", Path())

WRITERS = {
    "rules show": ("rules show -o {to}/new.png", ["new.png"]),
    "map show": ("map show paper_lab -o {to}/new.png", ["new.png"]),
    "map draw": (f"map draw {PAPER_LAB}/floor_plan.toml -o {{to}}", ["map.pgm", "map.yaml"]),
    "map import": (
        "map import {made}/plan.png --resolution 0.05 -o {to}",
        ["map.pgm", "map.yaml"],
    ),
    "map build": (
        "map build {made}/robot1.mcap --from odometry -o {to}",
        ["map.pgm", "map.yaml", "map.png", "loops.csv"],
    ),
    "bench --json": ("bench --sensing ideal --duration 1 --json {to}/out.json", ["out.json"]),
    "bench --record": ("bench --duration 1 --robots 1 --record {to}", []),
    "convert to a log": ("convert {made}/robot1.mcap -o {to}/out.log", ["out.log"]),
    "convert to a capture": ("convert {made}/robot1.mcap -o {to}/out.jsonl", ["out.jsonl"]),
    "convert to a table": (
        "convert {made}/robot1.mcap -o {to}/out.csv --stream decision",
        ["out.csv"],
    ),
    "convert to a ROS bag": ("convert {made}/robot1.mcap -o {to}/out.ros2", []),
    "convert from a log": (
        "convert {made}/robot1.log -o {to}/out.mcap --map paper_lab",
        ["out.mcap"],
    ),
    "convert from a capture": ("convert {made}/robot1.jsonl -o {to}/out.mcap", ["out.mcap"]),
    "report": ("report {made}/robot1.mcap -o {to}", ["report.html", "report.json"]),
    "report --figures": ("report {made}/robot1.mcap -o {to} --figures svg", ["map.svg"]),
    "localize --csv": (
        "localize --global --map paper_lab {made}/robot1.mcap --csv {to}/out.csv",
        ["out.csv"],
    ),
    "localize --json": (
        "localize --global --map paper_lab {made}/robot1.mcap --json {to}/out.json",
        ["out.json"],
    ),
    "perceive": ("perceive {seen}/robot1.mcap --pictures {to}", ["scan.png", "camera.jpg"]),
    "calibrate --mask": (
        "calibrate color {made}/band.png --box 60,40,40,40 --mask {to}/mask.png",
        ["mask.png"],
    ),
    "calibrate --robot": (
        "calibrate color {made}/band.png --box 60,40,40,40 --robot {to}/robot.toml",
        ["robot.toml"],
    ),
    "keys": ("keys robot1 --team north --host 127.0.0.1 -o {to}", []),
    "install": ("install {made}/robot1.toml --root {to}", []),
    "study": ("study {made}/study.toml -o {to}", ["study.csv"]),
}
"""Command lines, with the files that each writes and that may have been there."""


@contextmanager
def full_disk() -> Iterator[None]:
    """Let nothing be written to any file, as on a full disk: they can be made, and stay empty."""
    limits = resource.getrlimit(resource.RLIMIT_FSIZE)
    resource.setrlimit(resource.RLIMIT_FSIZE, (0, limits[1]))
    try:
        yield
    finally:
        resource.setrlimit(resource.RLIMIT_FSIZE, limits)


def record(folder: Path, duration: float, **options: Any) -> None:
    """Record one robot of a bench as robot1.mcap; options: of ``Fleet``."""
    recorder = FleetRecorder(load_map_folder(PAPER_LAB), folder)
    fleet = Fleet(load_map_folder(PAPER_LAB), 1, observer=recorder.observe, **options)
    while fleet.t < duration:
        fleet.step()
    fleet.shut_down()
    recorder.close()


@pytest.fixture(scope="module")
def seen(tmp_path_factory: pytest.TempPathFactory) -> Path:
    """Record a robot with a camera that reports an intruder."""
    folder = tmp_path_factory.mktemp("seen")
    record(folder, 40.0, seed=2, strangers=8, cameras=True)
    return folder


@pytest.fixture(scope="module")
def made(tmp_path_factory: pytest.TempPathFactory) -> Path:
    """Make what the commands read: a short drive in all forms, pictures, configurations."""
    folder = tmp_path_factory.mktemp("made")
    record(folder, 12.0, seed=1, starts=[Pose(8.0, 3.76, 0.0)])
    for suffix in ("log", "jsonl"):
        words = ["convert", str(folder / "robot1.mcap"), "-o", str(folder / f"robot1.{suffix}")]
        assert main(words) == 0
    plan = np.full((60, 80), 255, np.uint8)
    plan[[0, -1]] = plan[:, [0, -1]] = 0
    (folder / "plan.png").write_bytes(cv2.imencode(".png", plan)[1].tobytes())
    band = np.full((120, 160, 3), 60, np.uint8)
    band[40:80, 60:100] = (40, 190, 40)
    (folder / "band.png").write_bytes(cv2.imencode(".png", band)[1].tobytes())
    (folder / "robot1.toml").write_text('[robot]\nname = "robot1"\n[map]\nfolder = "paper_lab"\n')
    (folder / "study.toml").write_text(
        '[study]\nduration = 2.0\nseeds = 1\nsensing = "ideal"\n[vary]\nrobots = [2]\n'
    )
    return folder


@pytest.mark.parametrize("name", WRITERS)
def test_a_full_disk_is_one_line_and_loses_nothing(
    name: str,
    request: pytest.FixtureRequest,
    tmp_path: Path,
    capsys: pytest.CaptureFixture[str],
) -> None:
    line, written = WRITERS[name]
    needed = [each for each in ("made", "seen") if f"{{{each}}}" in line]
    read = {each: request.getfixturevalue(each) for each in needed}
    words = line.format(to=tmp_path, **read).split()
    for file in written:
        before = b"" if file.endswith(".toml") else BEFORE
        (tmp_path / file).write_bytes(before)
    with full_disk():
        status = main(words)
    assert status == 1
    *_progress, told = capsys.readouterr().err.splitlines()
    assert told.startswith(f"patrol {words[0]}: ")
    assert "File too large" in told
    for file in written:
        assert (tmp_path / file).read_bytes() == (b"" if file.endswith(".toml") else BEFORE)
    assert not list(tmp_path.rglob(".*")), "no half of a file stays"


@pytest.mark.parametrize(
    ("run", "does", "words"),
    [
        ("tools.commands.faults.run_faults", lambda *_: [], ("faults",)),
        ("tools.campaign.lie_list.chosen_lies", lambda _: [], ("campaign", "--lies")),
        (
            "tools.commands.trial.run_trial",
            lambda rows, *others: others[-1](rows[0], Outcome()),
            ("trial",),
        ),
    ],
)
def test_a_table_of_hours_is_printed_before_it_is_written(
    run: str,
    does: Callable[..., object],
    words: tuple[str, ...],
    tmp_path: Path,
    capsys: pytest.CaptureFixture[str],
    monkeypatch: pytest.MonkeyPatch,
) -> None:
    monkeypatch.setattr(run, does)
    table = tmp_path / "table.md"
    table.write_bytes(BEFORE)
    with full_disk():
        assert main([*words, "-o", str(table)]) == 1
    captured = capsys.readouterr()
    assert "| --- " in captured.out
    assert captured.err.splitlines()[-1].startswith(f"patrol {words[0]}: {table}: File too large")
    assert table.read_bytes() == BEFORE


def test_a_bundle_on_a_full_disk_keeps_its_sums(
    tmp_path: Path, capsys: pytest.CaptureFixture[str], monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.setattr("tools.deploy.bundle._pip", lambda *_: None)
    (tmp_path / "SHA256SUMS").write_bytes(BEFORE)
    with full_disk():
        assert main(["bundle", "-o", str(tmp_path)]) == 1
    told = capsys.readouterr().err.splitlines()[-1]
    assert told.startswith(f"patrol bundle: {tmp_path}/INSTALL.txt: File too large")
    assert (tmp_path / "SHA256SUMS").read_bytes() == BEFORE


@pytest.mark.usefixtures("capsys")
def test_keys_after_a_full_disk_are_complete(tmp_path: Path) -> None:
    words = ["keys", "robot1", "--team", "north", "--host", "127.0.0.1", "-o", str(tmp_path)]
    with full_disk():
        assert main(words) == 1
    assert main(words) == 0
    for party in ("operator", "robot1"):
        there = {path.name for path in (tmp_path / party).iterdir()}
        assert {"ca.pem", "certificate.pem", "key.pem"} <= there
    assert all(path.stat().st_size > 0 for path in tmp_path.rglob("*") if path.is_file())


def test_a_drive_that_cannot_be_recorded_says_so_and_fails(tmp_path: Path) -> None:
    robot = tmp_path / "robot1.toml"
    robot.write_text('[base]\nurl = "/dev/none-such"\n[laser]\nurl = "/dev/none-such"\n')
    words = program("tools.cli", "record", str(robot), "-o", "/dev/full")
    with subprocess.Popen(words, env=environment(), stderr=subprocess.PIPE, text=True) as record:
        assert record.stderr is not None
        told = next(line for line in record.stderr if "recording stopped" in line)
        record.send_signal(signal.SIGINT)
        last = record.stderr.read().splitlines()[-1]
    assert "/dev/full: recording stopped: No space left on device" in told
    assert last == "patrol record: /dev/full: recording stopped: No space left on device"
    assert record.returncode == 1
