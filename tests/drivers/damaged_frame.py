"""Damage to the frames of a protocol, for fuzzed streams."""

from __future__ import annotations

from collections.abc import Callable

import numpy as np


def mutated(
    frame: bytes, rng: np.random.Generator, frame_start: Callable[[np.random.Generator], bytes]
) -> bytes:
    """Return a frame with bytes changed, lost, added or repeated, or with a frame's start in it.

    frame_start: draws the first bytes of a frame that never comes.
    """
    data = bytearray(frame)
    at = int(rng.integers(len(data)))
    match int(rng.integers(7)):
        case 0:
            data[at] ^= 1 << int(rng.integers(8))
        case 1:
            data[at] = int(rng.integers(256))
        case 2:
            del data[at]
        case 3:
            del data[at:]
        case 4:
            data[at:at] = rng.bytes(int(rng.integers(1, 20)))
        case 5:
            data[at:at] = frame_start(rng)
        case _:
            data[at:at] = data[: int(rng.integers(len(data)))]
    return bytes(data)
