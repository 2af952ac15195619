"""The robot's x, y and heading counters made continuous."""

from __future__ import annotations

import math

from drivers.p2os.sip import COUNTS_PER_TURN

RADIANS_PER_COUNT = math.tau / COUNTS_PER_TURN
ZERO_DRIFT = 3  # counts
_HALF = COUNTS_PER_TURN // 2


def counter_step(new: int, old: int) -> int:
    """Return the step between two readings of a counter of at least 12 bits.

    Modulo 4096, so it is right for 12-, 15- and 16-bit counters while the true step is below
    2048 counts.
    """
    return (new - old + _HALF) % COUNTS_PER_TURN - _HALF


def in_finest_counts(heading: int, counts_per_turn: int) -> int:
    """Return a heading counter in COUNTS_PER_TURN, of a controller with fewer counts in a turn."""
    return heading * (COUNTS_PER_TURN // counts_per_turn)


def is_near_zero(counter: int) -> bool:
    """Whether a counter is at zero, within the drift of a robot at rest."""
    return abs((counter + 0x4000) % 0x8000 - 0x4000) <= ZERO_DRIFT


class Odometer:
    """Pose in the odom frame from wire counters, continuous across wraps and new references.

    The first pose is (0, 0, 0). The heading accumulates over whole turns.
    """

    def __init__(self) -> None:
        self.x = 0.0  # m
        self.y = 0.0  # m
        self.theta = 0.0  # rad, not wrapped
        self._counters: tuple[int, int, int] | None = None
        self._start = (0.0, 0.0, 0.0)  # pose at the reference
        self._travel = (0, 0, 0)  # counts since the reference
        self._turn = (1.0, 0.0)  # cosine and sine from the counters' frame to odom

    @property
    def counters(self) -> tuple[int, int, int] | None:
        """The latest counters on the wire; None before the first of a session."""
        return self._counters

    def forget_reference(self) -> None:
        """Use the next counters as a new reference only: they may start at any value."""
        self._counters = None

    def update(self, x: int, y: int, heading: int, metres_per_count: float) -> None:
        """Update the pose from the counters of one SIP."""
        if self._counters is None:
            self._set_reference(heading)
        else:
            old_x, old_y, old_heading = self._counters
            travel_x, travel_y, turned = self._travel
            self._travel = (
                travel_x + counter_step(x, old_x),
                travel_y + counter_step(y, old_y),
                turned + counter_step(heading, old_heading),
            )
        self._counters = (x, y, heading)
        self._place(metres_per_count)

    def _set_reference(self, heading: int) -> None:
        self._start = (self.x, self.y, self.theta)
        self._travel = (0, 0, 0)
        angle = self.theta - heading * RADIANS_PER_COUNT
        self._turn = (math.cos(angle), math.sin(angle))

    def _place(self, metres_per_count: float) -> None:
        start_x, start_y, start_theta = self._start
        along, across = self._travel[0] * metres_per_count, self._travel[1] * metres_per_count
        cosine, sine = self._turn
        self.x = start_x + cosine * along - sine * across
        self.y = start_y + sine * along + cosine * across
        self.theta = start_theta + self._travel[2] * RADIANS_PER_COUNT
