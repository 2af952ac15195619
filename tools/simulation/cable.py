"""A cable to an emulated device that can be pulled and put back."""

from __future__ import annotations

from pathlib import Path

from drivers.emulation.port import EmulatedDevice, PtyPort


class Cable:
    """A pty to a device under a name that stays, as udev gives it; can be pulled and put back."""

    def __init__(self, device: EmulatedDevice, path: Path) -> None:
        self.path = path
        self._device = device
        self._port: PtyPort | None = None
        self.put_back()

    def put_back(self) -> None:
        """Plug the cable in: the name appears, for whatever device node there is now."""
        self._port = PtyPort(self._device)
        self.path.symlink_to(self._port.url)

    def pull(self) -> None:
        """Unplug the cable: the name goes, and who has the port open is hung up on."""
        if self._port is not None:
            self.path.unlink()
            self._port.close()
            self._port = None

    def pump(self, t: float) -> None:
        """Carry bytes both ways; with the cable pulled, what the device sends is lost."""
        if self._port is not None:
            self._port.pump(t)
        else:
            self._device.pop_output(t)
