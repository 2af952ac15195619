"""Preflight of the robot base: session, limits, watchdog, battery, contacts. Motors stay off."""

from __future__ import annotations

import math
from collections.abc import Sequence

from drivers.p2os.base_state import BaseState
from drivers.p2os.model import RobotModel
from drivers.p2os.session import P2osSession, SessionState
from drivers.p2os.settings import BaseSettings
from drivers.scanner import DEFAULT_KIND
from tools.preflight.device_trial import DeviceTrial
from tools.preflight.doctor_port import describe_line, examine_line, examine_opening, examine_port
from tools.preflight.finding import Finding, failed, ok, skipped, warning
from tools.preflight.watchdog_trial import ADVISED_WATCHDOG_S

BATTERY_LOW = 11.75  # V, of one of 12 V
BATTERY_EMPTY = 11.0  # V, likewise; near it the controller shuts down
DRIVEN_LASERS = {"lms2xx": "lms200", "lms1xx": "lms1xx", "lms500": "lms1xx", "tim5xx": "lms1xx"}
"""The kind of driver for each type of laser in the vendor's files."""
LISTENING_S = 1.0  # with the session open
WATCHDOG_LIMIT_MS = 2000  # a robot cut off must stop within this


class BaseExamination:
    """The base's part of a preflight: run ``trial`` unless it is None, then read ``findings``."""

    def __init__(self, settings: BaseSettings, scanner: str = DEFAULT_KIND) -> None:
        """scanner: the configured kind of laser."""
        self._settings = settings
        self._scanner = scanner
        self._session = P2osSession(settings)
        self._reached = SessionState.DOWN
        self._trouble: str | None = None
        self._port = examine_port("base port", settings.url)
        self.trial: DeviceTrial[BaseState] | None = None
        if not self._port.remedy:
            self.trial = DeviceTrial(settings.url, settings.baud, self._session, self._enough)

    @property
    def model(self) -> RobotModel:
        """The model that the base has reported; before that the expected one."""
        return self._session.model

    def _enough(self, states: Sequence[tuple[float, BaseState]]) -> bool:
        """Return whether reports were received for LISTENING_S in state READY, or of a robot that
        has no model and so never gets there."""
        ready = self._session.state is SessionState.READY
        if ready:
            self._reached = SessionState.READY
            self._trouble = self._session.trouble
        if ready or self._session.model_trouble is not None:
            return bool(states) and states[-1][0] - self._session.state_since >= LISTENING_S
        return False

    def findings(self) -> list[Finding]:
        """Return the findings; call it after the trial."""
        if self.trial is None:
            return [self._port]
        not_open = examine_opening("base port", self.trial.line)
        if not_open is not None:
            return [not_open]
        states = [state for _, state in self.trial.measurements]
        if self._session.model_trouble is not None and states:
            return [self._port, self._identity()]
        if self._reached is not SessionState.READY or not states:
            return [self._port, self._no_session()]
        return [
            self._port,
            self._identity(),
            examine_laser_type(self._session.model, self._scanner),
            self._line(),
            self._limits(),
            self._watchdog(),
            examine_battery(
                states[-1].battery,
                charging=states[-1].charging,
                share=self._session.model.battery_share,
            ),
            examine_motors(states[-1]),
            examine_contacts(states[-1], self._session.missing_bumpers),
        ]

    def _no_session(self) -> Finding:
        assert self.trial is not None
        line = self.trial.line
        trouble = ""
        if not line.bytes_received:
            remedy = "switch the robot on; check that the cable leads to its HOST port"
        elif self._session.framer.counters.good:
            found = self._session.handshake.trouble
            trouble = "" if found is None else found.words.partition(";")[0]
            remedy = "press the robot's RESET button; end whatever else talks to it"
        else:
            remedy = "set its HOST port to one of these rates; check the cable: bytes come garbled"
        parts = filter(None, (trouble, describe_line(line)))
        return failed("base", f"no session: {'; '.join(parts)}", remedy)

    def _identity(self) -> Finding:
        identity = self._session.identity
        assert identity is not None, "a session has one"
        text = f"{identity.name}, {identity.robot_class} {identity.subclass}"
        text += f", at {self._session.baud} baud"
        trouble = self._session.model_trouble
        if trouble is not None:
            symptom, _, remedy = trouble.partition(": ")
            return failed("base", f"{text}: {symptom}; it will not drive", remedy)
        return ok("base", text)

    def _line(self) -> Finding:
        assert self.trial is not None
        counters = self._session.framer.counters
        return examine_line("base line", "packets", counters, self.trial.line)

    def _limits(self) -> Finding:
        config, settings = self._session.config, self._settings
        if config is None:
            return warning(
                "base limits",
                "no CONFIG answer: the model file's limits are taken",
                "none needed; some controllers never answer it rightly",
            )
        top_speed, top_turn_rate = 0.001 * config.speed_top, math.radians(config.turn_rate_top)
        text = f"firmware allows {top_speed:g} m/s, {config.turn_rate_top} deg/s"
        if config.firmware_version:
            text = (
                f"firmware {config.firmware_version} allows{text.removeprefix('firmware allows')}"
            )
        if top_speed < settings.max_speed or top_turn_rate < settings.max_turn_rate:
            return warning(
                "base limits",
                f"{text}; {settings.max_speed:g} m/s, "
                f"{math.degrees(settings.max_turn_rate):.0f} deg/s configured",
                "lower base.max_speed and base.max_turn_rate, or raise the controller's own",
            )
        if self._trouble and "keeps" in self._trouble:
            return warning("base limits", f"{text}; {self._trouble}", "adapt the base settings")
        return ok("base limits", text)

    def _watchdog(self) -> Finding:
        config = self._session.config
        if config is None or not config.is_whole:
            return skipped("base watchdog", "unknown: no CONFIG answer; 2 s from the factory")
        milliseconds = config.watchdog_ms
        remedy = f"set the controller's watchdog to {ADVISED_WATCHDOG_S:g} s with its FLASH tool"
        if 0 < milliseconds <= WATCHDOG_LIMIT_MS:
            text = f"stops the robot {0.001 * milliseconds:g} s after silence"
            if milliseconds <= 1000.0 * ADVISED_WATCHDOG_S:
                return ok("base watchdog", text)
            return warning("base watchdog", f"{text}, then its ramp", remedy)
        text = f"{0.001 * milliseconds:g} s" if milliseconds else "off"
        return failed(
            "base watchdog",
            f"{text}: a robot that is cut off would drive on",
            remedy,
        )


