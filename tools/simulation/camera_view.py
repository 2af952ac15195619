"""Rendering of the world for a camera on a robot: walls, posters, robots with bands, strangers.

Everything but walls and floor is an upright prism, painted from far to near, side by side; walls
occlude by columns. The colours are the surfaces' own: light and noise are added by
``camera_light``.
"""

from __future__ import annotations

import math
from collections.abc import Iterator, Sequence

import cv2
import numpy as np
from numpy.typing import NDArray

from maps.occupancy_map import FREE
from maps.pose import Pose
from tools.simulation.prism import Color, Prism, paint, rectangle
from tools.simulation.robot_body import BodyKind, RobotBody
from tools.simulation.truth.camera_truth import BandTruth, CameraTruth
from tools.simulation.world import World

MAGENTA: Color = (150, 40, 225)
WALL_HEIGHT = 2.5  # m
SIGHT = 12.0  # m; objects farther away are not painted
_NEAREST = 0.05  # m; depth of a wall that touches the lens
_FLOOR, _CEILING, _WALL = (70, 80, 90), (225, 225, 215), np.array((165.0, 190.0, 200.0))
_FADING = 14.0  # m over which a wall's brightness falls to 1/e
_MIN_BRIGHTNESS = 0.4
_COLUMNS_A_RAY = 2
_CLOTHES: tuple[Color, ...] = (
    (120, 60, 40), (40, 40, 45), (60, 120, 70), (60, 60, 190), (190, 180, 170), (90, 60, 130),
)  # fmt: skip
_POSTERS: tuple[Color, ...] = (
    (40, 40, 200), (50, 160, 60), (190, 90, 40), (40, 190, 220), (170, 60, 110), (150, 150, 235),
    (110, 90, 200),
)  # fmt: skip
_SKIN: Color = (140, 170, 215)
_BODY_RED: Color = (35, 30, 150)
_WHEELS: Color = (35, 35, 35)
_LASER_BLUE: Color = (150, 90, 60)
_CARDBOARD: Color = (90, 130, 165)


def prisms_of(body: RobotBody, band: BandTruth, color: Color) -> list[Prism]:
    """Return the prisms that make up a body."""
    x, y, theta, half_length, half_width = body.rectangle()
    if body.kind is BodyKind.BOX:
        plan = rectangle(x, y, theta, half_length, half_width)
        return [Prism(plan, 0.0, 0.7, _CARDBOARD)]
    if body.kind is BodyKind.PERSON:
        plan = rectangle(x, y, theta, half_length, half_width)
        head = rectangle(x, y, theta, 0.1, 0.08)
        trousers = _CLOTHES[body.index % len(_CLOTHES)]
        shirt = _CLOTHES[(5 * body.index + 3) % len(_CLOTHES)]
        return [
            Prism(plan, 0.0, 0.85, trousers),
            Prism(plan, 0.85, 1.45, shirt),
            Prism(head, 1.45, 1.72, _SKIN),
        ]
    low, high = band.middle - band.height / 2, band.middle + band.height / 2
    plan = rectangle(x, y, theta, 0.22, 0.19)
    return [
        Prism(rectangle(x, y, theta, half_length, half_width), 0.04, 0.1, _WHEELS),
        Prism(plan, 0.06, low, _BODY_RED),
        Prism(plan, low, high, color),
        Prism(rectangle(x, y, theta, 0.08, 0.08), high, high + 0.1, _LASER_BLUE),
    ]


def posters_on_walls(world: World, count: int = 24) -> list[Prism]:
    """Return coloured posters on the walls, the same ones for every robot of a map."""
    rng = np.random.default_rng(count)
    occupancy = world.occupancy
    free = np.argwhere(occupancy.cells == FREE)
    posters = []
    for _ in range(count):
        row, col = free[int(rng.integers(len(free)))].tolist()
        direction = float(rng.uniform(-math.pi, math.pi))
        x, y = occupancy.centre(row, col)
        # Just before the wall that the ray hits, turned along the nearer axis of the map.
        reach = world.free_way(x, y, direction) - 0.03
        if not math.isfinite(reach):
            continue
        wall = round(2.0 * direction / math.pi) * math.pi / 2
        x, y = x + reach * math.cos(direction), y + reach * math.sin(direction)
        width, height = rng.uniform(0.2, 0.8, 2).tolist()
        bottom = float(rng.uniform(0.1, 1.4))
        color = _POSTERS[int(rng.integers(len(_POSTERS)))]
        plan = rectangle(x, y, wall, 0.01, width / 2)
        posters.append(Prism(plan, bottom, bottom + height, color))
    return posters


