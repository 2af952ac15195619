"""A virtual computer with two USB sockets for serial adapters, run by qemu."""

from __future__ import annotations

import subprocess
import time
from collections.abc import Sequence
from dataclasses import dataclass
from pathlib import Path

from tools.field.acceleration import Acceleration, TrialClock, clean_up
from tools.field.guest import Guest
from tools.field.json_channel import JsonChannel
from tools.field.machine_image import MachineImage
from tools.field.trial_error import TrialError

MEMORY_MB = 1024
BOOT_LIMIT_S = 180.0
"""Limit until the guest answers, s of its clock."""
_END_S = 60.0


@dataclass(frozen=True, slots=True)
class Adapter:
    """A USB adapter (FTDI, 0403:6001) at a serial port of this machine.

    name: its role. serial: its number, by which udev knows it. port: a pseudo-terminal's path.
    """

    name: str
    serial: str
    port: str


class VirtualMachine:
    """A machine from its power-on to its power-off."""

    def __init__(
        self,
        image: MachineImage,
        disk: Path,
        acceleration: Acceleration,
        folder: Path,
        *,
        adapters: Sequence[Adapter] = (),
        stick: Path | None = None,
        clock_starts: str = "",
    ) -> None:
        """Switch it on with adapters plugged in, in this order.

        disk: qcow2, written to. folder: for sockets and the console's log. stick: image of a second
        disk, read only. clock_starts: date of the clock at power-on, empty for today.
        """
        self._clock = TrialClock(acceleration.rate)
        self._console = folder / "console.log"
        self._agent_socket = folder / "agent.sock"
        monitor = folder / "monitor.sock"
        for socket in (monitor, self._agent_socket):
            socket.unlink(missing_ok=True)
        command = [
            *acceleration.prefix(),
            *("qemu-system-x86_64", *acceleration.arguments, "-machine", "q35"),
            *("-m", str(MEMORY_MB), "-smp", "1", "-display", "none", "-nodefaults", "-S"),
            *("-kernel", str(image.kernel), "-initrd", str(image.initrd)),
            *("-append", "root=/dev/vda rw console=ttyS0 quiet panic=-1"),
            *("-drive", f"file={disk},format=qcow2,if=virtio"),
            *("-serial", f"file:{self._console}", "-device", "virtio-serial"),
            *("-chardev", f"socket,id=agent,path={self._agent_socket},server=on,wait=off"),
            *("-device", "virtserialport,chardev=agent,name=org.qemu.guest_agent.0"),
            *("-device", "qemu-xhci,id=usb", "-qmp", f"unix:{monitor},server=on,wait=off"),
            *("-rtc", f"base={clock_starts or 'utc'},clock=vm"),
        ]
        if stick is not None:
            command += ["-drive", f"file={stick},format=raw,if=virtio,readonly=on"]
        self._log = folder / "qemu.log"
        with self._log.open("w") as log:
            self._process = subprocess.Popen(command, stdin=subprocess.DEVNULL, stderr=log)
        self._guest: Guest | None = None
        try:
            self._monitor = JsonChannel(monitor)
            self._monitor.ask("qmp_capabilities")
            for adapter in adapters:
                self.plug(adapter)
            self._monitor.ask("cont")
        except BaseException as error:
            self.cut_power()
            if isinstance(error, TrialError):
                raise TrialError(f"{error}: {self.last_words()}") from error
            raise

    @property
    def guest(self) -> Guest:
        """The system, waited for at the first use; raises TrialError if it does not answer."""
        if self._guest is None:
            try:
                self._guest = Guest(self._agent_socket, self._clock, BOOT_LIMIT_S)
            except TrialError as error:
                raise TrialError(
                    f"the machine did not boot: {error}: {self.last_words()}"
                ) from error
        return self._guest

    def plug(self, adapter: Adapter) -> None:
        """Plug an adapter into a free socket."""
        line = f"line-{adapter.name}"
        backend = {"type": "serial", "data": {"device": adapter.port}}
        self._monitor.ask("chardev-add", {"id": line, "backend": backend})
        device = {"driver": "usb-serial", "bus": "usb.0", "serial": adapter.serial}
        self._monitor.ask("device_add", {**device, "id": adapter.name, "chardev": line})

    def pull(self, adapter: Adapter) -> None:
        """Pull an adapter out."""
        self._monitor.ask("device_del", {"id": adapter.name})
        self._monitor.wait_event("DEVICE_DELETED", adapter.name)
        self._monitor.ask("chardev-remove", {"id": f"line-{adapter.name}"})

    def cut_power(self) -> None:
        """Switch it off at once; no effect if it is off. What it had not written is lost."""
        if self._guest is not None:
            self._guest.close()
            self._guest = None
        if self._process.poll() is None:
            self._process.kill()
        self._process.wait()
        clean_up(self._process.pid)
        if hasattr(self, "_monitor"):
            self._monitor.close()

    def shut_down(self) -> None:
        """Shut the system down, then switch off; raises TrialError if it does not end."""
        self.guest.begin("systemctl --no-block poweroff")  # it may be off before the answer
        deadline = time.monotonic() + _END_S / self._clock.rate
        while self._process.poll() is None:
            if time.monotonic() > deadline:
                self.cut_power()
                raise TrialError(f"the machine did not shut down: {self.last_words()}")
            time.sleep(0.2)
        self.cut_power()

    def last_words(self) -> str:
        """Return the last words of qemu and of the machine's console."""
        words = self._log.read_text()
        if self._process.poll() is not None:
            words = f"qemu ended with {self._process.returncode}; {words}"
        if self._console.exists():
            words += self._console.read_text(errors="replace")
        return " ".join(words.split())[-600:]
