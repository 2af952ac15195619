"""``patrol demo``: emulated robots, one agent process each, and the operator's monitor."""

from __future__ import annotations

import argparse
import sys
import tempfile
from collections.abc import Iterator
from contextlib import contextmanager
from pathlib import Path

from maps.border import BorderError
from maps.map_folder import load_map_folder
from maps.zone_file import load_zones
from robot_agent.config import find_map
from robot_agent.recording.run_files import refuse_existing
from tools.commands.settings_option import add_set_option, chosen_config
from tools.commands.truth_option import add_truth_option, chosen_truth
from tools.demo.demo import Demo, DemoOptions
from tools.demo.demo_summary import print_summary, read_runs
from tools.monitor.endpoint import free_endpoint
from tools.monitor.site import Site
from tools.number_range import positive, whole
from tools.output_path import output_folder


def configure(parser: argparse.ArgumentParser) -> None:
    """Declare the options."""
    parser.epilog = "example: patrol demo --duration 240 --headless --record out/"
    parser.add_argument("--robots", type=whole(1, 500), default=3, metavar="N")
    parser.add_argument("--map", default="paper_lab", metavar="DIR", help="map folder or name")
    parser.add_argument("--border", default="border", metavar="NAME", help="border file of the map")
    parser.add_argument("--duration", type=positive, metavar="S", help="end after S seconds")
    parser.add_argument("--headless", action="store_true", help="no table, only the summary")
    parser.add_argument(
        "--http",
        metavar="HOST:PORT",
        help="where the page is served; default: a free port, none with --headless",
    )
    parser.add_argument(
        "--record", type=output_folder, metavar="DIR", help="keep recordings in DIR"
    )
    parser.add_argument(
        "--strangers",
        type=whole(),
        default=0,
        metavar="N",
        help="moving people and carts to emulate",
    )
    parser.add_argument("--camera", choices=["on", "off"], default="on", help="on the robots")
    add_truth_option(parser)
    add_set_option(parser)
    parser.add_argument("--seed", type=whole(), default=1, metavar="N")


def run(options: argparse.Namespace) -> int:
    """Run the demo until its duration is over or Ctrl-C, stop all processes, print the summary."""
    config, truth = chosen_config(options), chosen_truth(options)
    path = find_map(options.map, Path.cwd())
    folder = load_map_folder(path, options.border)
    if folder.border is None:
        raise BorderError(f"{path}: has no border.toml to patrol; add one")
    for number in range(options.robots if options.record else 0):
        refuse_existing(options.record / f"robot{number + 1}.mcap")
    with recordings_folder(options.record) as record:
        demo = Demo(
            DemoOptions(
                map_folder=path,
                border=options.border,
                robots=options.robots,
                seed=options.seed,
                operator=free_endpoint(),
                record=record,
                strangers=options.strangers,
                cameras=options.camera == "on",
                config=config,
                truth=truth.name,
            )
        )
        http = options.http or (None if options.headless else "127.0.0.1:0")
        site = Site(folder, load_zones(path))
        healthy = demo.watch(options.duration, site, http=http, headless=options.headless)
        recordings = {robot.name: demo.recording_path(robot.name) for robot in demo.robots}
        runs, contacts = read_runs(demo.truth_path, recordings)
        print_summary(folder.border, runs, contacts)
    for name, status in demo.exit_statuses.items():
        if status:
            print(f"patrol demo: {name} ended with status {status}", file=sys.stderr)
    clean = healthy and not any(demo.exit_statuses.values())
    return 0 if clean and contacts == 0 else 1


@contextmanager
def recordings_folder(wanted: Path | None) -> Iterator[Path]:
    """Yield the wanted folder, or a temporary one that is deleted afterwards if None is wanted."""
    if wanted is not None:
        yield wanted
        return
    with tempfile.TemporaryDirectory(prefix="patrol-demo-") as folder:
        yield Path(folder)
