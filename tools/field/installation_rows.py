"""Rows: the installation, by the lines that INSTALL.txt and README print."""

from __future__ import annotations

import re
import shlex
import shutil
import subprocess
from collections.abc import Callable
from pathlib import Path

from tools.deploy.bundle import make_bundle
from tools.field.emulated_robot import BASE_SERIAL, LASER_SERIAL
from tools.field.field_row import FieldRow, Outcome
from tools.field.field_stage import PATROL_LIMIT_S, UNIT, FieldStage, drives
from tools.field.guest import Guest
from tools.field.needed_programs import with_sbin
from tools.field.readme_lines import (
    FIRST_HOUR,
    SERVICE,
    command_lines,
    installation,
    robot_file,
    section,
)

FOLDER = "patrol-bundle"
"""The bundle's folder on the robot, in the home of root."""
RULES = "/etc/udev/rules.d/60-patrol.rules"
FIRST_WITH_ADAPTERS = "patrol ports"
"""The first line of INSTALL.txt that needs adapters: it and those after it are typed later."""
BY_HAND = {
    "$EDITOR robot1.toml": "the trial writes the file",
    "patrol record robot1.toml --teleop -o drive.mcap": "needs a driver; a map is there",
    "patrol map build drive.mcap -o my_map --from odometry": "needs the drive",
    "patrol map border my_map": "needs a person at a browser; a border is there",
}
"""Lines that the trial does not type, with the reason."""
FOLLOWING = "journalctl -f"
"""A line that begins so goes on for ever: it is ended after some seconds."""
_ROLE_LINE = re.compile(r"^\s*udev\s+(SUBSYSTEM.*)$", re.MULTILINE)
_PIP_LIMIT_S = 1500.0


def first_hour() -> list[str]:
    """Return the lines typed on a robot with its adapters, after the bundle's installation."""
    before, after = _halves()
    printed = [*command_lines(section(FIRST_HOUR)), *command_lines(section(SERVICE))]
    return [*after, *(line for line in printed if line not in before)]


def _halves() -> tuple[list[str], list[str]]:
    """Return INSTALL.txt's lines before and from the first that needs adapters."""
    lines = installation()
    place = lines.index(FIRST_WITH_ADAPTERS)
    return lines[:place], lines[place:]


def robot_configuration() -> str:
    """Return the file that README prints, with the adapters' names, for a robot of the trial."""
    text = robot_file()
    for device, name in (("/dev/ttyS0", "base"), ("/dev/ttyS2", "laser")):
        text = text.replace(f'"{device}"', f'"/dev/patrol/{name}"')
    return text


def udev_lines(ports: str) -> str:
    """Return rules for base and laser from what ``patrol ports`` has printed."""
    lines = _ROLE_LINE.findall(ports)
    roles = ((BASE_SERIAL, "base"), (LASER_SERIAL, "laser"))
    rules = [
        line.replace("ROLE", role) for serial, role in roles for line in lines if serial in line
    ]
    return "".join(f"{rule}\n" for rule in rules)


def make_stick(folder: Path, map_folder: Path, report: Callable[[str], None]) -> Path:
    """Make the bundle and the disk image that carries it and the robot's map to the robot."""
    content = folder / "stick"
    make_bundle(content / FOLDER, ["x86_64"], report)
    shutil.copytree(map_folder, content / "my_map")
    stick = folder / "stick.raw"
    command = ["mke2fs", "-q", "-t", "ext4", "-d", str(content), str(stick), "512M"]
    subprocess.run(command, check=True, timeout=300, env=with_sbin(), stdout=subprocess.DEVNULL)
    shutil.rmtree(content)
    return stick


def _install(stage: FieldStage, outcome: Outcome) -> None:
    stage.installed.unlink(missing_ok=True)  # lies over the disk that is made anew
    stick = make_stick(stage.folder, stage.map_folder, lambda _: None)
    guest = stage.workbench(backing=stage.image.disk, stick=stick)
    guest.run(f"mount -r /dev/vdb /mnt && cp -r /mnt/{FOLDER} /mnt/my_map /root/ && umount /mnt")
    lines, _ = _halves()
    _type(guest, lines, outcome)
    size = guest.run("du -sm /opt/patrol").split()[0]
    outcome.note(f"{len(lines)} lines, {size} MB")
    stage.keep_disk(stage.bundled)
    stick.unlink()


def _first_hour(stage: FieldStage, outcome: Outcome) -> None:
    stage.boot(backing=stage.bundled)
    guest = stage.guest
    guest.write(RULES, udev_lines(guest.run("patrol ports")))
    guest.write("/root/robot1.toml", robot_configuration())
    guest.run("udevadm control --reload && udevadm trigger --subsystem-match=tty")
    lines = [line for line in first_hour() if line not in BY_HAND]
    _type(guest, lines, outcome)
    outcome.note(f"{len(lines)} lines")
    outcome.within("drives after", stage.robot.wait(drives, PATROL_LIMIT_S), PATROL_LIMIT_S)
    guest.run(f"systemctl stop {UNIT} && rm -f /var/lib/patrol/*")  # each row begins anew
    stage.keep_disk(stage.installed)


def _type(guest: Guest, lines: list[str], outcome: Outcome) -> None:
    """Type lines one after the other in root's home; complain about each that fails."""
    folder = "/root"
    for line in lines:
        if line.startswith("cd "):
            folder = f"/root/{FOLDER}"
            continue
        command = f"timeout 5 {line}; test $? = 124" if line.startswith(FOLLOWING) else line
        if "--watchdog-test" in line:  # asks on a terminal
            command = f"echo yes | script -qec {shlex.quote(line)} /dev/null"
        done = guest.attempt(f"cd {folder}\n{command}", _PIP_LIMIT_S)
        last = " ".join(done.output.split())[-200:]
        outcome.require(done.status == 0, f"`{line}`: status {done.status}: {last}")


INSTALLATION_ROWS = (
    FieldRow(
        "install",
        "bundle copied to a fresh Debian 12, the lines of INSTALL.txt typed",
        "every line succeeds, with no network",
        _install,
    ),
    FieldRow(
        "first-hour",
        "both adapters plugged in; the lines of this README typed",
        "every line succeeds, the robot drives",
        _first_hour,
    ),
)
