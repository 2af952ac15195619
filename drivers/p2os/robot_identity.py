"""The robot's name, class and subclass from its reply to SYNC2."""

from __future__ import annotations

from dataclasses import dataclass

SYNC_REPLY = 0x02


@dataclass(frozen=True, slots=True)
class RobotIdentity:
    """Name given by the user, class (``Pioneer``) and subclass (``p2dx``) of a robot."""

    name: str
    robot_class: str
    subclass: str

    def encode(self) -> bytes:
        """Return the data of the SYNC2 reply: three NUL-terminated strings."""
        strings = (self.name, self.robot_class, self.subclass)
        return bytes((SYNC_REPLY,)) + b"".join(s.encode("latin-1") + b"\0" for s in strings)


def decode_sync_reply(data: bytes) -> RobotIdentity | None:
    """Decode a packet's data as the reply to SYNC2; None if it is not one."""
    strings = data[1:].split(b"\0")
    if data[0] != SYNC_REPLY or len(strings) < 3:
        return None
    name, robot_class, subclass = (s.decode("latin-1") for s in strings[:3])
    return RobotIdentity(name, robot_class, subclass)
