"""Changes sections of a robot's TOML file and keeps the rest, with its comments."""

from __future__ import annotations

import tomllib
from collections.abc import Callable, Mapping
from pathlib import Path
from typing import Any

import tomlkit
from tomlkit.exceptions import TOMLKitError
from tomlkit.items import Item, Table

from maps.whole_file import write_whole
from robot_agent.config import ConfigError, parse_config


def set_keys(path: Path, section: str, values: Mapping[str, Any]) -> None:
    """Set keys of a section, e.g. ``perception.color.band``; file, section and keys may be new.

    The file is replaced atomically. Raises ConfigError, leaving the file unchanged, if it cannot be
    read or written, is no valid configuration or would not be one afterwards.
    """
    try:
        content = require_config(path)
        changed = with_keys(content.decode(), section, values).encode()
        parse_config(changed, str(path))
        write_whole(path, changed)
    except OSError as error:
        raise ConfigError(
            f"{path}: cannot be changed ({error.strerror}); make file and folder writable"
        ) from error
    except UnplacedError as error:
        raise ConfigError(f"{path}: [{section}]: {error}") from error


def require_config(path: Path) -> bytes:
    """Return a configuration's content, empty for a new file.

    Raises ConfigError for an invalid one, OSError for one that cannot be read.
    """
    content = path.read_bytes() if path.exists() else b""
    parse_config(content, str(path))
    return content


class UnplacedError(ValueError):
    """Keys cannot be written into a TOML text; the message holds the lines to write by hand."""


def with_keys(text: str, section: str, values: Mapping[str, Any]) -> str:
    """Return valid TOML text with keys of a section set, in whatever syntax the section is.

    A missing section is added with its own header, or as an inline table where its parent is one or
    is written by dotted keys. Raises UnplacedError if neither gives the wanted content.
    """
    wanted = _merged(tomllib.loads(text), section, values)
    if text and not text.endswith("\n"):
        text += "\n"
    for new_table in (tomlkit.table, tomlkit.inline_table):
        try:
            changed = _edited(text, section, values, new_table)
            if tomllib.loads(changed) == wanted:
                # tomlkit ends added lines by LF.
                return changed.replace("\r\n", "\n").replace("\n", _line_end(text))
        except (TOMLKitError, ValueError):
            continue
    lines = "; ".join(f"{key} = {value}" for key, value in values.items())
    raise UnplacedError(f"cannot be written there, write it by hand: {lines}")


def _merged(content: dict[str, Any], section: str, values: Mapping[str, Any]) -> dict[str, Any]:
    table = content
    for name in section.split("."):
        table = table.setdefault(name, {})
    table.update(values)
    return content


def _edited(
    text: str, section: str, values: Mapping[str, Any], new_table: Callable[[], Item]
) -> str:
    document = tomlkit.parse(text)
    table: Any = document
    for name in section.split("."):
        if name not in table:
            table[name] = new_table()
        table = table[name]
    # Comments at the end of a section belong to the next one: new keys go before them.
    notes = _pop_trailing_comments(table) if isinstance(table, Table) else []
    for key, value in values.items():
        table[key] = value
    for note in notes:
        table.add(note)
    return tomlkit.dumps(document)


def _pop_trailing_comments(table: Table) -> list[Any]:
    """Remove the blank lines and comments after a table's last key; return them."""
    body = table.value.body
    end = len(body)
    while end and body[end - 1][0] is None:
        end -= 1
    notes = [item for _, item in body[end:]]
    del body[end:]
    return notes


def _line_end(text: str) -> str:
    return "\r\n" if "\r\n" in text else "\n"
