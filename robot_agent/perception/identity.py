"""What is known of who somebody is: teammate, stranger, or not known yet."""

from __future__ import annotations

import math
from dataclasses import dataclass
from enum import StrEnum

_WEIGHT_SCALE = 1.5  # nats of evidence after which little is unknown any more
_MOST = 5.0  # nats either way: nobody is so sure that a second of new evidence counts for nothing

# Logarithms of likelihood ratios, teammate over stranger. Those of one picture are far below what
# a single independent one, as pictures in a row show the same light and background.
_BAND = 1.2  # the team's band, where and as far as the laser sees something
_NO_BAND = -0.8  # none, though it would be in the picture
_ROBOT_LIKE = 0.4  # a Pioneer's outline fits it, and it moves as fast as one
_OTHER_SHAPE = -0.4  # as large as a robot, but no Pioneer's outline fits
_TOO_FAST = -0.5  # faster than any robot of the team drives
_WRONG_SIZE = -0.25  # seen whole and not as large as a robot
_REFLECTOR = 1.0  # reflecting tape at the laser's height

_TEAMMATE, _STRANGER = 1.5, -1.5  # nats at which somebody becomes one
_MAX_BY_LASER = 2.0  # nats either way; three pictures are enough against it
_KEPT = 0.0  # nats down (or up) to which somebody stays one


class Kind(StrEnum):
    """Who somebody is."""

    TEAMMATE = "teammate"
    STRANGER = "stranger"
    UNKNOWN = "unknown"


@dataclass(frozen=True, slots=True)
class Probabilities:
    """Of each kind; they add up to 1."""

    teammate: float
    stranger: float
    unknown: float


class Identity:
    """Accumulates evidence over a track's life; a decision once taken is kept through doubt."""

    def __init__(self) -> None:
        self.kind = Kind.UNKNOWN
        self.by_color = False
        """Whether any picture has said something."""
        self._log_odds = 0.0
        self._evidence = 0.0

    @property
    def probabilities(self) -> Probabilities:
        """The probability of each kind."""
        known = 1.0 - math.exp(-self._evidence / _WEIGHT_SCALE)
        teammate = 1.0 / (1.0 + math.exp(-self._log_odds))
        return Probabilities(known * teammate, known * (1.0 - teammate), 1.0 - known)

    def on_band(self, confidence: float) -> None:
        """A picture shows the team's band on it, with a confidence of 0 to 1."""
        self.by_color = True
        self._add(_BAND * confidence)

    def on_missing_band(self) -> None:
        """A picture shows it without a band."""
        self.by_color = True
        self._add(_NO_BAND)

    def on_robot_shape(self) -> None:
        """A Pioneer's outline fits it, and it moves as one."""
        if not self._told_by_color:
            self._add(min(_ROBOT_LIKE, max(_MAX_BY_LASER - self._log_odds, 0.0)))

    def on_other_shape(self) -> None:
        """It is as large as a Pioneer, whose outline does not fit."""
        if not self._told_by_color:
            self._add(max(_OTHER_SHAPE, min(-_MAX_BY_LASER - self._log_odds, 0.0)))

    @property
    def _told_by_color(self) -> bool:
        """Whether pictures have settled it: another team's robot has a robot's outline too, and a
        teammate may carry what changes its own."""
        return self.by_color and self.kind is not Kind.UNKNOWN

    def on_too_fast(self) -> None:
        """It is faster than a robot."""
        self._add(_TOO_FAST)

    def on_wrong_size(self) -> None:
        """It was seen whole, and is no robot by its size."""
        self._add(_WRONG_SIZE)

    def on_reflector(self) -> None:
        """It has a reflector that teammates wear."""
        self._add(_REFLECTOR)

    def _add(self, evidence: float) -> None:
        self._log_odds = min(max(self._log_odds + evidence, -_MOST), _MOST)
        self._evidence = min(self._evidence + abs(evidence), 4.0 * _MOST)
        if self._log_odds >= _TEAMMATE:
            self.kind = Kind.TEAMMATE
        elif self._log_odds <= _STRANGER:
            self.kind = Kind.STRANGER
        elif (self.kind is Kind.TEAMMATE and self._log_odds < _KEPT) or (
            self.kind is Kind.STRANGER and self._log_odds > _KEPT
        ):
            self.kind = Kind.UNKNOWN
