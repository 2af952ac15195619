"""Every key of the configuration with its default, unit and meaning, from the settings structs."""

from __future__ import annotations

from collections.abc import Iterator
from types import UnionType
from typing import Any, NamedTuple, get_args, get_type_hints

import msgspec

from robot_agent.config import AgentConfig

INTERNAL_SECTIONS = frozenset({"remembered", "base.model_file"})
"""Sections that the agent fills in for its recordings; not for configuration files."""


class Setting(NamedTuple):
    """One key of the configuration."""

    key: str
    """Dotted, e.g. ``base.max_speed``."""
    default: str
    """As TOML writes it, or ``required`` or ``unset``."""
    unit: str
    meaning: str
    """Empty if the struct does not describe it."""


def list_settings() -> list[Setting]:
    """Return every key that a configuration file may set, in the structs' order."""
    return list(_settings_of(AgentConfig, ""))


def format_settings(settings: list[Setting]) -> str:
    """Return settings as an aligned table with a heading, which ends with their number."""
    rows = [Setting("key", "default", "unit", "meaning"), *settings]
    widths = [max(len(row[column]) for row in rows) for column in range(3)]
    lines = ["  ".join((*map(str.ljust, row[:3], widths), row.meaning)).rstrip() for row in rows]
    return "\n".join((*lines, f"{len(settings)} settings"))


def _settings_of(shape: type[msgspec.Struct], place: str) -> Iterator[Setting]:
    hints = get_type_hints(shape, include_extras=True)
    for field in msgspec.structs.fields(shape):
        if place + field.name in INTERNAL_SECTIONS:
            continue
        hint = hints[field.name]
        section = _section_in(hint)
        if section is not None:
            yield from _settings_of(section, f"{place}{field.name}.")
            continue
        notes = _notes_in(hint)
        yield Setting(
            key=place + field.name,
            default=_default(field),
            unit=next((note.extra["unit"] for note in notes if note.extra), ""),
            meaning=next((note.description for note in notes if note.description), ""),
        )


def _section_in(hint: Any) -> type[msgspec.Struct] | None:
    """Return the settings struct in a field's type, also in ``Struct | None``; None without one."""
    choices = get_args(hint) if isinstance(hint, UnionType) else (hint,)
    for candidate in choices:
        if isinstance(candidate, type) and issubclass(candidate, msgspec.Struct):
            return candidate
    return None


def _notes_in(hint: Any) -> list[msgspec.Meta]:
    """Return the annotations of a field itself, the outermost last."""
    return [note for note in getattr(hint, "__metadata__", ()) if isinstance(note, msgspec.Meta)]


def _default(field: msgspec.structs.FieldInfo) -> str:
    if field.default is msgspec.NODEFAULT:
        return "required"
    if field.default is None:
        return "unset"
    return msgspec.json.encode(field.default).decode()
