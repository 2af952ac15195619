"""Reflecting tape round robots, as the beams of lasers meet it."""

from __future__ import annotations

from collections.abc import Sequence
from typing import NamedTuple

import numpy as np
from numpy.typing import NDArray

from tools.simulation.silhouette import Shapes
from tools.simulation.truth.robot_truth import TapeTruth

_ON = 1e-6  # m from a side at which a beam ends on it; rounding


class BeamEnds(NamedTuple):
    """Where n beams end: x and y, m, and the cosine and sine of their directions, map frame."""

    x: NDArray[np.float64]
    y: NDArray[np.float64]
    c: NDArray[np.float64]
    s: NDArray[np.float64]


def ends_on_tape(
    ends: BeamEnds,
    middles: NDArray[np.float64],
    shapes: Shapes,
    tapes: Sequence[TapeTruth | None],
    rng: np.random.Generator,
) -> NDArray[np.bool_]:
    """Return (n,) which beams return the light of a reflector.

    middles: (m, 3) places x, y, theta of the shapes. tapes: of each body, by the shapes' owner;
    None without. rng: of the beams that miss the tape.
    """
    found = np.zeros(len(ends.x), dtype=np.bool_)
    for row, owner in enumerate(shapes.owner.tolist()):
        tape = tapes[owner]
        if tape is None:
            continue
        facing = _facing(ends, middles[row], shapes.normals[row], shapes.offsets[row])
        met = np.flatnonzero(facing > np.cos(tape.facing))
        found[met] = rng.random(len(met)) >= tape.missed
    return found


def _facing(
    ends: BeamEnds,
    middle: NDArray[np.float64],
    normals: NDArray[np.float64],
    offsets: NDArray[np.float64],
) -> NDArray[np.float64]:
    """Return (n,) cosines of the angle between beams and the normal of the side they end on.

    -1 where they do not end on the polygon: middle (x, y, theta), normals (k, 2), offsets (k,).
    """
    x, y, theta = middle
    c, s = np.cos(theta), np.sin(theta)
    at = np.array((c * (ends.x - x) + s * (ends.y - y), c * (ends.y - y) - s * (ends.x - x)))
    along = np.array((c * ends.c + s * ends.s, c * ends.s - s * ends.c))
    beyond = normals @ at - offsets[:, None]
    side = beyond.argmax(axis=0)
    facing = -(normals[side].T * along).sum(axis=0)
    return np.where(np.abs(beyond.max(axis=0)) < _ON, facing, -1.0)
