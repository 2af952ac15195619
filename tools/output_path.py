"""Files and folders on the command line that a command writes: what cannot be written is one line
before the work, not after it. Missing folders are made when they are written to."""

from __future__ import annotations

import argparse
import os
from pathlib import Path


def output_file(text: str) -> Path:
    """Parse the path of a file to write; devices and pipes are files too."""
    path = Path(text)
    if path.is_dir():
        raise argparse.ArgumentTypeError(f"{text!r} is a folder: name a file in it")
    if not path.exists() or path.is_file():  # which is replaced, by one written beside it
        _require_room(path.parent)
    return path


def output_folder(text: str) -> Path:
    """Parse the path of a folder to write files to."""
    path = Path(text)
    _require_room(path)
    return path


def output_path(text: str) -> Path:
    """Parse the path of a file or a folder to write, where the suffix tells which."""
    path = Path(text)
    return output_folder(text) if path.is_dir() else output_file(text)


def _require_room(folder: Path) -> None:
    """Refuse a folder in which nothing can be made, itself included."""
    nearest = next(each for each in (folder, *folder.absolute().parents) if each.exists())
    if not nearest.is_dir():
        raise argparse.ArgumentTypeError(f"{str(nearest)!r} is no folder: give another path")
    if not os.access(nearest, os.W_OK | os.X_OK):
        raise argparse.ArgumentTypeError(f"{str(nearest)!r} cannot be written to: check its rights")
