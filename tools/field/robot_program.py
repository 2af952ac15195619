"""The emulated robot of a trial, a program of its own: it may have a slowed clock.

Serves base and laser on pseudo-terminals, prints their paths as one line of JSON, then a line ten
times a second: time, speeds, contacts so far.
"""

from __future__ import annotations

import json
import sys
import time
from pathlib import Path

from maps.map_folder import load_map_folder
from tools.simulation.base_options import BaseOptions
from tools.simulation.emulate import EmulateOptions, Emulation, parse_pose

PERIOD_S = 0.1


def main() -> None:
    """Run until the reader of the output is gone: ``MAP_FOLDER X,Y,DEG WATCHDOG_S``."""
    folder, pose, watchdog = sys.argv[1:]
    options = EmulateOptions(
        pose=parse_pose(pose), base=BaseOptions(watchdog=float(watchdog)), seed=1
    )
    emulation = Emulation(load_map_folder(Path(folder)), options)
    print(json.dumps(emulation.urls), flush=True)
    due = 0.0

    def tell() -> bool:
        nonlocal due
        now = time.monotonic()
        if now >= due:
            due = now + PERIOD_S
            v, w = emulation.rig.base.velocity
            print(json.dumps((now, v, w, emulation.rig.world.contacts)), flush=True)
        return True

    emulation.run(tell)


if __name__ == "__main__":
    main()
