"""``patrol localize``: localization alone on a log or recording, judged by its reference poses."""

from __future__ import annotations

import argparse
import json
from pathlib import Path
from typing import cast

import cv2
import numpy as np

from maps.map_folder import MapFolder, load_map_folder
from maps.whole_file import write_whole
from robot_agent.config import find_map
from tools.commands.log_option import add_no_return, add_topics, print_notes, topics_of
from tools.localize.localize import LocalizeOptions, localize_steps, log_steps, map_of_log
from tools.localize.localize_report import STUDIES, format_table, run_count, run_study
from tools.localize.localize_study import RESOLUTION, read_study_log
from tools.localize.localize_trials import kidnapped_steps, outcome
from tools.localize.occlusion import Occlusion
from tools.logs.carmen import LogError
from tools.logs.laser_log import read_laser_log
from tools.logs.log_step import LogStep
from tools.logs.recorded_config import recorded_config
from tools.logs.recorded_scans import recorded_scans
from tools.logs.recording import read_recording
from tools.logs.ros_bag import is_ros_bag
from tools.mapping.map_build import Scans
from tools.number_range import not_negative, share, whole
from tools.output_path import output_file
from tools.progress import progress_line

_EPILOG = """examples:
  patrol localize --map intel_lab intel.log.gz --json out.json
  patrol localize --map-from even intel.log.gz --csv out.csv
  patrol localize --map-from all intel.log.gz --kidnap 600 --seed 3
  patrol localize --study accuracy intel.log.gz aces.log.gz seattle.log.gz:27"""


def configure(parser: argparse.ArgumentParser) -> None:
    """Declare the options."""
    parser.epilog = _EPILOG
    parser.add_argument(
        "logs",
        nargs="+",
        metavar="LOG[:N]",
        help="CARMEN log (plain or gzip) or recording (.mcap), from scan N on",
    )
    source = parser.add_mutually_exclusive_group(required=True)
    source.add_argument("--map", metavar="DIR", help="map folder or name")
    source.add_argument(
        "--map-from",
        choices=("all", "even"),
        help="map of the log's own scans at its reference poses; even: of every second one, and "
        "only the scans between are localized",
    )
    source.add_argument(
        "--study",
        action="append",
        choices=STUDIES,
        help="many runs over CARMEN logs and a table of them; may be given several times",
    )
    size = parser.add_mutually_exclusive_group()
    size.add_argument("--particles", type=whole(1), metavar="N", help="a fixed number")
    size.add_argument("--kld", action="store_true", help="KLD-adaptive number (the default)")
    parser.add_argument("--beams", type=whole(1), metavar="N", help="beams used per scan")
    parser.add_argument(
        "--global", dest="anywhere", action="store_true", help="start without an initial pose"
    )
    parser.add_argument(
        "--kidnap",
        type=not_negative,
        metavar="T",
        help="carry the robot elsewhere T s after the start",
    )
    parser.add_argument("--start-noise", action="store_true", help="start off the true pose")
    parser.add_argument("--first-scan", type=whole(), default=0, metavar="N", help="as LOG:N")
    parser.add_argument("--seed", type=whole(), default=0, metavar="N")
    parser.add_argument("--seeds", type=whole(1), default=20, metavar="N", help="of a study")
    parser.add_argument("--trials", type=whole(1), default=100, metavar="N", help="of a study")
    parser.add_argument(
        "--map-every", type=whole(1), default=1, metavar="N", help="study's map: every Nth scan"
    )
    hidden = parser.add_mutually_exclusive_group()
    hidden.add_argument(
        "--short", type=share, metavar="SHARE", help="share of a study's beams that end short"
    )
    hidden.add_argument(
        "--people", type=share, metavar="SHARE", help="share of its beams that end on people"
    )
    add_no_return(parser)
    add_topics(parser)
    parser.add_argument("--csv", type=output_file, metavar="OUT", help="write one line per scan")
    parser.add_argument("--json", type=output_file, metavar="OUT", help="write the summary")


def run(options: argparse.Namespace) -> int:
    """Localize and print the summary as JSON, or run studies and print their tables."""
    cv2.setNumThreads(1)
    logs = [_split(word, options.first_scan) for word in options.logs]
    if options.study:
        return _study(logs, options)
    if len(logs) > 1:
        raise LogError(f"{len(logs)} logs: give one, or --study for tables over several")
    return _localize(*logs[0], options)


