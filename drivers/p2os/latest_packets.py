"""The latest of each kind of packet that a robot sends besides SIP and CONFIG."""

from __future__ import annotations

from drivers.p2os.extended_packets import (
    AuxPacket,
    BatteryPacket,
    EncoderPacket,
    GripperPacket,
    GyroPacket,
    IoPacket,
    JoystickPacket,
)
from drivers.p2os.packets import ExtendedPacket


class LatestPackets:
    """The latest packet of each kind; None if none came in this session."""

    def __init__(self) -> None:
        self.encoder: EncoderPacket | None = None
        self.gyro: GyroPacket | None = None
        self.io: IoPacket | None = None
        self.joystick: JoystickPacket | None = None
        self.gripper: GripperPacket | None = None
        self.battery: BatteryPacket | None = None
        self.aux: dict[int, AuxPacket] = {}
        """By port, 1 to 3."""
        self.received_at: dict[type[ExtendedPacket], float] = {}
        """Arrival time of the latest packet of each kind."""

    def update(self, packet: ExtendedPacket, t: float) -> None:
        """Replace the latest packet of this kind by one received at ``t``."""
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
            case GripperPacket():
                self.gripper = packet
            case BatteryPacket():
                self.battery = packet
            case AuxPacket():
                self.aux[packet.port] = packet
