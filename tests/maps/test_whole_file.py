"""Files written whole or not at all."""

from __future__ import annotations

import errno
import os
from pathlib import Path

import pytest

from maps.whole_file import whole_file, write_whole


def write_half(path: Path, error: BaseException) -> None:
    with whole_file(path) as part:
        part.write_text("aft")
        raise error


def test_file_is_replaced_at_the_end_and_keeps_its_mode(tmp_path: Path) -> None:
    path = tmp_path / "a.csv"
    path.write_text("before")
    path.chmod(0o640)
    with whole_file(path) as part:
        part.write_text("after")
        assert (part.parent, part.suffix) == (tmp_path, ".csv")
        assert path.read_text() == "before"
    assert path.read_text() == "after"
    assert path.stat().st_mode & 0o777 == 0o640
    assert list(tmp_path.iterdir()) == [path]


@pytest.mark.skipif(os.geteuid() != 0, reason="needs root: gives a file to somebody else")
def test_owner_is_kept(tmp_path: Path) -> None:
    path = tmp_path / "key.pem"
    path.write_text("before")
    path.chmod(0o600)
    os.chown(path, 12345, 23456)
    write_whole(path, "after")
    kept = path.stat()
    assert (kept.st_uid, kept.st_gid, kept.st_mode & 0o777) == (12345, 23456, 0o600)


def test_error_leaves_what_was_there_and_nothing_beside(tmp_path: Path) -> None:
    path = tmp_path / "a.csv"
    path.write_text("before")
    with pytest.raises(OSError, match="No space") as raised:
        write_half(path, OSError(errno.ENOSPC, os.strerror(errno.ENOSPC)))
    assert raised.value.filename == str(path)
    assert path.read_text() == "before"
    assert list(tmp_path.iterdir()) == [path]


def test_interruption_leaves_no_half_file(tmp_path: Path) -> None:
    with pytest.raises(KeyboardInterrupt):
        write_half(tmp_path / "a.csv", KeyboardInterrupt())
    assert list(tmp_path.iterdir()) == []


def test_link_stays_one(tmp_path: Path) -> None:
    (tmp_path / "real").mkdir()
    (tmp_path / "real" / "a").write_text("before")
    (tmp_path / "link").symlink_to(tmp_path / "real" / "a")
    write_whole(tmp_path / "link", b"after")
    assert (tmp_path / "link").is_symlink()
    assert (tmp_path / "real" / "a").read_text() == "after"


def test_device_is_written_to_itself() -> None:
    write_whole(Path(os.devnull), "words")
    with pytest.raises(OSError, match="No space") as raised:
        write_whole(Path("/dev/full"), "words")
    assert raised.value.filename == "/dev/full"


def test_error_of_another_file_keeps_its_name(tmp_path: Path) -> None:
    with pytest.raises(OSError, match="gone") as raised, whole_file(tmp_path / "a") as part:
        part.write_bytes((tmp_path / "gone").read_bytes())
    assert raised.value.filename == str(tmp_path / "gone")


def test_missing_folders_are_made(tmp_path: Path) -> None:
    path = tmp_path / "no" / "nor this" / "a.txt"
    write_whole(path, "words")
    assert path.read_text() == "words"


def test_file_in_the_place_of_a_folder_is_an_error_that_names_it(tmp_path: Path) -> None:
    (tmp_path / "no").write_text("kept")
    with pytest.raises(OSError, match=r"exists|[Nn]ot a directory") as raised:
        write_whole(tmp_path / "no" / "a.txt", "words")
    assert raised.value.filename == str(tmp_path / "no")
