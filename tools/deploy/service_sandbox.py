"""Runs a command in the sandbox of the service: its user, devices, files and system calls.

The properties are read from the unit, so that they cannot differ from those of the service.
"""

from __future__ import annotations

import os
import subprocess
from collections.abc import Sequence
from pathlib import Path

from tools.deploy.service import DEPLOY, RUNNING_SYSTEMD, UNIT, this_program

_OF_THE_RUN = (
    *("Type=", "NotifyAccess=", "ExecStart=", "Restart", "Watchdog", "Timeout", "KillMode="),
    *("RuntimeDirectory", "OOMPolicy=", "LogRateLimit", "SyslogIdentifier="),
)
"""Begins of properties about starting, watching and ending the service; all others are passed on,
so that a new one in the unit is in the sandbox too."""
_FIRST_OF_SYSTEMD = 200
"""Exit statuses from here on are systemd's own: the command was not started."""


class SandboxError(ValueError):
    """There can be no sandbox here; the message says why, with the remedy."""


def read_unit() -> str:
    """Return the unit as it is installed; the shipped one, for user patrol, where none is."""
    installed = Path("/") / UNIT
    if installed.is_file():
        return installed.read_text()
    shipped = (DEPLOY / UNIT.name).read_text()
    return shipped.replace("@PATROL@", str(this_program())).replace("@USER@", "patrol")


def sandbox_command(unit: str, arguments: Sequence[str]) -> list[str]:
    """Return the command line that runs the service's program with other arguments, as it would.

    unit: text of the unit.
    """
    _, _, section = unit.partition("[Service]")
    lines = [line.strip() for line in section.partition("\n[")[0].splitlines()]
    lines = [line for line in lines if line and not line.startswith("#")]
    started = next(line for line in lines if line.startswith("ExecStart="))
    program = started.removeprefix("ExecStart=").split()[0]
    properties = [line for line in lines if not line.startswith(_OF_THE_RUN)]
    return [
        *("systemd-run", "--quiet", "--pipe", "--wait", "--collect", "--service-type=exec"),
        *(f"--property={line}" for line in properties),
        *("--", program, *arguments),
    ]


def run_in_sandbox(arguments: Sequence[str]) -> int:
    """Run ``patrol`` with arguments in the sandbox; return its exit status.

    Raises SandboxError where systemd is not running, without root's rights, and when systemd cannot
    make the sandbox.
    """
    if not RUNNING_SYSTEMD.is_dir():
        raise SandboxError("systemd is not running here, and it makes the sandbox: run it there")
    if os.geteuid() != 0:
        raise SandboxError("only root may make the service's sandbox: run it with sudo")
    status = subprocess.run(sandbox_command(read_unit(), arguments), check=False).returncode
    if status >= _FIRST_OF_SYSTEMD:
        raise SandboxError(
            f"systemd could not start it in the sandbox (status {status}): has `patrol install` "
            "made the service's user, and may that user read the program?"
        )
    return status
