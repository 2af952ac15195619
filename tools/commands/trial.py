"""``patrol trial``: the bundle on a virtual robot's computer, started at boot, with faults."""

from __future__ import annotations

import argparse
import signal
import sys
import tempfile
from pathlib import Path
from types import FrameType

from maps.whole_file import write_whole
from tools.field.field_row import FieldRow, Outcome, markdown, verdict
from tools.field.field_trial import run_trial
from tools.field.row_list import ROWS, chosen_rows
from tools.number_range import positive
from tools.output_path import output_file, output_folder


def configure(parser: argparse.ArgumentParser) -> None:
    """Declare the options."""
    listing = "\n".join(f"  {row.name:<18} {row.what}" for row in ROWS)
    parser.epilog = (
        "example: patrol trial -o table.md\n"
        "         patrol trial --only boot-late --folder out/trial\n\n"
        "Needs qemu and packages of Debian 12, which it installs as root, or names.\n\n"
        f"rows:\n{listing}"
    )
    parser.add_argument("--only", action="append", default=[], metavar="ROW", help="this row")
    parser.add_argument("--list", action="store_true", help="name the rows and end")
    parser.add_argument(
        "-o", "--output", type=output_file, metavar="OUT.md", help="write the table there"
    )
    parser.add_argument(
        "--folder",
        type=output_folder,
        metavar="DIR",
        help="keep disks, logs and recordings there; an installation found there is used again",
    )
    parser.add_argument(
        "--rate",
        type=positive,
        metavar="R",
        help="seconds of the machine's clock in a real one; default 1 with KVM, else 0.25",
    )


def run(options: argparse.Namespace) -> int:
    """Run the rows and print the table; return 1 if anything did not hold, else 0."""
    if options.list:
        for row in ROWS:
            print(f"{row.name:<18} {row.what}; must: {row.must}")
        return 0
    rows = chosen_rows(options.only)
    signal.signal(signal.SIGTERM, _interrupt)  # as Ctrl-C: machines are switched off
    done: list[tuple[FieldRow, Outcome]] = []

    def ended(row: FieldRow, outcome: Outcome) -> None:
        done.append((row, outcome))
        _report(f"{row.name}: {verdict(outcome)} ({'; '.join(outcome.measured)})")
        if options.output:
            write_whole(options.output, markdown(done))

    try:
        with tempfile.TemporaryDirectory(prefix="patrol-trial-") as own:
            run_trial(rows, options.folder or Path(own), options.rate, _report, ended)
    finally:
        if done:  # rows take minutes: what is done is told, whatever ends them
            print(markdown(done), end="")
    return 1 if any(outcome.complaints for _, outcome in done) else 0


def _report(message: str) -> None:
    print(f"patrol trial: {message}", file=sys.stderr, flush=True)


def _interrupt(_number: int, _frame: FrameType | None) -> None:
    raise KeyboardInterrupt
