"""Preflight of the laser: session, identity, health, scan rate against the line's."""

from __future__ import annotations

import math
from collections.abc import Sequence

from drivers.lms200.health import health_of
from drivers.lms200.measurement import TURN
from drivers.lms200.session import Lms200Session, SessionState
from drivers.lms200.settings import LaserSettings as Lms200Settings
from drivers.scan import Scan
from drivers.scanner import ScannerHealth, ScannerSettings, scanner_session
from tools.preflight.device_trial import DeviceTrial
from tools.preflight.doctor_port import describe_line, examine_line, examine_opening, examine_port
from tools.preflight.finding import Finding, failed, ok, warning

LISTENING_S = 1.0
MIN_SHARE = 0.8  # of the scan rate the line can carry
SLOW_S = 10.0
"""A laser that took longer until its first scan is called slow; usual are 1 to 4 s."""
MIN_RETURNS = 0.1  # share of a scan's beams; fewer: covered, or nothing in range

_WRITING = (SessionState.SETTING_VARIANT, SessionState.WRITING_CONFIGURATION)
_DOWN = "down"  # state of a session before its line is open
_BITS_PER_BYTE = 10
_SCAN_OVERHEAD = 10  # bytes of a scan's telegram besides its values

_LINE_REMEDY = "switch the laser off and on: it then listens at 9600 baud; check its cable"
_SILENT_LINE_REMEDY = (
    "switch the laser on (it needs up to a minute) and check its cable; if it is on, switch it off "
    "and on: it then listens at 9600 baud"
)
_NETWORK_REMEDY = (
    "check that laser.url is the address and port (2111 or 2112) of the scanner; switch it off and "
    "on, and wait half a minute"
)


class LaserExamination:
    """The laser's part of a preflight: run ``trial`` unless it is None, then read ``findings``."""

    def __init__(self, settings: ScannerSettings) -> None:
        self._settings = settings
        self._session = scanner_session(settings)
        self._state = self._session.state
        self._port = examine_port("laser port", settings.url)
        self.trial: DeviceTrial[Scan] | None = None
        if not self._port.remedy:
            self.trial = DeviceTrial(
                settings.url, settings.baud, self._session, self._enough, self._answers
            )

    def _enough(self, scans: Sequence[tuple[float, Scan]]) -> bool:
        """Return whether scans were received for LISTENING_S."""
        self._state = self._session.state
        return len(scans) > 2 and scans[-1][0] - scans[0][0] >= LISTENING_S

    def _answers(self) -> bool:
        """Return whether an LMS 200 answers, if slowly."""
        return isinstance(self._session, Lms200Session) and self._session.answers

    def findings(self) -> list[Finding]:
        """Return the findings; call it after the trial."""
        if self.trial is None:
            return [self._port]
        not_open = examine_opening("laser port", self.trial.line)
        if not_open is not None:
            return [not_open]
        if not self.trial.measurements:
            return [self._port, self._no_stream()]
        last = self.trial.measurements[-1][1]
        health = self._session.health or health_of(last.status, (), defective=False)
        return [
            self._port,
            self._identity(),
            examine_health(health),
            self._scans(last),
            self._line(),
        ]

    def _no_stream(self) -> Finding:
        assert self.trial is not None
        line = self.trial.line
        if self._session.framer.counters.good and self._session.trouble:
            return failed(
                "laser",
                f"no scans: {self._session.trouble}",
                "switch the laser off and on; if that does not help, have it mended",
            )
        if self._state in _WRITING:
            return failed(
                "laser",
                f"no scans: it is slow and may still be writing its memory, at «{self._state}»",
                "leave it switched on for a minute, then run doctor again",
            )
        where = "" if self._state == _DOWN else f", stuck at «{self._state}»"
        remedy = _NETWORK_REMEDY
        if isinstance(self._settings, Lms200Settings):
            remedy = _LINE_REMEDY if line.bytes_received else _SILENT_LINE_REMEDY
        return failed("laser", f"no scans{where}: {describe_line(line)}", remedy)

    def _identity(self) -> Finding:
        text = f"{self._session.identity}, {self._session.manner}"
        if self._session.trouble:
            return warning("laser", f"{text}; {self._session.trouble}", "see the laser's manual")
        took = self._setting_up()
        return ok("laser", text if took < SLOW_S else f"{text}; slow: set up in {took:.0f} s")

    def _setting_up(self) -> float:
        """Return the time from opening the port to the first scan, s."""
        assert self.trial is not None
        return self.trial.measurements[0][0] - self.trial.line.opened_at

    def _scans(self, last: Scan) -> Finding:
        assert self.trial is not None
        times = [t for t, _ in self.trial.measurements]
        rate = (len(times) - 1) / max(times[-1] - times[0], last.turn_time)
        best = self._best_rate(last)
        step = math.degrees(last.angle_increment)
        seen = sum(map(math.isfinite, last.ranges.tolist())) / last.ranges.size
        text = (
            f"{rate:.1f} scans/s of {last.ranges.size} beams every {step:.2g} deg "
            f"({best:.1f} possible), {100 * seen:.0f} % of the beams return"
        )
        if rate < MIN_SHARE * best:
            return warning(
                "laser scans", text, "see the counters of its line; ease the computer's load"
            )
        if seen < MIN_RETURNS:
            return failed(
                "laser scans", text, "take the cover off; turn the robot to see its walls"
            )
        return ok("laser scans", text)

    def _best_rate(self, last: Scan) -> float:
        """Return the scan rate, 1/s, that line and settings allow."""
        wanted = 1.0 / max(last.turn_time, self._settings.scan_period)
        if isinstance(self._session, Lms200Session):
            return min(best_rate(last.ranges.size, last.turns, self._session.baud), wanted)
        return wanted

    def _line(self) -> Finding:
        assert self.trial is not None
        counters = self._session.framer.counters
        return examine_line("laser line", "telegrams", counters, self.trial.line)


def best_rate(beams: int, turns: int, baud: int) -> float:
    """Return the scan rate, 1/s, that an LMS 200's line can carry.

    Whole sweeps, one telegram at a time. turns: of the mirror per scan.
    """
    wire_time = (_SCAN_OVERHEAD + 2 * beams) * _BITS_PER_BYTE / baud
    sweep = turns * TURN
    return 1.0 / (sweep * max(1, math.ceil(wire_time / sweep - 1e-6)))


def examine_health(health: ScannerHealth) -> Finding:
    """Check the laser's status report."""
    if health.ok:
        return ok("laser status", "ok, no errors present, window clean")
    if health.pollution:
        remedy = "wipe the front window with a soft, damp cloth"
    else:
        remedy = "switch the laser off and on; if the error stays, have it mended"
    return failed("laser status", health.text, remedy)