class CameraView:
    """Paints the view of one robot's camera."""

    def __init__(
        self,
        world: World,
        camera: CameraTruth,
        band: BandTruth,
        posters: Sequence[Prism] = (),
    ) -> None:
        self._world = world
        self._camera = camera
        self._posters = posters
        self._band = band
        columns = np.arange(0, camera.width, _COLUMNS_A_RAY) + 0.5 * (_COLUMNS_A_RAY - 1)
        across = (columns - (camera.width - 1) / 2) / camera.focal_length
        self._bearings = -np.arctan(across)
        self._flatten = np.cos(self._bearings)
        self._rows = np.arange(camera.height, dtype=np.float32)[:, None]
        self._empty = np.empty((camera.height, camera.width, 3), dtype=np.uint8)
        self._empty[: camera.height // 2] = _CEILING
        self._empty[camera.height // 2 :] = _FLOOR

    def scene(self, pose: Pose, own: RobotBody | None = None) -> NDArray[np.uint8]:
        """Return the painted scene (height, width, 3; blue, green, red) from map_from_base.

        own: the robot that carries the camera, which is not painted.
        """
        lens = pose.compose(Pose(*self._camera.mount))
        picture = self._empty.copy()
        depth = self._paint_walls(picture, lens)
        for prism in self._in_sight(lens, own):
            paint(picture, depth, lens, prism, self._camera)
        return picture

    def _paint_walls(self, picture: NDArray[np.uint8], lens: Pose) -> NDArray[np.float64]:
        """Paint the walls; return the depth of the wall in each column, m."""
        camera = self._camera
        ranges = self._world.free_ways(lens.x, lens.y, lens.theta + self._bearings)
        rays = np.maximum(ranges * self._flatten, _NEAREST)
        brightness = np.clip(np.exp(-rays / _FADING), _MIN_BRIGHTNESS, 1.0)
        depth = np.repeat(rays, _COLUMNS_A_RAY)[: camera.width]
        inverse = (camera.focal_length / depth).astype(np.float32)
        middle = (camera.height - 1) / 2
        above = self._rows > middle - (WALL_HEIGHT - camera.mount_height) * inverse
        above &= self._rows < middle + camera.mount_height * inverse
        shades = (brightness[:, None] * _WALL).astype(np.uint8)
        wall = np.repeat(shades, _COLUMNS_A_RAY, axis=0)[: camera.width]
        cv2.copyTo(np.broadcast_to(wall, picture.shape), above.astype(np.uint8), picture)
        return depth

    def _in_sight(self, lens: Pose, own: RobotBody | None) -> Iterator[Prism]:
        """Yield the prisms before the lens, farthest first."""
        c, s = math.cos(lens.theta), math.sin(lens.theta)
        near: list[tuple[float, list[Prism]]] = []
        for body in self._world.bodies:
            dx, dy = body.pose.x - lens.x, body.pose.y - lens.y
            if body is own or c * dx + s * dy < -0.5 or math.hypot(dx, dy) > SIGHT:
                continue
            near.append((math.hypot(dx, dy), prisms_of(body, self._band, MAGENTA)))
        for poster in self._posters:
            dx, dy = (poster.corners.mean(axis=0) - (lens.x, lens.y)).tolist()
            if c * dx + s * dy > 0.0 and math.hypot(dx, dy) < SIGHT:
                near.append((math.hypot(dx, dy), [poster]))
        near.sort(key=lambda each: -each[0])
        for _, prisms in near:
            yield from prisms
