"""``patrol study``: many benches over seeds and settings, resumable; table and plots."""

from __future__ import annotations

import argparse
import os
import sys
from collections.abc import Sequence
from pathlib import Path

from rich.console import Console
from rich.table import Table

from tools.commands.settings_option import add_set_option, robots_file
from tools.commands.truth_option import add_truth_option, chosen_truth
from tools.number_range import whole
from tools.output_path import output_folder
from tools.progress import progress_line
from tools.report.style import FORMATS
from tools.studies.case_names import CaseNames
from tools.studies.study import Result, read_study, run_study
from tools.studies.study_difference import differences, write_differences
from tools.studies.study_markdown import write_markdown
from tools.studies.study_plot import Rows, plot_figures, plot_study
from tools.studies.study_table import table, write_csv
from tools.studies.trade_off_plot import plot_trade_off


def configure(parser: argparse.ArgumentParser) -> None:
    """Declare the options."""
    parser.epilog = "example: patrol study reversal.toml -o reversal/ --jobs 2"
    parser.add_argument("file", type=Path, metavar="FILE.toml", help="what to vary")
    parser.add_argument("-o", "--output", type=output_folder, required=True, metavar="DIR")
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
    parser.add_argument(
        "--figures",
        choices=FORMATS,
        help="write only the figures, a file each, in this format; no table",
    )
    add_truth_option(parser)
    add_set_option(parser)


def run(options: argparse.Namespace) -> int:
    """Run the study, write tables and figures, print the tables; return 1 on a contact."""
    config = robots_file(options).decode()
    study = read_study(options.file, options.set, config, chosen_truth(options).name)
    print(
        f"patrol study: {len(study.cases)} cases x {study.settings.seeds} seeds; "
        f"stop it any time, the same command goes on",
        file=sys.stderr,
    )
    with progress_line("study", len(study.runs), "runs") as progress:
        results = run_study(study, options.output, max(1, options.jobs), progress, options.cluster)
    rows, names = table(results), CaseNames(study.cases)
    if options.figures:
        for path in plot_figures(rows, names, options.output, options.figures):
            print(path)
        return status_of(results)
    found = differences(results, names)
    write_csv(results, options.output / "runs.csv")
    write_differences(found, names, options.output / "differences.csv")
    write_markdown(rows, names, options.output / "study.md")
    plot_study(rows, names, options.output)
    plot_trade_off(rows, names, results[0].figures["intruder_bound"], options.output)
    seeds = f"{study.settings.seeds} seeds"
    print_table(rows, names, f"mean and 95 % interval over {seeds}")
    if found:
        base = f"{names.column_key} {names.column(found[0].base)}"
        changes = {each.case: each.figures for each in found}
        print_table(changes, names, f"difference from {base}, paired over {seeds}")
    return status_of(results)


def status_of(results: Sequence[Result]) -> int:
    """Return 1 if there was a contact in any run, else 0."""
    return 1 if any(result.figures["contacts"] for result in results) else 0


def print_table(rows: Rows, names: CaseNames, title: str) -> None:
    """Print every figure: a line for each combination of the varied keys but the last."""
    columns = list(dict.fromkeys(map(names.column, rows)))
    lines = list(dict.fromkeys(map(names.row, rows)))
    case_of = {(names.row(case), names.column(case)): case for case in rows}
    printed = Table(title="\n".join(filter(None, (title, names.title))))
    printed.add_column("figure", no_wrap=True)
    for column in columns:
        printed.add_column(f"{names.column_key} {column}".strip(), justify="right")
    for name in next(iter(rows.values())):
        if not any(row[name] for row in rows.values()):
            continue
        if lines != [""]:
            printed.add_section()
            printed.add_row(name, style="bold")
        for line in lines:
            cases = [case_of.get((line, column)) for column in columns]
            cells = [str((rows[case][name] if case else None) or "") for case in cases]
            printed.add_row(f"  {line}" if line else name, *cells)
    Console(highlight=False).print(printed)
