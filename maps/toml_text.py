"""TOML files within their limits: whatever they hold, reading them ends soon with one error."""

from __future__ import annotations

import tomllib
from collections.abc import Iterator
from typing import Any

from maps.input_limits import MAX_DESCRIPTION_BYTES, MAX_NUMBER_TEXT


class TomlError(ValueError):
    """Bytes that are no TOML or exceed the limits; the message names the reason."""


def read_toml(data: bytes) -> dict[str, Any]:
    """Decode a TOML file's bytes, with or without the mark that Windows' editors write.

    Raises TomlError.
    """
    if len(data) > MAX_DESCRIPTION_BYTES:
        raise TomlError(f"has {len(data)} bytes, more than {MAX_DESCRIPTION_BYTES}: shorten it")
    try:
        table = tomllib.loads(data.decode("utf-8-sig"))
        _check_integers(table)
    except RecursionError:
        raise TomlError("is nested too deeply, flatten it") from None
    except ValueError as error:  # also of UTF-8, and of integers of thousands of digits
        raise TomlError(plain_trouble(error)) from error
    return table


def plain_trouble(error: ValueError) -> str:
    """Return in one line why a text cannot be decoded."""
    if "digits" in str(error):
        return "holds a number of thousands of digits, correct it"
    return f"{' '.join(str(error).split()):.200}"


def leaves(value: Any, place: str = "") -> Iterator[tuple[str, Any]]:
    """Yield all values in tables and lists, at any depth, with the dotted keys of their tables."""
    if isinstance(value, dict):
        for name, part in value.items():
            yield from leaves(part, f"{place}.{name}" if place else name)
    elif isinstance(value, list | tuple):
        for part in value:
            yield from leaves(part, place)
    else:
        yield place, value


def _check_integers(table: dict[str, Any]) -> None:
    """Raise TomlError for an integer that no float holds, at any depth."""
    for _place, value in leaves(table):
        if isinstance(value, int) and abs(value) > MAX_NUMBER_TEXT:
            raise TomlError(f"holds a number of {len(str(abs(value)))} digits, correct it")
