"""Preparation of a robot after its servers were opened: limits, set and read back."""

from __future__ import annotations

import math
from enum import Enum

import msgspec

from drivers.p2os.command_numbers import CommandNumber
from drivers.p2os.command_outbox import (
    DEFAULT_WATCHDOG,
    LATER_PERIOD,
    CommandOutbox,
)
from drivers.p2os.commands import REQUEST_CONFIG, STAND_STILL, STOP, Command, command
from drivers.p2os.config_packet import ConfigPacket
from drivers.p2os.model import RobotModel
from drivers.p2os.settings import BaseSettings
from drivers.p2os.trouble import Trouble, TroubleKind

ACCELERATION = 0.3  # m/s^2
DECELERATION = 0.6  # m/s^2
TURN_ACCELERATION = 1.75  # rad/s^2
TURN_DECELERATION = 1.75  # rad/s^2
CONFIG_TIMEOUT = 1.0  # s
CONFIG_RETRY = 0.33  # s
CONFIG_TRIES = 3
LIMIT_TRIES = 2
BUMP_STALL_CODES = {"off": 0, "front": 1, "rear": 2, "both": 3}


class Stage(Enum):
    """Stage of the preparation."""

    ASKING = "asking what the controller is like"
    SENDING = "sending limits"
    CHECKING = "reading the limits back"
    DONE = "done"


class SetUp:
    """Requests CONFIG, sends ``set_up_commands`` and compares the limits in the next CONFIG.

    Limits that were not taken are sent once more. A robot that never answers CONFIG, as some do
    not, is prepared without.
    """

    def __init__(self, settings: BaseSettings, outbox: CommandOutbox) -> None:
        self.config: ConfigPacket | None = None
        """The controller's latest CONFIG of this session."""
        self.trouble: Trouble | None = None
        self.refusals = 0
        """Times the robot kept other limits than those asked for."""
        self._settings = settings
        self._outbox = outbox
        self._stage = Stage.DONE
        self._answered = False
        self._queried_at = self._began_at = -math.inf
        self._tries = self._limits_sent = 0

    @property
    def watchdog(self) -> float:
        """Time without a packet, s, after which the controller halts; by CONFIG or default."""
        stated = self.config.watchdog_ms if self.config and self.config.is_whole else 0
        return 0.001 * stated if stated else DEFAULT_WATCHDOG

    def limit_to(self, model: RobotModel) -> None:
        """Ask for no higher limits than those of the robot's model."""
        self._settings = msgspec.structs.replace(
            self._settings,
            max_speed=min(self._settings.max_speed, model.top_speed),
            max_turn_rate=min(self._settings.max_turn_rate, model.top_turn_rate),
        )

    def begin(self, t: float, *, resumed: bool) -> None:
        """Start; a resumed session skips the first CONFIG."""
        self.trouble = None
        self._limits_sent = 0
        if not resumed:
            self.config = None
        if self.config is None:
            self._query(Stage.ASKING, t)
        else:
            self.on_config(self.config)
            self._send_commands()

    def on_config(self, config: ConfigPacket) -> None:
        """Take the controller's watchdog and command period from a CONFIG packet."""
        self.config = config
        self._answered = True
        self._outbox.watchdog = self.watchdog
        if config.is_of_later_firmware:
            self._outbox.period = LATER_PERIOD

    def advance(self, t: float) -> bool:
        """Do what is due at ``t``; return whether the robot is prepared."""
        if self._stage is Stage.SENDING and self._outbox.empty:
            if self.config is not None:
                self._query(Stage.CHECKING, t)
            else:
                self._stage = Stage.DONE
        elif self._stage in (Stage.ASKING, Stage.CHECKING):
            self._await_config(t)
        return self._stage is Stage.DONE

    def _await_config(self, t: float) -> None:
        if self._answered or t - self._began_at >= CONFIG_TIMEOUT:
            self._end_query()
        elif self._tries < CONFIG_TRIES and t - self._queried_at >= CONFIG_RETRY:
            self._send_query(t)

    def _end_query(self) -> None:
        if self._stage is Stage.ASKING:
            self._send_commands()
        else:
            self._check_limits()

    def _check_limits(self) -> None:
        self._stage = Stage.DONE
        if not self._answered or self.config is None:
            words = "limits not confirmed: the robot no longer answers CONFIG; link failing?"
            self.trouble = Trouble(TroubleKind.LIMITS, words)
            return
        kept = kept_otherwise(self._settings, self.config)
        if kept and self._limits_sent < LIMIT_TRIES:
            self._send_commands()
        elif kept:
            self.refusals += 1
            words = f"robot keeps {', '.join(kept)}: adapt the base settings to it"
            self.trouble = Trouble(TroubleKind.LIMITS, words)

    def _send_commands(self) -> None:
        self._limits_sent += 1
        self._stage = Stage.SENDING
        self._outbox.add(*set_up_commands(self._settings))

    def _query(self, stage: Stage, t: float) -> None:
        self._stage = stage
        self._answered = False
        self._began_at = t
        self._tries = 0
        self._send_query(t)

    def _send_query(self, t: float) -> None:
        self._tries += 1
        self._queried_at = t
        self._outbox.add(REQUEST_CONFIG)


def limit_commands(settings: BaseSettings) -> list[Command]:
    """Return the speed and acceleration limits by the settings."""
    return [
        command(CommandNumber.SETV, _whole_millimetres(settings.max_speed)),
        command(CommandNumber.SETRV, _whole_degrees(settings.max_turn_rate)),
        command(CommandNumber.SETA, _whole_millimetres(ACCELERATION)),
        command(CommandNumber.SETA, -_whole_millimetres(DECELERATION)),
        command(CommandNumber.SETRA, _whole_degrees(TURN_ACCELERATION)),
        command(CommandNumber.SETRA, -_whole_degrees(TURN_DECELERATION)),
    ]


def set_up_commands(settings: BaseSettings) -> list[Command]:
    """Return limits, bumpers and sonar by the settings, then zero motion, in sending order."""
    return [
        *limit_commands(settings),
        command(CommandNumber.BUMP_STALL, BUMP_STALL_CODES[settings.bump_stall]),
        command(CommandNumber.SONAR, 1),
        STOP,
        *STAND_STILL,
    ]


def kept_otherwise(settings: BaseSettings, config: ConfigPacket) -> list[str]:
    """Return, for people, each limit in which CONFIG differs from the settings."""
    if not config.is_whole:
        return []
    shown = (
        ("SETV", config.speed_max, "mm/s"),
        ("SETRV", config.turn_rate_max, "deg/s"),
        ("SETA", config.acceleration, "mm/s^2"),
        ("SETA", -config.deceleration, "mm/s^2"),
        ("SETRA", config.turn_acceleration, "deg/s^2"),
        ("SETRA", -config.turn_deceleration, "deg/s^2"),
    )
    return [
        f"{name} {value} {unit}, asked for {wanted.integer}"
        for wanted, (name, value, unit) in zip(limit_commands(settings), shown, strict=True)
        if abs(wanted.integer - value) > 1
    ]


def _whole_millimetres(metres: float) -> int:
    return max(1, round(1000.0 * metres))


def _whole_degrees(radians: float) -> int:
    return max(1, round(math.degrees(radians)))
