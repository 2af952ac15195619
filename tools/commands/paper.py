"""``patrol paper``: run the paper's experiment, draw its figures, check its claims."""

from __future__ import annotations

import argparse
import json
import sys
from pathlib import Path

from maps.map_folder import load_map_folder
from maps.whole_file import write_whole
from robot_agent.config import find_map
from robot_agent.patrol.settings import PAPER_STRATEGY
from tools.bench.sensing import Sensing
from tools.commands.settings_option import add_set_option, chosen_config
from tools.commands.truth_option import add_truth_option, chosen_truth
from tools.number_range import positive, whole
from tools.output_path import output_folder
from tools.progress import progress_line
from tools.studies.paper import BORDER, DURATION_S, MAP, PaperTrial, claims, over_seeds, run_seeds
from tools.studies.paper_figures import write_figures


def configure(parser: argparse.ArgumentParser) -> None:
    """Declare the options."""
    parser.epilog = (
        "Without --config the robots turn where the paper's do: no common_turns, no even_gaps; "
        "--pure leaves out the other modifiers too. example: patrol paper -o paper/ --seeds 20"
    )
    parser.add_argument(
        "-o",
        "--output",
        type=output_folder,
        required=True,
        metavar="DIR",
        help="for figures and JSON",
    )
    parser.add_argument("--duration", type=positive, default=DURATION_S, metavar="S")
    parser.add_argument("--seed", type=whole(), default=1, metavar="N", help="the first")
    parser.add_argument("--seeds", type=whole(1), default=1, metavar="N", help="how many")
    parser.add_argument("--jobs", type=whole(1), default=1, metavar="N", help="processes at a time")
    parser.add_argument("--map", default=MAP, metavar="DIR", help="map folder or name")
    parser.add_argument("--border", default=BORDER, metavar="NAME")
    parser.add_argument(
        "--sensing",
        choices=list(Sensing),
        default=Sensing.BYTES,
        help="bytes: every byte, full noise; ideal: the decision layer alone",
    )
    add_truth_option(parser)
    add_set_option(parser)


def run(options: argparse.Namespace) -> int:
    """Run the experiment and print the claims as JSON; return 1 when one did not hold, else 0.

    Every seed's claims are in ``claims.json``; the figures are of the first seed.
    """
    config = chosen_config(options, {"patrol.modifiers": list(PAPER_STRATEGY)})
    truth = chosen_truth(options)
    folder = find_map(options.map, Path.cwd())
    load_map_folder(folder, options.border)  # reports a wrong folder before anything is run
    sensing = Sensing(options.sensing)
    if options.truth and sensing is Sensing.IDEAL:
        print("patrol paper: --truth needs --sensing bytes", file=sys.stderr)
        return 2
    trial = PaperTrial(folder, options.border, sensing, options.duration, config, truth)
    seeds = range(options.seed, options.seed + options.seeds)
    claimed = []
    with progress_line("paper", len(seeds), "runs") as progress:
        for done in run_seeds(trial, seeds, options.jobs):
            claimed.append(claims(done))
            # Written after every run: an interrupted command keeps its results so far.
            write_whole(options.output / "claims.json", json.dumps(claimed, indent=2) + "\n")
            if len(claimed) == 1 and not write_figures(done, config.patrol, options.output):
                print("patrol paper: no two robots met, no figure of it", file=sys.stderr)
            progress(len(claimed))
    summary = over_seeds(claimed)
    print(json.dumps(summary, indent=2))
    return 0 if all(summary["held"].values()) else 1
