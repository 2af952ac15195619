"""Writes a file that people may have written before: what was there is kept beside it."""

from __future__ import annotations

from pathlib import Path


def write_kept(path: Path, text: str) -> None:
    """Write a text; another one that is there is kept as ``.before``. Raises OSError."""
    new = path.with_name(path.name + ".new")
    new.write_text(text, encoding="utf-8")
    if path.exists() and path.read_text(encoding="utf-8", errors="replace") != text:
        path.replace(path.with_name(path.name + ".before"))
    new.replace(path)
