"""The stage of a trial: the robot's virtual computer, its disks, and the emulated robot."""

from __future__ import annotations

import subprocess
from collections.abc import Sequence
from pathlib import Path

from tools.field.acceleration import Acceleration, TrialClock
from tools.field.emulated_robot import EmulatedRobot, Moment
from tools.field.guest import Guest
from tools.field.journal import JournalLine
from tools.field.machine_image import MachineImage
from tools.field.trial_error import TrialError
from tools.field.virtual_machine import VirtualMachine

UNIT = "patrol@robot1"
PATROL_LIMIT_S = 60.0
"""Limit from the kernel's start until the robot patrols, s: boot, start, devices, first pose."""
BOTH = ("base", "laser")


class FieldStage:
    """A machine at a time: the workbench, which has no robot, or the robot's computer.

    The workbench runs in real time, the robot's computer with the trial's clock. Each begins with
    the disk as ``installed`` left it, except after ``power_on``.
    """

    def __init__(
        self,
        folder: Path,
        image: MachineImage,
        acceleration: Acceleration,
        map_folder: Path,
        pose: str,
    ) -> None:
        """folder: for disks and logs. map_folder: the robot's true world. pose: its true start."""
        self.folder = folder
        self.image = image
        self.acceleration = acceleration
        self.clock = TrialClock(acceleration.rate)
        self.map_folder = map_folder
        self._pose = pose
        self._machine: VirtualMachine | None = None
        self._robot: EmulatedRobot | None = None
        self._disk = folder / "none"
        self._made = 0
        self._on_workbench = False
        self._spoiled = False
        self.bundled = folder / "bundled.qcow2"
        """The disk with the bundle installed, once it has been made."""
        self.installed = folder / "installed.qcow2"
        """The disk that machines begin with: with the robot's service too."""

    def close(self) -> None:
        """Switch everything off."""
        self._switch_off()
        if self._robot is not None:
            self._robot.close()
            self._robot = None

    @property
    def machine(self) -> VirtualMachine:
        """The machine that is on."""
        if self._machine is None:
            raise TrialError("no machine is on: a row must switch one on first")
        return self._machine

    @property
    def guest(self) -> Guest:
        """The system of the machine that is on."""
        return self.machine.guest

    @property
    def robot(self) -> EmulatedRobot:
        """The robot of the machine that is on."""
        if self._robot is None:
            raise TrialError("there is no robot: a row must boot its computer first")
        return self._robot

    @property
    def disk(self) -> Path:
        """The disk of the machine that is, or was last, on."""
        return self._disk

    def workbench(self, *, backing: Path | None = None, stick: Path | None = None) -> Guest:
        """Return the system of a machine without a robot; one that is on is used again.

        backing: begin with this disk instead. stick: image of a second disk.
        """
        if self._on_workbench and backing is None and stick is None:
            return self.guest
        self.close()
        self._new_disk(backing or self.installed)
        self._machine = VirtualMachine(
            *(self.image, self._disk, self.acceleration.at_full_speed, self.folder), stick=stick
        )
        self._on_workbench = True
        return self.guest

    def boot(
        self,
        plugged: Sequence[str] = BOTH,
        *,
        backing: Path | None = None,
        clock_starts: str = "",
        change: str = "",
    ) -> None:
        """Switch a computer and a new robot on, with adapters plugged in, in this order.

        change: shell lines that a machine has run on the disk before, and shut down.
        """
        if change:
            self.workbench(backing=backing or self.installed).run(change)
            self.machine.shut_down()
            backing = self._disk
        self.close()
        self._new_disk(backing or self.installed)
        self._robot = EmulatedRobot(self.acceleration, self.map_folder, self._pose)
        self.power_on(plugged, clock_starts)

    def power_on(self, plugged: Sequence[str] = BOTH, clock_starts: str = "") -> None:
        """Switch the computer on again, with the disk as it is and the robot where it is."""
        self._switch_off()
        self._spoiled = False
        self._machine = VirtualMachine(
            *(self.image, self._disk, self.acceleration, self.folder),
            adapters=[getattr(self.robot, name) for name in plugged],
            clock_starts=clock_starts,
        )

    def patrolling(self) -> None:
        """Have a robot that patrols: the one that is on if it does, else a new one.

        Raises TrialError if it does not begin to.
        """
        healthy = self._machine is not None and self._robot is not None and not self._spoiled
        if not healthy or self.robot.wait(drives, 10.0) is None:
            self.boot()
            if self.robot.wait(drives, PATROL_LIMIT_S) is None:
                raise TrialError(f"the robot does not patrol: {self.last_words()}")

    def spoil(self) -> None:
        """Have the next row begin with a new machine: this one's disk was changed."""
        self._spoiled = True

    def journal(self) -> list[JournalLine]:
        """Return the journal of the agent's service since the machine's start."""
        return self.guest.journal(UNIT)

    def wait_for_line(self, words: str, limit: float, since: float = 0.0) -> float | None:
        """Wait for a line of the service's journal; return its time since the kernel's start."""
        deadline = self.clock.now() + limit
        while True:
            for line in self.journal():
                if line.t >= since and words in line.text:
                    return line.t
            if self.clock.now() > deadline:
                return None
            self.clock.sleep(1.0)

    def last_words(self) -> str:
        """Return the end of the service's journal."""
        return " / ".join(line.text for line in self.journal()[-6:])

    def machine_words(self) -> str:
        """Return the last words of the machine that is on."""
        return "no machine is on" if self._machine is None else self._machine.last_words()

    def _switch_off(self) -> None:
        if self._machine is not None:
            self._machine.cut_power()
        self._machine = None
        self._on_workbench = False

    def _new_disk(self, backing: Path) -> None:
        """Make an empty disk over another, which is not written to any more."""
        self._made += 1
        self._disk = self.folder / f"disk{self._made}.qcow2"
        make_overlay(self._disk, backing)

    def keep_disk(self, path: Path) -> None:
        """Shut the machine down and keep its disk."""
        self.machine.shut_down()
        self._switch_off()
        self._disk.rename(path)
        self._disk = path


def make_overlay(disk: Path, backing: Path) -> None:
    """Make a disk that holds only what differs from another."""
    kind = "raw" if backing.suffix == ".raw" else "qcow2"
    subprocess.run(
        ["qemu-img", "create", "-q", "-f", "qcow2", "-b", backing, "-F", kind, disk],
        check=True,
        timeout=60,
    )


def drives(moment: Moment) -> bool:
    """Return whether a robot moves forward, for ``EmulatedRobot.wait``."""
    return moment.drives


def stands(moment: Moment) -> bool:
    """Return whether a robot's wheels are at rest."""
    return moment.stands
