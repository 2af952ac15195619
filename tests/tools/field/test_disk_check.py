"""The file system of a disk, judged on small real ones."""

from __future__ import annotations

import subprocess
from pathlib import Path

import pytest

from tools.field.disk_check import examine_disk
from tools.field.needed_programs import missing_packages, with_sbin

pytestmark = pytest.mark.skipif(
    bool({"qemu-utils", "e2fsprogs"} & set(missing_packages())), reason="programs are not there"
)
BLOCK = 1024


def make_disk(folder: Path) -> Path:
    content = folder / "content"
    content.mkdir()
    (content / "file").write_text("recorded")
    disk = folder / "disk.raw"
    command = ["mke2fs", "-q", "-t", "ext4", "-b", str(BLOCK), "-d", content, disk, "8M"]
    subprocess.run(command, check=True, env=with_sbin(), stdout=subprocess.DEVNULL)
    return disk


def test_a_sound_disk_is_sound_and_the_copy_is_gone(tmp_path: Path) -> None:
    copy = tmp_path / "copy.raw"
    assert examine_disk(make_disk(tmp_path), copy) == ""
    assert not copy.exists()


def test_a_disk_without_its_tables_needs_a_person(tmp_path: Path) -> None:
    disk = make_disk(tmp_path)
    with disk.open("r+b") as file:  # all but the superblock
        file.seek(2 * BLOCK)
        file.write(b"\xff" * 300 * BLOCK)
    assert examine_disk(disk, tmp_path / "copy.raw").startswith("e2fsck")
