"""The intruder who knows all robots' states and must strike now: by rollouts of the decision layer.

He knows where every robot is, what it remembers and when it will next think of turning back, but
not what chance will decide. The state of a run is copied, each copy goes on with chances of its
own, and he chooses the place that is visited in the fewest futures.
"""

from __future__ import annotations

import math

import numpy as np

from tools.batch.arrays import Reals
from tools.batch.batch import Batch
from tools.metrics.border_visits import BESIDE_WRECK, NearPlaces, visited_places
from tools.metrics.intruder_exposure import DWELL_S, least_detection

ROLLOUTS = 32
"""Futures of each moment: its probability is known to about 0.09, the mean of 100 to 0.009."""
_SAMPLE_STEPS = 2
"""Steps between two looks at who is where: 0.07 m of the patrol."""


def detections(batch: Batch, rollouts: int = ROLLOUTS) -> list[dict[str, float]]:
    """Return for each run of a batch, as it is now, the probabilities of detection by dwell time.

    The batch stays as it is.
    """
    assert batch.folder.border is not None
    places = visited_places(batch.folder.border)
    first = _first_visits(batch.branched(rollouts, seed=round(10.0 * batch.t)), places)
    found = []
    for run in range(len(batch.seeds)):
        kept = np.ones(len(places), dtype=np.bool_)
        for wreck in batch.wrecks(run):
            kept &= np.hypot(*(places - wreck[:2]).T) > BESIDE_WRECK
        own = first[run * rollouts : (run + 1) * rollouts, kept]
        found.append({f"{dwell:g}": least_detection(own, dwell) for dwell in DWELL_S})
    return found


def _first_visits(future: Batch, places: Reals) -> Reals:
    """Run all futures for the longest dwell time; return (futures, places) s to the first visit."""
    assert future.folder.border is not None
    near = NearPlaces(future.folder.border, places)
    begun = future.t
    first = np.full((len(future.seeds), len(places)), math.inf)
    while True:
        made, elapsed = future.decisions, future.t - begun
        assert made is not None, "the batch has taken a step"
        position = np.column_stack((future.bodies.x, future.bodies.y))
        robot, place = near.visited(position, made.abscissa, made.distance)
        run = robot // future.robots
        first[run, place] = np.minimum(first[run, place], elapsed)
        if elapsed >= max(DWELL_S):
            return first
        for _ in range(_SAMPLE_STEPS):
            future.step()
