"""Pictures to test the colour detection: a robot with its band before a generated background.

The backgrounds resemble photographs of rooms: surfaces of many scales in muted colours, a few
strongly coloured objects, uneven light, shadows and highlights. All is drawn from one generator.
"""

from __future__ import annotations

import math
from dataclasses import dataclass

import cv2
import numpy as np
from numpy.typing import NDArray

from maps.pose import Pose
from tools.simulation.camera_light import Light, LitCamera
from tools.simulation.camera_view import MAGENTA, prisms_of
from tools.simulation.prism import Color, paint
from tools.simulation.robot_body import RobotBody
from tools.simulation.truth.camera_truth import BandTruth, CameraTruth

_CLUTTER = (4, 14)  # least and largest number of objects in a background
_STRONG_SHARE = 0.25  # of them in strong colours
_STRONG: tuple[Color, ...] = (
    (40, 40, 200), (50, 160, 60), (190, 90, 40), (40, 190, 220), (40, 110, 230), (170, 60, 110),
    (150, 150, 235), (110, 90, 200),
)  # fmt: skip
"""Red, green, blue, yellow, orange, violet, pink and a faded crimson."""


@dataclass(frozen=True, slots=True, eq=False)
class ComposedPicture:
    """A picture with its ground truth: place of the robot with the band, None if there is none."""

    pixels: NDArray[np.uint8]
    light: Light
    distance: float | None  # m from the lens
    bearing: float | None  # rad, left positive


class Composer:
    """Generates pictures from a seed, each different."""

    def __init__(self, camera: CameraTruth, band: BandTruth, seed: int) -> None:
        self._camera = camera
        self._band = band
        self._rng = np.random.default_rng(seed)
        self._lit = LitCamera(self._rng)

    def picture(
        self, distance: float | None, lux: tuple[float, float] = (10.0, 2000.0)
    ) -> ComposedPicture:
        """Return a picture of a robot at a distance, m, and a random bearing; None: no robot."""
        rng = self._rng
        scene = self._background()
        bearing = None
        if distance is not None:
            half_view = math.atan(0.5 * self._camera.width / self._camera.focal_length)
            # All of the robot is in the picture.
            bearing = float(rng.uniform(-1.0, 1.0)) * (half_view - math.atan(0.35 / distance))
            self._paint_robot(scene, distance, bearing)
        scene = self._uneven(scene)
        light = Light(
            lux=float(np.exp(rng.uniform(*np.log(lux)))),
            kelvin=float(rng.uniform(2700.0, 7500.0)),
            exposure=float(np.exp(rng.normal(0.0, 0.25))),
        )
        # The less light, the longer the exposure and its motion blur while the robot turns.
        longest = 5 if light.lux < 100.0 else 3
        smear = 2 * int(rng.integers(0, longest // 2 + 1)) + 1
        blur = float(rng.uniform(0.4, 1.2))
        return ComposedPicture(
            self._coded(self._lit.expose(scene, light, smear, blur)), light, distance, bearing
        )

    def _background(self) -> NDArray[np.uint8]:
        """Return a scene (height, width, 3) without robots."""
        scene = self._surface()
        for _ in range(int(self._rng.integers(*_CLUTTER))):
            self._paint_clutter(scene)
        return scene

    def _surface(self) -> NDArray[np.uint8]:
        """Return noise of all scales, the coarsest strongest, about a muted colour."""
        rng, camera = self._rng, self._camera
        total = np.zeros((camera.height, camera.width, 3), dtype=np.float32)
        for octave in range(1, 7):
            cells = 2**octave
            coarse = rng.normal(0.0, 1.0, (cells, cells, 1)) + rng.normal(
                0.0, 0.25, (cells, cells, 3)
            )
            total += 0.6**octave * cv2.resize(
                coarse.astype(np.float32),
                (camera.width, camera.height),
                interpolation=cv2.INTER_CUBIC,
            )
        base = rng.uniform(50.0, 190.0) * np.exp(rng.normal(0.0, 0.12, 3))
        return np.asarray(np.clip(base * np.exp(0.35 * total), 5.0, 250.0), dtype=np.uint8)

    def _paint_clutter(self, scene: NDArray[np.uint8]) -> None:
        """Paint a patch, a disc or a strip, textured, plain or strongly coloured."""
        rng, camera = self._rng, self._camera
        strong = rng.random() < _STRONG_SHARE
        if strong:
            color = np.array(_STRONG[int(rng.integers(len(_STRONG)))], dtype=np.float64)
            color = np.clip(color * rng.uniform(0.6, 1.1), 0.0, 255.0)
        else:
            color = np.clip(rng.uniform(30.0, 220.0) + rng.normal(0.0, 18.0, 3), 0.0, 255.0)
        x, y = rng.uniform(0.0, camera.width), rng.uniform(0.0, camera.height)
        width, height = np.exp(rng.uniform(math.log(6.0), math.log(110.0), 2))
        mask = np.zeros(scene.shape[:2], dtype=np.uint8)
        if rng.random() < 0.4:
            cv2.ellipse(mask, ((x, y), (width, height), float(rng.uniform(0, 180))), 255, -1)
        else:
            box = cv2.boxPoints(((x, y), (width, height), float(rng.normal(0.0, 15.0))))
            cv2.fillConvexPoly(mask, np.rint(box).astype(np.int32), 255)
        texture = scene[mask > 0].astype(np.float64)
        mixed = 0.85 * color + 0.15 * texture
        scene[mask > 0] = mixed.astype(np.uint8)

    def _paint_robot(self, scene: NDArray[np.uint8], distance: float, bearing: float) -> None:
        heading = float(self._rng.uniform(-math.pi, math.pi))
        middle = Pose(distance * math.cos(bearing), distance * math.sin(bearing), heading)
        body = RobotBody(0, Pose(0.0, 0.0, 0.0))
        body.pose = middle.compose(Pose(-body.outline.middle, 0.0, 0.0))
        far = np.full(self._camera.width, np.inf)
        for prism in prisms_of(body, self._band, MAGENTA):
            paint(scene, far, Pose(0.0, 0.0, 0.0), prism, self._camera)

    def _uneven(self, scene: NDArray[np.uint8]) -> NDArray[np.uint8]:
        """Return the scene in a light that falls off to one side, with a shadow's edge."""
        rng, camera = self._rng, self._camera
        shade = rng.uniform(0.55, 1.0, (3, 3)).astype(np.float32)
        size = (camera.width, camera.height)
        light = np.asarray(cv2.resize(shade, size, interpolation=cv2.INTER_CUBIC), dtype=np.float64)
        if rng.random() < 0.3:
            edge = int(rng.integers(camera.width))
            light[:, edge:] *= rng.uniform(0.5, 0.9)
        return np.asarray(np.clip(scene * light[..., None], 0.0, 255.0), dtype=np.uint8)

    def _coded(self, picture: NDArray[np.uint8]) -> NDArray[np.uint8]:
        """Return a picture after the camera's JPEG coding."""
        quality = int(self._rng.integers(70, 95))
        _, jpeg = cv2.imencode(".jpg", picture, [cv2.IMWRITE_JPEG_QUALITY, quality])
        return np.asarray(cv2.imdecode(jpeg, cv2.IMREAD_COLOR), dtype=np.uint8)
