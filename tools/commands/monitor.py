"""``patrol monitor``: the operator's side, as a table in a terminal."""

from __future__ import annotations

import argparse

from tools.monitor.text_view import run_text_monitor


def configure(parser: argparse.ArgumentParser) -> None:
    """Declare the options."""
    parser.epilog = "example: patrol monitor --text --listen tcp/0.0.0.0:7447"
    parser.add_argument(
        "--text", action="store_true", required=True, help="a table in the terminal"
    )
    parser.add_argument("--listen", default="tcp/0.0.0.0:7447", metavar="ENDPOINT")
    parser.add_argument("--duration", type=float, metavar="S", help="end after S seconds")


def run(options: argparse.Namespace) -> int:
    """Show the team until interrupted."""
    run_text_monitor(options.listen, options.duration)
    return 0
