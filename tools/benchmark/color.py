"""Figures of the colour band detection."""

from __future__ import annotations

import math
from collections.abc import Iterator
from pathlib import Path

from tools.benchmark.figure import SEED, Figure
from tools.calibration.color_trial import run_color_trial

COLOR_PICTURES = 800


def color(_folder_path: Path) -> Iterator[Figure]:
    """Detect bands in synthetic pictures at 10 to 2000 lux, half of them without a band."""
    trial = run_color_trial(COLOR_PICTURES, SEED)
    yield Figure("bands at 2.5 m found", 100 * trial.recall, "%", 95.0, at_least=True)
    yield Figure("bands at 0.6 to 2.5 m found", 100 * trial.recall_near, "%", 95.0, at_least=True)
    yield Figure("false bands in 200 pictures", 200 * trial.false_share, "", 1.0)
    yield Figure("bearing of a band at 2.5 m, sigma", math.degrees(trial.bearing_sigma), "deg")
    yield Figure("range of a band at 2.5 m, bias", trial.range_bias, "m")
    yield Figure("range of a band at 2.5 m, sigma", trial.range_sigma, "m")
    yield Figure("colour detection, 320 x 240, processor time", trial.cpu_ms, "ms", 5.0, speed=True)
