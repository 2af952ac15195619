"""Regression test of decisions: short runs, each compared with a stored list of decisions.

A list has one line per decision with the command in the base's integer units (mm/s, degrees/s), so
it does not depend on the machine's rounding. References are beside the tests; ``patrol regression
--update`` rewrites them and prints the changes.
"""

from __future__ import annotations

import gzip
import math
import os
import tempfile
import zlib
from collections.abc import Callable
from contextlib import closing
from dataclasses import dataclass
from itertools import zip_longest
from pathlib import Path

from maps.map_folder import load_map_folder
from maps.pose import Pose
from maps.whole_file import write_whole
from robot_agent.config import find_map
from robot_agent.messages.streams import DecisionPayload, decode
from tools.bench.bench_fault import parse_fault
from tools.bench.fleet import Fleet
from tools.bench.fleet_recorder import FleetRecorder
from tools.logs.carmen import read_carmen
from tools.logs.recording import read_recording
from tools.replay.carmen_recording import convert

REFERENCES = Path(__file__).resolve().parents[2] / "tests" / "tools" / "quality" / "regression"
SHOWN = 6
"""Most differing lines printed."""
RUN_S = 30.0
SCANS = 30


class RegressionError(ValueError):
    """A case cannot be run or compared; the message names case and remedy."""


@dataclass(frozen=True, slots=True)
class Case:
    """A short run: its name, and the function that makes its recordings in a folder."""

    name: str
    record: Callable[[Path], list[Path]]

    @property
    def reference(self) -> Path:
        """File of its reference decisions."""
        return REFERENCES / f"{self.name}.z"


def two_robots_meet(target: Path) -> list[Path]:
    """Record two emulated robots that meet on the paper's border; robot1's laser fails for 2 s."""
    folder = load_map_folder(find_map("paper_lab", Path()))
    with closing(FleetRecorder(folder, target)) as recorder:
        fleet = Fleet(
            *(folder, 2, 3),
            starts=[Pose(8.0, 3.76, 0.0), Pose(14.0, 3.76, math.pi)],
            observer=recorder.observe,
            faults=[parse_fault("robot1:blind@20-22")],
        )
        while fleet.t < RUN_S:
            fleet.step()
        fleet.shut_down()
    return recorder.paths


def real_log(target: Path) -> list[Path]:
    """Convert the first scans of the Intel log to a recording of device bytes.

    Raises RegressionError if the data are missing.
    """
    source = _data_folder() / "logs" / "intel-corrected.log.gz"
    if not source.is_file():
        raise RegressionError(f"real_log: {source} is not there: set PATROL_DATA to its folder")
    rows = gzip.decompress(source.read_bytes()).splitlines()
    ends = [number for number, row in enumerate(rows) if row.startswith(b"FLASER")]
    log = target / "intel.log"
    log.write_bytes(b"\n".join(rows[: ends[SCANS - 1] + 1]) + b"\n")
    recording = target / "intel.mcap"
    convert(read_carmen(log), load_map_folder(find_map("intel_lab", Path())), recording)
    return [recording]


def _data_folder() -> Path:
    beside = Path(__file__).resolve().parents[3] / "shared" / "data"
    return Path(os.environ.get("PATROL_DATA", beside))


CASES = (Case("two_robots_meet", two_robots_meet), Case("real_log", real_log))


def chosen_cases(names: list[str]) -> list[Case]:
    """Return the cases of these names, all for no names; raises RegressionError if unknown."""
    known = {case.name: case for case in CASES}
    for name in names:
        if name not in known:
            raise RegressionError(f"no case {name!r}; cases are {', '.join(known)}")
    return [known[name] for name in names] or list(CASES)


def decisions(case: Case) -> list[str]:
    """Run a case; return one line per decision."""
    with tempfile.TemporaryDirectory(prefix="patrol-regression-") as folder:
        return [line for path in case.record(Path(folder)) for line in _lines(path)]


def _lines(path: Path) -> list[str]:
    lines = []
    recording = read_recording(path)
    for _topic, t, data in recording.messages(("decision",)):
        decision = decode("decision", data)
        assert isinstance(decision, DecisionPayload)
        command = decision.command
        lines.append(
            f"{recording.header.robot} {t:.3f} {decision.action} {decision.direction:+d} "
            f"{decision.gate_reason or '-'} {round(1e3 * command.v)} mm/s "
            f"{round(math.degrees(command.w))} deg/s"
        )
    return lines


def read_reference(case: Case) -> list[str]:
    """Return the reference decisions, empty if there is no reference yet.

    Raises RegressionError if the file is damaged.
    """
    if not case.reference.is_file():
        return []
    try:
        return zlib.decompress(case.reference.read_bytes()).decode().splitlines()
    except zlib.error as error:
        raise RegressionError(
            f"{case.reference}: damaged ({error}); rewrite it by `patrol regression --update`"
        ) from error


def write_reference(case: Case, lines: list[str]) -> None:
    """Store these decisions as the reference."""
    write_whole(case.reference, zlib.compress("\n".join(lines).encode(), 9))


def difference(kept: list[str], now: list[str]) -> list[str]:
    """Return the differing decisions as lines of text; empty if there are none."""
    pairs = list(zip_longest(kept, now, fillvalue="(none)"))
    changed = [(a, b) for a, b in pairs if a != b]
    if not changed:
        return []
    lines = [f"{len(changed)} of {len(pairs)} decisions differ ({len(kept)} kept, {len(now)} now)"]
    for a, b in changed[:SHOWN]:
        lines += [f"  kept: {a}", f"  now:  {b}"]
    if len(changed) > SHOWN:
        lines.append(f"  and {len(changed) - SHOWN} more")
    return lines
