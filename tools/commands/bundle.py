"""``patrol bundle``: everything a robot's computer needs, for installation with no network."""

from __future__ import annotations

import argparse
import sys

from tools.deploy.bundle import MACHINES, make_bundle
from tools.output_path import output_folder


def configure(parser: argparse.ArgumentParser) -> None:
    """Declare the options."""
    parser.epilog = "example: patrol bundle -o patrol-bundle\n\nNeeds a package index, once."
    parser.add_argument("-o", "--output", type=output_folder, required=True, metavar="DIR")
    parser.add_argument(
        "--machine",
        action="append",
        choices=list(MACHINES),
        help="x86_64 or aarch64 (arm64); default: both",
    )


def run(options: argparse.Namespace) -> int:
    """Make the bundle, print its files and return 0."""
    machines = options.machine or list(MACHINES)

    def report(message: str) -> None:
        print(f"patrol bundle: {message}", file=sys.stderr, flush=True)

    files = make_bundle(options.output, machines, report)
    for path in files:
        print(f"{path.stat().st_size / 1e6:8.2f} MB  {path}")
    print(f"patrol bundle: now follow {options.output / 'INSTALL.txt'}", file=sys.stderr)
    return 0
