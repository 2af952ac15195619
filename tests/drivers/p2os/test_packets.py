from __future__ import annotations

import math
from dataclasses import replace

import pytest
from hypothesis import given
from hypothesis import strategies as st

from drivers.p2os.base_state import base_state
from drivers.p2os.config_packet import ConfigPacket, decode_config
from drivers.p2os.fitted_bumpers import FittedBumpers
from drivers.p2os.model import load_model
from drivers.p2os.odometer import Odometer
from drivers.p2os.robot_identity import RobotIdentity, decode_sync_reply
from drivers.p2os.sip import Sip, SipTail, decode_sip

MOVING = bytes.fromhex(
    "33 E8 03 BC 7F 00 04 C8 00 38 FF 7F 00 00 00 00 03 00 00 02 00 93 0E 08 E1 48 05 00 00 FF 00"
)
IDLE = bytes.fromhex("32 00 00 00 00 00 00 00 00 00 00 80 00 00 00 00 00 00 00 00 05 00 00 FF 00")
STALLED = bytes.fromhex(
    "32 00 00 00 00 00 00 00 00 00 00 80 09 22 00 00 01 00 00 00 05 00 00 FF 00"
)
CONFIG = bytes.fromhex(
    "20 50 69 6F 6E 65 65 72 00 70 32 64 78 00 53 49 4D 30 30 30 31 00 00 68 01 E8 03 2C 01 D0 07"
    "F4 01 73 69 6D 00 64 00 00 00 00 01 00 01 6E 00 BA 40 D0 07 00 C8 00 64 00 F4 01 32 00 64 00"
    "90 01 64 00 64 00 14 00 14 00 00 00 2C 01 2C 01 14 00 14 00 00 00"
)
SYNC_REPLY = bytes.fromhex("024D79526F626F740050696F6E65657200703264780 0".replace(" ", ""))


def sip_of(data: bytes) -> Sip:
    sip = decode_sip(data)
    assert sip is not None
    return sip


@pytest.mark.parametrize("data", [MOVING, IDLE, STALLED])
def test_documented_sips_re_encode(data: bytes) -> None:
    assert sip_of(data).encode() == data


def test_moving_sip_is_decoded() -> None:
    sip = sip_of(MOVING)
    assert (sip.packet_type, sip.x_counts, sip.y_counts) == (0x33, 1000, 32700)
    assert (sip.heading_counts, sip.left_speed_counts, sip.right_speed_counts) == (1024, 200, -200)
    assert sip.sonar == ((0, 3731), (8, 18657))
    assert sip.tail == SipTail(5, 0, 0, 0xFF, 0)
    odometer = Odometer()
    model = load_model("p2dx")
    odometer.update(0, 32700, 1024, model.conversion.distance)
    odometer.update(sip.x_counts, sip.y_counts, 1024 + 1024, model.conversion.distance)
    state = base_state(5.0, sip, odometer, model, FittedBumpers((5, 5)))
    # The counters' frame was a quarter turn ahead of odom when the reference was set.
    assert (state.x, state.y) == pytest.approx((0.0, -0.84))
    assert state.theta == pytest.approx(math.pi / 2)
    assert (state.v_left, state.v_right, state.v) == pytest.approx((0.2, -0.2, 0.0))
    assert state.w == pytest.approx(-0.2 * 5.6)
    assert state.battery == pytest.approx(12.7)
    assert (state.motors_enabled, state.sonar_on) == (True, True)
    assert state.sonar == (
        (0, pytest.approx(0.9999, abs=1e-4)),
        (8, pytest.approx(5.0001, abs=1e-4)),
    )
    assert not state.standing


def test_stalled_sip_is_decoded() -> None:
    state = base_state(0.0, sip_of(STALLED), Odometer(), load_model("p2dx"), FittedBumpers((5, 5)))
    assert (state.stall_left, state.stall_right) == (True, False)
    assert state.rear_bumpers == 1 << 2
    assert state.front_bumpers == 1 << 0 | 1 << 4
    assert (state.motors_enabled, state.sonar_on) == (True, False)
    assert state.standing


def test_battery_of_later_firmware_replaces_the_byte() -> None:
    sip = sip_of(IDLE + bytes.fromhex("7b00 00 c4ff"))
    assert sip.tail.battery_decivolts == 123
    assert sip.tail.turn_rate_decidegrees_s == -60
    seen = base_state(0.0, sip, Odometer(), load_model("p2dx"), FittedBumpers((5, 5)))
    assert seen.battery == pytest.approx(12.3)


@pytest.mark.parametrize("length", range(len(MOVING)))
def test_sip_cut_anywhere_is_none_or_re_encodes(length: int) -> None:
    sip = decode_sip(MOVING[:length]) if length else None
    assert (sip is None) == (length < 26)
    if sip is not None:
        assert sip.encode() == MOVING[:length]


@given(st.binary(min_size=20, max_size=120), st.integers(0x30, 0x3F), st.integers(0, 20))
def test_any_sip_decodes_or_not_and_re_encodes(data: bytes, kind: int, sonars: int) -> None:
    changed = bytes((kind,)) + data[1:19] + bytes((sonars,)) + data[20:]
    sip = decode_sip(changed)
    assert (sip is None) == (len(changed) < 20 + 3 * sonars)
    if sip is not None:
        assert sip.encode() == changed


@given(st.binary(min_size=1, max_size=253))
def test_no_data_raises(data: bytes) -> None:
    decode_sip(data)
    decode_sync_reply(data)
    config = decode_config(b"\x20" + data)
    assert config is not None
    assert config.encode() == b"\x20" + data


def test_sync_reply_is_decoded() -> None:
    identity = RobotIdentity("MyRobot", "Pioneer", "p2dx")
    assert decode_sync_reply(SYNC_REPLY) == identity
    assert identity.encode() == SYNC_REPLY
    assert decode_sync_reply(b"\x02") is None
    assert decode_sync_reply(MOVING) is None


def test_config_is_decoded() -> None:
    config = decode_config(CONFIG)
    assert config is not None
    assert config.encode() == CONFIG
    assert config.field_count == 36
    assert (config.robot_class, config.subclass, config.serial_number) == (
        "Pioneer",
        "p2dx",
        "SIM0001",
    )
    assert (config.turn_rate_top, config.speed_top) == (360, 1000)
    assert (config.turn_acceleration_top, config.acceleration_top) == (300, 2000)
    assert (config.pwm_max, config.name, config.sip_cycle_ms) == (500, "sim", 100)
    assert (config.front_sonar, config.rear_sonar, config.low_battery_decivolts) == (1, 1, 110)
    assert (config.revcount, config.watchdog_ms) == (16570, 2000)
    assert (config.acceleration, config.deceleration) == (300, 300)
    assert decode_config(IDLE) is None


def test_config_with_every_field() -> None:
    full = ConfigPacket(name="x", drift_factor=-7, gyro_firmware=-1, config_flags=1 << 31)
    full = replace(full, field_count=200)
    decoded = decode_config(full.encode())
    assert decoded is not None
    assert (decoded.drift_factor, decoded.gyro_firmware) == (-7, -1)
    assert decoded.config_flags == 1 << 31
