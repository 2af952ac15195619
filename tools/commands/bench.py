"""``patrol bench``: robots in lockstep, through every byte or by the decision layer alone."""

from __future__ import annotations

import argparse
import json
import sys
from contextlib import ExitStack, closing
from pathlib import Path

import cv2

from maps.border import BorderError
from maps.map_folder import load_map_folder
from maps.whole_file import write_whole
from robot_agent.config import find_map
from tools.batch.batch import Batch
from tools.batch.batch_bench import MOMENTS, run_batch
from tools.bench.bench_fault import FaultKind, draw_faults
from tools.bench.bench_table import bench_table
from tools.bench.fleet_recorder import FleetRecorder
from tools.bench.sensing import Sensing, bench
from tools.commands.settings_option import add_set_option, chosen_config
from tools.commands.truth_option import add_truth_option, chosen_truth
from tools.number_range import positive, whole
from tools.output_path import output_file, output_folder
from tools.progress import progress_line

STANDARD_OUTPUT = Path("-")


def configure(parser: argparse.ArgumentParser) -> None:
    """Declare the options."""
    parser.epilog = "example: patrol bench --robots 3 --duration 600 --json out.json"
    parser.add_argument("--robots", type=whole(1, 500), default=3, metavar="N")
    parser.add_argument("--map", default="paper_lab", metavar="DIR", help="map folder or name")
    parser.add_argument("--border", default="border", metavar="NAME", help="border file of the map")
    parser.add_argument(
        "--duration", type=positive, default=300.0, metavar="S", help="simulated time"
    )
    parser.add_argument("--seed", type=whole(), default=1, metavar="N")
    parser.add_argument(
        "--sensing",
        choices=[sensing.value for sensing in Sensing],
        default=Sensing.BYTES,
        help="bytes: the real agents, every byte; ideal: the decision layer alone, far faster",
    )
    parser.add_argument(
        "--all-knowing",
        action="store_true",
        help="with --sensing ideal: also the intruder who sees all robots, by rollouts; slower",
    )
    parser.add_argument(
        "--fault",
        action="append",
        default=[],
        metavar="SPEC",
        help="robot2:dead@120, robot1:blind@60-90 or @60+30 (s), any2:dead@60..300 (drawn by the "
        "seed); kinds: " + ", ".join(FaultKind),
    )
    parser.add_argument(
        "--strangers",
        type=whole(),
        default=0,
        metavar="N",
        help="moving people and carts to emulate",
    )
    parser.add_argument(
        "--camera", choices=["on", "off"], default="off", help="emulate the robots' cameras; slower"
    )
    parser.add_argument(
        "--tight",
        action="store_true",
        help="start beside walls, where robots can hardly turn: a stress of the safety gate",
    )
    add_truth_option(parser)
    add_set_option(parser)
    parser.add_argument(
        "--record", type=output_folder, metavar="DIR", help="keep a recording per robot"
    )
    parser.add_argument(
        "--json",
        type=output_file,
        metavar="OUT",
        help="write all figures to this file; -: print them",
    )


def run(options: argparse.Namespace) -> int:
    """Run one bench; print its figures."""
    truth = chosen_truth(options)
    config = chosen_config(options)
    cv2.setNumThreads(1)  # images are small: more threads cost more than they save
    path = find_map(options.map, Path.cwd())
    folder = load_map_folder(path, options.border)
    if folder.border is None:
        raise BorderError(f"{path}: has no border.toml to patrol; add one")
    team = [f"robot{number}" for number in range(1, options.robots + 1)]
    faults = draw_faults(options.fault, team, options.seed)
    sensing = Sensing(options.sensing)
    if options.record and sensing is Sensing.IDEAL:
        print("patrol bench: --record keeps bytes, and --sensing ideal has none", file=sys.stderr)
        return 2
    if options.truth and sensing is Sensing.IDEAL:
        print("patrol bench: --truth needs --sensing bytes", file=sys.stderr)
        return 2
    if options.all_knowing and sensing is not Sensing.IDEAL:
        print("patrol bench: --all-knowing needs --sensing ideal", file=sys.stderr)
        return 2
    cameras = options.camera == "on"
    if (options.strangers or cameras or options.tight) and sensing is Sensing.IDEAL:
        needs = "--strangers, --camera and --tight need --sensing bytes"
        print(f"patrol bench: {needs}", file=sys.stderr)
        return 2
    with ExitStack() as stack:
        recorder = None
        if options.record:
            recorder = stack.enter_context(closing(FleetRecorder(folder, options.record)))
        progress = stack.enter_context(progress_line("bench", options.duration, "s"))
        if options.all_knowing:
            batch = Batch(folder, options.robots, [options.seed], config, faults=[faults])
            (figures,) = run_batch(batch, options.duration, moments=MOMENTS, progress=progress)
        else:
            figures = bench(
                sensing,
                folder,
                options.robots,
                options.seed,
                options.duration,
                config=config,
                faults=faults,
                observer=recorder.observe if recorder else None,
                strangers=options.strangers,
                cameras=cameras,
                truth=truth,
                tight=options.tight,
                progress=progress,
            )
    text = json.dumps(figures, indent=2)
    if options.json == STANDARD_OUTPUT:
        print(text)
    else:
        print(bench_table(figures))
        if options.json:
            write_whole(options.json, text + "\n")
    return 0 if figures["contacts"] == 0 else 1
