"""``patrol benchmark``: one table of the figures every change keeps."""

from __future__ import annotations

import argparse
import sys
from pathlib import Path

import cv2
from rich.console import Console
from rich.table import Table

from robot_agent.config import find_map
from tools.benchmark.figure import Figure
from tools.benchmark.groups import GROUPS


def configure(parser: argparse.ArgumentParser) -> None:
    """Declare the options."""
    parser.epilog = "example: patrol benchmark supervisor replay"
    parser.add_argument("group", nargs="*", choices=[[], *GROUPS], help="only these groups")


def run(options: argparse.Namespace) -> int:
    """Measure the chosen groups and print the table; return 1 when a limit is missed, else 0."""
    cv2.setNumThreads(1)
    folder = find_map("paper_lab", Path.cwd())
    figures: list[Figure] = []
    for group in options.group or GROUPS:
        print(f"patrol benchmark: measuring {group}", file=sys.stderr, flush=True)
        figures += [figure.beside_kernel() for figure in GROUPS[group](folder)]
    table = Table(title="figures every change keeps")
    for heading in ("figure", "measured", "x kernel", "limit", ""):
        table.add_column(heading)
    for figure in figures:
        table.add_row(*figure.cells())
    Console(highlight=False).print(table)
    return 0 if all(figure.kept for figure in figures) else 1
