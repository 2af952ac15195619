"""The options of commands that read logs, and their notes on a log."""

from __future__ import annotations

import argparse
import sys
from collections.abc import Iterable

from tools.logs.ros_bag import RosTopics
from tools.number_range import positive


def add_no_return(parser: argparse.ArgumentParser) -> None:
    """Declare ``--no-return``."""
    parser.add_argument(
        "--no-return",
        type=positive,
        metavar="M",
        help="readings of a log from M metres on mean no return; found in the log when absent",
    )


def add_topics(parser: argparse.ArgumentParser) -> None:
    """Declare ``--scan-topic`` and ``--odom-topic``."""
    for option, kind in (("--scan-topic", "LaserScan"), ("--odom-topic", "Odometry")):
        parser.add_argument(
            option, metavar="NAME", help=f"of a ROS bag with several topics of {kind}"
        )


def topics_of(options: argparse.Namespace) -> RosTopics:
    """Return the chosen topics."""
    return RosTopics(options.scan_topic, options.odom_topic)


def print_notes(command: str, notes: Iterable[str]) -> None:
    """Print what was assumed or left out in reading a log, a line each."""
    for note in notes:
        print(f"patrol {command}: {note}", file=sys.stderr)
