"""Which bumper rings a robot has: open inputs are not pressed bumpers."""

from __future__ import annotations

from drivers.p2os.config_packet import ConfigPacket
from drivers.p2os.sip import Sip

SEGMENT_BITS = 7
"""Bits of a stall byte above the stall's own."""
OPEN_INPUTS = (1 << SEGMENT_BITS) - 1
"""What a ring reads that is not there: inputs without a switch read 1."""


class BumperRing:
    """The bumper inputs at one end of the robot during one session.

    A ring that reads OPEN_INPUTS from the session's first report on is not fitted, until it reads
    anything else. A ring of fewer than SEGMENT_BITS segments cannot read OPEN_INPUTS when pressed;
    most of the vendor's have five. Of a ring to which model or CONFIG give SEGMENT_BITS or more
    (the PowerBot's front) a press all along looks the same, so that it counts. A ring that reads
    OPEN_INPUTS only later has lost its cable: that counts as pressed.
    """

    def __init__(self, segments: int) -> None:
        """Start without a report; segments: of the model's ring, 0 if it has none."""
        self._open_so_far = True
        self._seen = False
        self._most_segments = self._segments = segments

    @property
    def absence(self) -> str | None:
        """Why the ring's bits do not mean pressed segments; None if they do."""
        if self._segments == 0:
            return "it has no segments, by CONFIG or model"
        may_be_pressed = self._most_segments >= SEGMENT_BITS
        if self._seen and self._open_so_far and not may_be_pressed:
            return "every bit reads 1"
        return None

    def state_segments(self, count: int) -> None:
        """Take the number of segments that CONFIG states."""
        self._segments = count
        self._most_segments = max(self._most_segments, count)

    def pressed(self, bits: int) -> int:
        """Take the bits of a report; return the mask of pressed segments, 0 if not fitted."""
        self._seen = True
        self._open_so_far = self._open_so_far and bits == OPEN_INPUTS
        return bits if self.absence is None else 0


class FittedBumpers:
    """Both rings of one session; make it anew where the servers are opened anew."""

    def __init__(self, segments: tuple[int, int]) -> None:
        """Start without a report; segments: of the model's (front, rear) ring."""
        front, rear = segments
        self._front = BumperRing(front)
        self._rear = BumperRing(rear)

    @property
    def missing(self) -> str | None:
        """A line for people with the rings that are not fitted; None if both are."""
        front, rear = self._front.absence, self._rear.absence
        if front is not None and front == rear:
            return f"no bumpers fitted ({front})"
        absences = (("front", front), ("rear", rear))
        missing = [f"no {ring} bumpers fitted ({why})" for ring, why in absences if why]
        return "; ".join(missing) or None

    def on_config(self, config: ConfigPacket) -> None:
        """Take the numbers of segments from a CONFIG that has those fields."""
        if config.states_bumpers:
            self._front.state_segments(config.front_bumper_segments)
            self._rear.state_segments(config.rear_bumper_segments)

    def pressed(self, sip: Sip) -> tuple[int, int]:
        """Return the masks of pressed (front, rear) segments in a SIP, bit 0 the first."""
        return (
            self._front.pressed(sip.right_stall_byte >> 1),
            self._rear.pressed(sip.left_stall_byte >> 1),
        )
