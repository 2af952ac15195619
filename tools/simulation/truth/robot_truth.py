"""What one simulated robot really is: body, outline in the laser, devices and what ails them."""

from __future__ import annotations

import math
from typing import Annotated, Literal

import msgspec

from tools.simulation.truth.camera_truth import BandTruth, CameraTruth

Length = Annotated[float, msgspec.Meta(gt=0.0)]
NotNegative = Annotated[float, msgspec.Meta(ge=0.0)]
_FARTHEST = 1.1 * math.pi  # rad; half a turn and a spread about it
Angle = Annotated[float, msgspec.Meta(ge=-_FARTHEST, le=_FARTHEST)]
SteepAngle = Annotated[float, msgspec.Meta(gt=0.0, le=math.pi / 2)]
Share = Annotated[float, msgspec.Meta(ge=0.0, le=1.0)]
Corner = tuple[float, float]
"""x and y in base_link, m."""
Segments = Annotated[int, msgspec.Meta(ge=0, le=7)]
Polygons = tuple[tuple[Corner, ...], ...]
ScannerKind = Literal["lms200", "lms1xx"]


class BodyTruth(msgspec.Struct, frozen=True, kw_only=True, forbid_unknown_fields=True):
    """What of the body can touch, about base_link, m: a rectangle, or a polygon within it.

    corners: of a convex polygon, counter-clockwise; empty for the rectangle.
    """

    front: Length
    rear: Length
    half_width: Length
    track: Length  # between the driven wheels
    corners: tuple[Corner, ...]

    def __post_init__(self) -> None:
        _require_convex((self.corners,) if self.corners else ())


class SilhouetteTruth(msgspec.Struct, frozen=True, kw_only=True, forbid_unknown_fields=True):
    """What other robots' lasers see: convex polygons at the laser's height.

    polygons: each three or more corners in base_link, m, counter-clockwise. Raises ValueError for
    any other.
    """

    polygons: Polygons

    def __post_init__(self) -> None:
        _require_convex(self.polygons)


class TapeTruth(msgspec.Struct, frozen=True, kw_only=True, forbid_unknown_fields=True):
    """Reflecting tape round the robot, at the height of other robots' lasers.

    facing: rad, the largest angle between a beam and the tape's normal at which it returns a
    reflector's light. missed: share of the beams within that angle that miss it: seams, dirt and
    slack.
    """

    worn: bool
    facing: SteepAngle
    missed: Share


class LaserTruth(msgspec.Struct, frozen=True, kw_only=True, forbid_unknown_fields=True):
    """Which scanner the robot has, how it really sits on it, and what is wrong with it.

    theta: rad, counter-clockwise. upside_down: turned over about its axis of view. mirrored: beams
    are sent in the reverse order. repeats_from: from so many s after power-on every scan is the
    first one again, with the range noise added anew; inf for never. stuck_from: from so many s
    after power-on the beams between the two angles of stuck, rad from the laser's axis, report the
    ranges that they had then; inf for never. tilt and roll: rad, by which the plane goes down ahead
    of the laser and on its left. offset, stretch: systematic error, m, and per m of range. quantum:
    ranges are whole multiples of it, m; 0 for none. reach: farther, m, nothing returns. dazzles:
    times per second that a sector of beams is blinded for a while. own_parts: convex polygons in
    base_link of parts of the robot that stand in its own view.
    """

    kind: ScannerKind
    x: float  # m, in base_link
    y: float  # m
    theta: Angle
    height: Length  # m, of its plane above the floor
    upside_down: bool
    mirrored: bool
    repeats_from: float
    stuck_from: float
    stuck: tuple[Angle, Angle]
    tilt: Angle
    roll: Angle
    offset: float
    stretch: float
    quantum: NotNegative
    reach: Length
    dazzles: NotNegative
    own_parts: Polygons

    def __post_init__(self) -> None:
        _require_convex(self.own_parts)

    @property
    def mount(self) -> tuple[float, float, float]:
        """Pose in base_link: m, m, rad."""
        return self.x, self.y, self.theta


