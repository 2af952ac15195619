"""``patrol mutation``: mutation test of the safety gate against its table of cases."""

from __future__ import annotations

import argparse

from tools.progress import progress_line
from tools.quality.gate_mutation import SURVIVORS, judge, load_cases, mutant_names, unexplained


def configure(parser: argparse.ArgumentParser) -> None:
    """Declare the options."""
    parser.epilog = (
        "example: patrol mutation\n\nChanges every comparison, constant, sign and operator of the "
        "safety gate, one at a time,\nand lists which its test cases kill and which survive, and "
        "why. Needs a checkout."
    )
    parser.add_argument("--all", action="store_true", help="list the killed ones too")


def run(options: argparse.Namespace) -> int:
    """Run every mutant; return 1 when one survives that is not listed as equivalent, else 0."""
    cases = load_cases()
    survivors, count = [], 0
    with progress_line("mutants", len(mutant_names())) as progress:
        for verdict in judge(cases):
            count += 1
            progress(count)
            if not verdict.killed:
                survivors.append(verdict.mutant)
            elif options.all:
                print(f"killed    {verdict.mutant}")
    reasons = dict(SURVIVORS)
    for name in survivors:
        print(f"survived  {name}\n          {reasons.get(name, 'NOT EXPLAINED')}")
    gaps = unexplained(survivors)
    print(f"{count} mutants, {count - len(survivors)} killed, {len(survivors)} survived, ", end="")
    print(f"{len(gaps)} of them unexplained")
    return 1 if gaps else 0
