"""Numbers on the command line with their ranges: what is outside is one line, no traceback."""

from __future__ import annotations

import argparse
import math
from collections.abc import Callable

LARGEST = 1e12
MOST = 2**31


def whole(least: int = 0, most: int = MOST) -> Callable[[str], int]:
    """Return an argparse type of whole numbers from ``least`` to ``most``."""

    wanted = f"a whole number from {least} to {most}"

    def parse(text: str) -> int:
        try:
            number = int(text)
        except ValueError:
            raise _refused(text, "no whole number", wanted) from None
        if not least <= number <= most:
            raise _refused(text, "out of range", wanted)
        return number

    return parse


def positive(text: str) -> float:
    """Parse a number above 0."""
    number = real(text)
    if number <= 0.0:
        raise _refused(text, "out of range", "a number above 0")
    return number


def not_negative(text: str) -> float:
    """Parse a number from 0 on."""
    number = real(text)
    if number < 0.0:
        raise _refused(text, "out of range", "a number from 0 on")
    return number


def share(text: str) -> float:
    """Parse a share between 0 and 1, both left out."""
    number = real(text)
    if not 0.0 < number < 1.0:
        raise _refused(text, "out of range", "a number between 0 and 1")
    return number


def real(text: str) -> float:
    """Parse a finite number."""
    wanted = f"a number from {-LARGEST:g} to {LARGEST:g}"
    try:
        number = float(text)
    except ValueError:
        raise _refused(text, "no number", wanted) from None
    if not (math.isfinite(number) and abs(number) <= LARGEST):
        raise _refused(text, "out of range", wanted)
    return number


def _refused(text: str, why: str, wanted: str) -> argparse.ArgumentTypeError:
    """Return the error of a value, in whose words the parser names the option."""
    return argparse.ArgumentTypeError(f"{text!r:.40} is {why}: give {wanted}")
