"""A cable to an emulated device that can be unplugged and plugged in again."""

from __future__ import annotations

from pathlib import Path

from drivers.emulation.port import EmulatedDevice, PtyPort


class Cable:
    """A pty to a device under a persistent name, as udev makes it; can be unplugged."""

    def __init__(self, device: EmulatedDevice, path: Path) -> None:
        self.path = path
        self._device = device
        self._port: PtyPort | None = None
        self.put_back()

    def put_back(self) -> None:
        """Plug the cable in: the name appears and points to a new device node."""
        self._port = PtyPort(self._device)
        self.path.symlink_to(self._port.url)

    def pull(self) -> None:
        """Unplug the cable: the name disappears and the port's client is disconnected."""
        if self._port is not None:
            self.path.unlink()
            self._port.close()
            self._port = None

    def pump(self, t: float) -> None:
        """Move bytes both ways at ``t``; while unplugged, what the device sends is lost."""
        if self._port is not None:
            self._port.pump(t)
        else:
            self._device.pop_output(t)
