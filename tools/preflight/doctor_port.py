"""Preflight of a device's port: existence, permission, other users, adapter, line quality."""

from __future__ import annotations

import os
import stat
from pathlib import Path
from typing import Protocol

from tools.preflight.device_trial import LineRecord
from tools.preflight.finding import Finding, failed, ok, warning
from tools.preflight.ports import SerialPort, holders_of, list_serial_ports, owner_of


def examine_port(subject: str, url: str) -> Finding:
    """Check a port without opening it; a pyserial URL is ok, only the trial can check it."""
    if "://" in url:
        return ok(subject, url)
    path = Path(url)
    try:
        mode = path.stat().st_mode
    except OSError as error:
        return failed(subject, f"{url}: {error.strerror}", _plug_in())
    if not stat.S_ISCHR(mode):
        return failed(subject, f"{url} is not a serial port", f"correct its url; {_present()}")
    if not os.access(path, os.R_OK | os.W_OK):
        group = owner_of(path).split()[0].partition(":")[2] or "dialout"
        return failed(
            subject,
            f"{url}: no permission ({owner_of(path)})",
            f"`sudo adduser $USER {group}`, then log in again",
        )
    holders = holders_of(path)
    if holders:
        process = holders[0].split()[0]
        return failed(
            subject,
            f"{url} is open in process {', '.join(holders)}",
            f"end it first: `kill {process}`, or stop its service",
        )
    return ok(subject, _describe(path))


def examine_opening(subject: str, line: LineRecord) -> Finding | None:
    """Return the finding on a port that could not be opened or was lost; None if it was neither."""
    if not line.lost:
        return None
    reason, _, remedy = line.lost.partition("; ")
    if not remedy:
        reason, _, remedy = line.lost.rpartition(": ")
    return failed(subject, reason or line.lost, remedy or "check the cable, then try again")


class LineCounters(Protocol):
    """Counters of a framer."""

    @property
    def good(self) -> int:
        """Complete frames with a correct checksum."""

    @property
    def bad_checksum(self) -> int:
        """Frames with a wrong checksum."""

    @property
    def discarded_bytes(self) -> int:
        """Bytes between frames."""


def examine_line(subject: str, frames: str, counters: LineCounters, line: LineRecord) -> Finding:
    """Check a line's share of bad frames; frames: the device's word for them, plural."""
    text = (
        f"{counters.good} {frames} good, {counters.bad_checksum} with a bad checksum, "
        f"{counters.discarded_bytes} bytes between {frames}; {describe_line(line)}"
    )
    if counters.bad_checksum > 0.01 * counters.good:
        return warning(subject, text, "shorten or change the cable, or its adapter")
    return ok(subject, text)


def describe_line(line: LineRecord) -> str:
    """Return the rates tried, none on a network, and the last bytes received, as text."""
    has_rate = bool(line.bauds_tried)
    tried = f"tried {', '.join(map(str, line.bauds_tried))} baud, " if has_rate else ""
    if not line.bytes_received:
        return f"{tried}no byte received"
    last = line.last_bytes.hex(" ").upper()
    rate = f" at {line.last_bytes_baud} baud" if has_rate else ""
    return f"{tried}{line.bytes_received} bytes, last {last}{rate}"


def _describe(path: Path) -> str:
    device = path.resolve()
    port = next((port for port in list_serial_ports() if port.device == str(device)), None)
    name = str(path) if device == path else f"{path} -> {device}"
    kind = "" if port is None else f": {_adapter(port)}"
    return f"{name}{kind}, {owner_of(path)}"


def _adapter(port: SerialPort) -> str:
    serial = f"serial {port.serial}" if port.serial else "no serial number"
    if not port.vendor_id:
        return f"port of the board, driver {port.driver}"
    return f"{port.product} ({port.vendor_id}:{port.product_id}, {serial}, at {port.location})"


def _plug_in() -> str:
    return f"plug the adapter in or correct its url; {_present()}"


def _present() -> str:
    devices = [port.device for port in list_serial_ports()]
    return f"present: {', '.join(devices) or 'none'} (see `patrol ports`)"
