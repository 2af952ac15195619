"""Evaluates the band detector on synthetic pictures: recall, errors, false bands, time."""

from __future__ import annotations

import time
from collections.abc import Callable
from dataclasses import dataclass

import numpy as np

from drivers.camera_source import CameraSettings
from robot_agent.messages.blob import Blob
from robot_agent.perception.band_detector import BandDetector
from robot_agent.perception.color_settings import ColorSettings
from tools.simulation.composed_picture import ComposedPicture, Composer
from tools.simulation.truth.camera_truth import BandTruth, CameraTruth

VISIBILITY = 2.5
"""The paper's visibility range, m."""
SAME_RAD = 0.08
"""Largest bearing error of a blob that counts as the robot's."""
SURFACE_M = 0.2
"""Distance from a robot's middle to its sides, where its band is."""
SAME_SHARE = 0.3
"""Largest range error of a blob that counts as the robot's, as a share of the distance."""


@dataclass(frozen=True)
class ColorTrial:
    """Figures of a trial."""

    pictures: int
    recall: float
    """Share of the robots at VISIBILITY that were found."""
    recall_near: float
    """The same of robots from 0.6 m to VISIBILITY."""
    false_share: float
    """False bands per picture, over all pictures."""
    bearing_sigma: float  # rad
    range_bias: float  # m, at 2.5 m
    range_sigma: float  # m, at 2.5 m
    cpu_ms: float
    """Median CPU time of one detection."""


def run_color_trial(
    pictures: int,
    seed: int,
    camera: CameraSettings | None = None,
    color: ColorSettings | None = None,
    progress: Callable[[float], None] = lambda _: None,
) -> ColorTrial:
    """Detect bands in synthetic pictures: a quarter at 2.5 m, a quarter nearer, half without band.

    pictures: their number, 4 or more; camera, color: None: the defaults.
    """
    camera, color = camera or CameraSettings(), color or ColorSettings()
    truth = CameraTruth(
        width=camera.width,
        height=camera.height,
        focal_length=camera.focal_length,
        mount=camera.mount,
        mount_height=camera.mount_height,
    )
    band = BandTruth(middle=color.band_middle, height=color.band_height)
    composer = Composer(truth, band, seed)
    detector = BandDetector(camera, color)
    rng = np.random.default_rng(seed + 1)
    found: dict[str, list[bool]] = {"far": [], "near": []}
    errors: list[tuple[float, float]] = []
    false, times = 0, []
    for number in range(pictures):
        kind = ("far", "none", "near", "none")[number % 4]
        distance = {"far": VISIBILITY, "near": float(rng.uniform(0.6, VISIBILITY))}.get(kind)
        composed = composer.picture(distance)
        started = time.process_time()
        blobs = detector.look(composed.pixels).blobs
        times.append(time.process_time() - started)
        right = [blob for blob in blobs if _is_of(blob, composed)]
        false += len(blobs) - len(right)
        if kind in found:
            found[kind].append(bool(right))
        if kind == "far" and right:
            assert composed.bearing is not None
            errors.append(
                (right[0].bearing - composed.bearing, right[0].range - VISIBILITY + SURFACE_M)
            )
        progress(number + 1)
    off = np.array(errors).reshape(-1, 2)
    return ColorTrial(
        pictures=pictures,
        recall=float(np.mean(found["far"])),
        recall_near=float(np.mean(found["near"])),
        false_share=false / pictures,
        bearing_sigma=float(off[:, 0].std()),
        range_bias=float(off[:, 1].mean()),
        range_sigma=float(off[:, 1].std()),
        cpu_ms=1e3 * float(np.median(times)),
    )


def _is_of(blob: Blob, composed: ComposedPicture) -> bool:
    if composed.distance is None or composed.bearing is None:
        return False
    surface = composed.distance - SURFACE_M
    near = abs(blob.bearing - composed.bearing) < SAME_RAD
    return near and abs(blob.range - surface) < SAME_SHARE * surface
