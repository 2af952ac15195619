"""The persistent name of a serial adapter: it stays when the kernel renames the device node.

udev keeps one link per adapter (by vendor, product and serial number) in one folder; the kernel's
names (ttyUSB0, ttyUSB1) go by the order of plugging in.
"""

from __future__ import annotations

from pathlib import Path

BY_ID = Path("/dev/serial/by-id")


def persistent_name(device: str, folder: Path = BY_ID) -> Path | None:
    """Return the link that points to ``device`` now; None if there is none, or no such device."""
    try:
        target = Path(device).resolve(strict=True)
        links = sorted(folder.iterdir())
    except OSError:
        return None
    return next((link for link in links if _leads_to(link, target)), None)


def _leads_to(link: Path, target: Path) -> bool:
    try:
        return link.resolve(strict=True) == target
    except OSError:
        return False
