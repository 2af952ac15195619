"""Serial ports read from a copy of the kernel's file tree, and the udev rules."""

from __future__ import annotations

import json
import os
import posixpath
import re
import shutil
import subprocess
from pathlib import Path
from types import SimpleNamespace
from typing import Any

import pytest
from serial.tools import list_ports_linux

from tools.cli import main
from tools.preflight.ports import KernelFiles, SerialPort, holders_of, list_serial_ports, udev_lines

RULES = Path(__file__).resolve().parents[3] / "tools" / "deploy" / "60-patrol.rules"
MATCH_KEYS = {"SUBSYSTEM", "KERNEL", "KERNELS", "ATTRS"}
ASSIGNMENT_KEYS = {"SYMLINK", "GROUP", "MODE", "ENV"}
PART = re.compile(r'([A-Z]+)(?:\{([^}]+)\})?(==|\+=|=)"([^"]*)"')


class RebasedPath:
    """``os.path`` for pyserial with the kernel's folders below another root."""

    def __init__(self, root: Path) -> None:
        self._root = root

    def __getattr__(self, name: str) -> Any:
        def call(path: str, *more: str) -> Any:
            inside = path.startswith(("/sys", "/dev"))
            return getattr(posixpath, name)(f"{self._root}{path}" if inside else path, *more)

        return call


