"""``patrol record``: record a robot driven by keys or pushed by hand, to build a map from."""

from __future__ import annotations

import argparse
import sys
from contextlib import ExitStack
from pathlib import Path

import cv2
import msgspec

from robot_agent.agent import Agent
from robot_agent.config import load_config
from robot_agent.process.journal import Journal
from robot_agent.process.runtime import Clock, Runtime, end_on_signals
from robot_agent.process.telemetry import Telemetry
from robot_agent.recording.recorder import Recorder
from robot_agent.recording.run_files import OneFile, refuse_existing
from robot_agent.recording.run_header import header_of_run
from tools.mapping.blank_map import blank_map
from tools.output_path import output_file
from tools.teleop.drive_line import LineBelow, drive_line, size_of
from tools.teleop.terminal_keys import HELP, terminal_keys


def configure(parser: argparse.ArgumentParser) -> None:
    """Declare the options."""
    parser.epilog = """example: patrol record robot1.toml --teleop -o drive.mcap
then: patrol map build drive.mcap -o my_map --from odometry

The robot drives only while a key is held, slowly, and stops before anything the laser sees. It
needs no map and no pose. Keys come from this terminal only."""
    parser.add_argument("config", type=Path, metavar="ROBOT.toml", help="the robot's configuration")
    parser.add_argument("-o", "--output", type=output_file, required=True, metavar="REC.mcap")
    parser.add_argument("--teleop", action="store_true", help="drive by the keys of this terminal")


def run(options: argparse.Namespace) -> int:
    """Record until the key q, SIGINT or SIGTERM; the robot is stopped on every way out.

    Returns 1 when records were lost, else 0.
    """
    config = load_config(options.config)
    teleop = msgspec.structs.replace(config.teleop, enabled=True)
    config = msgspec.structs.replace(config, teleop=teleop)
    folder = blank_map()
    cv2.setNumThreads(1)
    clock = Clock()
    header = header_of_run(
        config,
        folder,
        source="live",
        start_wall_ns=clock.start_wall_ns,
        start_monotonic_ns=clock.start_monotonic_ns,
    )
    refuse_existing(options.output)
    with ExitStack() as stack:
        recorder = Recorder(OneFile(options.output), header)
        stack.callback(recorder.close)
        telemetry = Telemetry(config.telemetry, robot=config.robot.name, team=config.robot.team)
        stack.callback(telemetry.close)
        agent = Agent(config, folder, clock.start_wall_ns)
        below = LineBelow(sys.stderr) if sys.stderr.isatty() else None
        journal = Journal(sys.stderr if below is None else below)
        runtime = Runtime(agent, clock, recorder, telemetry, journal)
        end_on_signals(runtime)
        if options.teleop:
            stack.enter_context(terminal_keys(runtime.press, runtime.end))
            print(f"patrol record: {HELP}", file=sys.stderr, flush=True)
        else:
            print("patrol record: push the robot; Ctrl-C ends", file=sys.stderr, flush=True)
        if below is not None:
            stack.enter_context(
                drive_line(
                    below,
                    lambda: agent.odometry.latest,
                    lambda: size_of(recorder.files.path),
                )
            )
        runtime.run()
    if recorder.failed or recorder.lost:
        trouble = recorder.failed or f"{recorder.lost} records lost, the disk was full or too slow"
        print(f"patrol record: {trouble}", file=sys.stderr)
        return 1
    print(options.output)
    return 0
