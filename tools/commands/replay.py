"""``patrol replay``: feed a recording to the agent again, and compare."""

from __future__ import annotations

import argparse
import sys
from pathlib import Path

import cv2

from maps.map_folder import load_map_folder
from robot_agent.config import find_map
from tools.progress import Progress
from tools.recording import read_recording
from tools.replay import Replay, report_lines


def configure(parser: argparse.ArgumentParser) -> None:
    """Declare the options."""
    parser.epilog = "example: patrol replay out/robot1.mcap --check"
    parser.add_argument("recording", type=Path, metavar="REC.mcap")
    parser.add_argument(
        "--check", action="store_true", help="compare every decision and byte with the recorded"
    )
    parser.add_argument("--until", type=float, metavar="T", help="stop at agent time T (s)")
    parser.add_argument("--map", metavar="DIR", help="use this map in place of the recorded one")


def run(options: argparse.Namespace) -> int:
    """Replay one recording; print what it held, and with --check whether all was identical."""
    cv2.setNumThreads(1)
    recording = read_recording(options.recording)
    folder = load_map_folder(find_map(options.map, Path.cwd())) if options.map else None
    replay = Replay(recording, folder)
    with Progress("replay", options.until, "s") as progress:
        result = replay.run(options.until, progress, check=options.check)
    if recording.truncated:
        print(f"patrol replay: {recording.truncated}; what is whole was replayed", file=sys.stderr)
    for line in report_lines(result):
        print(line)
    if not options.check:
        return 0
    if result.events == 0:
        print("nothing to compare: the recording holds no event")
        return 1
    if result.difference is not None:
        print(result.difference)
        return 1
    counts = f"{result.events} events, {result.decisions} decisions, {result.bytes_sent} bytes"
    print(f"identical: {counts}")
    return 0
