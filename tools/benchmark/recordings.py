"""Figures of recordings: speed of replay and report, size."""

from __future__ import annotations

import tempfile
import time
from collections.abc import Iterator
from contextlib import closing
from pathlib import Path

from maps.map_folder import MapFolder, load_map_folder
from tools.bench.fleet import Fleet
from tools.bench.fleet_recorder import FleetRecorder
from tools.benchmark.figure import SEED, Figure
from tools.logs.recording import read_recording
from tools.replay.replay import Replay
from tools.report.alignment import align
from tools.report.numbers import numbers
from tools.report.page import page
from tools.report.run_log import read_run
from tools.report.team import Team

REPORTED_S = 120.0


def replay_speed(folder_path: Path) -> Iterator[Figure]:
    """Record one robot in lockstep for 180 s (simulated) and time the replay."""
    folder = load_map_folder(folder_path)
    with tempfile.TemporaryDirectory() as parent:
        path = record_lockstep(folder, 180.0, Path(parent))
        result = Replay(read_recording(path)).run()
        size = path.stat().st_size
    yield Figure(
        "replay of a recording",
        result.duration / result.wall,
        "x real time",
        50.0,
        at_least=True,
        speed=True,
    )
    yield Figure("recording of one hour", size * 3600 / result.duration / 2**20, "MB", 250.0)


def report_speed(folder_path: Path) -> Iterator[Figure]:
    """Record three robots in lockstep for ``REPORTED_S``; time reading and reporting."""
    folder = load_map_folder(folder_path)
    with tempfile.TemporaryDirectory() as parent:
        with closing(FleetRecorder(folder, Path(parent))) as recorder:
            fleet = Fleet(folder, 3, SEED, observer=recorder.observe)
            while fleet.t < REPORTED_S:
                fleet.step()
            fleet.shut_down()
        started = time.process_time()
        runs = [read_run(path) for path in recorder.paths]
        read = time.process_time()
        team = Team(runs, align(runs))
        page(team, numbers(team), lambda _done: None)
        drawn = time.process_time()
    yield Figure(
        "reading a recording for a report",
        3 * REPORTED_S / (read - started),
        "x real time",
        speed=True,
    )
    yield Figure("report of three runs, figures and page", drawn - read, "s of CPU", speed=True)


def record_lockstep(folder: MapFolder, duration: float, target: Path) -> Path:
    """Record one robot in lockstep for a simulated duration, s; return the file in ``target``."""
    with closing(FleetRecorder(folder, target)) as recorder:
        fleet = Fleet(folder, 1, SEED, observer=recorder.observe)
        while fleet.t < duration:
            fleet.step()
        fleet.shut_down()
    return recorder.paths[0]
