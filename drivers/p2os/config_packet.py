"""The CONFIG packet (0x20): the controller's FLASH parameters and present limits, in wire units.

Source: Pioneer 2 and H8-series Operations Manuals; later fields as their clients read them.
"""

from __future__ import annotations

import struct
from dataclasses import dataclass, fields
from typing import Annotated, Any, get_type_hints

CONFIG_TYPE = 0x20
P2OS_FIELD_COUNT = 36

U8 = Annotated[int, "B"]
I8 = Annotated[int, "b"]
U16 = Annotated[int, "H"]
I16 = Annotated[int, "h"]
U32 = Annotated[int, "I"]
Text = Annotated[str, "text"]  # NUL-terminated


@dataclass(frozen=True, slots=True, kw_only=True)
class ConfigPacket:
    """The fields in wire order; fields that a shorter packet lacks are zero.

    ``field_count`` is how many were on the wire (P2OS_FIELD_COUNT on P2OS), ``surplus`` the bytes
    behind them.
    Speeds are in mm/s and deg/s, accelerations in mm/s^2 and deg/s^2.
    """

    robot_class: Text = ""
    subclass: Text = ""
    serial_number: Text = ""
    four_motors: U8 = 0
    turn_rate_top: U16 = 0
    speed_top: U16 = 0
    turn_acceleration_top: U16 = 0
    acceleration_top: U16 = 0
    pwm_max: U16 = 0
    name: Text = ""
    sip_cycle_ms: U8 = 0
    host_baud_code: U8 = 0
    aux1_baud_code: U8 = 0
    gripper: U16 = 0
    front_sonar: U16 = 0
    rear_sonar: U8 = 0
    low_battery_decivolts: U16 = 0
    revcount: U16 = 0
    watchdog_ms: U16 = 0
    alternative_sip: U8 = 0
    stall_pwm: U16 = 0
    stall_pause_ms: U16 = 0
    joystick_speed: U16 = 0
    joystick_turn_rate: U16 = 0
    turn_rate_max: U16 = 0
    speed_max: U16 = 0
    turn_acceleration: U16 = 0
    turn_deceleration: U16 = 0
    turn_kp: U16 = 0
    turn_kv: U16 = 0
    turn_ki: U16 = 0
    acceleration: U16 = 0
    deceleration: U16 = 0
    speed_kp: U16 = 0
    speed_kv: U16 = 0
    speed_ki: U16 = 0
    # AROS
    front_bumper_segments: U8 = 0
    rear_bumper_segments: U8 = 0
    charger_type: U8 = 0
    sonar_cycle_ms: U8 = 0
    autobaud: U8 = 0  # 1 settable, 2 switches at once
    gyro_type: U8 = 0
    # ARCOS
    drift_factor: I16 = 0
    aux2_baud_code: U8 = 0
    aux3_baud_code: U8 = 0
    ticks_per_mm: U16 = 0
    shutdown_decivolts: U16 = 0
    firmware_version: Text = ""
    gyro_clockwise: U16 = 0
    gyro_counter_clockwise: U16 = 0
    kinematics_delay_ms: U8 = 0
    lateral_speed_top: U16 = 0
    lateral_acceleration_top: U16 = 0
    lateral_speed_max: U16 = 0
    lateral_acceleration: U16 = 0
    lateral_deceleration: U16 = 0
    charge_threshold: U16 = 0
    power_board_port: U8 = 0
    gyro_rate_limit: U16 = 0
    high_temperature_celsius: I8 = 0
    power_bits: U16 = 0
    battery_type: U8 = 0
    low_charge_percent: U16 = 0
    shutdown_charge_percent: U16 = 0
    bootloader_version: Text = ""
    config_flags: U32 = 0
    gyro_firmware: I16 = 0

    field_count: int = P2OS_FIELD_COUNT
    surplus: bytes = b""

    @property
    def is_whole(self) -> bool:
        """Whether all fields of P2OS were on the wire."""
        return self.field_count >= P2OS_FIELD_COUNT

    @property
    def is_of_later_firmware(self) -> bool:
        """Whether the packet has more fields than those of P2OS."""
        return self.field_count > P2OS_FIELD_COUNT

    @property
    def states_bumpers(self) -> bool:
        """Whether the fields with the numbers of bumper segments were on the wire."""
        return self.field_count >= BUMPER_FIELD_COUNT

    def encode(self) -> bytes:
        """Return the packet's data: the first ``field_count`` fields and the surplus."""
        parts = [bytes((CONFIG_TYPE,))]
        for name, code in _LAYOUT[: self.field_count]:
            value = getattr(self, name)
            if code == "text":
                parts.append(value.encode("latin-1") + b"\0")
            else:
                parts.append(struct.pack("<" + code, value))
        return b"".join(parts) + self.surplus


def _wire_layout() -> list[tuple[str, str]]:
    hints = get_type_hints(ConfigPacket, include_extras=True)
    names = (field.name for field in fields(ConfigPacket))
    return [(n, hints[n].__metadata__[0]) for n in names if hasattr(hints[n], "__metadata__")]


_LAYOUT = _wire_layout()
BUMPER_FIELD_COUNT = [name for name, _ in _LAYOUT].index("rear_bumper_segments") + 1
"""Fields of the shortest packet with the numbers of bumper segments."""
AROS_FIELD_COUNT = [name for name, _ in _LAYOUT].index("gyro_type") + 1
"""Fields that AROS 1.8 sends."""
LATER_FIELD_COUNT = [name for name, _ in _LAYOUT].index("charge_threshold") + 1
"""Fields that ARCOS sends."""


def decode_config(data: bytes) -> ConfigPacket | None:
    """Decode a packet's data as a CONFIG, also a short one; None if it is another packet."""
    if data[0] != CONFIG_TYPE:
        return None
    values: dict[str, Any] = {}
    at = 1
    for name, code in _LAYOUT:
        size = data.find(b"\0", at) + 1 - at if code == "text" else struct.calcsize("<" + code)
        if size <= 0 or at + size > len(data):
            break
        if code == "text":
            values[name] = data[at : at + size - 1].decode("latin-1")
        else:
            (values[name],) = struct.unpack_from("<" + code, data, at)
        at += size
    return ConfigPacket(**values, field_count=len(values), surplus=data[at:])
