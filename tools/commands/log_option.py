"""The option ``--no-return`` of commands that read CARMEN logs, and their notes on a log."""

from __future__ import annotations

import argparse
import sys
from collections.abc import Iterable

from tools.number_range import positive


def add_no_return(parser: argparse.ArgumentParser) -> None:
    """Declare ``--no-return``."""
    parser.add_argument(
        "--no-return",
        type=positive,
        metavar="M",
        help="readings of a log from M metres on mean no return; found in the log when absent",
    )


def print_notes(command: str, notes: Iterable[str]) -> None:
    """Print what was assumed or left out in reading a log, a line each."""
    for note in notes:
        print(f"patrol {command}: {note}", file=sys.stderr)
