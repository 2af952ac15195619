"""Emulated devices that play back a CARMEN log: odometry and scans as real device bytes.

The base's odometer is set from the log, and the agent's drive commands have no effect. Everything
else is live: handshakes, configuration, timing.
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
from drivers.p2os.emulator.make import PIONEER_2DX
from maps.pose import Pose, wrap_angle
from tools.logs.carmen import CarmenLog, CarmenScan
from tools.simulation.lockstep import LockstepAgent

LEAD_IN_S = 10.0
"""Time before the log's first moment for both devices' handshakes, s."""
SIP_PERIOD_S = 0.1
MIN_STEP_S = 0.01
"""Odometry sooner than this before the next is left out, s: the line is too slow for it."""
BASE_BAUD = 38400
LASER_BAUD = 500000
"""Rate fast enough for scans that loggers stamped within hundredths of a second, baud."""
LEAD_OUT_S = 1.0


@dataclass(frozen=True, eq=False)
class Moment:
    """One time of the log, with its odometry and, if there is one, its scan."""

    t: float
    """Agent time."""
    odometry: Pose
    scan: CarmenScan | None


def moments(log: CarmenLog) -> list[Moment]:
    """Return the log's odometry and scans in agent time, with interpolated reports in gaps.

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
    """Return report times strictly between two times, at intervals of SIP_PERIOD_S."""
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
    """The emulated base and laser of a log's robot."""

    def __init__(self, name: str = "log") -> None:
        """Power on both devices; neither sends reports by itself."""
        self.base = P2osEmulator(PIONEER_2DX, baud=BASE_BAUD, name=name, sip_period=None)
        self.laser = Lms200Emulator(scan_source=None)

    def play_moment(self, moment: Moment) -> None:
        """Set a moment's odometry, send a report of it, and send its scan."""
        self.base.advance(moment.t)
        self.base.set_odometry(*moment.odometry)
        self.base.emit_sip(moment.t)
        self.laser.advance(moment.t)
        if moment.scan is not None:
            self.laser.send_scan(padded_ranges(moment.scan), moment.t)


def padded_ranges(scan: CarmenScan) -> NDArray[np.float64]:
    """Return the ranges with the beam that loggers leave out: an LMS sends 181 or 361 values."""
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
    """Run the agent through a whole log; return the duration in agent time, s.

    ``on_scan`` is called for each scan before its bytes are sent.
    """
    lockstep.start(0.0)
    for moment in moments(log):
        lockstep.deliver(moment.t)
        if moment.scan is not None:
            on_scan(moment)
        rig.play_moment(moment)
        progress(moment.t)
    end = moment.t + LEAD_OUT_S
    lockstep.deliver(end)
    lockstep.shut_down(end)
    return end
