"""``patrol report``: what happened in a run, as a page with figures and as numbers."""

from __future__ import annotations

import argparse
import json
import sys
from pathlib import Path

from maps.whole_file import write_whole
from robot_agent.config import find_map
from tools.output_path import output_folder
from tools.progress import progress_line
from tools.report.alignment import AlignmentError, align
from tools.report.numbers import numbers
from tools.report.page import figures_alone, page
from tools.report.recorded_zones import stated_zones, zones_here
from tools.report.run_log import read_run
from tools.report.sections import SECTIONS
from tools.report.style import FORMATS
from tools.report.team import Team


def configure(parser: argparse.ArgumentParser) -> None:
    """Declare the options."""
    parser.epilog = """examples:
  patrol report out/robot1.mcap out/robot2.mcap out/robot3.mcap -o report/
  patrol report night/*.mcap -o report/ --offset robot2=-1.25"""
    parser.add_argument("recordings", type=Path, nargs="+", metavar="REC.mcap")
    parser.add_argument(
        "-o",
        "--output",
        type=output_folder,
        required=True,
        metavar="DIR",
        help="for report.html and .json",
    )
    parser.add_argument(
        "--figures", choices=FORMATS, help="write only the figures, a file each, in this format"
    )
    parser.add_argument(
        "--map",
        metavar="DIR",
        help="map folder, or shipped map, whose zones name the places; default: the one that the "
        "recordings name, if it is here",
    )
    parser.add_argument(
        "--offset",
        action="append",
        default=[],
        metavar="ROBOT=S",
        help="seconds to add to a robot's clock, instead of estimating them",
    )
    parser.add_argument(
        "--clocks",
        choices=("host", "sightings"),
        default="host",
        help="set clocks by mutual sightings even where all robots ran on one host",
    )


def run(options: argparse.Namespace) -> int:
    """Write the report of one run; return 0. Raises AlignmentError when clocks cannot be set."""
    stated = dict(map(_offset, options.offset))
    with progress_line("read", len(options.recordings), "recordings") as progress:
        runs = []
        for number, path in enumerate(options.recordings):
            progress(number)
            runs.append(read_run(path))
    for log in runs:
        if log.truncated:
            print(f"patrol report: {log.truncated}; what is whole is reported", file=sys.stderr)
        if log.unreadable:
            print(
                f"patrol report: {log.path}: {log.unreadable} messages do not fit their stream and "
                "are left out; record again",
                file=sys.stderr,
            )
    team = Team(runs, align(runs, stated, trust_host=options.clocks == "host"))
    if options.map is None:
        team.zones = zones_here(team.folder, find_map(team.map_named, Path.cwd()))
    else:
        team.zones = stated_zones(team.folder, find_map(options.map, Path.cwd()))
    figures = numbers(team)
    if options.figures:
        for path in figures_alone(team, figures, options.output, options.figures):
            print(path)
        return 0
    with progress_line("draw", len(SECTIONS), "sections") as progress:
        text = page(team, figures, progress)
    write_whole(options.output / "report.html", text)
    write_whole(options.output / "report.json", json.dumps(figures, indent=2) + "\n")
    print(options.output / "report.html")
    return 0


def _offset(text: str) -> tuple[str, float]:
    robot, _, seconds = text.partition("=")
    try:
        return robot, float(seconds)
    except ValueError as error:
        raise AlignmentError(f"--offset {text}: is not ROBOT=S; e.g. robot2=-1.25") from error
