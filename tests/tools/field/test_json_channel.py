"""Requests and events over a socket, answered by a peer as qemu's monitor does."""

from __future__ import annotations

import socket
import threading
from collections.abc import Iterator
from contextlib import closing, contextmanager
from pathlib import Path

import pytest

from tools.field.json_channel import JsonChannel
from tools.field.trial_error import TrialError


@contextmanager
def peer(folder: Path, answer: bytes) -> Iterator[JsonChannel]:
    """Yield a channel to a peer that gives one answer to the first request, then hangs up."""
    path = folder / "monitor.sock"
    with closing(socket.socket(socket.AF_UNIX)) as listener:
        listener.bind(str(path))
        listener.listen()

        def serve() -> None:
            connection, _ = listener.accept()
            with connection:
                connection.recv(4096)
                connection.sendall(answer)

        thread = threading.Thread(target=serve)
        thread.start()
        with closing(JsonChannel(path)) as channel:
            yield channel
        thread.join()


def test_events_before_the_answer_are_kept(tmp_path: Path) -> None:
    answer = b'{"event": "DEVICE_DELETED", "data": {"device": "base"}}\n{"return": {"a": 1}}\n'
    with peer(tmp_path, answer) as channel:
        assert channel.ask("device_del", {"id": "base"}) == {"a": 1}
        channel.wait_event("DEVICE_DELETED", "base")


def test_a_refusal_is_told(tmp_path: Path) -> None:
    answer = b'{"error": {"class": "GenericError", "desc": "no such device"}}\n'
    with (
        peer(tmp_path, answer) as channel,
        pytest.raises(TrialError, match="device_del: no such device"),
    ):
        channel.ask("device_del")


def test_a_machine_that_goes_off_is_told(tmp_path: Path) -> None:
    with peer(tmp_path, b"") as channel, pytest.raises(TrialError, match="the machine is off"):
        channel.ask("query-status")
