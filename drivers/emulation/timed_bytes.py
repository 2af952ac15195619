"""Bytes with the time at which they were complete on a serial line."""

from __future__ import annotations

from dataclasses import dataclass


@dataclass(frozen=True, slots=True)
class TimedBytes:
    """Bytes sent by an emulated device; ``t`` is when the last of them has left the wire."""

    t: float
    data: bytes
