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
        sections = _sections_in(hint)
        if sections:
            yield from _settings_of_kinds(sections, f"{place}{field.name}.")
            continue
        notes = _notes_in(hint)
        yield Setting(
            key=place + field.name,
            default=_default(field),
            unit=next((note.extra["unit"] for note in notes if note.extra), ""),
            meaning=next((note.description for note in notes if note.description), ""),
        )


def _settings_of_kinds(sections: list[type[msgspec.Struct]], place: str) -> Iterator[Setting]:
    """Yield the settings of a section, which may be of several kinds: each key once."""
    first, *others = sections
    if not others:
        yield from _settings_of(first, place)
        return
    config = first.__struct_config__
    kinds = [str(section.__struct_config__.tag) for section in sections]
    yield Setting(f"{place}{config.tag_field}", f'"{kinds[0]}"', "", " or ".join(kinds))
    listed = {setting.key: setting for setting in _settings_of(first, place)}
    for section, kind in zip(others, kinds[1:], strict=True):
        for setting in _settings_of(section, place):
            known = listed.get(setting.key)
            if known is None:
                listed[setting.key] = setting._replace(meaning=f"{kind}: {setting.meaning}")
            else:
                listed[setting.key] = known._replace(meaning=_joined(known, setting, kind))
    yield from listed.values()


def _joined(known: Setting, other: Setting, kind: str) -> str:
    """Return the meaning of a key with what is different in another kind of its section."""
    different = [other.default] if other.default != known.default else []
    if other.meaning != known.meaning:
        different.append(other.meaning)
    return f"{known.meaning}; {kind}: {', '.join(different)}" if different else known.meaning


def _sections_in(hint: Any) -> list[type[msgspec.Struct]]:
    """Return the settings structs in a field's type, also in ``Struct | None``; [] without one."""
    choices = get_args(hint) if isinstance(hint, UnionType) else (hint,)
    return [
        candidate
        for candidate in choices
        if isinstance(candidate, type) and issubclass(candidate, msgspec.Struct)
    ]


def _notes_in(hint: Any) -> list[msgspec.Meta]:
    """Return the annotations of a field itself, the outermost last."""
    return [note for note in getattr(hint, "__metadata__", ()) if isinstance(note, msgspec.Meta)]


def _default(field: msgspec.structs.FieldInfo) -> str:
    if field.default is msgspec.NODEFAULT:
        return "required"
    if field.default is None:
        return "unset"
    return msgspec.json.encode(field.default).decode()
