"""Reading a recording's configuration, also one of an earlier version of the program."""

from __future__ import annotations

import tomllib
from typing import Any, get_args, get_type_hints

import msgspec
import tomli_w

from maps.toml_text import TomlError, read_toml
from robot_agent.config import (
    FIXED_KEYS,
    RENAMED_KEYS,
    AgentConfig,
    ConfigError,
    parse_config,
)
from robot_agent.patrol.settings import EVEN_GAPS, PAPER_STRATEGY
from tools.logs.recording import Recording

BODY_KEY = "gate.front"
"""In every configuration of the versions in which base.model was only a fallback."""


def recorded_config(recording: Recording) -> tuple[AgentConfig, list[str]]:
    """Return a recording's configuration and the names of settings left out as obsolete.

    Raises ConfigError for an invalid configuration.
    """
    return parse_old_config(recording.header.configuration, f"{recording.path} (configuration)")


def parse_old_config(content: bytes, source: str) -> tuple[AgentConfig, list[str]]:
    """Decode a configuration of any version: renames old keys, leaves out obsolete ones.

    Returns the names of those left out, except if their value is the present constant.
    """
    table, left_out = _upgraded(content, source)
    return parse_config(tomli_w.dumps(table).encode(), source), left_out


def _upgraded(content: bytes, source: str) -> tuple[dict[str, Any], list[str]]:
    try:
        table = read_toml(content)
    except TomlError as error:
        raise ConfigError(f"{source}: is not TOML: {error}; the recording is damaged") from error
    left_out: list[str] = []
    strategy = _lookup(table, "patrol.strategy")  # "paper", or what is a modifier now
    if strategy is not None:
        added = [EVEN_GAPS] if strategy == EVEN_GAPS else []
        _set(table, "patrol.modifiers", [*PAPER_STRATEGY, *added])
        _remove(table, "patrol.strategy")
    if _lookup(table, BODY_KEY) is not None and _lookup(table, "base.model") is not None:
        _remove(table, "base.model")  # what the robot reported was driven by its own model then
    for key in [key for key in RENAMED_KEYS if _lookup(table, key) is not None]:
        _set(table, RENAMED_KEYS[key], _lookup(table, key))
        _remove(table, key)
    for key, constant in FIXED_KEYS.items():
        value = _lookup(table, key)
        if value is None:
            continue
        if value != constant:
            left_out.append(key)
        _remove(table, key)
    return _known(table, AgentConfig, "", left_out), left_out


def changed_config(content: bytes, source: str, changes: list[str]) -> AgentConfig:
    """Return a configuration with ``section.key=value`` changes, each value in TOML syntax.

    Raises ConfigError naming the change.
    """
    table, _left_out = _upgraded(content, source)
    for change in changes:
        _apply(table, change)
    return parse_config(tomli_w.dumps(table).encode(), f"{source} with {', '.join(changes)}")


def _apply(table: dict[str, Any], change: str) -> None:
    key, equals, text = change.partition("=")
    *sections, name = key.strip().split(".")
    if not equals or not sections or not name:
        raise ConfigError(f"--set {change}: is not SECTION.KEY=VALUE; e.g. gate.max_speed=0.2")
    try:
        value = tomllib.loads(f"value = {text}")["value"]
    except tomllib.TOMLDecodeError:
        value = text  # a string may lack quotes
    for section in sections:
        table = table.setdefault(section, {})
        if not isinstance(table, dict):
            raise ConfigError(
                f"--set {change}: {section} is no section; see `patrol agent --list-settings`"
            )
    table[name] = value


def _lookup(table: dict[str, Any], key: str) -> Any:
    """Return the value of a dotted key; None if it is missing."""
    value: Any = table
    for name in key.split("."):
        value = value.get(name) if isinstance(value, dict) else None
    return value


def _set(table: dict[str, Any], key: str, value: Any) -> None:
    *sections, name = key.split(".")
    for section in sections:
        table = table.setdefault(section, {})
    table[name] = value


def _remove(table: dict[str, Any], key: str) -> None:
    """Remove an existing dotted key, and its section if that becomes empty."""
    section, _, name = key.rpartition(".")
    rest = _lookup(table, section) if section else table
    del rest[name]
    if not rest and section:
        _remove(table, section)


def _known(
    table: dict[str, Any], shape: type[msgspec.Struct], place: str, left_out: list[str]
) -> dict[str, Any]:
    """Return the part of a table for which a settings struct has fields."""
    hints = get_type_hints(shape)
    tag_field = shape.__struct_config__.tag_field
    kept: dict[str, Any] = {}
    for key, value in table.items():
        if key == tag_field:
            kept[key] = value
            continue
        if key not in hints:
            left_out.append(place + key)
            continue
        inner = _struct_of(hints[key], value)
        if inner is not None and isinstance(value, dict):
            kept[key] = _known(value, inner, f"{place}{key}.", left_out)
        else:
            kept[key] = value
    return kept


def _struct_of(hint: Any, value: Any) -> type[msgspec.Struct] | None:
    """Return the settings struct of a field's type, None if it is none.

    Of several, told apart by a tag in their tables, the one of ``value``, by default the first.
    """
    structs = [
        candidate
        for candidate in (hint, *get_args(hint))
        if isinstance(candidate, type) and issubclass(candidate, msgspec.Struct)
    ]
    for struct in structs:
        config = struct.__struct_config__
        if isinstance(value, dict) and value.get(config.tag_field) == config.tag:
            return struct
    return structs[0] if structs else None
