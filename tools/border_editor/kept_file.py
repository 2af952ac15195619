"""Writes a file that people may have written before: what was there is kept beside it."""

from __future__ import annotations

from pathlib import Path

from maps.whole_file import write_whole


def write_kept(path: Path, text: str) -> None:
    """Write a text; another one that is there is kept as ``.before``. Raises OSError."""
    if path.exists() and (before := path.read_bytes()) != text.encode():
        write_whole(path.with_name(path.name + ".before"), before)
    write_whole(path, text)
