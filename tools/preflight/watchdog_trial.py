"""Whether the base stops by itself when nobody talks to it any more.

The only thing that stops a robot that is cut off. It can be seen only on turning wheels: they
turn slowly for a second, then the test falls silent and listens until the reports show them at
rest. The wheels must be off the ground.
"""

from __future__ import annotations

from collections.abc import Callable

from drivers.p2os.base_state import BaseState
from drivers.p2os.session import P2osSession, SessionState
from drivers.p2os.settings import BaseSettings
from drivers.requests import Request
from tools.preflight.device_trial import DeviceTrial, run_trials
from tools.preflight.finding import Finding, failed, ok

SPEED = 0.1  # m/s
TURNING_S = 1.0
LONGEST_WATCHDOG_S = 2.0
ADVISED_WATCHDOG_S = 1.2
"""With it a robot that is cut off at patrol speed stands within 2 s; 2 s are set in the factory."""
RAMP_S = 0.7
"""From that speed to rest, and a report's age."""
GIVE_UP_S = 5.0
"""Of silence; a base that still moves then has no watchdog: it is told to stand."""
LIMIT_S = 25.0
WARNING = (
    "This turns the wheels for about three seconds: lift the robot so that they are OFF THE GROUND"
)


class WatchdogTrial:
    """A session that drives slowly once it is ready, then keeps silent and listens."""

    def __init__(self, settings: BaseSettings) -> None:
        self.session = P2osSession(settings)
        self.over = False
        self.stopped_after: float | None = None
        """s from the last byte to the base until its report of rest."""
        self._moving_since: float | None = None
        self._last_sent: float | None = None
        self._silent = False
        self._t = 0.0

    @property
    def moved(self) -> bool:
        """Whether the wheels have turned at all."""
        return self._moving_since is not None

    def link_up(self, t: float) -> None:
        """The port is open."""
        self.session.link_up(t)

    def link_down(self, t: float) -> None:
        """The port is lost, which ends the test."""
        self.session.link_down(t)
        self.over = True

    def feed(self, data: bytes, t: float) -> list[BaseState]:
        """Take bytes of the base; drive, fall silent, or see that it stands."""
        states = self.session.feed(data, t)
        self._t = t
        for state in states:
            if self._silent:
                self._watch(t, state)
            else:
                self._drive(t, state)
        return states

    def tick(self, t: float) -> None:
        """Let the session go on, until the silence."""
        self._t = t
        if not self._silent:
            self.session.tick(t)
        elif self._last_sent is not None and t - self._last_sent > GIVE_UP_S:
            self.over = True

    def pop_requests(self) -> list[Request]:
        """Return what the session sends; nothing in the silence."""
        requests = self.session.pop_requests()
        if self._silent and not self.over:
            return []
        if requests:
            self._last_sent = self._t
        return requests

    def shut_down(self, t: float) -> None:
        """Stop the wheels, motors off, close the session."""
        self._silent, self.over = False, True
        self.session.shut_down(t)

    def _drive(self, t: float, state: BaseState) -> None:
        if self.session.state is not SessionState.READY or self.over:
            return
        self.session.enable_motors(t)
        self.session.drive(t, SPEED, 0.0)
        if abs(state.v) > SPEED / 2.0 and self._moving_since is None:
            self._moving_since = t
        self._silent = self._moving_since is not None and t - self._moving_since >= TURNING_S

    def _watch(self, t: float, state: BaseState) -> None:
        if state.standing and self._last_sent is not None:
            self.stopped_after = t - self._last_sent
            self.over = True


def try_watchdog(
    settings: BaseSettings, progress: Callable[[float], None] = lambda _: None
) -> Finding:
    """Turn the wheels, fall silent, and judge how the base takes it; about 10 s.

    The robot's wheels must be off the ground: the caller has made sure of that.
    """
    tested = WatchdogTrial(settings)
    trial = DeviceTrial(settings.url, settings.baud, tested, lambda _: tested.over)
    run_trials([trial], LIMIT_S, progress)
    if not tested.moved:
        why = trial.line.lost or tested.session.trouble or "the wheels did not turn"
        return failed("watchdog test", why, "run patrol doctor without --watchdog-test first")
    after = tested.stopped_after
    limit = LONGEST_WATCHDOG_S + RAMP_S
    if after is None:
        return failed(
            *("watchdog test", f"the wheels still turned after {GIVE_UP_S:g} s of silence"),
            "do not let this robot drive: set the controller's watchdog with its FLASH tool",
        )
    text = f"wheels at rest {after:.2f} s after the last command, at most {limit:g}"
    if after > limit:
        remedy = f"set the controller's watchdog to {ADVISED_WATCHDOG_S:g} s with its FLASH tool"
        return failed("watchdog test", text, remedy)
    return ok("watchdog test", text)
