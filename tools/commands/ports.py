"""``patrol ports``: serial adapters, their udev attributes, and a rule line for each."""

from __future__ import annotations

import argparse
import dataclasses
import json
import sys

from tools.preflight.ports import SerialPort, list_serial_ports, udev_lines


def configure(parser: argparse.ArgumentParser) -> None:
    """Declare the options."""
    parser.epilog = (
        "example: patrol ports\n\n"
        "Put the lines, with ROLE replaced by base or laser, into /etc/udev/rules.d/\n"
        "60-patrol.rules; then: udevadm control --reload && udevadm trigger --subsystem-match=tty"
    )
    parser.add_argument("--json", action="store_true", help="print a JSON list instead")


def run(options: argparse.Namespace) -> int:
    """Print every serial port."""
    ports = list_serial_ports()
    lines = udev_lines(ports)
    if options.json:
        rows = [
            {**dataclasses.asdict(port), "udev": line}
            for port, line in zip(ports, lines, strict=True)
        ]
        print(json.dumps(rows, indent=2))
        return 0
    if not ports:
        print(
            "patrol ports: no serial port: plug the adapter in, or load its driver", file=sys.stderr
        )
    for port, line in zip(ports, lines, strict=True):
        print("\n".join(describe(port)))
        print(f"  udev      {line}\n")
    return 0


def describe(port: SerialPort) -> list[str]:
    """Return a port as lines of text: the device, then its known attributes."""
    ids = f"{port.vendor_id}:{port.product_id}" if port.vendor_id else ""
    access = "usable" if port.usable else "not usable by you: join its group and log in again"
    facts = {
        "adapter": " ".join(filter(None, (ids, port.product))),
        "serial": port.serial,
        "location": port.location,
        "driver": port.driver,
        "by id": port.by_id,
        "access": f"{port.owner}, {access}",
        "open in": ", ".join(port.holders),
    }
    return [port.device, *(f"  {name:<9} {fact}" for name, fact in facts.items() if fact)]
