"""The packets an open robot sends, by their first data byte.

The SYNC2 reply is not among them: its type is unique only during the handshake.
"""

from __future__ import annotations

from collections.abc import Callable

from drivers.p2os.config_packet import CONFIG_TYPE, ConfigPacket, decode_config
from drivers.p2os.extended_packets import (
    AUX_TYPES,
    BATTERY_TYPE,
    ENCODER_TYPE,
    GRIPPER_TYPE,
    GYRO_TYPE,
    IO_TYPE,
    JOYSTICK_TYPE,
    NOTIFICATION_TYPES,
    AuxPacket,
    BatteryPacket,
    EncoderPacket,
    GripperPacket,
    GyroPacket,
    IoPacket,
    JoystickPacket,
    Notification,
    decode_aux,
    decode_battery,
    decode_encoder,
    decode_gripper,
    decode_gyro,
    decode_io,
    decode_joystick,
    decode_notification,
)
from drivers.p2os.sip import SIP_TYPES, Sip, decode_sip

ExtendedPacket = (
    EncoderPacket
    | GyroPacket
    | AuxPacket
    | IoPacket
    | JoystickPacket
    | GripperPacket
    | BatteryPacket
)
Packet = Sip | ConfigPacket | ExtendedPacket | Notification

_DECODERS: dict[int, Callable[[bytes], Packet | None]] = {
    **dict.fromkeys(SIP_TYPES, decode_sip),
    CONFIG_TYPE: decode_config,
    ENCODER_TYPE: decode_encoder,
    GYRO_TYPE: decode_gyro,
    **dict.fromkeys(AUX_TYPES, decode_aux),
    IO_TYPE: decode_io,
    JOYSTICK_TYPE: decode_joystick,
    GRIPPER_TYPE: decode_gripper,
    BATTERY_TYPE: decode_battery,
    **dict.fromkeys(NOTIFICATION_TYPES, decode_notification),
}


def is_known(data: bytes) -> bool:
    """Whether a packet's data is of a type listed here."""
    return data[0] in _DECODERS


def decode_packet(data: bytes) -> Packet | None:
    """Decode a packet's data; None where its type is unknown or it is too short."""
    decoder = _DECODERS.get(data[0])
    return None if decoder is None else decoder(data)
