"""Runs the tracker alone on a log of a building without robots of the team."""

from __future__ import annotations

from collections.abc import Callable, Sequence
from dataclasses import dataclass

import numpy as np

from drivers.p2os.model import DEFAULT_MODEL, load_model
from localization.health import Health
from localization.localizer import Localizer
from localization.settings import LocalizationSettings
from maps.map_folder import MapFolder
from robot_agent.perception.pose_sigma import PoseSigma
from robot_agent.perception.settings import PerceptionSettings
from robot_agent.perception.silhouette import Silhouettes, body_corners
from robot_agent.perception.tracker import TeammateTracker
from tools.logs.carmen import LogError
from tools.logs.log_step import LogStep

MIN_STEP_S = 0.1
_BODY = body_corners(load_model(DEFAULT_MODEL).body)  # the robots of the logs, or nearly


@dataclass(frozen=True)
class PerceiveResult:
    """Counts of the tracker's results on a log, over the localized scans."""

    looked_at: int
    """All scans; the tracker sees those at which the robot is localized."""
    scans: int
    teammates: int
    """Tracks classified as a teammate at any time."""
    tracks: int
    """Confirmed tracks."""
    moving: int
    """Sum over the scans of confirmed tracks seen in it that had moved."""
    standing: int
    """Sum over the scans of confirmed tracks seen in it that had not moved."""

    @property
    def moving_per_100(self) -> float:
        """Moving tracks in a hundred scans."""
        return 100.0 * self.moving / max(self.scans, 1)

    @property
    def summary(self) -> dict[str, float]:
        """The figures for JSON."""
        return {
            "looked_at": self.looked_at,
            "scans": self.scans,
            "teammates": self.teammates,
            "tracks": self.tracks,
            "moving_per_100_scans": self.moving_per_100,
            "standing_per_100_scans": 100.0 * self.standing / max(self.scans, 1),
        }


def perceive(
    name: str,
    steps: Sequence[LogStep],
    folder: MapFolder,
    seed: int = 0,
    progress: Callable[[float], None] = lambda _: None,
) -> PerceiveResult:
    """Localize on a log and run the tracker by laser alone, as an agent does.

    A log's scans may be many seconds apart: they get times MIN_STEP_S apart, as a robot's have, so
    that an object at one place in three scans becomes a track. steps: at least one.
    Raises LogError if the first scan has no reference pose to start from.
    """
    first = steps[0].reference
    if first is None:
        raise LogError(f"{name}: its first scan has no reference pose to start from")
    localizer = Localizer(LocalizationSettings(), folder.map, np.random.default_rng(seed))
    localizer.start_at(first, 0.1, 0.05)
    settings = PerceptionSettings()
    tracker = TeammateTracker(
        settings, folder.map, Silhouettes.admitted(settings.silhouettes, _BODY)
    )
    scans = moving = standing = 0
    seen: set[int] = set()
    teammates: set[int] = set()
    for number, step in enumerate(steps):
        estimate = localizer.update(step.t, step.odometry, step.points)
        progress(number + 1)
        if estimate.health is not Health.LOCALIZED:
            continue
        t = number * MIN_STEP_S
        sigma = PoseSigma.of(estimate.covariance)
        tracker.update(t, estimate.pose, step.points, sigma=sigma)
        scans += 1
        for track in tracker.tracks:
            seen.add(track.id)
            if track.teammate:
                teammates.add(track.id)
            if track.last_seen == t:
                moving += track.moving
                standing += not track.moving
    return PerceiveResult(len(steps), scans, len(teammates), len(seen), moving, standing)
