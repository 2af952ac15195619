from __future__ import annotations

import math
from dataclasses import replace

import pytest

from drivers.p2os.base_state import ChargeState
from drivers.p2os.emulator.base import EmulatedBase
from drivers.p2os.emulator.board import EmulatedBoard, EmulatedPins
from drivers.p2os.emulator.firmware import Firmware
from drivers.p2os.emulator.make import PIONEER_2DX, BaseMake
from drivers.p2os.emulator.reports import encoder_report, io_report, sip_report
from drivers.p2os.sip import SIP_MOVING, SIP_STOPPED, Sip, decode_sip


def base(make: BaseMake = PIONEER_2DX) -> EmulatedBase:
    made = EmulatedBase(make)
    made.run_to(0.0)
    made.open_session()
    return made


def report(
    robot: EmulatedBase,
    firmware: Firmware = Firmware.P2OS,
    sonar: tuple[tuple[int, float], ...] = (),
) -> Sip:
    board = EmulatedBoard(robot.model, firmware)
    board.sonar.start(0.0)
    return sip_report(robot, board, sonar)


def test_idle_report_of_p2os_ends_at_the_digital_outputs() -> None:
    sip = sip_report(base(), EmulatedBoard(PIONEER_2DX, Firmware.P2OS), ())
    assert len(sip.encode()) == 25
    assert sip.packet_type == SIP_STOPPED
    assert (sip.flags, sip.sonar, sip.battery_decivolts) == (0, (), 130)
    assert not sip.is_of_later_firmware
    assert decode_sip(sip.encode()) == sip


def test_counters_and_heading_wrap_as_on_the_wire() -> None:
    robot = base()
    robot.set_odometry(-0.84, 27.6, -math.pi - 0.1)
    sip = report(robot)
    assert sip.x_counts == 0x8000 - 1000
    assert sip.y_counts == round(27.6 / 0.00084) - 0x8000
    assert sip.heading_counts == round((math.pi - 0.1) / math.tau * 4096)


def test_wheel_speeds_sonar_and_contacts_are_reported() -> None:
    robot = base()
    robot.controller.v, robot.controller.w = 0.2, 0.56
    robot.set_contact(stalled=False, front_bumpers=0b10001, rear_bumpers=0b100)
    sip = report(robot, sonar=((3, 1.0), (8, math.inf)))
    assert sip.packet_type == SIP_MOVING
    assert (sip.left_speed_counts, sip.right_speed_counts) == (100, 300)
    assert sip.sonar == ((3, round(1 / 0.000268)), (8, round(5 / 0.000268)))
    assert sip.sonar_on
    assert (sip.left_stall_byte, sip.right_stall_byte) == (0b1000, 0b100010)
    robot.set_contact(stalled=True, front_bumpers=0, rear_bumpers=0)
    stalled = report(robot)
    assert (stalled.left_stall_byte, stalled.right_stall_byte) == (1, 1)


@pytest.mark.parametrize(
    ("firmware", "tail"),
    [
        (Firmware.P2OS, (5, 0, 0, 0xFF, 0)),
        (Firmware.AROS, (5, 0, 0, 0xFF, 0, 130, 1)),
        (Firmware.ARCOS, (5, 0, 0, 0xFF, 0, 130, 1, 300, 2)),
    ],
)
def test_each_firmware_has_its_tail(firmware: Firmware, tail: tuple[int, ...]) -> None:
    robot = base()
    robot.controller.w = math.radians(30.0)
    robot.battery.charge_state = ChargeState.BULK
    robot.fault_flags = 2
    sip = report(robot, firmware)
    assert tuple(value for value in sip.tail if value is not None) == tail
    assert decode_sip(sip.encode()) == sip
    assert len(sip.encode()) == {5: 25, 7: 28, 9: 32}[len(tail)]


@pytest.mark.parametrize("firmware", [Firmware.AROS, Firmware.ARCOS])
def test_later_firmware_reports_stop_button_charger_and_arrays(firmware: Firmware) -> None:
    robot = base()
    assert report(robot, firmware).flags == 0x6  # two arrays of eight
    robot.e_stall = True
    robot.battery.charge_state = ChargeState.FLOAT
    robot.press_stop_button()
    sip = report(robot, firmware)
    assert sip.flags == 0x6 | 0x20 | 0x40 | 0x400
    assert sip.stop_button
    assert sip.charger_power
    assert (sip.left_stall_byte, sip.right_stall_byte) == (1, 1)
    assert report(robot).flags == 0x2


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
    board = EmulatedBoard(PIONEER_2DX, Firmware.P2OS)
    board.pins.outputs = 7
    packet = io_report(robot, board)
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
        sip = report(robot)
        assert sip.heading_counts == counts


def test_battery_of_24_volts_is_on_the_scale_of_12_and_real_in_later_firmware() -> None:
    robot = base(replace(PIONEER_2DX, battery=24.0))
    early = report(robot)
    later = report(robot, Firmware.ARCOS)
    assert early.battery_decivolts == later.battery_decivolts == 130
    assert later.tail.battery_decivolts == 260
