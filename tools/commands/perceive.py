"""``patrol perceive``: whom the tracker sees on a log, by laser alone."""

from __future__ import annotations

import argparse
import json
from pathlib import Path

import cv2

from maps.map_folder import load_map_folder
from robot_agent.config import find_map
from tools.carmen import LogError, read_carmen
from tools.localize import log_steps, map_of_log
from tools.perceive import perceive
from tools.progress import Progress

RESOLUTION = 0.05  # m


def configure(parser: argparse.ArgumentParser) -> None:
    """Declare the options."""
    parser.epilog = "example: patrol perceive LOG.gz --first-scan 27"
    parser.add_argument("log", type=Path, metavar="LOG", help="CARMEN log")
    parser.add_argument(
        "--map",
        metavar="DIR",
        help="map folder or name; without it the map is built of every second scan of the log, "
        "and the others are looked at",
    )
    parser.add_argument(
        "--first-scan", type=int, default=0, metavar="N", help="leave out those before"
    )
    parser.add_argument("--seed", type=int, default=0, metavar="N")


def run(options: argparse.Namespace) -> int:
    """Track on one log; print the figures as JSON. Status 1 when anyone is called a teammate."""
    cv2.setNumThreads(1)
    log = read_carmen(options.log)
    steps = log_steps(log)[options.first_scan :]
    if not steps:
        raise LogError(f"{options.log}: no scan from scan {options.first_scan} on")
    if options.map:
        folder = load_map_folder(find_map(options.map, Path.cwd()))
    else:
        folder = map_of_log(log, RESOLUTION, "even")
        steps = steps[1 - options.first_scan % 2 :: 2]
    with Progress("perceive", len(steps), "scans") as progress:
        result = perceive(str(options.log), steps, folder, options.seed, progress)
    print(json.dumps({"log": options.log.name, **result.summary}, indent=2))
    return 1 if result.teammates else 0
