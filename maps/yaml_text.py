"""YAML files within their limits: whatever they hold, reading them ends soon with one error."""

from __future__ import annotations

from typing import Any

import yaml

from maps.input_limits import MAX_DEPTH, MAX_DESCRIPTION_BYTES
from maps.toml_text import plain_trouble


class YamlError(ValueError):
    """Bytes that are no YAML or exceed the limits; the message names line and reason."""


def read_yaml(data: bytes) -> Any:
    """Decode a YAML file's bytes; aliases, which can stand for more than memory holds, are refused.

    Raises YamlError.
    """
    if len(data) > MAX_DESCRIPTION_BYTES:
        raise YamlError(f"has {len(data)} bytes, more than {MAX_DESCRIPTION_BYTES}: shorten it")
    try:
        trouble = _first_trouble(data)
        content = None if trouble else yaml.safe_load(data)
    except (yaml.YAMLError, ValueError, RecursionError) as error:
        # ValueError: of UTF-8, of dates, and of integers of thousands of digits
        reason = plain_trouble(error) if isinstance(error, ValueError) else _one_line(error)
        raise YamlError(f"not YAML ({reason})") from None
    if trouble:
        raise YamlError(trouble)
    return content


def _one_line(error: Exception) -> str:
    return f"{' '.join(str(error).split()):.200}"


def _first_trouble(data: bytes) -> str:
    """Return the first place that would cost too much to construct; empty if there is none."""
    depth = 0
    for event in yaml.parse(data, Loader=yaml.SafeLoader):
        line = 0 if event.start_mark is None else event.start_mark.line + 1
        if isinstance(event, yaml.AliasEvent):
            return f"line {line}: has an alias, write out what it stands for"
        depth += isinstance(event, yaml.CollectionStartEvent)
        depth -= isinstance(event, yaml.CollectionEndEvent)
        if depth > MAX_DEPTH:
            return f"line {line}: is nested too deeply, correct it"
    return ""
