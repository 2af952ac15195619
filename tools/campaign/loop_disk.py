"""A small disk of its own for a robot's files, which can be made to hang.

A frozen file system takes no write and answers none until it is thawed, as a disk does whose
controller or cable fails. It is a file mounted as a loop device: that needs root.
"""

from __future__ import annotations

import subprocess
from contextlib import suppress
from pathlib import Path

SIZE_BYTES = 1024 * 2**20
"""Above what the recorder leaves free; the file is sparse."""


class NotHereError(RuntimeError):
    """A fault that this machine or user cannot make; the message says why."""


class LoopDisk:
    """A mounted file system in a folder; ``close`` unmounts it, thawed."""

    def __init__(self, folder: Path) -> None:
        """Make the file system; raises NotHereError where that is not possible."""
        self.folder = folder / "disk"
        image = folder / "disk.img"
        self.folder.mkdir()
        with image.open("wb") as file:
            file.truncate(SIZE_BYTES)
        self._do("mkfs.ext4", "-q", str(image))
        self._do("mount", "-o", "loop", str(image), str(self.folder))

    def freeze(self) -> None:
        """Let every write wait from now on."""
        self._do("fsfreeze", "--freeze", str(self.folder))

    def thaw(self) -> None:
        """Let the writes that wait go on."""
        self._do("fsfreeze", "--unfreeze", str(self.folder))

    def close(self) -> None:
        """Unmount it; what still has a file open keeps it until then."""
        with suppress(NotHereError):
            self.thaw()
        with suppress(NotHereError):
            self._do("umount", "--lazy", str(self.folder))

    def _do(self, *command: str) -> None:
        try:
            done = subprocess.run(command, capture_output=True, text=True, check=False)
        except OSError as error:
            raise NotHereError(f"{command[0]}: {error.strerror}") from error
        if done.returncode:
            raise NotHereError(f"{command[0]}: {done.stderr.strip()}; it needs root")
