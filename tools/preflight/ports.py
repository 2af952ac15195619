"""Serial ports of this machine: attributes for udev rules, permissions, processes using them.

USB attributes come from pyserial's list_ports. The list of ports, permissions and users come from
the kernel's files (``/sys``, ``/dev``, ``/proc``): pyserial lists numbers without a chip behind
them and leaves out names it does not know. Names such as ttyUSB0 follow the order of plugging; a
udev rule gives each role its own name, by the adapter's serial number, or by its USB socket where
several adapters have the same.
"""

from __future__ import annotations

import os
import stat
from collections import Counter
from collections.abc import Sequence
from dataclasses import dataclass
from pathlib import Path

from serial.tools.list_ports_linux import SysFS

from drivers.adapter_name import persistent_name

PHANTOM_UART = "0"
"""Content of a serial port's ``type`` file if there is no chip behind its number."""


@dataclass(frozen=True, slots=True, kw_only=True)
class SerialPort:
    """One serial port; texts are empty where unknown."""

    device: str
    """Path, e.g. /dev/ttyUSB0."""
    driver: str = ""
    vendor_id: str = ""
    product_id: str = ""
    serial: str = ""
    """Serial number of the adapter."""
    product: str = ""
    """Maker and product name of the adapter."""
    location: str = ""
    """USB bus and sockets, then configuration and interface, e.g. 1-1.2:1.0."""
    by_id: str = ""
    """Link below /dev/serial/by-id."""
    owner: str = ""
    """Owning user and group and the mode, e.g. root:dialout 0660."""
    usable: bool = False
    """Whether this user may read and write it."""
    holders: tuple[str, ...] = ()
    """Processes that have it open, as ``number name``; those of other users only for root."""

    @property
    def adapter(self) -> tuple[str, str, str]:
        """Identity of the adapter: vendor id, product id, serial number."""
        return self.vendor_id, self.product_id, self.serial


@dataclass(frozen=True, slots=True)
class KernelFiles:
    """Folders of the kernel's files; others in tests."""

    sys: Path = Path("/sys")
    dev: Path = Path("/dev")
    proc: Path = Path("/proc")


def list_serial_ports(files: KernelFiles | None = None) -> list[SerialPort]:
    """Return the serial ports that exist in hardware, in order of name."""
    files = files or KernelFiles()
    entries = sorted((files.sys / "class" / "tty").glob("tty*"))
    return [_describe(entry, files) for entry in entries if _is_hardware(entry)]


def _is_hardware(entry: Path) -> bool:
    """Return whether a tty is a serial port (no console) with a chip behind it."""
    return (entry / "device").exists() and _text(entry / "type") != PHANTOM_UART


def _describe(entry: Path, files: KernelFiles) -> SerialPort:
    hardware = (entry / "device").resolve()
    path = files.dev / entry.name
    return SerialPort(
        device=str(path),
        driver=_link_name(hardware / "driver"),
        by_id=str(persistent_name(str(path), files.dev / "serial" / "by-id") or ""),
        owner=owner_of(path),
        usable=os.access(path, os.R_OK | os.W_OK),
        holders=holders_of(path, files.proc),
        **{"location": hardware.name, **_usb_facts(path.name)},
    )


def _usb_facts(name: str) -> dict[str, str]:
    """Return the attributes of a port's USB device; empty if it has none.

    The location is that of the interface, since one adapter may have several ports.
    """
    try:
        adapter = SysFS(f"/dev/{name}")
    except (TypeError, ValueError):  # raised by pyserial if it is unplugged meanwhile
        return {}
    if adapter.usb_interface_path is None:
        return {}
    return {
        "vendor_id": f"{adapter.vid:04x}",
        "product_id": f"{adapter.pid:04x}",
        "serial": adapter.serial_number or "",
        "product": " ".join(filter(None, (adapter.manufacturer, adapter.product))),
        "location": Path(adapter.usb_interface_path).name,
    }


def owner_of(path: Path) -> str:
    """Return user, group and mode of a device; empty where it does not exist."""
    try:
        status = path.stat()
        return f"{path.owner()}:{path.group()} {stat.S_IMODE(status.st_mode):04o}"
    except (OSError, KeyError):
        return ""


def holders_of(device: Path, proc: Path = Path("/proc")) -> tuple[str, ...]:
    """Return the processes, other than this one, that have a device open."""
    target = str(device.resolve())
    processes = sorted(proc.glob("[0-9]*"), key=lambda path: int(path.name))
    return tuple(
        f"{process.name} {_text(process / 'comm')}".strip()
        for process in processes
        if process.name != str(os.getpid()) and target in _open_files(process)
    )


def _open_files(process: Path) -> set[str]:
    """Return the paths of a process's open files; empty without permission."""
    opened: set[str] = set()
    try:
        descriptors = list((process / "fd").iterdir())
    except OSError:
        return opened
    for descriptor in descriptors:
        try:
            opened.add(str(descriptor.readlink()))
        except OSError:  # closed meanwhile
            continue
    return opened


def udev_lines(ports: Sequence[SerialPort]) -> list[str]:
    """Return for each port a udev rule line that gives it a role's name.

    It matches the adapter's serial number where that is unique, else the location. All matches of
    one line must hold for one parent of the port: serial number and ids belong to the USB device,
    the location to the interface.
    """
    alike = Counter(port.adapter for port in ports)
    return [_udev_line(port, unique=alike[port.adapter] == 1) for port in ports]


def _udev_line(port: SerialPort, *, unique: bool) -> str:
    if port.serial and unique:
        matches = (
            f'ATTRS{{idVendor}}=="{port.vendor_id}", ATTRS{{idProduct}}=="{port.product_id}", '
            f'ATTRS{{serial}}=="{port.serial}"'
        )
    elif port.vendor_id:
        matches = f'KERNELS=="{port.location}"'
    else:
        matches = f'KERNEL=="{Path(port.device).name}"'
    assignments = 'SYMLINK+="patrol/ROLE", GROUP="dialout", MODE="0660"'
    return f'SUBSYSTEM=="tty", {matches}, {assignments}, ENV{{ID_MM_DEVICE_IGNORE}}="1"'


def _text(path: Path) -> str:
    try:
        return path.read_text(errors="replace").strip()
    except OSError:
        return ""


def _link_name(link: Path) -> str:
    return link.resolve().name if link.exists() else ""