# --- one run ---------------------------------------------------------------------------------


def _localize(path: Path, first_scan: int, options: argparse.Namespace) -> int:
    steps, folder = _read(path, options)
    steps = steps[first_scan:]
    if not steps:
        raise LogError(f"{path}: no scan from scan {first_scan} on: start with an earlier one")
    if options.map_from == "even":
        steps = steps[1 - first_scan % 2 :: 2]
    event = 0 if options.anywhere else None
    if options.kidnap is not None:
        event = _scans_before(steps, options.kidnap)
        rng = np.random.default_rng(options.seed)
        steps = kidnapped_steps(steps[:event], steps, rng)
    choices = LocalizeOptions(
        particles=options.particles,
        beams=options.beams,
        seed=options.seed,
        start_noise=options.start_noise,
        anywhere=options.anywhere,
    )
    with progress_line("localize", len(steps), "scans") as progress:
        result = localize_steps(str(path), steps, folder, choices, progress)
    summary = result.summary
    if event is not None and all(step.reference is not None for step in steps):
        summary["after_event"] = outcome(result, steps, event).summary
    _print_summary(summary, options.json)
    if options.csv:
        result.write_csv(options.csv)
    return 0


def _read(path: Path, options: argparse.Namespace) -> tuple[list[LogStep], MapFolder]:
    """Return a log's or recording's scans, and the map to localize on.

    Raises LogError for ``--map-from`` with a recording, which holds no reference poses.
    """
    if path.suffix == ".mcap" and not is_ros_bag(path):
        if options.map_from:
            raise LogError(f"{path}: --map-from needs a CARMEN log: give --map DIR")
        recording = read_recording(path)
        config, _ = recorded_config(recording)
        steps = list(recorded_scans(recording, config))
        print_notes("localize", [recording.truncated] if recording.truncated else [])
        return steps, _folder(options)
    log = read_laser_log(path, options.no_return, topics_of(options))
    print_notes("localize", log.notes)
    if not options.map_from:
        return log_steps(log), _folder(options)
    with progress_line("map", len(log.scans), "scans") as progress:
        scans = cast("Scans", options.map_from)
        return log_steps(log), map_of_log(log, RESOLUTION, scans, progress)


def _folder(options: argparse.Namespace) -> MapFolder:
    return load_map_folder(find_map(options.map, Path.cwd()))


def _scans_before(steps: list[LogStep], seconds: float) -> int:
    """Return the number of scans within that many seconds of the first; at least 1."""
    return max(1, sum(step.t - steps[0].t < seconds for step in steps))


# --- studies ---------------------------------------------------------------------------------


def _study(paths: list[tuple[Path, int]], options: argparse.Namespace) -> int:
    logs = []
    with progress_line("maps", len(paths), "logs") as progress:
        for done, (path, first_scan) in enumerate(paths, start=1):
            logs.append(
                read_study_log(
                    path,
                    first_scan,
                    options.no_return,
                    map_every=options.map_every,
                    occlusion=_occlusion(options),
                )
            )
            progress(done)
    tables = {}
    for name in dict.fromkeys(options.study):
        runs = run_count(name, len(logs), options.seeds, options.trials)
        with progress_line(name, runs, "runs") as progress:
            tables[name] = run_study(name, logs, options.seeds, options.trials, progress)
        print(f"{name}\n{format_table(tables[name])}\n", flush=True)
    if options.json:
        write_whole(options.json, json.dumps(tables, indent=2) + "\n")
    return 0


def _occlusion(options: argparse.Namespace) -> Occlusion | None:
    if options.short is not None:
        return Occlusion(options.short, by_people=False)
    return None if options.people is None else Occlusion(options.people, by_people=True)


# --- arguments and output --------------------------------------------------------------------


def _split(word: str, first_scan: int) -> tuple[Path, int]:
    """Return path and first scan of ``LOG:N``; an existing file of the whole name wins."""
    name, _, number = word.rpartition(":")
    if name and number.isdecimal() and not Path(word).exists():
        return Path(name), int(number)
    return Path(word), first_scan


def _print_summary(summary: dict[str, object], path: Path | None) -> None:
    text = json.dumps(summary, indent=2)
    print(text)
    if path is not None:
        write_whole(path, text + "\n")
