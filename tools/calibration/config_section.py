"""Changes sections of a robot's TOML file and leaves the rest, comments and all, as it is."""

from __future__ import annotations

import re
from collections.abc import Mapping
from pathlib import Path
from typing import Any

import tomli_w

from robot_agent.config import parse_config


def set_keys(path: Path, section: str, values: Mapping[str, Any]) -> None:
    """Set keys of a section, e.g. ``perception.color.band``; both may be new, the file too.

    Raises ConfigError if the file would not be a configuration afterwards; it is untouched then.
    """
    text = path.read_text() if path.exists() else ""
    changed = with_keys(text, section, values)
    parse_config(changed.encode(), str(path))
    path.write_text(changed)


def with_keys(text: str, section: str, values: Mapping[str, Any]) -> str:
    """Return TOML text with keys of a section set."""
    header = f"[{section}]"
    before, found, rest = _split_at(text, header)
    if not found:
        lead = text if not text or text.endswith("\n") else text + "\n"
        gap = "\n" if lead else ""
        return f"{lead}{gap}{header}\n{tomli_w.dumps(dict(values))}"
    following = re.search(r"^\s*\[", rest, flags=re.MULTILINE)
    end = following.start() if following else len(rest)
    body, after = rest[:end], rest[end:]
    for key in values:
        body = re.sub(rf"^{key}\s*=\s*(\[[^\]]*\]|[^\n]*)\n?", "", body, flags=re.MULTILINE)
    return f"{before}{header}\n{tomli_w.dumps(dict(values))}{body.lstrip(chr(10))}{after}"


def _split_at(text: str, header: str) -> tuple[str, bool, str]:
    match = re.search(rf"^{re.escape(header)}[^\n]*\n?", text, flags=re.MULTILINE)
    if match is None:
        return text, False, ""
    return text[: match.start()], True, text[match.end() :]
