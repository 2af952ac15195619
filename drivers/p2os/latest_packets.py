"""The latest of each kind of packet that a robot sends besides SIP and CONFIG."""

from __future__ import annotations

from drivers.p2os.extended_packets import (
    AuxPacket,
    EncoderPacket,
    GyroPacket,
    IoPacket,
    JoystickPacket,
)
from drivers.p2os.packets import ExtendedPacket


class LatestPackets:
    """What each source said last; None for one that has said nothing in this session."""

    def __init__(self) -> None:
        self.encoder: EncoderPacket | None = None
        self.gyro: GyroPacket | None = None
        self.io: IoPacket | None = None
        self.joystick: JoystickPacket | None = None
        self.aux: dict[int, AuxPacket] = {}
        """By port, 1 to 3."""
        self.received_at: dict[type[ExtendedPacket], float] = {}
        """When a packet of each kind last came, s."""

    def update(self, packet: ExtendedPacket, t: float) -> None:
        """Keep a packet received at ``t`` in place of the one before."""
        self.received_at[type(packet)] = t
        match packet:
            case EncoderPacket():
                self.encoder = packet
            case GyroPacket():
                self.gyro = packet
            case IoPacket():
                self.io = packet
            case JoystickPacket():
                self.joystick = packet
            case AuxPacket():
                self.aux[packet.port] = packet
