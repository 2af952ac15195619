"""``patrol convert``: a CARMEN log becomes a recording of real device bytes."""

from __future__ import annotations

import argparse
import sys
import tempfile
from pathlib import Path

from maps.map_folder import MapFolder, load_map_folder
from maps.occupancy_map import save_map
from robot_agent.config import find_map
from tools.carmen import CarmenLog, read_carmen
from tools.convert import convert
from tools.mapping import build_map
from tools.progress import Progress


def configure(parser: argparse.ArgumentParser) -> None:
    """Declare the options."""
    parser.epilog = "example: patrol convert intel.log.gz -o intel.mcap --map intel_lab"
    parser.add_argument("log", type=Path, help="CARMEN log, plain or gzip")
    parser.add_argument("-o", "--output", type=Path, required=True, metavar="REC.mcap")
    parser.add_argument(
        "--map",
        metavar="DIR",
        help="map folder or shipped map of the log's place; built from the log when not given",
    )


def run(options: argparse.Namespace) -> int:
    """Convert one log."""
    log = read_carmen(options.log)
    if log.truncated:
        print(f"patrol convert: {log.truncated}", file=sys.stderr)
    if options.map:
        folder = load_map_folder(find_map(options.map, Path.cwd()))
    else:
        print("patrol convert: no --map given: building one from the log", file=sys.stderr)
        folder = map_of(log)
    with Progress("convert", log.odometry[-1][0] - log.odometry[0][0], "s") as progress:
        conversion = convert(log, folder, options.output, progress)
    print(
        f"{options.output}: {conversion.scans} scans and {conversion.base_reports} base reports "
        f"in {conversion.duration:.0f} s, as device bytes"
    )
    return 0


def map_of(log: CarmenLog) -> MapFolder:
    """Build the map of a log's place from its reference poses; it has no border."""
    with Progress("map", len(log.scans), "scans") as progress:
        built = build_map(log, progress=progress)
    with tempfile.TemporaryDirectory() as parent:
        folder = Path(parent) / log.path.name.split(".")[0]
        save_map(built.map, folder)
        return load_map_folder(folder)
