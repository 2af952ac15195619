"""``patrol soak``: a team under random faults for hours, faster than real time."""

from __future__ import annotations

import argparse
import dataclasses
import json
import tempfile
from pathlib import Path

from maps.map_folder import load_map_folder
from robot_agent.config import find_map
from tools.commands.truth_option import add_truth_option, chosen_truth
from tools.number_range import not_negative, positive, whole
from tools.output_path import output_file, output_folder
from tools.progress import progress_line
from tools.studies.soak import HOUR_S, Soak, SoakHour, SoakLog, summary


def configure(parser: argparse.ArgumentParser) -> None:
    """Declare the options."""
    parser.epilog = (
        "example: patrol soak --hours 24 --json soak.jsonl\n\n"
        "One line per simulated hour: contacts, idleness, memory, recordings; then a summary."
    )
    parser.add_argument("--hours", type=positive, default=24.0, metavar="H", help="simulated hours")
    parser.add_argument("--robots", type=whole(1, 500), default=3, metavar="N")
    parser.add_argument("--map", default="paper_lab", metavar="DIR", help="map folder or name")
    parser.add_argument("--seed", type=whole(), default=1, metavar="N")
    parser.add_argument(
        *("--every", "--fault-every"),
        type=not_negative,
        default=600.0,
        metavar="S",
        help="mean time between two faults of a robot",
    )
    add_truth_option(parser)
    parser.add_argument(
        "--record", type=output_folder, metavar="DIR", help="keep the last recordings there"
    )
    parser.add_argument(
        "--json",
        type=output_file,
        metavar="OUT.jsonl",
        help="append a line after each hour, and write OUT.summary.json: a kill loses one hour",
    )


def run(options: argparse.Namespace) -> int:
    """Run the soak; return 1 after a contact under a running agent or a lost record, else 0."""
    folder = load_map_folder(find_map(options.map, Path.cwd()))
    duration = options.hours * HOUR_S
    rows: list[SoakHour] = []
    log = SoakLog(options.json) if options.json else None
    with (
        tempfile.TemporaryDirectory(prefix="patrol-soak-") as kept,
        progress_line("soak", duration, "s") as progress,
    ):
        soak = Soak(
            folder,
            options.robots,
            options.seed,
            duration,
            options.every,
            options.record or Path(kept),
            chosen_truth(options),
        )
        for row in soak.hours(progress):
            rows.append(row)
            print(json.dumps(dataclasses.asdict(row)), flush=True)
            if log is not None:
                log.add(row)
    print(json.dumps(summary(rows), indent=2))
    return 1 if rows[-1].contacts or rows[-1].records_lost else 0
