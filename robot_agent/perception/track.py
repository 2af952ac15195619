"""A track: the state of one object that is not in the map, estimated over time."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from robot_agent.perception.identity import Kind, Probabilities

TRACK_MEMORY = 3.0  # s for which a confirmed track is kept without a detection


@dataclass(frozen=True, slots=True, eq=False)
class Track:
    """Position, velocity and class of a tracked object.

    x, y: centre of the body's outline, m, map frame. vx, vy: velocity, m/s, map frame. covariance:
    (2, 2) of the position, m^2. first_seen, last_seen: times of the laser's first and latest
    detection. robot_sized: as large as a Pioneer in most detections that show it whole. moving: it
    has moved farther than errors explain. by_color: whether there is evidence by pictures. small:
    its outline is that of a scanner's housing; a robot's body may lie below the laser's plane.
    legs: it was a pair of legs in several scans in a row.
    """

    id: int
    x: float
    y: float
    vx: float
    vy: float
    covariance: NDArray[np.float64]
    first_seen: float
    last_seen: float
    kind: Kind
    probabilities: Probabilities
    robot_sized: bool
    moving: bool
    by_color: bool
    small: bool = False
    legs: bool = False

    @property
    def teammate(self) -> bool:
        """Whether it is a teammate."""
        return self.kind is Kind.TEAMMATE

    @property
    def needs_room(self) -> bool:
        """Whether it may be a robot whose body reaches farther than what the laser sees of it."""
        return self.robot_like or (self.small and self.kind is Kind.UNKNOWN)

    @property
    def may_turn(self) -> bool:
        """Whether it may be a robot that turns in place, which has not moved.

        Its shape denies it no more than its rest: in a gap between walls no outline fits.
        """
        denied = self.by_color and self.kind is Kind.STRANGER
        return self.needs_room or (self.robot_sized and not denied)

    @property
    def person_like(self) -> bool:
        """Whether it is a pair of legs, or has moved and is narrower than a robot.

        Legs are so whatever size they had from afar, where they may look like a housing.
        """
        walks = self.moving and not self.robot_sized
        return (self.legs or walks) and not self.needs_room

    @property
    def robot_like(self) -> bool:
        """Whether it is a teammate, or moves and has a robot's size and no picture denies it."""
        return is_robot_like(
            self.kind, by_color=self.by_color, moving=self.moving, robot_sized=self.robot_sized
        )


def is_robot_like(kind: Kind, *, by_color: bool, moving: bool, robot_sized: bool) -> bool:
    """Return ``Track.robot_like`` of a track with these fields."""
    if kind is Kind.TEAMMATE:
        return True
    denied = by_color and kind is Kind.STRANGER
    return moving and robot_sized and not denied
