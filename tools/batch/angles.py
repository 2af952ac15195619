"""Angles wrapped as ``math.remainder`` wraps them, bit for bit, for angles of less than 3 pi."""

from __future__ import annotations

import math

import numpy as np

from tools.batch.arrays import Reals


def remainders(angle: Reals) -> Reals:
    """Return angles, rad, in [-pi, pi], as ``math.remainder(angle, math.tau)``."""
    turned = np.where(angle > math.pi, angle - math.tau, angle)
    return np.where(angle < -math.pi, angle + math.tau, turned)


def wrapped(angle: Reals) -> Reals:
    """Return angles, rad, in (-pi, pi], as ``wrap_angle``."""
    inside = remainders(angle)
    return np.where(inside == -math.pi, math.pi, inside)
