"""Emulated devices that relive a CARMEN log: its odometry and scans leave as real device bytes.

The robot of the log was not driven by us, so the base's odometer is imposed and what the agent
asks of the wheels changes nothing. Everything else is live: handshakes, configuration, pacing.
"""

from __future__ import annotations

import math
from collections.abc import Callable, Iterator
from dataclasses import dataclass
from itertools import pairwise

import numpy as np
from numpy.typing import NDArray

from drivers.lms200.emulator.emulator import Lms200Emulator
from drivers.p2os.emulator.emulator import P2osEmulator
from drivers.p2os.model import load_model
from maps.pose import Pose, wrap_angle
from tools.logs.carmen import CarmenLog, CarmenScan
from tools.simulation.lockstep import LockstepAgent

LEAD_IN_S = 10.0
"""Time before the log's first moment, for both devices' handshakes."""
SIP_PERIOD_S = 0.1
MIN_STEP_S = 0.01
"""Odometry closer than this to the next is left out: the line could not carry it in time."""
BASE_BAUD = 38400
LASER_BAUD = 500000
"""Fast enough for the few scans that loggers stamped within hundredths of a second."""
LEAD_OUT_S = 1.0


@dataclass(frozen=True, eq=False)
class Moment:
    """Something the robot of the log did: its odometer stood there, perhaps a scan was taken."""

    t: float
    """Agent time, s."""
    odometry: Pose
    scan: CarmenScan | None


def moments(log: CarmenLog) -> list[Moment]:
    """Return the log's odometry and scans on the agent's clock, with reports in the gaps.

    A base reports every 100 ms: where the log has nothing for longer, its odometry is interpolated.
    """
    start = log.odometry[0][0] - LEAD_IN_S
    scans = {scan.t: scan for scan in log.scans}
    found = [Moment(t - start, odometry, scans.pop(t, None)) for t, odometry in log.odometry]
    assert not scans, "every scan has an odometry knot at its time"
    first, last = found[0], found[-1]
    lead_in = [Moment(t, first.odometry, None) for t in _times(0.0, first.t)]
    lead_out = [Moment(t, last.odometry, None) for t in _times(last.t, last.t + LEAD_OUT_S)]
    return [*lead_in, *_without_gaps(found), *lead_out]


def _times(after: float, before: float) -> list[float]:
    """Return report times strictly between two times, SIP_PERIOD_S apart."""
    times: list[float] = np.arange(
        after + SIP_PERIOD_S, before - 0.5 * SIP_PERIOD_S, SIP_PERIOD_S
    ).tolist()
    return times


def _without_gaps(found: list[Moment]) -> Iterator[Moment]:
    yield found[0]
    for a, b in pairwise(found):
        turn = math.remainder(b.odometry.theta - a.odometry.theta, math.tau)
        for t in _times(a.t, b.t):
            share = (t - a.t) / (b.t - a.t)
            yield Moment(
                t,
                Pose(
                    a.odometry.x + share * (b.odometry.x - a.odometry.x),
                    a.odometry.y + share * (b.odometry.y - a.odometry.y),
                    wrap_angle(a.odometry.theta + share * turn),
                ),
                None,
            )
        yield b


class LogRig:
    """The two emulated devices of a log's robot."""

    def __init__(self, name: str = "log") -> None:
        """Power both devices; neither reports by itself."""
        self.base = P2osEmulator(load_model("p2dx"), baud=BASE_BAUD, name=name, sip_period=None)
        self.laser = Lms200Emulator(scan_source=None)

    def relive(self, moment: Moment) -> None:
        """Impose a moment's odometry, report it, and send its scan."""
        self.base.advance(moment.t)
        self.base.set_odometry(*moment.odometry)
        self.base.emit_sip(moment.t)
        self.laser.advance(moment.t)
        if moment.scan is not None:
            self.laser.send_scan(padded_ranges(moment.scan), moment.t)


def padded_ranges(scan: CarmenScan) -> NDArray[np.float64]:
    """Return the ranges with the beam a logger left out: an LMS sends 181 or 361 values."""
    if scan.ranges.size % 2:
        return scan.ranges
    return np.append(scan.ranges, np.inf)


def play(
    log: CarmenLog,
    rig: LogRig,
    lockstep: LockstepAgent,
    on_scan: Callable[[Moment], None],
    progress: Callable[[float], None],
) -> float:
    """Run the agent through a whole log; return the time it took on the agent's clock, s.

    ``on_scan`` is told of each scan before its bytes come.
    """
    lockstep.start(0.0)
    for moment in moments(log):
        lockstep.deliver(moment.t)
        if moment.scan is not None:
            on_scan(moment)
        rig.relive(moment)
        progress(moment.t)
    end = moment.t + LEAD_OUT_S
    lockstep.deliver(end)
    lockstep.shut_down(end)
    return end
