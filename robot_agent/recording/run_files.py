"""The files that a robot's runs are recorded to."""

from __future__ import annotations

import datetime
import re
from pathlib import Path
from typing import BinaryIO, Protocol

from robot_agent.recording.run_counter import next_number


class RecordingExistsError(ValueError):
    """A recording would be overwritten; the message names file and remedy."""


class RunFiles(Protocol):
    """Where a recorder puts its files, each opened once and never overwritten."""

    path: Path
    """The file in use; before the first one, where it will be."""

    def open_next(self) -> BinaryIO:
        """Create a new file and its folder; raises OSError."""

    def older(self) -> list[Path]:
        """Return the runs beside ``path`` that may be deleted, the oldest first."""


class OneFile:
    """A file of the user's choice; its continuation after an error of the disk is beside it.

    The continuations of ``run.mcap`` are ``run.2.mcap``, ``run.3.mcap`` and so on.
    """

    def __init__(self, path: Path) -> None:
        self.path = path
        self._first = path
        self._parts = 0

    def open_next(self) -> BinaryIO:
        """Create the file, or a continuation; raises OSError."""
        path = self._first
        if self._parts:
            path = path.with_name(f"{path.stem}.{self._parts + 1}{path.suffix}")
        path.parent.mkdir(parents=True, exist_ok=True)
        file = path.open("wb" if _is_device(path) else "xb")
        if not _is_device(path):
            self._parts += 1
        self.path = path
        return file

    def older(self) -> list[Path]:
        """Return nothing: what the user named is the user's."""
        return []


class NumberedRuns:
    """A robot's runs in the recorder's folder: ``<robot>-<number>-<UTC time>.mcap``.

    Names sort by the number, which counts the starts of the agent; the time is a label.
    """

    def __init__(self, folder: Path, robot: str) -> None:
        self.path = folder
        self._folder = folder
        self._robot = robot
        # Files of earlier versions have no number: they are older than any that has one.
        self._name = re.compile(rf"{re.escape(robot)}-(?:(\d{{6,}})-)?\d{{8}}T\d{{6}}Z\.mcap")

    def open_next(self) -> BinaryIO:
        """Create the file of the next number; raises OSError."""
        self._folder.mkdir(parents=True, exist_ok=True)
        used = max((number for number, _name in self._runs()), default=0)
        number = next_number(self._folder / f"{self._robot}.counter", used)
        stamp = datetime.datetime.now(datetime.UTC).strftime("%Y%m%dT%H%M%SZ")
        path = self._folder / f"{self._robot}-{number:06d}-{stamp}.mcap"
        file = path.open("xb")
        self.path = path
        return file

    def older(self) -> list[Path]:
        """Return the robot's other runs in the folder, by number."""
        runs = [self._folder / name for _number, name in sorted(self._runs())]
        return [path for path in runs if path != self.path]

    def _runs(self) -> list[tuple[int, str]]:
        """Return number, 0 for none, and name of each run of the robot in the folder."""
        names = (path.name for path in self._folder.iterdir())
        matches = filter(None, map(self._name.fullmatch, names))
        return [(int(match[1] or 0), match[0]) for match in matches]


def refuse_existing(path: Path) -> None:
    """Raise RecordingExistsError if a file would be overwritten; devices and pipes are not."""
    if path.exists() and not _is_device(path):
        raise RecordingExistsError(
            f"{path} exists, and recordings are never overwritten; give another name or move it"
        )


def _is_device(path: Path) -> bool:
    return path.exists() and not path.is_file()
