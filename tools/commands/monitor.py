"""``patrol monitor``: the operator's side, as a page and as a table in a terminal."""

from __future__ import annotations

import argparse
import sys
import time
from pathlib import Path

from maps.map_folder import load_map_folder
from robot_agent.config import find_map
from tools.monitor.monitor import Monitor, MonitorOptions, until
from tools.monitor.site import Site
from tools.monitor.text_view import show_team

POLL_S = 0.2


def configure(parser: argparse.ArgumentParser) -> None:
    """Declare the options."""
    parser.epilog = (
        "examples: patrol monitor --map paper_lab\n"
        "          patrol monitor --text --listen tcp/0.0.0.0:7447"
    )
    parser.add_argument(
        "--listen", default="tcp/0.0.0.0:7447", metavar="ENDPOINT", help="where robots report to"
    )
    parser.add_argument(
        "--http", default="127.0.0.1:8080", metavar="HOST:PORT", help="where the page is served"
    )
    parser.add_argument("--map", metavar="DIR", help="map folder or name, for the page")
    parser.add_argument("--border", default="border", metavar="NAME", help="border file of the map")
    parser.add_argument("--text", action="store_true", help="a table in the terminal, no page")
    parser.add_argument("--duration", type=float, metavar="S", help="end after S seconds")


def run(options: argparse.Namespace) -> int:
    """Show the team until interrupted."""
    site = chosen_site(options.map, options.border)
    http = None if options.text else options.http
    with Monitor(MonitorOptions(options.listen, http, site)) as monitor:
        going_on = until(options.duration)
        if options.text:
            show_team(monitor.watch, going_on)
            return 0
        print(f"patrol monitor: {monitor.url} (robots report to {options.listen})", file=sys.stderr)
        while going_on():
            time.sleep(POLL_S)
    return 0


def chosen_site(name: str | None, border: str) -> Site:
    """Return the place on a map, or one without a map."""
    if name is None:
        return Site(None)
    return Site(load_map_folder(find_map(name, Path.cwd()), border))
