"""The handshake against simulators and against robots with late replies."""

from __future__ import annotations

from collections.abc import Callable

import pytest

from drivers.p2os.framing import PacketFramer
from drivers.p2os.handshake import Handshake
from drivers.p2os.robot_identity import RobotIdentity
from drivers.requests import Request, Write

IDENTITY = RobotIdentity("Sim", "Pioneer", "p2dx")
SIP = bytes.fromhex("32 00 00 00 00 00 00 00 00 00 00 80 00 00 00 00 00 00 00 00 05 00 00 FF 00")


class PassiveServer:
    """Echoes any packet as the expected SYNC, as a known simulator does; a first packet numbered
    above 2 ends its handshake without a reply."""

    def __init__(self) -> None:
        self.awaited = 0

    def answer(self, packet: bytes) -> list[bytes]:
        if self.awaited > 2:
            return []
        self.awaited = packet[0] + 1
        return [IDENTITY.encode() if packet[0] == 2 else packet[:1]]


class StrictRobot:
    """Starts over at any packet out of order, as controllers do."""

    def __init__(self) -> None:
        self.awaited = 0

    def answer(self, packet: bytes) -> list[bytes]:
        number = packet[0]
        if number == 0 or number == self.awaited < 3:
            self.awaited = number + 1
            return [IDENTITY.encode() if number == 2 else packet[:1]]
        self.awaited = 0
        return []


class OpenRobot(StrictRobot):
    """Is in another client's session, and reports, until CLOSE."""

    def __init__(self) -> None:
        super().__init__()
        self.heard: list[int] = []
        self.is_open = True

    def answer(self, packet: bytes) -> list[bytes]:
        self.heard.append(packet[0])
        if not self.is_open:
            return super().answer(packet)
        self.is_open = packet[0] != 2
        return [SIP]


def shake(
    answer: Callable[[bytes], list[bytes]], delay: float, *, unasked: float | None = None
) -> tuple[RobotIdentity | None, float]:
    """Run a handshake for 5 s with replies late by ``delay`` s and a report at ``unasked``."""
    requests: list[Request] = []
    handshake, framer = Handshake(9600, requests), PacketFramer()
    handshake.start(0.0)
    coming = [] if unasked is None else [(unasked, SIP)]
    for step in range(500):
        t = 0.01 * step
        for at, packet in [item for item in coming if item[0] <= t]:
            coming.remove((at, packet))
            identity = handshake.feed(packet, t)
            if identity is not None:
                return identity, t
        if step % 5 == 0:
            handshake.tick(t)
        sent = [request.data for request in requests if isinstance(request, Write)]
        requests.clear()
        for packet in framer.feed(b"".join(sent)):
            coming += [(t + delay, reply) for reply in answer(packet)]
    return None, t


@pytest.mark.parametrize("server", [PassiveServer, StrictRobot])
@pytest.mark.parametrize("delay", [0.0, 0.02, 0.13, 0.3])
def test_every_kind_of_server_is_opened(
    server: type[PassiveServer | StrictRobot], delay: float
) -> None:
    identity, t = shake(server().answer, delay)
    assert identity == IDENTITY
    assert t <= 0.25 + 3 * (delay + 0.05)


def test_reporting_robot_gets_stop_and_close_before_sync() -> None:
    robot = OpenRobot()
    identity, t = shake(robot.answer, 0.02, unasked=0.1)
    assert identity == IDENTITY
    assert robot.heard == [29, 2, 0, 1, 2]
    assert t < 1.0


def test_missing_replies_time_out() -> None:
    identity, _ = shake(lambda _packet: [], 0.0)
    assert identity is None


def test_handshake_completes_after_late_replies_out_of_order() -> None:
    late = {"left": 1}
    robot = StrictRobot()

    def answer(packet: bytes) -> list[bytes]:
        replies = robot.answer(packet)
        if packet[0] == 0 and late["left"]:
            late["left"] -= 1
            return [b"\x01", *replies]
        return replies

    identity, t = shake(answer, 0.02)
    assert identity == IDENTITY
    assert t < 2.0
