"""Which robot's details the terminal shows, chosen by keys."""

from __future__ import annotations

import re
from collections.abc import Sequence

from tools.monitor.robot_row import NumberedRobot

HELP = "up and down or a number choose a robot, Esc the worst; q ends"

_KEYS = re.compile(rb"\x1b[\[O]([AB])|\x1b(?![\[O])|[0-9jkq]")
"""Arrows, Escape, digits and letters; anything else says nothing."""
_STEPS = {b"A": -1, b"k": -1, b"B": 1, b"j": 1}


class RobotChoice:
    """The robot that is chosen; without a choice the first of the list, the one in most trouble."""

    def __init__(self, name: str | None = None) -> None:
        """name: of the robot that is chosen at first, with or without its team; None: none is."""
        self.ended = False
        """Whether ``q`` was typed."""
        self._name = name
        self._typed = ""  # digits of a number

    def chosen(self, robots: Sequence[NumberedRobot]) -> NumberedRobot | None:
        """Return the robot to show of those listed; None if none is listed."""
        named = (each for each in robots if self._name in (each.robot.id, each.robot.robot))
        return next(named, robots[0] if robots else None)

    def type(self, typed: bytes, robots: Sequence[NumberedRobot]) -> None:
        """Take what was typed while ``robots`` were listed in this order."""
        for found in _KEYS.finditer(typed):
            key = found[1] or found[0]
            if key == b"q":
                self.ended = True
            elif key == b"\x1b":
                self._name = None
            elif key.isdigit():
                self._choose_number(key.decode(), robots)
                continue
            elif robots:
                self._step(_STEPS[key], robots)
            self._typed = ""

    def _choose_number(self, digit: str, robots: Sequence[NumberedRobot]) -> None:
        """Choose by number; digits in a row are one number while a robot has it."""
        numbers = {each.number: each.robot.id for each in robots}
        longer = self._typed + digit
        self._typed = longer if int(longer) in numbers else digit
        self._name = numbers.get(int(self._typed), self._name)

    def _step(self, step: int, robots: Sequence[NumberedRobot]) -> None:
        ids = [each.robot.id for each in robots]
        shown = self.chosen(robots)
        place = 0 if shown is None else ids.index(shown.robot.id)
        self._name = ids[min(max(place + step, 0), len(ids) - 1)]
