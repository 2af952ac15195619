"""``patrol paper``: the paper's experiment, its figures and whether its claims hold."""

from __future__ import annotations

import argparse
import json
import sys
from pathlib import Path

from maps.map_folder import load_map_folder
from robot_agent.config import find_map
from tools.bench.sensing import Sensing
from tools.paper import BORDER, DURATION_S, MAP, claims, run_paper
from tools.paper_figures import actions, distances, meeting
from tools.progress import Progress


def configure(parser: argparse.ArgumentParser) -> None:
    """Declare the options."""
    parser.epilog = "example: patrol paper -o paper/"
    parser.add_argument(
        "-o", "--output", type=Path, required=True, metavar="DIR", help="for figures and JSON"
    )
    parser.add_argument("--duration", type=float, default=DURATION_S, metavar="S")
    parser.add_argument("--seed", type=int, default=1, metavar="N")
    parser.add_argument(
        "--sensing",
        choices=list(Sensing),
        default=Sensing.BYTES,
        help="bytes: every byte, full noise; ideal: the decision layer alone",
    )


def run(options: argparse.Namespace) -> int:
    """Run it; print the claims as JSON; status 1 when one did not hold."""
    folder = load_map_folder(find_map(MAP, Path.cwd()), BORDER)
    sensing = Sensing(options.sensing)
    with Progress("paper", options.duration, "s") as progress:
        done = run_paper(folder, sensing, options.seed, options.duration, progress)
    told = claims(done)
    options.output.mkdir(parents=True, exist_ok=True)
    (options.output / "claims.json").write_text(json.dumps(told, indent=2) + "\n")
    for name, figure in (
        ("distance_from_border", distances(done)),
        ("actions", actions(done)),
        ("meeting", meeting(done)),
    ):
        if figure is None:
            print("patrol paper: no two robots met, no figure of it", file=sys.stderr)
            continue
        for suffix in ("svg", "png"):
            figure.savefig(options.output / f"{name}.{suffix}")
    print(json.dumps({key: value for key, value in told.items() if key != "turns"}, indent=2))
    return 0 if all(told["held"].values()) else 1
