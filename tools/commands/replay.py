"""``patrol replay``: feed a recording's events to a new agent and compare its effects."""

from __future__ import annotations

import argparse
import sys
from pathlib import Path

import cv2

from maps.map_folder import load_map_folder
from robot_agent.config import find_map
from robot_agent.messages.events import LinkName
from robot_agent.recording.run_header import same_arithmetic
from tools.logs.recorded_config import changed_config
from tools.logs.recording import Recording, read_recording
from tools.number_range import not_negative
from tools.progress import progress_line
from tools.replay.recorded_devices import serve
from tools.replay.replay import Replay, notices, report_lines
from tools.replay.verdict import Verdict, verdict
from tools.replay.what_if import WhatIf

_EXIT_STATUS = {Verdict.IDENTICAL: 0, Verdict.DIFFERENT: 1, Verdict.EQUAL_IN_DECISIONS: 3}
"""Of ``--check``."""


def configure(parser: argparse.ArgumentParser) -> None:
    """Declare the options."""
    parser.epilog = """examples:
  patrol replay out/robot1.mcap --check
  patrol replay out/robot1.mcap --set gate.max_speed=0.2 --from 60 --until 120
  patrol replay out/robot1.mcap --serve --base tcp:8101
exit status of --check: 0 identical, 3 equal in decisions (on another computer), 1 different"""
    parser.add_argument("recording", type=Path, metavar="REC.mcap")
    parser.add_argument(
        "--check", action="store_true", help="compare every decision and byte with the recorded"
    )
    parser.add_argument(
        "--set",
        action="append",
        default=[],
        metavar="KEY=VALUE",
        help="change a setting and print what would have been decided differently, "
        "e.g. gate.max_speed=0.2",
    )
    parser.add_argument(
        "--from",
        dest="since",
        type=not_negative,
        default=0.0,
        metavar="T",
        help="report from T (s) on",
    )
    parser.add_argument("--until", type=not_negative, metavar="T", help="stop at agent time T (s)")
    parser.add_argument(
        "--serve", action="store_true", help="play the recorded devices to an external driver"
    )
    for link, name in (("base", "P2OS"), ("laser", "LMS200")):
        parser.add_argument(
            f"--{link}",
            default="pty",
            metavar="pty|tcp:PORT",
            help=f"with --serve: where a driver finds the {name} device",
        )
    parser.add_argument("--map", metavar="DIR", help="use this map in place of the recorded one")


def run(options: argparse.Namespace) -> int:
    """Replay one recording; print its contents and, with ``--check``, the comparison.

    Returns 1 when a comparison fails or is empty, 2 for contradicting options, 3 when it is equal
    in decisions only, else 0.
    """
    if options.check and (options.set or options.map):
        _print_messages(
            ["--check compares with the recorded settings and map: leave out --set and --map"]
        )
        return 2
    cv2.setNumThreads(1)
    recording = read_recording(options.recording)
    if options.serve:
        return _serve(recording, options)
    folder = load_map_folder(find_map(options.map, Path.cwd())) if options.map else None
    config = None
    if options.set:
        config = changed_config(recording.header.configuration, str(options.recording), options.set)
    replay = Replay(recording, folder, config)
    _print_messages(notices(replay, recording))
    changed = bool(options.set or options.map)
    by_decisions = options.check and not same_arithmetic(recording.header)
    what_if = WhatIf() if changed or by_decisions else None
    with progress_line("replay", options.until or recording.end(), "s") as progress:
        result = replay.run(
            options.until,
            progress,
            check=options.check,
            since=options.since,
            what_if=what_if,
            against=Replay(recording) if changed else None,
        )
    if recording.truncated:
        _print_messages([f"{recording.truncated}; what is whole was replayed"])
    for line in (*report_lines(result), *(what_if.lines() if what_if else ())):
        print(line)
    if not options.check:
        return 0
    found, words = verdict(result, what_if)
    print(words)
    return _EXIT_STATUS[found]


def _serve(recording: Recording, options: argparse.Namespace) -> int:
    """Play the devices' recorded bytes to their end, or until ``--until``; return 0."""
    until = options.until or recording.end()
    with progress_line("serve", until, "s") as progress:

        def going_on(t: float) -> bool:
            progress(t)
            return t <= until

        def announce(link: str, url: str) -> None:
            print(f"{link}: {url}", flush=True)

        places: dict[LinkName, str] = {"base": options.base, "laser": options.laser}
        devices = serve(recording, places, announce, going_on)
    for link, device in devices.items():
        print(f"{link}: {device.played} bytes played, {device.received} received")
    return 0


def _print_messages(lines: list[str]) -> None:
    for line in lines:
        print(f"patrol replay: {line}", file=sys.stderr)
