"""``patrol perceive``: run the tracker on a log, or draw an intruder report of a recording."""

from __future__ import annotations

import argparse
import json
from pathlib import Path

import cv2

from maps.map_folder import load_map_folder
from robot_agent.config import find_map
from tools.calibration.perceive import perceive
from tools.calibration.perception_pictures import draw_picture, draw_scan, moment_of
from tools.commands.log_option import add_no_return, add_topics, print_notes, topics_of
from tools.localize.localize import log_steps, map_of_log
from tools.logs.carmen import LogError
from tools.logs.laser_log import read_laser_log
from tools.logs.recording import read_recording
from tools.logs.ros_bag import is_ros_bag
from tools.number_range import whole
from tools.output_path import output_folder
from tools.progress import progress_line

RESOLUTION = 0.05  # m


def configure(parser: argparse.ArgumentParser) -> None:
    """Declare the options."""
    parser.epilog = (
        "examples:\n"
        "  patrol perceive LOG.gz --first-scan 27    figures of the tracker by laser alone\n"
        "  patrol perceive RUN.mcap --pictures out/  what was seen when an intruder was reported"
    )
    parser.add_argument("log", type=Path, metavar="LOG", help="CARMEN log, or recording")
    parser.add_argument(
        "--pictures", type=output_folder, metavar="DIR", help="draw scan.png and camera.jpg"
    )
    parser.add_argument(
        "--map",
        metavar="DIR",
        help="map folder or name; without it the map is built of every second scan of the log, "
        "and the others are looked at",
    )
    parser.add_argument(
        "--first-scan", type=whole(), default=0, metavar="N", help="leave out the scans before"
    )
    parser.add_argument("--seed", type=whole(), default=0, metavar="N")
    add_no_return(parser)
    add_topics(parser)


def run(options: argparse.Namespace) -> int:
    """Track on one log and print the figures as JSON, or draw a recording's intruder report.

    Returns 1 when a track of the log is classified as a teammate (logs have none), else 0.
    """
    cv2.setNumThreads(1)
    if options.log.suffix == ".mcap" and not is_ros_bag(options.log):
        return _draw(options)
    log = read_laser_log(options.log, options.no_return, topics_of(options))
    print_notes("perceive", log.notes)
    steps = log_steps(log)[options.first_scan :]
    if not steps:
        raise LogError(f"{options.log}: no scan from scan {options.first_scan} on")
    if options.map:
        folder = load_map_folder(find_map(options.map, Path.cwd()))
    else:
        folder = map_of_log(log, RESOLUTION, "even")
        steps = steps[1 - options.first_scan % 2 :: 2]
    if not steps:
        raise LogError(f"{options.log}: too few scans for a map of every second: give --map DIR")
    with progress_line("perceive", len(steps), "scans") as progress:
        result = perceive(str(options.log), steps, folder, options.seed, progress)
    print(json.dumps({"log": options.log.name, **result.summary}, indent=2))
    return 1 if result.teammates else 0


def _draw(options: argparse.Namespace) -> int:
    if options.pictures is None:
        raise LogError(f"{options.log}: a recording is drawn: say where with --pictures DIR")
    moment = moment_of(read_recording(options.log))
    draw_scan(moment, options.pictures / "scan.png")
    draw_picture(moment, options.pictures / "camera.jpg")
    return 0
