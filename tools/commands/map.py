"""``patrol map``: build, draw, show and check map folders."""

from __future__ import annotations

import argparse
import sys
import time
from contextlib import closing
from pathlib import Path

import cv2

from maps.border import BorderError
from maps.map_folder import DEFAULT_BORDER, MAP_FILE, load_map_folder
from maps.occupancy_map import MapError, load_map, save_map
from maps.zone_file import load_zones
from robot_agent.config import SHIPPED_MAPS, find_map
from tools.commands.log_option import add_no_return, add_topics, print_notes, topics_of
from tools.logs.carmen import LogError
from tools.logs.scan_log import ScanLog, read_scan_log
from tools.mapping.floor_plan import draw_floor_plan
from tools.mapping.map_build import build_map
from tools.mapping.map_check import check_map
from tools.mapping.map_picture import draw_map, draw_map_alone
from tools.mapping.map_verdict import Grade, judge
from tools.mapping.picture_import import import_picture
from tools.mapping.slam.loop_check import write_loops
from tools.mapping.slam.mapper import Mapping, map_from_odometry
from tools.mapping.slam.relations import read_relations, relation_error, synchronize
from tools.mapping.slam.trajectory import Trajectory
from tools.mapping.zone_stretches import zone_lines
from tools.number_range import positive, real, share, whole
from tools.output_path import output_file, output_folder
from tools.progress import progress_line

_POLL_S = 0.2
PICTURE = "map.png"
LOOPS = "loops.csv"
"""The picture that ``map build`` puts beside the map."""


def configure(parser: argparse.ArgumentParser) -> None:
    """Declare the options."""
    actions = parser.add_subparsers(dest="action", metavar="ACTION", required=True)

    build = actions.add_parser("build", help="build a map from a log or recording")
    build.epilog = "example: patrol map build drive.mcap -o my_map --from odometry"
    build.add_argument("log", type=Path, help="CARMEN log (plain or gzip), ROS bag or recording")
    build.add_argument("-o", "--output", type=output_folder, required=True, metavar="DIR")
    build.add_argument("--resolution", type=positive, default=0.05, metavar="M", help="cell side")
    build.add_argument(
        "--max-range", type=positive, default=20.0, metavar="M", help="leave out longer beams"
    )
    build.add_argument("--scans", choices=("all", "even", "odd"), default="all")
    build.add_argument(
        "--from",
        dest="source",
        choices=("reference", "odometry"),
        default="reference",
        help="poses: those in the log, or found from raw odometry and the scans",
    )
    build.add_argument(
        "--first-scan", type=whole(), default=0, metavar="N", help="leave out earlier"
    )
    build.add_argument(
        "--relations", type=Path, metavar="FILE", help="true relations to judge the poses by"
    )
    build.add_argument(
        "--relations-epoch",
        type=real,
        default=0.0,
        metavar="S",
        help="the relations' time at the log's time zero",
    )
    add_no_return(build)
    add_topics(build)
    build.set_defaults(act=_build)

    draw = actions.add_parser("draw", help="draw a map from a floor plan file")
    draw.epilog = "example: patrol map draw floor_plan.toml -o my_map"
    draw.add_argument("plan", type=Path, metavar="FLOOR_PLAN.toml")
    draw.add_argument("-o", "--output", type=output_folder, required=True, metavar="DIR")
    draw.set_defaults(act=_draw)

    imported = actions.add_parser("import", help="make a map of a plan's picture")
    imported.epilog = "example: patrol map import plan.png --resolution 0.05 -o my_map"
    imported.add_argument("picture", type=Path, metavar="PICTURE", help="PNG, BMP or PGM")
    imported.add_argument("-o", "--output", type=output_folder, required=True, metavar="DIR")
    imported.add_argument(
        "--resolution", type=positive, required=True, metavar="M", help="metres of a pixel's side"
    )
    imported.add_argument(
        "--dark",
        type=share,
        default=0.5,
        metavar="SHARE",
        help="pixels darker than this share of black are walls",
    )
    imported.set_defaults(act=_import)

    show = actions.add_parser(
        "show", help="write a picture of a map, its border and zones; list the zones"
    )
    show.epilog = "example: patrol map show paper_lab -o paper_lab.png"
    _add_folder(show)
    show.add_argument("-o", "--output", type=output_file, required=True, metavar="PNG")
    show.set_defaults(act=_show)

    border = actions.add_parser("border", help="draw a border on a map, in a browser")
    border.epilog = "example: patrol map border my_map"
    _add_folder(border)
    border.add_argument(
        "--http", default="127.0.0.1:8090", metavar="HOST:PORT", help="where the page is served"
    )
    border.set_defaults(act=_border)

    check = actions.add_parser("check", help="check that a border can be patrolled")
    check.epilog = "example: patrol map check paper_lab --border open"
    _add_folder(check)
    check.set_defaults(act=_check)


