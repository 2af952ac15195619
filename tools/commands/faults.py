"""``patrol faults``: how a patrolling robot takes faults, measured on emulated devices."""

from __future__ import annotations

import argparse
import dataclasses
import json
import sys

from drivers.p2os.emulator.base import FACTORY_WATCHDOG
from maps.whole_file import write_whole
from tools.campaign.fault_list import FAULTS, chosen_faults
from tools.campaign.fault_table import markdown, run_faults
from tools.campaign.reaction import Reaction
from tools.number_range import not_negative
from tools.output_path import output_file, output_folder
from tools.preflight.watchdog_trial import ADVISED_WATCHDOG_S
from tools.progress import progress_line


def configure(parser: argparse.ArgumentParser) -> None:
    """Declare the options."""
    listing = "\n".join(f"  {fault.name:<16} {fault.what}" for fault in FAULTS)
    parser.epilog = (
        f"example: patrol faults base-unplugged laser-silent\n\nfaults, about 15 s each:\n{listing}"
    )
    parser.add_argument("faults", nargs="*", metavar="FAULT", help="which ones; default: all")
    parser.add_argument(
        "-o", "--output", type=output_file, metavar="OUT.md", help="write the table there"
    )
    parser.add_argument(
        "--record", type=output_folder, metavar="DIR", help="keep recordings, in a folder per fault"
    )
    parser.add_argument(
        "--watchdog",
        type=not_negative,
        default=ADVISED_WATCHDOG_S,
        metavar="S",
        help=f"watchdog time-out in the base's FLASH; default {ADVISED_WATCHDOG_S:g}, factory "
        f"{FACTORY_WATCHDOG:g}",
    )
    parser.add_argument("--json", action="store_true", help="print JSON instead of Markdown")


def run(options: argparse.Namespace) -> int:
    """Run the faults and print the table; return 1 when a reaction misses its limits, else 0."""
    faults = chosen_faults(options.faults)
    with progress_line("faults", len(faults)) as progress:
        done: list[Reaction] = []

        def report(reaction: Reaction) -> None:
            done.append(reaction)
            progress(len(done))
            if not sys.stderr.isatty():
                verdict = "; ".join(reaction.complaints) or "ok"
                print(f"patrol faults: {reaction.fault}: {verdict}", file=sys.stderr, flush=True)

        reactions = run_faults(faults, report, options.record, options.watchdog)
    if options.json:
        print(json.dumps([dataclasses.asdict(reaction) for reaction in reactions], indent=2))
    else:
        print(markdown(reactions), end="")
    if options.output:
        write_whole(options.output, markdown(reactions))
    return 1 if any(reaction.complaints for reaction in reactions) else 0
