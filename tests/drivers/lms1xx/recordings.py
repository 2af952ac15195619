"""Recorded byte streams of real scanners, with what is stated of them."""

from __future__ import annotations

import gzip
import json
from dataclasses import dataclass
from pathlib import Path

import pytest


@dataclass(frozen=True)
class Device:
    """A recording and the values that its README states. Angles: deg, ranges: mm."""

    name: str
    serial: int
    scans: int
    first: float
    step: float
    values: int
    rate: float
    lowest: int
    median: int
    highest: int
    first_three: tuple[int, ...]
    last_three: tuple[int, ...]


DEVICES = (
    Device(
        *("lms111", 18090362, 175, -45.0, 0.5, 541, 50.0, 77, 889, 1817),
        (93, 80, 86),
        (90, 80, 77),
    ),
    Device(
        *("lms511", 18110550, 174, -5.0, 0.1667, 1141, 25.0, 427, 1164, 2912),
        (1305, 1299, 1307),
        (626, 623, 624),
    ),
    Device(
        *("tim781s", 18480390, 140, -45.0, 0.3333, 811, 15.0, 302, 1119, 2960),
        (1356, 1382, 1435),
        (669, 662, 662),
    ),
)


def recorded(data_folder: Path, name: str, direction: str) -> list[tuple[float, bytes]]:
    """Return times, s, and bytes of one direction, ``laser->host`` or ``host->laser``."""
    file = data_folder / "sick" / f"{name}.jsonl.gz"
    if not file.is_file():
        pytest.skip(f"no recording of a real scanner at {file}: set PATROL_DATA to its folder")
    with gzip.open(file, "rt") as lines:
        items = [json.loads(line) for line in lines]
    return [(item["t"], bytes.fromhex(item["hex"])) for item in items if item["dir"] == direction]