def run(options: argparse.Namespace) -> int:
    """Run the chosen action."""
    status: int = options.act(options)
    return status


def _add_folder(parser: argparse.ArgumentParser) -> None:
    parser.add_argument("folder", metavar="DIR", help="map folder, or a shipped map's name")
    parser.add_argument("--border", default=DEFAULT_BORDER, metavar="NAME")


def _build(options: argparse.Namespace) -> int:
    cv2.setNumThreads(1)
    relations = (
        read_relations(options.relations, options.relations_epoch) if options.relations else []
    )
    log = read_scan_log(options.log, options.no_return, topics_of(options))
    print_notes("map", log.notes)
    log, trajectory, found = _posed(log.from_scan(options.first_scan), options.source)
    if relations:
        lined_up = synchronize(relations, trajectory.times)
        print(relation_error(lined_up, trajectory.at).table())
    with progress_line("map", len(log.scans), "scans") as progress:
        built = build_map(
            log,
            options.resolution,
            scans=options.scans,
            max_range=options.max_range,
            progress=progress,
        )
    save_map(built.map, options.output)
    if found is None:
        verdict = judge(built.map, log.scans, options.max_range)
    else:
        verdict = judge(
            built.map, log.scans, options.max_range, found.unmatched, found.loops, found.bend
        )
        write_loops(options.output / LOOPS, found.loops)
    draw_map(options.output, options.output / PICTURE, doubts=verdict.places)
    print(f"{options.output}: {built.summary()}")
    print(f"{options.output}: {verdict}")
    if verdict.grade is Grade.FAILED:
        return 1
    print(f"next: draw its border with `patrol map border {options.output}`")
    return 0


def _posed(log: ScanLog, source: str) -> tuple[ScanLog, Trajectory, Mapping | None]:
    """Return the log with the poses to build from, poses at all times, and how they were found.

    None if they are the log's own.
    """
    if source == "odometry":
        found = map_from_odometry(log)
        print(found.summary())
        return found.log, found.trajectory, found
    if not log.referenced:
        raise LogError(
            f"{log.path}: scans without reference poses: build the map with --from odometry"
        )
    poses = {line: scan.reference for line, scan in zip(log.scan_lines, log.scans, strict=True)}
    return log, Trajectory(log.odometry, poses), None


def _draw(options: argparse.Namespace) -> int:
    width, height = draw_floor_plan(options.plan, options.output).size
    print(f"{options.output}: {width:.1f} x {height:.1f} m")
    print(f"next: draw its border with `patrol map border {options.output}`")
    return 0


def _import(options: argparse.Namespace) -> int:
    imported = import_picture(options.picture, options.resolution, dark=options.dark)
    save_map(imported.map, options.output)
    width, height = imported.map.size
    print(f"{options.output}: {width:.1f} x {height:.1f} m, {imported.summary}")
    print(f"next: draw its border with `patrol map border {options.output}`")
    return 0


def _show(options: argparse.Namespace) -> int:
    folder = find_map(options.folder, Path.cwd())
    try:
        draw_map(folder, options.output, options.border)
    except BorderError as error:
        draw_map_alone(folder, options.output, str(error))
        print(f"{options.output}: without the border: {error}", file=sys.stderr)
        return 1
    print(options.output)
    for line in zone_lines(load_zones(folder), load_map_folder(folder, options.border).border):
        print(line)
    return 0


def _border(options: argparse.Namespace) -> int:
    from tools.border_editor.editor_server import EditorServer  # robots have no web server

    path = find_map(options.folder, Path.cwd())
    if path == SHIPPED_MAPS / options.folder:
        raise MapError(f"{path}: is a shipped map: copy the folder, and draw on the copy")
    file = path / f"{options.border}.toml"
    with closing(EditorServer(file, load_map(path / MAP_FILE), options.http)) as server:
        print(f"patrol map: draw at {server.link}, saved to {server.file}", file=sys.stderr)
        while True:
            server.check()
            time.sleep(_POLL_S)


def _check(options: argparse.Namespace) -> int:
    report = check_map(find_map(options.folder, Path.cwd()), options.border)
    print(report)
    return 0 if report.ok else 1
