"""``patrol study``: many benches over seeds and settings, resumable; table and plots."""

from __future__ import annotations

import argparse
import os
import sys
from pathlib import Path

from rich.console import Console
from rich.table import Table

from tools.commands.settings_option import add_set_option, robots_file
from tools.commands.truth_option import add_truth_option, chosen_truth
from tools.number_range import whole
from tools.progress import progress_line
from tools.studies.study import read_study, run_study
from tools.studies.study_plot import plot_study, plot_trade_off
from tools.studies.study_table import table, write_csv


def configure(parser: argparse.ArgumentParser) -> None:
    """Declare the options."""
    parser.epilog = "example: patrol study reversal.toml -o reversal/ --jobs 2"
    parser.add_argument("file", type=Path, metavar="FILE.toml", help="what to vary")
    parser.add_argument("-o", "--output", type=Path, required=True, metavar="DIR")
    parser.add_argument(
        "--jobs",
        type=whole(1),
        default=os.cpu_count() or 1,
        metavar="N",
        help="processes at a time",
    )
    parser.add_argument(
        "--cluster",
        metavar="ADDRESS",
        help="run on the Dask cluster of this scheduler, such as tcp://host:8786",
    )
    add_truth_option(parser)
    add_set_option(parser)


def run(options: argparse.Namespace) -> int:
    """Run the study, write runs.csv and the plots, print the table; return 1 on a contact."""
    config = robots_file(options).decode()
    study = read_study(options.file, options.set, config, chosen_truth(options).name)
    print(
        f"patrol study: {len(study.cases)} cases x {study.settings.seeds} seeds; "
        f"stop it any time, the same command goes on",
        file=sys.stderr,
    )
    with progress_line("study", len(study.runs), "runs") as progress:
        results = run_study(study, options.output, max(1, options.jobs), progress, options.cluster)
    rows = table(results)
    write_csv(results, options.output / "runs.csv")
    plot_study(rows, options.output / "study.svg")
    bounds = results[0].figures["intruder_bound"]
    plot_trade_off(rows, bounds, options.output / "trade_off.svg")
    printed = Table(title=f"mean and 95 % interval over {study.settings.seeds} seeds")
    printed.add_column("figure", no_wrap=True)
    for case in rows:
        printed.add_column(str(case))
    for name in next(iter(rows.values())):
        printed.add_row(name, *(str(row[name] or "") for row in rows.values()))
    Console(highlight=False).print(printed)
    return 1 if any(result.figures["contacts"] for result in results) else 0
