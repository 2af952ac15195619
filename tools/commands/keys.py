"""``patrol keys``: TLS certificates that authenticate robots and operator to each other."""

from __future__ import annotations

import argparse

from tools.deploy.certificates import make_keys
from tools.number_range import whole
from tools.output_path import output_folder


def configure(parser: argparse.ArgumentParser) -> None:
    """Declare the options."""
    parser.epilog = (
        "examples: patrol keys robot1 robot2 --team lab --host 192.168.1.10 -o keys\n"
        "          patrol keys --site --team lab --host office.example -o office-keys"
    )
    parser.add_argument("robots", nargs="*", metavar="ROBOT", help="robots that need a certificate")
    parser.add_argument(
        "--site",
        action="store_true",
        help="one for the monitor of the team's site, which forwards it to a head office",
    )
    parser.add_argument("--team", required=True, help="their team, as in their configuration")
    parser.add_argument(
        "--host",
        action="append",
        default=[],
        metavar="ADDRESS",
        help="address or name at which robots reach the operator; several may be given",
    )
    parser.add_argument("-o", "--output", type=output_folder, required=True, metavar="DIR")
    parser.add_argument("--days", type=whole(1), default=3650, metavar="N", help="validity in days")


def run(options: argparse.Namespace) -> int:
    """Make the missing certificates and print the files made."""
    made = make_keys(
        *(options.output, options.team, options.robots, options.host, options.days),
        site=options.site,
    )
    for name in made:
        print(options.output / name)
    return 0
