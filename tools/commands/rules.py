"""``patrol rules``: draw and check the supervisor's fuzzy sets and rules."""

from __future__ import annotations

import argparse
from pathlib import Path

from robot_agent.patrol.rules import RULES_FILE, check_rules
from robot_agent.patrol.settings import PatrolSettings
from tools.number_range import not_negative
from tools.output_path import output_file

_SHIPPED = PatrolSettings()


def configure(parser: argparse.ArgumentParser) -> None:
    """Declare the options."""
    actions = parser.add_subparsers(dest="action", metavar="ACTION", required=True)

    show = actions.add_parser("show", help="write a picture of the fuzzy sets and decisions")
    show.epilog = "example: patrol rules show -o rules.png"
    show.add_argument(
        "rules", type=Path, nargs="?", default=RULES_FILE, metavar="RULES.toml", help="or shipped"
    )
    show.add_argument("--reading", choices=("R1", "R2", "R3"), default=_SHIPPED.reading)
    show.add_argument("--open", action="store_true", help="with the ends of an open border")
    show.add_argument("-o", "--output", type=output_file, required=True, metavar="PNG")
    _add_safety_distance(show)
    show.set_defaults(act=_show)

    check = actions.add_parser("check", help="check a rule file in all its readings")
    check.epilog = "example: patrol rules check my_rules.toml"
    check.add_argument("rules", type=Path, metavar="RULES.toml")
    _add_safety_distance(check)
    check.set_defaults(act=_check)


def run(options: argparse.Namespace) -> int:
    """Run the chosen action."""
    status: int = options.act(options)
    return status


def _add_safety_distance(parser: argparse.ArgumentParser) -> None:
    parser.add_argument(
        "--safety-distance",
        type=not_negative,
        default=_SHIPPED.safety_distance,
        metavar="M",
        help="d_s the sets must agree with",
    )


def _show(options: argparse.Namespace) -> int:
    from tools.studies.rules_picture import draw_rules  # needs matplotlib, checking does not

    draw_rules(
        options.rules,
        options.output,
        reading=options.reading,
        safety_distance=options.safety_distance,
        open_border=options.open,
    )
    print(options.output)
    return 0


def _check(options: argparse.Namespace) -> int:
    check_rules(options.rules, safety_distance=options.safety_distance)
    print(f"{options.rules}: OK")
    return 0
