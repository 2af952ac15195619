"""Files that are written whole or not at all: what was there stays until the new one is complete.

A full disk, a kill or an error in between leaves the former file, or none.
"""

from __future__ import annotations

import os
import shutil
from collections.abc import Iterator
from contextlib import contextmanager, suppress
from pathlib import Path


@contextmanager
def whole_file(path: Path) -> Iterator[Path]:
    """Yield the path to write to instead of ``path``, which it replaces at the end of the block.

    It lies in the same folder, which is made if missing, and has the same suffix; an existing
    file's mode and owner are kept. What is no file, as a device or a pipe, is written to itself.
    Raises OSError, which names ``path`` or its folder; a block that raises leaves ``path`` as it
    was.
    """
    target = path.resolve()  # a link stays one
    part = target.with_name(f".{target.stem}.part{target.suffix}")
    try:
        if path.is_relative_to("/dev") or (path.exists() and not path.is_file()):
            yield path
            return
        part.parent.mkdir(parents=True, exist_ok=True)
        part.unlink(missing_ok=True)  # of a process that was killed
        try:
            yield part
            _sync(part)
            if target.exists():
                _be_as(target, part)
            part.replace(target)
        finally:
            part.unlink(missing_ok=True)
    except OSError as error:
        if error.filename in (None, str(part)):
            error.filename = str(path)
        raise


def write_whole(path: Path, content: bytes | str) -> None:
    """Write a file's content, text as UTF-8, as ``whole_file`` does; raises OSError."""
    data = content.encode() if isinstance(content, str) else content
    with whole_file(path) as part:
        part.write_bytes(data)


def _be_as(target: Path, part: Path) -> None:
    """Give a file the owner of another one, as far as this process may, and its mode."""
    owner = target.stat()
    with suppress(PermissionError):
        os.chown(part, owner.st_uid, owner.st_gid)
    shutil.copymode(target, part)


def _sync(path: Path) -> None:
    """Wait until a file is on the disk: else a power cut may leave an empty one."""
    descriptor = os.open(path, os.O_RDONLY)
    try:
        os.fsync(descriptor)
    finally:
        os.close(descriptor)
