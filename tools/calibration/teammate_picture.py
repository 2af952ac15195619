"""Draws a learned silhouette with the points it was learned from."""

from __future__ import annotations

from pathlib import Path

import matplotlib as mpl
import numpy as np

from maps.whole_file import whole_file
from tools.calibration.teammate_calibration import LearnedSilhouette

mpl.use("Agg")
from matplotlib import pyplot as plt


def draw_silhouette(learned: LearnedSilhouette, path: Path) -> None:
    """Write a PNG: the scans' points turned back, the polygon, and the axis of the turn."""
    figure, axes = plt.subplots(figsize=(5.0, 5.0), dpi=80)
    axes.plot(*learned.points.T, ",", color="0.5")
    outline = np.array([*learned.corners, learned.corners[0]])
    axes.plot(*outline.T, "o-", color="tab:blue", label="silhouette")
    axes.plot(0.0, 0.0, "k+", ms=12, label="axis of the turn")
    reach = 1.3 * float(np.abs(outline).max())
    axes.set(xlim=(-reach, reach), ylim=(-reach, reach), xlabel="m", ylabel="m")
    axes.set_title(f"points within {1000 * learned.rms:.0f} mm rms of it")
    axes.set_aspect("equal")
    axes.legend(loc="upper right", fontsize=8)
    figure.tight_layout()
    with whole_file(path) as part:
        figure.savefig(part)
    plt.close(figure)
