"""``patrol emulate``: one emulated robot for any client."""

from __future__ import annotations

import argparse
import signal
import sys
import threading
from contextlib import closing
from pathlib import Path

from maps.map_folder import load_map_folder
from robot_agent.config import find_map
from tools.commands.truth_option import add_truth_option, chosen_truth
from tools.number_range import whole
from tools.simulation.base_options import add_base_options, chosen_base
from tools.simulation.emulate import EmulateOptions, Emulation, parse_pose


def configure(parser: argparse.ArgumentParser) -> None:
    """Declare the options."""
    parser.epilog = (
        "example: patrol emulate --p2os tcp:8101 --lms200 pty --pose 4.0,3.7,90\n\n"
        "SPEC, chances from 0 to 1, times in s since the start, all of it optional:\n"
        "  drop=0.01,corrupt=0.001            per byte\n"
        "  duplicate=0.01,split=0.1           per piece of traffic\n"
        "  delay=0.05:0.2                     that share comes 0.2 s late\n"
        "  silence=5:8,cut=12:15,reset=20     from:to, from:to (the port goes away), at\n\n"
        "STATE, all of it optional:\n"
        "  baud=500000,variant=100:0.25       rate it is switched on at; degrees and step\n"
        "  streaming,address=0x81             left so by a client; the address of its replies\n"
        "  polluted,error=fatal:57            or info, warning, error and the listing's number\n"
        "  no-ack,slow                        no ACK; mode changes take 2.8 s, its EEPROM 6 s\n\n"
        "on a TCP port the laser has no rate until the client orders one or baud= gives it\n\n"
        "A client that is killed while its robot drives leaves it driving until the base's\n"
        "watchdog stops it, 2 s later. Its session stays open, and the next packet of any client\n"
        "resumes the motion, as on a real robot: also the SYNC0 with which ARIA connects again,\n"
        "up to its CLOSE."
    )
    add_truth_option(parser)
    parser.add_argument(
        "--model",
        dest="truth",
        metavar="SUBCLASS",
        help="the robot is of this make, e.g. p3dx-sh: --truth of that name",
    )
    add_base_options(parser)
    for name, device in (("p2os", "base"), ("lms200", "laser")):
        parser.add_argument(
            f"--{name}", default="pty", metavar="PLACE", help=f"{device}: pty or tcp:PORT"
        )
        parser.add_argument(
            f"--{name}-faults", default="", metavar="SPEC", help=f"faults of the {device}'s line"
        )
    parser.add_argument(
        "--lms200-start", default="", metavar="STATE", help="how the laser is found"
    )
    parser.add_argument(
        "--lms1xx", default="", metavar="PLACE", help="an LMS 111 instead of the LMS 200: tcp:PORT"
    )
    parser.add_argument(
        "--lms1xx-faults", default="", metavar="SPEC", help="faults of its connection"
    )
    parser.add_argument(
        "--camera", type=whole(0, 65535), metavar="PORT", help="serve its view as MJPEG there"
    )
    parser.add_argument("--map", default="paper_lab", metavar="DIR", help="map folder or name")
    parser.add_argument("--pose", metavar="X,Y,DEG", help="start; default a free place")
    parser.add_argument("--seed", type=whole(), default=1, metavar="N")


def run(options: argparse.Namespace) -> int:
    """Emulate until SIGINT or SIGTERM; print the URL of each device, one line each."""
    folder = load_map_folder(find_map(options.map, Path.cwd()))
    wanted = EmulateOptions(
        truth=chosen_truth(options),
        p2os=options.p2os,
        lms200=options.lms200,
        p2os_faults=options.p2os_faults,
        lms200_faults=options.lms200_faults,
        lms200_start=options.lms200_start,
        lms1xx=options.lms1xx,
        lms1xx_faults=options.lms1xx_faults,
        camera=options.camera,
        pose=None if options.pose is None else parse_pose(options.pose),
        base=chosen_base(options),
        seed=options.seed,
    )
    ended = threading.Event()
    with closing(Emulation(folder, wanted)) as emulation:
        for number in (signal.SIGINT, signal.SIGTERM):
            signal.signal(number, lambda *_: ended.set())
        for name, url in emulation.urls.items():
            print(name, url, flush=True)
        pose = emulation.rig.body.pose
        print(f"patrol emulate: robot at {pose.x:.2f}, {pose.y:.2f}; Ctrl-C ends", file=sys.stderr)
        emulation.run(lambda: not ended.is_set())
    return 0
