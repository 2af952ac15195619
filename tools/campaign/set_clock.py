"""A program whose clock can be set while it runs, by libfaketime; its monotonic clock goes on."""

from __future__ import annotations

from pathlib import Path

from maps.whole_file import write_whole


def faketime_library() -> Path | None:
    """Return libfaketime for programs with threads; None: it is not installed."""
    return next(iter(sorted(Path("/usr/lib").glob("*/faketime/libfaketimeMT.so.1"))), None)


class SetClock:
    """The clock of the programs that get its ``environment``."""

    def __init__(self, library: Path, file: Path) -> None:
        """library: of ``faketime_library``; file: made, by which the programs learn the time."""
        self._file = file
        self.set("+0")
        self.environment = {
            "LD_PRELOAD": str(library),
            "FAKETIME_TIMESTAMP_FILE": str(file),
            "FAKETIME_NO_CACHE": "1",
            "FAKETIME_DONT_FAKE_MONOTONIC": "1",
        }

    def set(self, offset: str) -> None:
        """Set the clock off the real one, as libfaketime writes it: "+0", "+20y", "-30y"."""
        write_whole(self._file, f"{offset}\n")  # at once: the programs read it at any time
