"""Serial adapters of this machine: what udev can tell them apart by, and who uses them.

pyserial's list_ports tells what an adapter says of itself. Which ports there are, who may use them
and who does comes from the kernel's files (``/sys``, ``/dev``, ``/proc``): pyserial lists numbers
without a chip behind them and leaves out names it does not know. Names such as ttyUSB0 follow the
order of plugging; a udev rule gives each role a name of its own, by the adapter's serial number, or
by the socket it is plugged into where several adapters are alike.
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
"""What ``type`` of a serial port says when there is no chip behind its number."""


@dataclass(frozen=True, slots=True, kw_only=True)
class SerialPort:
    """One serial port; texts are empty where the kernel has nothing to say."""

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
    """Where it is plugged in: bus and sockets, then configuration and interface, e.g. 1-1.2:1.0."""
    by_id: str = ""
    """Link below /dev/serial/by-id."""
    owner: str = ""
    """Owning user and group and the mode, e.g. root:dialout 0660."""
    usable: bool = False
    """Whether this user may read and write it."""
    holders: tuple[str, ...] = ()
    """Processes that have it open, as «number name»; those of other users only show to root."""

    @property
    def adapter(self) -> tuple[str, str, str]:
        """What one adapter is told from another by: vendor, product, serial number."""
        return self.vendor_id, self.product_id, self.serial


@dataclass(frozen=True, slots=True)
class KernelFiles:
    """Where the kernel's files are; another place in tests."""

    sys: Path = Path("/sys")
    dev: Path = Path("/dev")
    proc: Path = Path("/proc")


def list_serial_ports(files: KernelFiles | None = None) -> list[SerialPort]:
    """Return the serial ports that exist in hardware, by name."""
    files = files or KernelFiles()
    entries = sorted((files.sys / "class" / "tty").glob("tty*"))
    return [_describe(entry, files) for entry in entries if _is_hardware(entry)]


def _is_hardware(entry: Path) -> bool:
    """Tell serial ports from consoles, and chips from numbers reserved for none."""
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
    """Return what is known of a port by its USB device; nothing where it has none.

    Its place is the interface below the device: one adapter may have several ports.
    """
    try:
        adapter = SysFS(f"/dev/{name}")
    except (TypeError, ValueError):  # what pyserial does when it is unplugged meanwhile
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
    """Return what a process has open; nothing where we may not look."""
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
    """Return a rule line for each port that names it for a role.

    By the adapter's serial number where that tells it from all others, else by the place where it
    is plugged in. All matches of one line must hold for one parent of the port: the serial number
    and the ids belong to the USB device, the interface's place to the interface.
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
    return f'SUBSYSTEM=="tty", {matches}, SYMLINK+="patrol/ROLE", GROUP="dialout", MODE="0660"'


def _text(path: Path) -> str:
    try:
        return path.read_text(errors="replace").strip()
    except OSError:
        return ""


def _link_name(link: Path) -> str:
    return link.resolve().name if link.exists() else ""