@pytest.fixture
def files(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> KernelFiles:
    """Return the files of a machine without serial ports."""
    monkeypatch.setattr(list_ports_linux, "os", SimpleNamespace(path=RebasedPath(tmp_path)))
    files = KernelFiles(tmp_path / "sys", tmp_path / "dev", tmp_path / "proc")
    (files.sys / "class" / "tty").mkdir(parents=True)
    (files.dev / "serial" / "by-id").mkdir(parents=True)
    files.proc.mkdir()
    console = files.sys / "class" / "tty" / "tty0"
    console.mkdir()
    return files


def plug_in(files: KernelFiles, name: str, place: str, serial: str) -> None:
    """Plug a USB adapter into a socket."""
    usb = files.sys / "devices" / "usb1" / place
    port = usb / f"{place}:1.0" / name
    port.mkdir(parents=True)
    subsystem = files.sys / "bus" / "usb-serial"
    subsystem.mkdir(parents=True, exist_ok=True)
    (port / "subsystem").symlink_to(subsystem)
    for attribute, value in (
        ("idVendor", "0403"),
        ("idProduct", "6001"),
        ("serial", serial),
        ("bNumInterfaces", "1"),
    ):
        if value:
            (usb / attribute).write_text(f"{value}\n")
    (usb / "manufacturer").write_text("FTDI\n")
    (usb / "product").write_text("FT232R USB UART\n")
    driver = files.sys / "bus" / "ftdi_sio"
    driver.mkdir(parents=True, exist_ok=True)
    (port / "driver").symlink_to(driver)
    entry = files.sys / "class" / "tty" / name
    entry.mkdir()
    (entry / "device").symlink_to(port)
    (files.dev / name).touch()


def fit_uart(files: KernelFiles, name: str, kind: str, bus: str = "pnp") -> None:
    """Add a serial port number of the board; kind 0: without a chip."""
    chip = files.sys / "devices" / bus / f"00:{name}"
    chip.mkdir(parents=True)
    subsystem = files.sys / "bus" / bus
    subsystem.mkdir(parents=True, exist_ok=True)
    (chip / "subsystem").symlink_to(subsystem)
    entry = files.sys / "class" / "tty" / name
    entry.mkdir()
    (entry / "type").write_text(f"{kind}\n")
    (entry / "device").symlink_to(chip)
    (files.dev / name).touch()


def test_adapter_has_all_its_attributes(files: KernelFiles) -> None:
    plug_in(files, "ttyUSB0", "1-1.2", "A6008isP")
    (files.dev / "serial" / "by-id" / "usb-FTDI-if00").symlink_to(files.dev / "ttyUSB0")
    process = files.proc / "4711" / "fd"
    process.mkdir(parents=True)
    (process / "3").symlink_to(files.dev / "ttyUSB0")
    (files.proc / "4711" / "comm").write_text("patrol\n")

    (port,) = list_serial_ports(files)
    assert (port.device, port.driver) == (str(files.dev / "ttyUSB0"), "ftdi_sio")
    assert port.adapter == ("0403", "6001", "A6008isP")
    assert port.product == "FTDI FT232R USB UART"
    assert port.location == "1-1.2:1.0"
    assert port.by_id == str(files.dev / "serial" / "by-id" / "usb-FTDI-if00")
    assert port.holders == ("4711 patrol",)
    assert port.usable
    assert re.fullmatch(r"\S+:\S+ 0[0-7]{3}", port.owner)


def test_only_chips_that_exist_are_listed(files: KernelFiles) -> None:
    fit_uart(files, "ttyS0", "4")
    fit_uart(files, "ttyS1", "0")
    assert [Path(port.device).name for port in list_serial_ports(files)] == ["ttyS0"]


def test_chips_not_listed_by_pyserial_are_listed(files: KernelFiles) -> None:
    fit_uart(files, "ttyS2", "4", "platform")
    fit_uart(files, "ttyTHS1", "0x1", "serial")
    ports = list_serial_ports(files)
    assert [Path(port.device).name for port in ports] == ["ttyS2", "ttyTHS1"]
    assert [port.location for port in ports] == ["00:ttyS2", "00:ttyTHS1"]


def test_adapter_unplugged_meanwhile_has_no_usb_attributes(files: KernelFiles) -> None:
    plug_in(files, "ttyUSB0", "1-1.2", "A6008isP")
    (files.sys / "devices" / "usb1" / "1-1.2" / "bNumInterfaces").unlink()
    (port,) = list_serial_ports(files)
    assert (port.device, port.adapter) == (str(files.dev / "ttyUSB0"), ("", "", ""))


def test_machine_without_ports_has_an_empty_list(files: KernelFiles) -> None:
    assert list_serial_ports(files) == []


def test_own_process_is_no_holder_of_a_port(tmp_path: Path) -> None:
    device = tmp_path / "device"
    with device.open("w"):
        assert holders_of(device) == ()


def parts_of(line: str) -> list[tuple[str, str, str, str]]:
    """Return a rule line's parts (key, attribute, operator, value); fails on anything else."""
    parts = []
    for piece in line.split(", "):
        match = PART.fullmatch(piece)
        assert match, f"not a udev key: {piece}"
        parts.append((match[1], match[2] or "", match[3], match[4]))
    return parts


def check_rule(line: str) -> None:
    """Check that a rule line's matches can hold for one port, and that it names one role."""
    parts = parts_of(line)
    keys = [key for key, *_ in parts]
    assert set(keys) <= MATCH_KEYS | ASSIGNMENT_KEYS
    assert all((op == "==") == (key in MATCH_KEYS) for key, _, op, _ in parts)
    assert ("SUBSYSTEM", "", "==", "tty") in parts
    assert ("GROUP", "", "=", "dialout") in parts
    assert ("MODE", "", "=", "0660") in parts
    assert ("ENV", "ID_MM_DEVICE_IGNORE", "=", "1") in parts, "ModemManager would probe the robot"
    assert keys.count("SYMLINK") == 1
    assert ("SYMLINK", "+=") in {(key, op) for key, _, op, _ in parts}, "= would drop other links"
    # ATTRS and KERNELS of one line must hold for one and the same parent device.
    assert not {"ATTRS", "KERNELS"} <= set(keys)
    assert {"ATTRS", "KERNELS", "KERNEL"} & set(keys), "matches every serial port"


def test_shipped_rules_are_valid_and_name_both_roles() -> None:
    lines = [line.lstrip("#") for line in RULES.read_text().splitlines() if "SYMLINK" in line]
    roles = [part[3] for line in lines for part in parts_of(line) if part[0] == "SYMLINK"]
    assert roles == 3 * ["patrol/base", "patrol/laser"]
    for line in lines:
        check_rule(line)


def test_shipped_rules_pass_udevadm_verify() -> None:
    if shutil.which("udevadm") is None:
        pytest.skip("no udevadm on this machine")
    verify = ["udevadm", "verify", str(RULES)]
    result = subprocess.run(verify, capture_output=True, text=True, check=False)
    if "Unknown command" in result.stderr:
        pytest.skip("this udevadm is too old to verify rules")
    assert result.returncode == 0, result.stdout + result.stderr


def test_adapters_are_matched_by_serial_number(files: KernelFiles) -> None:
    plug_in(files, "ttyUSB0", "1-1.2", "A6008isP")
    plug_in(files, "ttyUSB1", "1-1.3", "A7004ulM")
    lines = udev_lines(list_serial_ports(files))
    assert 'ATTRS{serial}=="A6008isP"' in lines[0]
    assert 'ATTRS{serial}=="A7004ulM"' in lines[1]
    for line in lines:
        check_rule(line)


@pytest.mark.parametrize("serial", ["", "0001"])
def test_adapters_without_unique_serial_are_matched_by_socket(
    files: KernelFiles, serial: str
) -> None:
    plug_in(files, "ttyUSB0", "1-1.2", serial)
    plug_in(files, "ttyUSB1", "1-1.3", serial)
    lines = udev_lines(list_serial_ports(files))
    assert ['KERNELS=="1-1.2:1.0"' in lines[0], 'KERNELS=="1-1.3:1.0"' in lines[1]] == [True, True]
    for line in lines:
        check_rule(line)


def test_ports_of_one_adapter_are_matched_by_interface() -> None:
    ports = [
        SerialPort(
            device=f"/dev/ttyUSB{n}",
            vendor_id="0403",
            product_id="6010",
            serial="FT1",
            location=f"1-1:1.{n}",
        )
        for n in range(2)
    ]
    lines = udev_lines(ports)
    assert ['KERNELS=="1-1:1.0"' in lines[0], 'KERNELS=="1-1:1.1"' in lines[1]] == [True, True]


def test_board_port_is_matched_by_its_number(files: KernelFiles) -> None:
    fit_uart(files, "ttyS0", "4")
    (line,) = udev_lines(list_serial_ports(files))
    assert 'KERNEL=="ttyS0"' in line
    check_rule(line)


def test_command_prints_every_port_with_its_rule(capsys: pytest.CaptureFixture[str]) -> None:
    assert main(["ports", "--json"]) == 0
    rows = json.loads(capsys.readouterr().out)
    assert all({"device", "serial", "location", "udev"} <= row.keys() for row in rows)
    assert main(["ports"]) == 0
    text = capsys.readouterr().out
    assert all(row["device"] in text for row in rows)
    assert os.linesep.join(row["udev"] for row in rows[:1]) in text
