"""Reads whole recordings once, beside their playback: all alarms, and a history of every robot."""

from __future__ import annotations

import threading
import time
from collections.abc import Sequence

from tools.monitor.history import PERIOD_S, SAMPLES_KEPT, HistorySample, RobotHistory
from tools.monitor.payload_stream import PayloadStream
from tools.monitor.recorded_payloads import RecordedPayloads
from tools.monitor.shift_log import ShiftLog
from tools.monitor.site import Site
from tools.monitor.team_state import TeamState
from tools.monitor.watch import Watch

_STEP_S = 0.5  # of the recordings' time: an alarm is right within this
_LONGEST_GAP_S = 30.0  # a longer time without any payload is skipped: every alarm is raised by then
_REST_S = 0.002  # after each step, for the page's own thread


class Survey:
    """A survey, on a thread of its own until it is done or closed."""

    def __init__(self, files: Sequence[RecordedPayloads], site: Site, log: ShiftLog) -> None:
        """Start; every alarm is put into the log."""
        self.done = False
        self.histories: dict[str, list[HistorySample]] = {}
        """Samples of each robot by its id, about an hour's number of them; once it is done."""
        self._stream = PayloadStream(files)
        duration = self._stream.end - self._stream.start
        self._period = max(PERIOD_S, duration / (SAMPLES_KEPT - 2))
        self._watch = Watch(TeamState(), site, on_alarm=log.put)
        self._ending = threading.Event()
        self._thread = threading.Thread(target=self._run, name="survey", daemon=True)
        self._thread.start()

    def close(self) -> None:
        """End it; idempotent."""
        self._ending.set()
        self._thread.join()

    def _run(self) -> None:
        histories: dict[str, RobotHistory] = {}
        t = self._stream.start
        while t < self._stream.end and not self._ending.is_set():
            t = self._next_t(t)
            self._stream.feed_newest(self._watch.team, t)
            self._watch.advance(t, t)
            for robot in self._watch.robots:
                history = histories.setdefault(robot.id, RobotHistory(self._period))
                history.sample(robot, t, t)
            time.sleep(_REST_S)
        self.histories = {robot: history.since(0) for robot, history in histories.items()}
        self.done = not self._ending.is_set()

    def _next_t(self, t: float) -> float:
        following = self._stream.next_t
        if following is not None and following - t > _LONGEST_GAP_S:
            return max(t + _STEP_S, following - _STEP_S) if self._told(t) else t + _STEP_S
        return min(t + _STEP_S, self._stream.end)

    def _told(self, t: float) -> bool:
        """Return whether nothing has been heard for so long that no more alarms come of it."""
        return all(robot.silence(t) > _LONGEST_GAP_S for robot in self._watch.robots)
