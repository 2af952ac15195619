"""The emulated robot of a trial: what its wheels did, second by second."""

from __future__ import annotations

import json
import subprocess
import threading
from collections.abc import Callable, Sequence
from dataclasses import dataclass
from pathlib import Path

from tools.deploy.child_program import environment, program
from tools.field.acceleration import Acceleration, TrialClock, clean_up
from tools.field.trial_error import TrialError
from tools.field.virtual_machine import Adapter
from tools.preflight.watchdog_trial import ADVISED_WATCHDOG_S

BASE_SERIAL, LASER_SERIAL = "TRIALB1", "TRIALL1"
"""Serial numbers of the adapters of base and laser."""
DRIVING_SPEED = 0.1
"""A robot is driving above it, m/s."""
STANDING_SPEED = 0.005
"""A robot stands below it, m/s and rad/s."""
STEADY_S = 1.0
"""Time for which it must have been driving or standing, s."""
_POLL_S = 0.2


@dataclass(frozen=True, slots=True)
class Moment:
    """What the robot did at ``t`` (s of its clock): forward speed, m/s, turn rate, rad/s."""

    t: float
    v: float
    w: float
    contacts: int

    @property
    def drives(self) -> bool:
        """Whether it moves forward."""
        return self.v > DRIVING_SPEED

    @property
    def stands(self) -> bool:
        """Whether its wheels are at rest."""
        return abs(self.v) < STANDING_SPEED and abs(self.w) < STANDING_SPEED


class EmulatedRobot:
    """A base and a laser at two adapters, in a process of their own."""

    def __init__(self, acceleration: Acceleration, map_folder: Path, pose: str) -> None:
        """Switch it on; pose: true start, ``X,Y,DEG``. Raises TrialError if that fails."""
        self._clock = TrialClock(acceleration.rate)
        command = program(
            "tools.field.robot_program", str(map_folder), pose, f"{ADVISED_WATCHDOG_S}"
        )
        self._process = subprocess.Popen(
            [*acceleration.prefix(), *command],
            env=environment(),
            stdin=subprocess.DEVNULL,
            stdout=subprocess.PIPE,
            text=True,
        )
        assert self._process.stdout is not None
        ports, first = (self._process.stdout.readline() for _ in range(2))
        if not first:
            raise TrialError("the emulated robot did not start, see above")
        urls = json.loads(ports)
        self.base = Adapter("base", BASE_SERIAL, urls["p2os"])
        self.laser = Adapter("laser", LASER_SERIAL, urls["lms200"])
        self._trace = [Moment(*json.loads(first))]
        self._reader = threading.Thread(target=self._read, daemon=True)
        self._reader.start()

    def close(self) -> None:
        """Switch it off."""
        self._process.kill()
        self._process.wait()
        clean_up(self._process.pid)
        self._reader.join()
        assert self._process.stdout is not None
        self._process.stdout.close()

    @property
    def trace(self) -> list[Moment]:
        """All moments so far, ten a second."""
        return list(self._trace)

    @property
    def now(self) -> float:
        """The time of its last moment, s."""
        return self._trace[-1].t

    @property
    def contacts(self) -> int:
        """How many times it has touched anything."""
        return self._trace[-1].contacts

    def wait(
        self, state: Callable[[Moment], bool], limit: float, since: float | None = None
    ) -> float | None:
        """Wait until a state has lasted for STEADY_S; return its begin, s after ``since``.

        since: a time of ``now``, None for the present. Returns None if the state did not begin
        within ``limit`` s.
        """
        begun = self.now if since is None else since
        while True:
            entered = state_since(self.trace, begun, state)
            if entered is not None:
                return entered - begun
            if self.now - begun > limit + STEADY_S or self._process.poll() is not None:
                return None
            self._clock.sleep(_POLL_S)

    def _read(self) -> None:
        assert self._process.stdout is not None
        for line in self._process.stdout:
            self._trace.append(Moment(*json.loads(line)))


def state_since(
    trace: Sequence[Moment], begun: float, state: Callable[[Moment], bool]
) -> float | None:
    """Return the begin, not before ``begun``, of the first STEADY_S in a state; None if none."""
    since = None
    for moment in trace:
        if moment.t < begun or not state(moment):
            since = None
        elif since is None:
            since = moment.t
        if since is not None and moment.t - since >= STEADY_S:
            return since
    return None
