"""How fast a virtual machine runs here, and the clock it gets for that.

Where KVM runs guests they are as fast as this machine and live in real time. Elsewhere each
instruction is emulated, some ten times slower; then machine and emulated robot both get a clock
that goes at a fraction of the real one, by libfaketime, so that every limit of the software means
as much work as on a real computer.
"""

from __future__ import annotations

import subprocess
import tempfile
import time
from dataclasses import dataclass
from pathlib import Path

from tools.campaign.set_clock import faketime_library
from tools.field.trial_error import TrialError

EMULATED_RATE = 0.25
"""Seconds of an emulated machine's clock in a real second. Ours: an agent then uses some 15 % of
the emulated processor on a machine of 2025, as on a small computer of today."""
_WORD = 0x10
_PROBE = bytes((0xB0, _WORD, 0xE6, 0xF4, 0xEB, 0xFE)).ljust(510, b"\0") + b"\x55\xaa"
"""A boot sector: writes ``_WORD`` to the port of isa-debug-exit, which ends qemu."""
_PROBE_STATUS = _WORD << 1 | 1
_PROBE_LIMIT_S = 10.0
"""Ours; it takes 0.1 s."""


@dataclass(frozen=True, slots=True)
class Acceleration:
    """How guests run.

    arguments: of qemu. rate: seconds of the guest's clock in a real second.
    """

    name: str
    arguments: tuple[str, ...]
    rate: float

    def prefix(self) -> list[str]:
        """Return the start of a command that gives a program this clock, and an end with ours."""
        tied = ["setpriv", "--pdeathsig", "KILL", "--"]
        if self.rate == 1.0:
            return tied
        slowed = (f"LD_PRELOAD={_faketime_library()}", f"FAKETIME=+0 x{self.rate:g}")
        return [*tied, "env", *slowed]

    @property
    def at_full_speed(self) -> Acceleration:
        """The same in real time, for work without a robot."""
        return Acceleration(self.name, self.arguments, 1.0)


def clean_up(program: int) -> None:
    """Delete the shared memory that libfaketime leaves behind when a program (its id) is killed."""
    for name in (f"faketime_shm_{program}", f"sem.faketime_sem_{program}"):
        Path("/dev/shm", name).unlink(missing_ok=True)  # noqa: S108 - libfaketime's place


class TrialClock:
    """The clock of machine and robot, s."""

    def __init__(self, rate: float) -> None:
        self.rate = rate

    def now(self) -> float:
        """Return the time since any moment, s."""
        return time.monotonic() * self.rate

    def sleep(self, duration: float) -> None:
        """Wait for a time of this clock, s."""
        time.sleep(duration / self.rate)


def choose_acceleration(rate: float | None) -> Acceleration:
    """Return KVM where a guest really runs, else emulation with a slowed clock.

    rate: seconds of the guest's clock in a real second; None for the usual one.
    """
    kvm = ("-accel", "kvm", "-cpu", "host")
    if Path("/dev/kvm").exists() and runs_guest(kvm):
        return Acceleration("KVM", kvm, 1.0 if rate is None else rate)
    slowed = EMULATED_RATE if rate is None else rate
    return Acceleration("emulation", ("-accel", "tcg", "-cpu", "max"), slowed)


def runs_guest(arguments: tuple[str, ...]) -> bool:
    """Return whether a guest executes its first instructions; /dev/kvm alone does not say so."""
    with tempfile.NamedTemporaryFile(prefix="patrol-probe-") as sector:
        sector.write(_PROBE)
        sector.flush()
        command = [
            *("qemu-system-x86_64", *arguments, "-m", "64", "-display", "none", "-nodefaults"),
            *("-device", "isa-debug-exit,iobase=0xf4,iosize=4"),
            *("-drive", f"file={sector.name},format=raw,if=floppy"),
        ]
        try:
            done = subprocess.run(command, capture_output=True, check=False, timeout=_PROBE_LIMIT_S)
        except subprocess.TimeoutExpired:
            return False
    return done.returncode == _PROBE_STATUS


def _faketime_library() -> Path:
    library = faketime_library()
    if library is None:
        raise TrialError("libfaketime is not there: `apt-get install faketime`")
    return library
