from __future__ import annotations

from pathlib import Path

from drivers.adapter_name import persistent_name


def test_link_to_the_device_is_its_persistent_name(tmp_path: Path) -> None:
    by_id = tmp_path / "by-id"
    by_id.mkdir()
    for number in range(2):
        (tmp_path / f"ttyUSB{number}").touch()
        (by_id / f"usb-adapter-{number}").symlink_to(tmp_path / f"ttyUSB{number}")
    (by_id / "a-left-over").symlink_to(tmp_path / "ttyUSB7")
    assert persistent_name(str(tmp_path / "ttyUSB1"), by_id) == by_id / "usb-adapter-1"
    assert persistent_name(str(by_id / "usb-adapter-0"), by_id) == by_id / "usb-adapter-0"


def test_missing_link_folder_or_device_gives_none(tmp_path: Path) -> None:
    (tmp_path / "ttyS0").touch()
    assert persistent_name(str(tmp_path / "ttyS0"), tmp_path / "none") is None
    empty = tmp_path / "by-id"
    empty.mkdir()
    assert persistent_name(str(tmp_path / "ttyS0"), empty) is None
    assert persistent_name(str(tmp_path / "ttyS1"), empty) is None
    assert persistent_name("socket://127.0.0.1:8101", empty) is None