class DriveTruth(msgspec.Struct, frozen=True, kw_only=True, forbid_unknown_fields=True):
    """How the robot follows its wheels and its wheels follow the controller.

    turn_scale: turn of the body for a turn of 1 by the controller's track; the ratio of the track
    in the controller to the true one. braking: share of the ordered deceleration that the motors
    reach with this payload on this floor.
    """

    turn_scale: Length
    braking: Annotated[float, msgspec.Meta(gt=0.0, le=1.0)]


class SonarPlace(msgspec.Struct, frozen=True, array_like=True, forbid_unknown_fields=True):
    """Pose of one transducer in base_link."""

    x: float  # m
    y: float  # m
    heading_deg: float


class BaseTruth(msgspec.Struct, frozen=True, kw_only=True, forbid_unknown_fields=True):
    """What the base is built as: limits, what its counts mean, where its sonars are.

    sonar: by number. no_sonar: the numbers that have no transducer, which never echo. firmware:
    operating system of its controller: that of a Pioneer 2, of the H8 boards or of the SH2 boards.
    clock: s of the controller's clock in a second.
    """

    top_speed: Length  # m/s
    top_turn_rate_deg: Length  # deg/s
    sonar_far: Length  # m, sent by a transducer without an echo
    sonar: tuple[SonarPlace, ...]
    no_sonar: tuple[int, ...]
    battery: Length  # V, nominal
    firmware: Literal["p2os", "aros", "arcos"]
    clock: Length
    heading_counts: Annotated[int, msgspec.Meta(gt=0)]  # per turn
    distance_count: Length  # m, of one count of x or y
    speed_count: Length  # m/s, of one count of a wheel's speed
    range_count: Length  # m, of one count of a sonar
    wheel_speed_count: Length  # m/s, of one count of VEL2
    turn: Length  # rad/s per m/s of half the wheels' speed difference, as the base computes it


class BumperTruth(msgspec.Struct, frozen=True, kw_only=True, forbid_unknown_fields=True):
    """The bumpers.

    fitted: whether there are any; without, their inputs are open and every bit reads 1. segments:
    of the front and the rear ring, as CONFIG states them.
    """

    fitted: bool
    segments: tuple[Segments, Segments]


class ChargingTruth(msgspec.Struct, frozen=True, kw_only=True, forbid_unknown_fields=True):
    """The charger.

    connected: the base reports a bulk charge, in the field that only later firmware has.
    """

    connected: bool


class RobotTruth(msgspec.Struct, frozen=True, kw_only=True, forbid_unknown_fields=True):
    """One robot. subclass: what it says it is when a client connects."""

    subclass: str
    base: BaseTruth
    body: BodyTruth
    silhouette: SilhouetteTruth
    tape: TapeTruth
    laser: LaserTruth
    camera: CameraTruth
    band: BandTruth
    drive: DriveTruth
    bumpers: BumperTruth
    charging: ChargingTruth


def _require_convex(polygons: Polygons) -> None:
    """Raise ValueError unless each polygon is convex and counter-clockwise."""
    for number, corners in enumerate(polygons):
        if not _is_convex(corners):
            raise ValueError(
                f"polygon {number} is not convex and counter-clockwise: list its corners "
                "counter-clockwise, or split it"
            )


def _is_convex(corners: tuple[Corner, ...]) -> bool:
    """Return whether corners turn left everywhere, and once round in all."""
    if len(corners) < 3:
        return False
    turned = 0.0
    for (ax, ay), (bx, by), (cx, cy) in zip(
        corners, corners[1:] + corners[:1], corners[2:] + corners[:2], strict=True
    ):
        along = (bx - ax) * (cx - bx) + (by - ay) * (cy - by)
        left = (bx - ax) * (cy - by) - (by - ay) * (cx - bx)
        if left <= 0.0:
            return False
        turned += math.atan2(left, along)
    return turned < 1.5 * math.tau
