"""The onboard process: a robot's agent from its file to its end."""

from __future__ import annotations

import ctypes
import gc
import os
import sys
from contextlib import ExitStack
from pathlib import Path

import cv2
import msgspec

from maps.map_folder import MapFolder
from robot_agent.agent import Agent
from robot_agent.config import AgentConfig, ConfigError, load_config
from robot_agent.process.journal import Journal
from robot_agent.process.key_rights import rights_trouble
from robot_agent.process.pose_file import PoseFile
from robot_agent.process.runtime import Clock, DeviceFilterError, Runtime, end_on_signals
from robot_agent.process.telemetry import Telemetry
from robot_agent.recording.recorder import Recorder
from robot_agent.recording.recording_retention import RecordingRetention
from robot_agent.recording.run_files import NumberedRuns, OneFile, RunFiles, refuse_existing
from robot_agent.recording.run_header import header_of_run
from tools.preflight.doctor import NeverDrivesError, load_patrol_map


def run_robot(path: Path, record: Path | None) -> int:
    """Run the agent of a robot's file until SIGINT or SIGTERM; return the process's exit status.

    record: the recording to write, None for the configured one. Errors are told in one line; a
    configuration that can never patrol has the status EX_CONFIG.
    """
    try:
        return _run(path, record)
    except ConfigError as error:
        print(f"patrol agent: {error}", file=sys.stderr)
        return os.EX_CONFIG
    except DeviceFilterError as error:
        print(f"patrol agent: {error}", file=sys.stderr)
        return 1


def _run(path: Path, record: Path | None) -> int:
    config = load_config(path)
    try:
        folder = load_patrol_map(config, path.parent)
    except NeverDrivesError as error:
        raise ConfigError(f"{path}: can never patrol: {error}") from error
    cv2.setNumThreads(1)
    pose_file = make_pose_file(config, folder)
    if pose_file is not None:
        config = msgspec.structs.replace(config, remembered=pose_file.load())
        if pose_file.failed:
            print(f"patrol agent: {pose_file.failed}", file=sys.stderr)
    if config.telemetry.keys and (told := rights_trouble(Path(config.telemetry.keys))):
        print(f"patrol agent: {told}", file=sys.stderr)
    clock = Clock()
    with ExitStack() as stack:
        recorder = make_recorder(record, config, folder, clock)
        if recorder is not None:
            stack.callback(recorder.close)
        telemetry = Telemetry(config.telemetry, robot=config.robot.name, team=config.robot.team)
        stack.callback(telemetry.close)
        agent = Agent(config, folder, clock.start_wall_ns)
        settle_memory()
        runtime = Runtime(agent, clock, recorder, telemetry, Journal(sys.stderr), pose_file)
        end_on_signals(runtime)
        print(f"patrol agent: {config.robot.name} started", file=sys.stderr, flush=True)
        runtime.run()
    if recorder is not None and (recorder.failed or recorder.lost):
        trouble = recorder.failed or f"{recorder.lost} records lost, the disk was full or too slow"
        print(f"patrol agent: {trouble}", file=sys.stderr)
    if pose_file is not None and pose_file.failed:
        print(f"patrol agent: {pose_file.failed}", file=sys.stderr)
    print(f"patrol agent: {config.robot.name} ended", file=sys.stderr)
    return 0


def make_pose_file(config: AgentConfig, folder: MapFolder) -> PoseFile | None:
    """Return the file that keeps the robot's pose over restarts, or None if none is configured."""
    if not config.memory.file:
        return None
    return PoseFile(Path(config.memory.file), config.robot.name, folder)


def settle_memory() -> None:
    """Leave what the start made out of later garbage collections, and return freed memory."""
    gc.enable()
    gc.freeze()
    trim = getattr(ctypes.CDLL(None), "malloc_trim", None)
    if trim is not None:  # glibc's
        trim(0)


def make_recorder(
    wanted: Path | None, config: AgentConfig, folder: MapFolder, clock: Clock
) -> Recorder | None:
    """Create and start the flight recorder.

    wanted: file of ``--record``; None: a new file in the configured folder. Returns None if neither
    is given. Raises RecordingExistsError if the wanted file exists.
    """
    if wanted is None and not config.recorder.folder:
        return None
    header = header_of_run(
        config,
        folder,
        source="live",
        start_wall_ns=clock.start_wall_ns,
        start_monotonic_ns=clock.start_monotonic_ns,
    )
    files: RunFiles = NumberedRuns(Path(config.recorder.folder), config.robot.name)
    if wanted is not None:
        refuse_existing(wanted)
        files = OneFile(wanted)
    return Recorder(files, header, room=RecordingRetention(files, config.recorder))
