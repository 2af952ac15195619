"""The turn logs of many robots, with the number of turns of each as an array."""

from __future__ import annotations

from collections.abc import Iterator, Sequence
from copy import deepcopy

import numpy as np

from robot_agent.patrol.turn_log import Turn, TurnLog
from tools.batch.arrays import Indices


class TurnLogs(Sequence[TurnLog]):
    """One ``TurnLog`` per robot; turns are rare, so each is kept as the agent keeps it."""

    def __init__(self, n: int) -> None:
        self._logs = [TurnLog() for _ in range(n)]
        self.times = np.zeros(n, dtype=np.intp)
        """Turns of each robot so far."""

    def add(self, robot: int, turn: Turn) -> None:
        """Append a turn of a robot."""
        self._logs[robot].add(turn)
        self.times[robot] += 1

    def pick(self, robots: Indices) -> None:
        """Keep some robots, as ``arrays.pick`` does."""
        self._logs = [deepcopy(self._logs[robot]) for robot in robots.tolist()]
        self.times = self.times[robots]

    def __len__(self) -> int:
        return len(self._logs)

    def __iter__(self) -> Iterator[TurnLog]:
        return iter(self._logs)

    def __getitem__(self, robot: int) -> TurnLog:  # type: ignore[override]
        return self._logs[robot]
