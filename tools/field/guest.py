"""The running system of a virtual machine: commands run in it, by Debian's qemu-guest-agent."""

from __future__ import annotations

import base64
import json
import shlex
import time
from dataclasses import dataclass
from pathlib import Path

from tools.field.acceleration import TrialClock
from tools.field.journal import JournalLine
from tools.field.json_channel import JsonChannel
from tools.field.trial_error import TrialError

_POLL_S = 0.25
_HOME = "cd /root && export HOME=/root PATH=/usr/local/sbin:/usr/local/bin:/usr/sbin:/usr/bin"


@dataclass(frozen=True, slots=True)
class Done:
    """A command that has ended; output: standard output, then standard error."""

    command: str
    status: int
    output: str


class Guest:
    """The system that runs in a machine, as root."""

    def __init__(self, socket: Path, clock: TrialClock, limit: float) -> None:
        """Wait until the system answers; limit: seconds of its clock. Raises TrialError."""
        self._clock = clock
        self._channel = JsonChannel(socket)
        self._channel.ask("guest-ping", limit_s=limit / clock.rate)

    def close(self) -> None:
        """Disconnect."""
        self._channel.close()

    def begin(self, command: str) -> int:
        """Start shell lines, as those that end the machine; return the number of their process."""
        line = f"{_HOME}\n{command}"
        how = {"path": "/bin/bash", "arg": ["-c", line], "capture-output": True}
        return int(self._channel.ask("guest-exec", how)["pid"])

    def attempt(self, command: str, limit: float = 120.0) -> Done:
        """Run shell lines; limit: s of the guest's clock, then TrialError is raised."""
        number = self.begin(command)
        deadline = self._clock.now() + limit
        while True:
            state = self._channel.ask("guest-exec-status", {"pid": number})
            if state["exited"]:
                break
            if self._clock.now() > deadline:
                raise TrialError(f"in the machine: {command}: no end after {limit:.0f} s")
            time.sleep(_POLL_S)
        output = b"".join(
            base64.b64decode(state.get(part, "")) for part in ("out-data", "err-data")
        )
        status = state.get("exitcode", -state.get("signal", 0))
        return Done(command, status, output.decode(errors="replace"))

    def run(self, command: str, limit: float = 120.0) -> str:
        """Run shell lines that must succeed, return their output; raises TrialError otherwise."""
        done = self.attempt(command, limit)
        if done.status:
            raise TrialError(
                f"in the machine: {command}: status {done.status}: {done.output.strip()[-500:]}"
            )
        return done.output

    def uptime(self) -> float:
        """Return the seconds since its kernel's start."""
        return float(self.run("cat /proc/uptime").split()[0])

    def write(self, path: str, content: str) -> None:
        """Write a file."""
        self.run(f"printf %s {shlex.quote(content)} > {shlex.quote(path)}")

    def read(self, path: str) -> bytes:
        """Return a file's content, up to some megabytes."""
        return base64.b64decode(self.run(f"base64 {shlex.quote(path)}"))

    def journal(self, unit: str) -> list[JournalLine]:
        """Return the lines about a unit since the machine's start."""
        shown = self.run(f"journalctl -b -u {shlex.quote(unit)} -o json --no-pager")
        return [JournalLine.of(json.loads(line)) for line in shown.splitlines()]
