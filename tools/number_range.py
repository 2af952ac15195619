"""Numbers on the command line with their ranges: what is outside is one line, no traceback."""

from __future__ import annotations

import argparse
import math
from collections.abc import Callable

LARGEST = 1e12
MOST = 2**31


def whole(least: int = 0, most: int = MOST) -> Callable[[str], int]:
    """Return an argparse type of whole numbers from ``least`` to ``most``."""

    def parse(text: str) -> int:
        try:
            number = int(text)
        except ValueError:
            raise argparse.ArgumentTypeError(f"{text!r:.40} is no whole number") from None
        if not least <= number <= most:
            raise argparse.ArgumentTypeError(f"{text:.40} is not from {least} to {most}")
        return number

    return parse


def positive(text: str) -> float:
    """Parse a number above 0."""
    number = real(text)
    if number <= 0.0:
        raise argparse.ArgumentTypeError(f"{text:.40} is not above 0")
    return number


def not_negative(text: str) -> float:
    """Parse a number from 0 on."""
    number = real(text)
    if number < 0.0:
        raise argparse.ArgumentTypeError(f"{text:.40} is below 0")
    return number


def share(text: str) -> float:
    """Parse a share between 0 and 1, both left out."""
    number = positive(text)
    if number >= 1.0:
        raise argparse.ArgumentTypeError(f"{text:.40} is not below 1")
    return number


def real(text: str) -> float:
    """Parse a finite number."""
    try:
        number = float(text)
    except ValueError:
        raise argparse.ArgumentTypeError(f"{text!r:.40} is no number") from None
    if not (math.isfinite(number) and abs(number) <= LARGEST):
        raise argparse.ArgumentTypeError(f"{text:.40} is not within {LARGEST:g}")
    return number
