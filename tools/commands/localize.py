"""``patrol localize``: localization alone on a log or recording, judged by its reference poses."""

from __future__ import annotations

import argparse
import json
import sys
from pathlib import Path

import cv2

from maps.map_folder import MapFolder, load_map_folder
from robot_agent.config import find_map, parse_config
from tools.carmen import read_carmen
from tools.localize import LocalizeOptions, localize, localize_steps
from tools.localize_result import LocalizeResult
from tools.progress import Progress
from tools.recorded_scans import recorded_scans
from tools.recording import read_recording


def configure(parser: argparse.ArgumentParser) -> None:
    """Declare the options."""
    parser.epilog = "example: patrol localize --map intel_lab intel.log.gz --json out.json"
    parser.add_argument("log", type=Path, help="CARMEN log (plain or gzip) or recording (.mcap)")
    parser.add_argument("--map", required=True, metavar="DIR", help="map folder or name")
    size = parser.add_mutually_exclusive_group()
    size.add_argument("--particles", type=_positive, metavar="N", help="a fixed number")
    size.add_argument("--kld", action="store_true", help="KLD-adaptive number (the default)")
    parser.add_argument("--beams", type=_positive, metavar="N", help="beams used per scan")
    parser.add_argument(
        "--global", dest="anywhere", action="store_true", help="start with no idea of the pose"
    )
    parser.add_argument("--start-noise", action="store_true", help="start off the true pose")
    parser.add_argument("--first-scan", type=int, default=0, metavar="N", help="leave out earlier")
    parser.add_argument("--seed", type=int, default=0, metavar="N")
    parser.add_argument("--csv", type=Path, metavar="OUT", help="write one line per scan")
    parser.add_argument("--json", type=Path, metavar="OUT", help="write the summary")


def run(options: argparse.Namespace) -> int:
    """Localize, print the summary as JSON; status 1 when the robot was lost."""
    cv2.setNumThreads(1)
    folder = load_map_folder(find_map(options.map, Path.cwd()))
    result = _localize(
        options.log,
        folder,
        LocalizeOptions(
            particles=options.particles,
            beams=options.beams,
            seed=options.seed,
            start_noise=options.start_noise,
            anywhere=options.anywhere,
            first_scan=options.first_scan,
        ),
    )
    if options.csv:
        result.write_csv(options.csv)
    if options.json:
        result.write_json(options.json)
    print(json.dumps(result.summary, indent=2))
    return 0


def _localize(path: Path, folder: MapFolder, options: LocalizeOptions) -> LocalizeResult:
    if path.suffix == ".mcap":
        recording = read_recording(path)
        config = parse_config(recording.header.configuration, f"{path} (configuration)")
        steps = list(recorded_scans(recording, config))
        _warn(recording.truncated)
        with Progress("localize", len(steps), "scans") as progress:
            return localize_steps(str(path), steps, folder, options, progress)
    log = read_carmen(path)
    _warn(log.truncated)
    with Progress("localize", len(log.scans), "scans") as progress:
        return localize(log, folder, options, progress)


def _warn(truncated: str | None) -> None:
    if truncated:
        print(f"patrol localize: {truncated}", file=sys.stderr)


def _positive(text: str) -> int:
    value = int(text)
    if value < 1:
        raise argparse.ArgumentTypeError(f"{text} is not a positive number")
    return value