def examine_laser_type(model: RobotModel, kind: str = DEFAULT_KIND) -> Finding:
    """Check that the laser that the vendor mounts on a robot is of the configured kind."""
    laser = model.laser
    fitting = DRIVEN_LASERS.get(laser.type)
    if fitting != kind:
        there = "no laser" if laser.type == "none" else f"a laser of type {laser.type}"
        remedy = "mount another laser and set laser.kind, and laser.mount to its place"
        if fitting is not None:
            remedy = f'set laser.kind = "{fitting}", or laser.mount to the place of the other one'
        return warning(
            "laser type", f"a {model.subclass} comes with {there}, laser.kind is {kind}", remedy
        )
    text = f"the vendor mounts a laser of type {laser.type} on a {model.subclass}"
    return ok("laser type", f"{text}, upside down" if laser.upside_down else text)


def examine_battery(volts: float, *, charging: bool = False, share: float = 1.0) -> Finding:
    """Check a battery's voltage, V, and that no charger is at work.

    share: of the robot's nominal voltage in 12 V.
    """
    empty, low = BATTERY_EMPTY * share, BATTERY_LOW * share
    text = f"{volts:.1f} V"
    if charging:
        return warning("battery", f"{text}, on its charger", "unplug it: it does not drive so")
    if volts < empty:
        return failed("battery", f"{text}, empty below {empty:g} V", "charge or swap it now")
    if volts < low:
        return warning("battery", f"{text}, low below {low:g} V", "charge it before a patrol")
    return ok("battery", text)


def examine_motors(state: BaseState) -> Finding:
    """Check whether the agent will be able to switch the motors on."""
    if state.stop_button:
        return failed("motors", "the STOP button is pressed", "release the STOP button")
    if state.motors_enabled:
        return warning(
            "motors",
            "on, though nobody has enabled them",
            "press the MOTORS button once, and end whatever else drives the robot",
        )
    return ok("motors", "off, as after every connect; the agent switches them on")


def examine_contacts(state: BaseState, missing_bumpers: str | None = None) -> Finding:
    """Check for stalled wheels and pressed bumpers; missing_bumpers: a line on rings not there."""
    sides = [
        side for side, stall in (("left", state.stall_left), ("right", state.stall_right)) if stall
    ]
    pressed = [
        f"{ring} {segment + 1}"
        for ring, mask in (("front", state.front_bumpers), ("rear", state.rear_bumpers))
        for segment in range(7)
        if mask >> segment & 1
    ]
    parts = [f"{' and '.join(sides)} wheel stalled"] if sides else []
    parts += [f"bumper pressed: {', '.join(pressed)}"] if pressed else []
    if parts:
        return failed("contacts", "; ".join(parts), "push the robot clear of what it touches")
    if missing_bumpers is not None:
        return ok("contacts", f"no wheel stalled, no bumper pressed; {missing_bumpers}")
    return ok("contacts", "no wheel stalled, no bumper pressed")
