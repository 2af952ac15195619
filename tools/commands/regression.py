"""``patrol regression``: compare the decisions of short runs with the stored reference.

``--update`` makes today's decisions the reference.
"""

from __future__ import annotations

import argparse

import cv2

from tools.quality.regression import (
    CASES,
    chosen_cases,
    decisions,
    difference,
    read_reference,
    write_reference,
)


def configure(parser: argparse.ArgumentParser) -> None:
    """Declare the options."""
    names = ", ".join(case.name for case in CASES)
    parser.epilog = f"example: patrol regression --update\n\ncases: {names}"
    parser.add_argument("cases", nargs="*", metavar="CASE", help="which ones; default: all")
    parser.add_argument(
        "--update", action="store_true", help="make today's decisions the reference"
    )


def run(options: argparse.Namespace) -> int:
    """Compare the decisions of short runs with the reference; print every difference.

    Returns 1 when one differs and ``--update`` is not given, else 0.
    """
    cv2.setNumThreads(1)
    changed = False
    for case in chosen_cases(options.cases):
        now = decisions(case)
        lines = difference(read_reference(case), now)
        print(f"{case.name}: {lines[0] if lines else f'{len(now)} decisions, all as kept'}")
        for line in lines[1:]:
            print(line)
        changed = changed or bool(lines)
        if lines and options.update:
            write_reference(case, now)
            print(f"{case.name}: reference updated: {case.reference.name}")
    return 1 if changed and not options.update else 0
