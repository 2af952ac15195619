from __future__ import annotations

import math
from dataclasses import replace

import pytest

from drivers.p2os.emulator.base import EmulatedBase
from drivers.p2os.emulator.make import PIONEER_2DX, BaseMake
from drivers.p2os.emulator.reports import EmulatedPins, encoder_report, io_report, sip_report
from drivers.p2os.sip import SIP_MOVING, SIP_STOPPED, decode_sip


def base(make: BaseMake = PIONEER_2DX) -> EmulatedBase:
    made = EmulatedBase(make)
    made.run_to(0.0)
    made.open_session()
    return made


def test_idle_report_of_p2os_ends_at_the_digital_outputs() -> None:
    sip = sip_report(base(), EmulatedPins(), None, later_firmware=False)
    assert len(sip.encode()) == 25
    assert sip.packet_type == SIP_STOPPED
    assert (sip.flags, sip.sonar, sip.battery_decivolts) == (0, (), 130)
    assert not sip.is_of_later_firmware
    assert decode_sip(sip.encode()) == sip


def test_counters_and_heading_wrap_as_on_the_wire() -> None:
    robot = base()
    robot.set_odometry(-0.84, 27.6, -math.pi - 0.1)
    sip = sip_report(robot, EmulatedPins(), None, later_firmware=False)
    assert sip.x_counts == 0x8000 - 1000
    assert sip.y_counts == round(27.6 / 0.00084) - 0x8000
    assert sip.heading_counts == round((math.pi - 0.1) / math.tau * 4096)


def test_wheel_speeds_sonar_and_contacts_are_reported() -> None:
    robot = base()
    robot.controller.v, robot.controller.w = 0.2, 0.56
    robot.set_contact(stalled=False, front_bumpers=0b10001, rear_bumpers=0b100)
    sip = sip_report(robot, EmulatedPins(), [(3, 1.0), (8, math.inf)], later_firmware=False)
    assert sip.packet_type == SIP_MOVING
    assert (sip.left_speed_counts, sip.right_speed_counts) == (100, 300)
    assert sip.sonar == ((3, round(1 / 0.000268)), (8, round(5 / 0.000268)))
    assert sip.sonar_on
    assert (sip.left_stall_byte, sip.right_stall_byte) == (0b1000, 0b100010)
    robot.set_contact(stalled=True, front_bumpers=0, rear_bumpers=0)
    stalled = sip_report(robot, EmulatedPins(), None, later_firmware=False)
    assert (stalled.left_stall_byte, stalled.right_stall_byte) == (1, 1)


def test_later_firmware_reports_more_fields() -> None:
    robot = base()
    robot.controller.w = math.radians(30.0)
    robot.press_stop_button()
    robot.controller.w = math.radians(30.0)
    sip = sip_report(robot, EmulatedPins(), None, later_firmware=True)
    assert sip.stop_button
    assert sip.is_of_later_firmware
    assert sip.tail.battery_decivolts == 130
    assert sip.tail.turn_rate_decidegrees_s == 300
    assert decode_sip(sip.encode()) == sip


@pytest.mark.parametrize(
    ("mask", "states", "outputs"), [(0xFF, 5, 5), (0x0F, 0, 0xA0), (1, 3, 0xAB)]
)
def test_outputs_are_set_by_mask(mask: int, states: int, outputs: int) -> None:
    pins = EmulatedPins(outputs=0xAA)
    pins.set_outputs(mask, states)
    assert pins.outputs == outputs


def test_io_report_has_bumpers_low_where_pressed_and_the_battery() -> None:
    robot = base()
    robot.set_contact(stalled=False, front_bumpers=0b1, rear_bumpers=0b10)
    robot.battery.volts = 10.0
    packet = io_report(robot, EmulatedPins(outputs=7))
    assert packet.inputs == bytes((0xFF, 0b11111101, 0b11111011, 0))
    assert packet.outputs == b"\x07"
    assert packet.analog_counts == (0, 0, 0, 0, 512)


def test_encoder_report_has_the_ticks() -> None:
    robot = base()
    robot.turn_odometer(1.0, 0.0)
    packet = encoder_report(robot)
    assert (packet.left_ticks, packet.right_ticks) == robot.ticks == (128_000, 128_000)


def test_heading_of_a_pioneer_1_has_1024_counts_a_turn() -> None:
    robot = base(replace(PIONEER_2DX, heading_counts=1024))
    for theta, counts in ((math.pi / 2, 256), (-math.pi / 2, -256), (math.pi, -512)):
        robot.set_odometry(0.0, 0.0, theta)
        sip = sip_report(robot, EmulatedPins(), None, later_firmware=False)
        assert sip.heading_counts == counts


def test_battery_of_24_volts_is_on_the_scale_of_12_and_real_in_later_firmware() -> None:
    robot = base(replace(PIONEER_2DX, battery=24.0))
    early = sip_report(robot, EmulatedPins(), None, later_firmware=False)
    later = sip_report(robot, EmulatedPins(), None, later_firmware=True)
    assert early.battery_decivolts == later.battery_decivolts == 130
    assert later.tail.battery_decivolts == 260
