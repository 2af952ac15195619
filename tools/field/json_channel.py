"""Requests to qemu's monitor and to the agent in a guest: JSON lines on a Unix socket."""

from __future__ import annotations

import json
import socket
import time
from collections.abc import Mapping
from pathlib import Path
from typing import Any

from tools.field.trial_error import TrialError

ANSWER_S = 60.0
"""Real seconds for an answer, of a machine that is emulated on a busy one."""
_NONE: Mapping[str, object] = {}


class JsonChannel:
    """A connection to a socket of qemu."""

    def __init__(self, path: Path) -> None:
        """Connect; raises TrialError when nothing listens there."""
        self._path = path
        self._socket = _connected(path)
        self._rest = b""
        self._events: list[dict[str, Any]] = []

    def close(self) -> None:
        """Disconnect."""
        self._socket.close()

    def ask(
        self, command: str, arguments: Mapping[str, object] = _NONE, limit_s: float = ANSWER_S
    ) -> Any:
        """Return what a command returns; raises TrialError if it fails or is not answered.

        limit_s: real seconds.
        """
        request = {"execute": command, "arguments": dict(arguments)}
        deadline = time.monotonic() + limit_s
        try:
            self._socket.sendall(json.dumps(request).encode() + b"\n")
        except OSError as error:
            raise TrialError(f"{self._path.name}: {command}: {error.strerror}") from error
        while True:
            line = self._line(deadline, command)
            if "error" in line:
                raise TrialError(f"{command}: {line['error'].get('desc', line['error'])}")
            if "return" in line:
                return line["return"]
            if "event" in line:
                self._events.append(line)

    def wait_event(self, name: str, device: str) -> None:
        """Wait for an event of a device, also one that has come already; raises TrialError."""
        deadline = time.monotonic() + ANSWER_S
        while True:
            for event in self._events:
                if event["event"] == name and event.get("data", {}).get("device") == device:
                    self._events.remove(event)
                    return
            line = self._line(deadline, name)
            if "event" in line:
                self._events.append(line)

    def _line(self, deadline: float, purpose: str) -> dict[str, Any]:
        """Return the next line; raises TrialError at the deadline and at the end."""
        while b"\n" not in self._rest:
            self._socket.settimeout(max(0.01, deadline - time.monotonic()))
            try:
                data = self._socket.recv(65536)
            except TimeoutError as error:
                raise TrialError(f"{self._path.name}: no answer to {purpose}") from error
            except OSError as error:
                raise TrialError(f"{self._path.name}: {purpose}: {error.strerror}") from error
            if not data:
                raise TrialError(f"{self._path.name}: {purpose}: the machine is off")
            self._rest += data
        line, _, self._rest = self._rest.partition(b"\n")
        message: dict[str, Any] = json.loads(line)
        return message


def _connected(path: Path) -> socket.socket:
    deadline = time.monotonic() + ANSWER_S
    while True:
        connection = socket.socket(socket.AF_UNIX)
        try:
            connection.connect(str(path))
        except OSError as error:
            connection.close()
            if time.monotonic() > deadline:
                raise TrialError(f"{path}: {error.strerror}") from error
            time.sleep(0.1)
        else:
            return connection
