"""``patrol monitor``: the operator's view of the team, as a web page or as a terminal table."""

from __future__ import annotations

import argparse
import sys
import time
from collections.abc import Callable
from contextlib import closing
from pathlib import Path

from robot_agent.config import find_map
from robot_agent.recording.run_files import refuse_existing
from tools.monitor.monitor import Monitor, MonitorOptions, PeriodicCall, until, while_sound
from tools.monitor.playback import Playback
from tools.monitor.playback_page import playback_page
from tools.monitor.site import Site, load_site
from tools.monitor.team_state import TeamState
from tools.monitor.text_view import show_team
from tools.monitor.watch import Watch
from tools.number_range import positive
from tools.output_path import output_file

POLL_S = 0.2
LOG_FILE = "shift_log.sqlite"


def configure(parser: argparse.ArgumentParser) -> None:
    """Declare the options."""
    parser.epilog = (
        "examples: patrol monitor --map paper_lab\n"
        "          patrol monitor --text --listen tcp/0.0.0.0:7447\n"
        "          patrol monitor --play robot1.mcap robot2.mcap"
    )
    parser.add_argument(
        "--listen", default="tcp/0.0.0.0:7447", metavar="ENDPOINT", help="where robots connect to"
    )
    parser.add_argument(
        "--keys", type=Path, metavar="DIR", help="the operator's keys, for a tls/ endpoint"
    )
    parser.add_argument(
        "--http", default="127.0.0.1:8080", metavar="HOST:PORT", help="where the page is served"
    )
    parser.add_argument("--map", metavar="DIR", help="map folder or name, for the page")
    parser.add_argument("--border", default="border", metavar="NAME", help="border file of the map")
    parser.add_argument("--text", action="store_true", help="the team in the terminal, no page")
    parser.add_argument(
        "--robot", metavar="NAME", help="with --text: whose details are shown at first"
    )
    parser.add_argument(
        "--record", type=output_file, metavar="OUT.mcap", help="record every payload received"
    )
    parser.add_argument(
        "--log",
        type=output_file,
        metavar="FILE.sqlite",
        help=f"keep the shift log in a file; with --record the default is {LOG_FILE} beside it",
    )
    parser.add_argument(
        "--forward", metavar="ENDPOINT", help="head office's monitor that gets every payload too"
    )
    parser.add_argument(
        "--forward-keys",
        type=Path,
        metavar="DIR",
        help="this site's keys from the office, for a tls/ endpoint of --forward",
    )
    parser.add_argument(
        "--foxglove", metavar="HOST:PORT", help="serve Foxglove viewers (needs foxglove-sdk)"
    )
    parser.add_argument(
        "--play",
        type=Path,
        nargs="+",
        metavar="REC.mcap",
        help="show recordings of agents or of a monitor instead, in step",
    )
    parser.add_argument("--duration", type=positive, metavar="S", help="end after S seconds")


def run(options: argparse.Namespace) -> int:
    """Show the team until interrupted."""
    going_on = until(options.duration)
    if options.play:
        return play(options, going_on)
    if options.record is not None:
        refuse_existing(options.record)
    site = chosen_site(options.map, options.border)
    http = None if options.text else options.http
    chosen = MonitorOptions(
        options.listen,
        http,
        site,
        record=options.record,
        log=log_file(options.log, options.record),
        border=options.border,
        keys=options.keys,
        forward=options.forward,
        forward_keys=options.forward_keys,
        foxglove=options.foxglove,
    )
    with closing(Monitor(chosen)) as monitor:
        going_on = while_sound(going_on, monitor.check)
        if options.text:
            show_team(monitor.watch, going_on, robot=options.robot)
            return 0
        print(f"patrol monitor: {monitor.url} (robots report to {options.listen})", file=sys.stderr)
        while going_on():
            time.sleep(POLL_S)
    return 0


def log_file(named: Path | None, record: Path | None) -> Path | None:
    """Return the shift log's file: as named, else beside the recording; None without either."""
    return named if named is not None or record is None else record.with_name(LOG_FILE)


def play(options: argparse.Namespace, going_on: Callable[[], bool]) -> int:
    """Play recordings until interrupted or ``going_on`` returns False; return 0.

    Raises RecordingError for a file that is no recording, WebError for a bad ``--http`` address.
    """
    playback = Playback(options.play)
    chosen = chosen_site(options.map, options.border)
    site = chosen if chosen.folder else playback.site()
    if options.text:
        watch = Watch(TeamState(), site)
        with closing(PeriodicCall(lambda: playback.advance(watch))) as caller:
            show_team(watch, while_sound(going_on, caller.check), robot=options.robot)
        return 0
    with playback_page(playback, site, options.http) as server:
        print(f"patrol monitor: {server.link} plays {len(options.play)} files", file=sys.stderr)
        going_on = while_sound(going_on, server.check)
        while going_on():
            time.sleep(POLL_S)
    return 0


def chosen_site(name: str | None, border: str) -> Site:
    """Return the site of a map folder's name or path; a site without map for None."""
    if name is None:
        return Site(None)
    return load_site(find_map(name, Path.cwd()), border)
