"""Measures the base's watchdog: the time it takes to stop by itself when commands cease.

Only the watchdog stops a disconnected robot. The wheels turn slowly for a second, then the test
sends nothing until the reports show them at rest. The wheels must be off the ground.
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
"""With it a robot disconnected at patrol speed stands within 2 s; the factory sets 2 s."""
RAMP_S = 0.7
"""Time from SPEED to rest, and a report's age."""
GIVE_UP_S = 5.0
"""Time without commands after which a moving base has no watchdog, and is commanded to stop."""
LIMIT_S = 25.0
WARNING = (
    "This turns the wheels for about three seconds: lift the robot so that they are OFF THE GROUND"
)


class WatchdogTrial:
    """A base session that drives slowly once it is ready, then sends nothing and measures."""

    def __init__(self, settings: BaseSettings) -> None:
        self.session = P2osSession(settings)
        self.over = False
        self.stopped_after: float | None = None
        """Time from the last byte sent to the report of rest, s; None: not at rest yet."""
        self._moving_since: float | None = None
        self._last_sent: float | None = None
        self._silent = False
        self._t = 0.0

    @property
    def moved(self) -> bool:
        """Whether the wheels have turned."""
        return self._moving_since is not None

    def link_up(self, t: float) -> None:
        """Start the session."""
        self.session.link_up(t)

    def link_down(self, t: float) -> None:
        """End the test: the port is lost."""
        self.session.link_down(t)
        self.over = True

    def feed(self, data: bytes, t: float) -> list[BaseState]:
        """Decode bytes; drive, stop sending, or detect rest."""
        states = self.session.feed(data, t)
        self._t = t
        for state in states:
            if self._silent:
                self._watch(t, state)
            else:
                self._drive(t, state)
        return states

    def tick(self, t: float) -> None:
        """Tick the session while sending; end the test GIVE_UP_S after the last command."""
        self._t = t
        if not self._silent:
            self.session.tick(t)
        elif self._last_sent is not None and t - self._last_sent > GIVE_UP_S:
            self.over = True

    def pop_requests(self) -> list[Request]:
        """Return the session's requests; none while measuring."""
        requests = self.session.pop_requests()
        if self._silent and not self.over:
            return []
        if requests:
            self._last_sent = self._t
        return requests

    def shut_down(self, t: float) -> None:
        """Stop the wheels, switch the motors off, close the session."""
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
    """Turn the wheels, stop sending, and check the base's time to rest; takes about 10 s.

    The caller must have made sure that the wheels are off the ground.
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
