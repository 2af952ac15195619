"""Classification of a track: teammate, stranger, or unknown."""

from __future__ import annotations

import math
from dataclasses import dataclass
from enum import StrEnum

_WEIGHT_SCALE = 1.5  # nats; scale at which evidence lowers the probability of unknown
_MAX_LOG_ODDS = 5.0  # nats either way, so that a second of new evidence still counts

# Log likelihood ratios, teammate over stranger. Those of one picture are far below that of an
# independent measurement, as pictures in a row have the same light and background.
_BAND = 1.2  # the team's band at the bearing and distance of the track
_NO_BAND = -0.8  # no band, though it should be in the picture
_ROBOT_LIKE = 0.4  # a teammate's silhouette fits, at a robot's speed
_SMALL_LIKE = 0.2  # the same of a silhouette so small that a leg's fits too
_OTHER_SHAPE = -0.4  # as large as a robot, but a Pioneer's outline does not fit
_TOO_FAST = -0.5  # faster than any robot of the team
_WRONG_SIZE = -0.25  # seen whole and not as large as a robot
_REFLECTOR = 1.0  # reflecting tape at the laser's height

_TEAMMATE, _STRANGER = 1.5, -1.5  # nats at which the kind is decided
_MAX_BY_LASER = 2.0  # nats either way by shape; three pictures outweigh it
_KEPT = 0.0  # nats down (or up) to which the kind stays decided


class Kind(StrEnum):
    """Class of a track."""

    TEAMMATE = "teammate"
    STRANGER = "stranger"
    UNKNOWN = "unknown"


@dataclass(frozen=True, slots=True)
class Probabilities:
    """Probability of each kind; they add up to 1."""

    teammate: float
    stranger: float
    unknown: float


class Identity:
    """Log odds of teammate over stranger, accumulated over a track's life; with hysteresis."""

    def __init__(self) -> None:
        self.kind = Kind.UNKNOWN
        self.by_color = False
        """Whether any picture has given evidence."""
        self._log_odds = 0.0
        self._evidence = 0.0

    @property
    def probabilities(self) -> Probabilities:
        """The probability of each kind."""
        known = 1.0 - math.exp(-self._evidence / _WEIGHT_SCALE)
        teammate = 1.0 / (1.0 + math.exp(-self._log_odds))
        return Probabilities(known * teammate, known * (1.0 - teammate), 1.0 - known)

    def on_band(self, confidence: float) -> None:
        """Add the evidence of a picture with the team's band on it, with a confidence, 0 to 1."""
        self.by_color = True
        self._add(_BAND * confidence)

    def on_missing_band(self) -> None:
        """Add the evidence of a picture that shows it without a band."""
        self.by_color = True
        self._add(_NO_BAND)

    def on_robot_shape(self, *, small: bool = False) -> None:
        """Add the evidence of a scan in which a teammate's silhouette fits, at a robot's speed."""
        if not self._decided_by_color:
            evidence = _SMALL_LIKE if small else _ROBOT_LIKE
            self._add(min(evidence, max(_MAX_BY_LASER - self._log_odds, 0.0)))

    def on_other_shape(self) -> None:
        """Add the evidence of a scan in which it has a Pioneer's size, but not its outline."""
        if not self._decided_by_color:
            self._add(max(_OTHER_SHAPE, min(-_MAX_BY_LASER - self._log_odds, 0.0)))

    @property
    def _decided_by_color(self) -> bool:
        """Whether the kind is decided with pictures; outline evidence is ignored then.

        Another team's robot has a robot's outline too, and a load may change a teammate's.
        """
        return self.by_color and self.kind is not Kind.UNKNOWN

    def on_too_fast(self) -> None:
        """Add the evidence of a scan in which it is faster than a robot."""
        self._add(_TOO_FAST)

    def on_wrong_size(self) -> None:
        """Add the evidence of a scan in which, seen whole, it does not have the size of a robot."""
        self._add(_WRONG_SIZE)

    def on_reflector(self) -> None:
        """Add the evidence of a scan in which it wears reflecting tape, as teammates do."""
        self._add(_REFLECTOR)

    def _add(self, evidence: float) -> None:
        self._log_odds = min(max(self._log_odds + evidence, -_MAX_LOG_ODDS), _MAX_LOG_ODDS)
        self._evidence = min(self._evidence + abs(evidence), 4.0 * _MAX_LOG_ODDS)
        if self._log_odds >= _TEAMMATE:
            self.kind = Kind.TEAMMATE
        elif self._log_odds <= _STRANGER:
            self.kind = Kind.STRANGER
        elif (self.kind is Kind.TEAMMATE and self._log_odds < _KEPT) or (
            self.kind is Kind.STRANGER and self._log_odds > _KEPT
        ):
            self.kind = Kind.UNKNOWN
