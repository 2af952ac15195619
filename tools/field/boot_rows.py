"""Rows: starts of the robot's computer."""

from __future__ import annotations

import math
import subprocess
import sys
from collections.abc import Sequence
from pathlib import Path

from tools.field.field_row import FieldRow, Outcome
from tools.field.field_stage import BOTH, PATROL_LIMIT_S, UNIT, FieldStage, drives
from tools.field.journal import starts
from tools.logs.recording import read_recording

LATE_S = 20.0
"""Time after the service's start at which late adapters are plugged in, s."""
PLUGGED_LIMIT_S = 30.0
"""Limit from the plugging in until the robot drives, s: devices set up, first pose."""
FILTER_LIMIT_S = PLUGGED_LIMIT_S + 15.0
"""The same where the agent has to end first, which it does after 10 s, and start again."""
DECISION_LIMIT_S = 5.0
"""Limit from the service's start to the first decision, s: the issue's for a slow computer."""
SLOW_SHARE = 0.2
"""Share of this machine's core down to which that limit holds: the issue's slow computer."""
_LOOP = "import time; t = time.{0}(); sum(i * i for i in range(10**6)); print(time.{0}() - t)"
DRIVERS = "/etc/modules-load.d/patrol.conf"


def _plugged_in(stage: FieldStage, outcome: Outcome) -> None:
    stage.boot()
    _drives_within(stage, outcome, PATROL_LIMIT_S)
    _first_decision(stage, outcome)


def _late(stage: FieldStage, outcome: Outcome) -> None:
    stage.boot(plugged=())
    _plug_late(stage, BOTH)
    _drives_within(stage, outcome, PLUGGED_LIMIT_S)
    outcome.require(starts(stage.journal()) == 1, "the service was started more than once")


def _late_driver(stage: FieldStage, outcome: Outcome) -> None:
    stage.boot(plugged=(), change=f"rm {DRIVERS}")
    loaded = stage.guest.run("lsmod")
    outcome.require("usbserial" not in loaded, "the driver was there before the adapters")
    _plug_late(stage, BOTH)
    _drives_within(stage, outcome, FILTER_LIMIT_S)
    outcome.note(f"{starts(stage.journal())} starts")
    stage.spoil()


def _swapped(stage: FieldStage, outcome: Outcome) -> None:
    stage.boot(plugged=("laser", "base"))
    _drives_within(stage, outcome, PATROL_LIMIT_S)
    _names(stage, outcome, "ttyUSB1", "ttyUSB0")


def _swapped_driving(stage: FieldStage, outcome: Outcome) -> None:
    stage.patrolling()
    before = _name(stage, "base")
    for name in BOTH:
        stage.machine.pull(getattr(stage.robot, name))
    stage.clock.sleep(5.0)
    for name in ("laser", "base") if before == "ttyUSB0" else BOTH:
        stage.clock.sleep(1.0)
        stage.machine.plug(getattr(stage.robot, name))
    _drives_within(stage, outcome, PLUGGED_LIMIT_S)
    outcome.require(_name(stage, "base") != before, f"the base is at {before} as before")


def _plug_late(stage: FieldStage, names: Sequence[str]) -> None:
    """Wait for the service, then plug adapters in."""
    stage.guest.run(f"until systemctl is-active -q {UNIT}; do sleep 1; done", PATROL_LIMIT_S)
    stage.clock.sleep(LATE_S)
    for name in names:
        stage.machine.plug(getattr(stage.robot, name))


def _drives_within(stage: FieldStage, outcome: Outcome, limit: float) -> None:
    outcome.within("drives after", stage.robot.wait(drives, limit), limit)
    outcome.require(stage.robot.contacts == 0, f"{stage.robot.contacts} contacts")
    if outcome.complaints:
        outcome.note(stage.last_words())


def _names(stage: FieldStage, outcome: Outcome, base: str, laser: str) -> None:
    found = (_name(stage, "base"), _name(stage, "laser"))
    outcome.note(f"base at {found[0]}, laser at {found[1]}")
    outcome.require(found == (base, laser), f"should be {base} and {laser}")


def _name(stage: FieldStage, role: str) -> str:
    return Path(stage.guest.run(f"readlink -f /dev/patrol/{role}").strip()).name


def _first_decision(stage: FieldStage, outcome: Outcome) -> None:
    """Note when the first decision was made, from the recording and systemd's account."""
    asked = f"systemctl show {UNIT} --value -p ExecMainStartTimestampMonotonic"
    started = float(stage.guest.run(asked)) / 1e6
    newest = stage.guest.run("ls -t /var/lib/patrol/*.mcap | head -1").strip()
    copy = stage.folder / "first-decision.mcap"
    copy.write_bytes(stage.guest.read(newest))
    decided = first_decision(copy)
    outcome.note(f"first decision {decided - started:.1f} s after the service's start")
    outcome.note(f"{decided:.1f} s after the kernel's")
    share = share_of_a_core(stage)
    outcome.note(f"with {share:.0%} of this machine's core")
    late = decided - started > DECISION_LIMIT_S
    outcome.require(not late or share < SLOW_SHARE, f"first decision: over {DECISION_LIMIT_S:g} s")


def share_of_a_core(stage: FieldStage) -> float:
    """Return how fast Python runs in the machine, as a share of what it does here unhindered."""
    there = float(stage.guest.run(f"python3 -c '{_LOOP.format('perf_counter')}'"))
    command = [sys.executable, "-c", _LOOP.format("process_time")]
    here = subprocess.run(command, capture_output=True, text=True, check=True, timeout=60)
    return float(here.stdout) / there


def first_decision(path: Path) -> float:
    """Return the time of a recording's first decision, s since its computer's start."""
    recording = read_recording(path)
    times = (t for _, t, _ in recording.messages(("decision",)))
    return recording.header.start_monotonic_ns / 1e9 + next(times, math.inf)


BOOT_ROWS = (
    FieldRow(
        "boot",
        "switched on with both adapters plugged in",
        f"drives, nobody helps; first decision in {DECISION_LIMIT_S:g} s, on a computer with "
        f"{SLOW_SHARE:.0%} of this machine's core or more",
        _plugged_in,
    ),
    FieldRow(
        "boot-late",
        f"both plugged in {LATE_S:.0f} s after the service's start",
        f"drives within {PLUGGED_LIMIT_S:.0f} s, no new start",
        _late,
    ),
    FieldRow(
        "boot-late-driver",
        "the same, and the adapters' driver is loaded only then",
        f"drives within {FILTER_LIMIT_S:.0f} s: a new start with a new filter",
        _late_driver,
    ),
    FieldRow(
        "boot-swapped",
        "switched on with the laser in the first socket: ttyUSB0 and ttyUSB1 exchanged",
        "the names follow the serial numbers, drives",
        _swapped,
    ),
    FieldRow(
        "swapped",
        "both pulled while it drives, plugged in in the other order",
        f"the names follow, drives within {PLUGGED_LIMIT_S:.0f} s",
        _swapped_driving,
    ),
)
