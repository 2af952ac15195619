"""The tracker alone on a log: a building without any robot of the team."""

from __future__ import annotations

from collections.abc import Callable, Sequence
from dataclasses import dataclass

import numpy as np

from localization.health import Health
from localization.localizer import Localizer
from localization.settings import LocalizationSettings
from maps.map_folder import MapFolder
from robot_agent.perception.pose_sigma import PoseSigma
from robot_agent.perception.settings import PerceptionSettings
from robot_agent.perception.tracker import TeammateTracker
from tools.logs.carmen import LogError
from tools.logs.log_step import LogStep

MIN_STEP_S = 0.1


@dataclass(frozen=True)
class PerceiveResult:
    """What the tracker made of a log, counted over the scans that were localized."""

    scans: int
    teammates: int
    """Tracks taken for a teammate at any time."""
    tracks: int
    """Confirmed tracks."""
    moving: int
    """Scans times confirmed tracks just seen that had moved."""
    standing: int
    """Scans times confirmed tracks just seen that had not."""

    @property
    def moving_per_100(self) -> float:
        """Moving segments in a hundred scans."""
        return 100.0 * self.moving / max(self.scans, 1)

    @property
    def summary(self) -> dict[str, float]:
        """The figures as JSON has them."""
        return {
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
    """Localize on a log and track who is there, by laser alone, as an agent would.

    A log's scans may be many seconds apart, where a robot's are a tenth: they are dated a tenth of
    a second apart, so that whatever stands at one place for three scans becomes a track.
    Raises LogError if the log has no reference pose to start from.
    """
    first = steps[0].reference
    if first is None:
        raise LogError(f"{name}: its first scan has no reference pose to start from")
    localizer = Localizer(LocalizationSettings(), folder.map, np.random.default_rng(seed))
    localizer.start_at(first, 0.1, 0.05)
    tracker = TeammateTracker(PerceptionSettings(), folder.map)
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
    return PerceiveResult(scans, len(teammates), len(seen), moving, standing)
