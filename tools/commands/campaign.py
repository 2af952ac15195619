"""``patrol campaign``: every fault once, ``--endurance``: a few again and again, ``--lies``."""

from __future__ import annotations

import argparse
import sys

from maps.whole_file import write_whole
from tools.commands import faults
from tools.number_range import whole
from tools.output_path import output_file
from tools.progress import progress_line


def configure(parser: argparse.ArgumentParser) -> None:
    """Declare the options: those of ``patrol faults``, and the endurance."""
    faults.configure(parser)
    parser.add_argument(
        "--endurance",
        nargs="*",
        metavar="TRIAL",
        help="instead: handles, threads and memory over many cycles: replug, come-and-go, "
        "disk-full, kill-starts, clock-jumps, monitored-day; default: all, half an hour",
    )
    parser.add_argument(
        "--series",
        type=output_file,
        metavar="FILE",
        help="of an endurance: what was held after each cycle, as .csv, or drawn as .svg, .png, "
        ".pdf",
    )
    parser.add_argument(
        "--lies",
        nargs="*",
        metavar="LIE",
        help="instead: robots whose devices or map tell them something wrong, 3 minutes each by "
        "the bench's clock: half-stuck, mirrored, scaled, crowd, blind-corner ...; default: all",
    )
    parser.add_argument(
        "--seeds", type=whole(1), default=3, metavar="N", help="runs of each lie; default: 3"
    )
    parser.add_argument(
        "--cycles", type=whole(2), metavar="N", help="of each trial; default: its own number"
    )


def run(options: argparse.Namespace) -> int:
    """Run faults or endurance and print the table; return 1 when a limit is missed, else 0."""
    if options.lies is not None:
        return _tell_lies(options)
    if options.endurance is None:
        return faults.run(options)
    return _endure(options)


def _endure(options: argparse.Namespace) -> int:
    from tools.campaign.endurance import endure, markdown
    from tools.campaign.endurance_list import chosen_trials
    from tools.campaign.endurance_series import check_series, write_series

    if options.series:
        check_series(options.series)
    outcomes = []
    for trial in chosen_trials(options.endurance):
        cycles = options.cycles or trial.cycles
        with progress_line(trial.name, cycles) as progress:
            outcomes.append(endure(trial, cycles, progress))
        verdict = "; ".join(outcomes[-1].complaints) or "ok"
        print(f"patrol campaign: {trial.name}: {verdict}", file=sys.stderr, flush=True)
    print(markdown(outcomes), end="")
    if options.series:
        write_series(outcomes, options.series)
    return 1 if any(outcome.complaints for outcome in outcomes) else 0


def _tell_lies(options: argparse.Namespace) -> int:
    from tools.campaign.lie import lies_table, seconds_of, tell
    from tools.campaign.lie_list import chosen_lies

    seeds = range(1, options.seeds + 1)
    told = []
    for lie in chosen_lies(options.lies):
        with progress_line(lie.name, seconds_of(seeds)) as progress:
            told.append(tell(lie, seeds, progress))
    table = lies_table(told)
    print(table, end="")
    if options.output:
        write_whole(options.output, table)
    return 1 if any(each.complaints for each in told) else 0
