"""The base of ``patrol emulate`` is as its options say, the rest as its truth says."""

from __future__ import annotations

import argparse
from pathlib import Path

import numpy as np
import pytest

from drivers.emulation.fault_plan import Span
from drivers.p2os.commands import Command
from drivers.p2os.config_packet import decode_config
from drivers.p2os.emulator.firmware import Firmware
from drivers.p2os.extended_packets import decode_aux
from drivers.p2os.framing import PacketFramer
from drivers.p2os.sip import Sip, decode_sip
from maps.map_folder import load_map_folder
from maps.pose import Pose
from robot_agent.config import find_map
from tools.simulation.base_options import BaseOptions, add_base_options, chosen_base
from tools.simulation.emulate_error import EmulateError
from tools.simulation.rig import RobotRig, make_rig
from tools.simulation.truth.truth import load_truth
from tools.simulation.world import World

PLACE = Pose(5.0, 13.4, 0.4)


class Robot:
    """A robot of a truth and options in an open session, under a virtual clock."""

    def __init__(self, truth: str, options: BaseOptions) -> None:
        folder = load_map_folder(find_map("paper_lab", Path()))
        world = World(folder.map, np.random.default_rng(1), load_truth("ideal").noise)
        robot = options.applied(load_truth(truth).robot)
        self.options = options
        self.rig: RobotRig = make_rig(
            *("R", world, PLACE, 0.0, robot), baud=options.baud, watchdog=options.watchdog
        )
        options.plug_in(self.rig.base)
        self.packets: list[bytes] = []
        self._framer = PacketFramer()
        self._steps = 0
        self.send(Command(0), Command(1), Command(2), Command(1, 1), Command(4, 1), Command(18))
        self.run(0.5)

    def send(self, *commands: Command) -> None:
        for command in commands:
            self.rig.base.feed(command.encode(), 0.01 * self._steps)

    def run(self, seconds: float) -> None:
        for _ in range(round(seconds / 0.01)):
            self._steps += 1
            t = 0.01 * self._steps
            self.options.press(self.rig.base, t)
            self.rig.move(t)
            for sent in self.rig.base.pop_output(t):
                self.packets += self._framer.feed(sent.data)

    @property
    def sip(self) -> Sip:
        return [sip for p in self.packets if (sip := decode_sip(p)) is not None][-1]


def parsed(*arguments: str) -> BaseOptions:
    parser = argparse.ArgumentParser()
    add_base_options(parser)
    return chosen_base(parser.parse_args(arguments))


def test_no_option_changes_nothing_of_the_truth() -> None:
    assert parsed() == BaseOptions()
    for name in ("plain", "no_bumpers", "charging", "p3dx-sh"):
        assert BaseOptions().applied(load_truth(name).robot) == load_truth(name).robot


@pytest.mark.parametrize(
    ("truth", "fields"),
    [("plain", 5), ("p2at", 5), ("p3dx", 7), ("p2d8+", 7), ("p3dx-sh", 9), ("seekur", 9)],
)
def test_each_model_reports_with_the_firmware_it_came_with(truth: str, fields: int) -> None:
    tail = Robot(truth, BaseOptions()).sip.tail
    assert sum(value is not None for value in tail) == fields


def test_firmware_of_the_option_goes_before_that_of_the_model() -> None:
    tail = Robot("plain", parsed("--firmware", "arcos")).sip.tail
    assert tail.turn_rate_decidegrees_s == 0
    tail = Robot("p3dx-sh", parsed("--firmware", "p2os")).sip.tail
    assert tail.battery_decivolts is None


def test_rate_and_watchdog_are_those_of_the_options() -> None:
    robot = Robot("plain", parsed("--p2os-baud", "38400", "--watchdog", "1.5"))
    assert robot.rig.base.baud == 38400
    [config] = [config for p in robot.packets if (config := decode_config(p)) is not None]
    assert (config.host_baud_code, config.watchdog_ms) == (2, 1500)
    robot.send(Command(50, 4), Command(2, 1))
    assert robot.rig.base.baud == 38400


def test_stop_button_is_held_from_then_to_then() -> None:
    robot = Robot("p3dx-sh", parsed("--stop-button", "1:2"))
    assert robot.sip.motors_enabled
    robot.run(1.0)
    assert (robot.sip.motors_enabled, robot.sip.stop_button) == (False, True)
    robot.send(Command(4, 1))
    robot.run(0.3)
    assert not robot.sip.motors_enabled
    robot.run(0.5)
    assert not robot.sip.stop_button
    robot.send(Command(4, 1))
    robot.run(0.3)
    assert robot.sip.motors_enabled


def test_charger_is_reported_by_firmware_that_can() -> None:
    sip = Robot("p3dx-sh", parsed("--charging")).sip
    assert sip.tail.charge_state == 1
    assert sip.charger_power
    with pytest.raises(EmulateError, match="--firmware arcos"):
        Robot("plain", parsed("--charging"))


def test_bumpers_that_are_absent_read_1() -> None:
    robot = Robot("plain", parsed("--no-bumpers"))
    assert (robot.sip.left_stall_byte, robot.sip.right_stall_byte) == (0xFE, 0xFE)


def test_plugs_return_what_is_sent_also_after_a_reset() -> None:
    robot = Robot("plain", parsed("--loop-back"))
    robot.rig.base.reset(0.5)
    robot.run(1.5)
    robot.send(Command(0), Command(1), Command(2), Command(1, 1))
    robot.send(Command(42, b"hello"), Command(43, 5))
    robot.run(0.3)
    answers = [decode_aux(packet) for packet in robot.packets if packet[0] == 0xB0]
    assert [(aux.port, aux.data) for aux in answers if aux is not None] == [(1, b"hello")]


def test_span_that_is_none_is_refused() -> None:
    assert parsed("--stop-button", "5:8").stop_button == Span(5.0, 8.0)
    with pytest.raises(EmulateError, match="use e"):
        parsed("--stop-button", "always")


def test_every_firmware_is_one_of_the_choices() -> None:
    assert {parsed("--firmware", name).firmware for name in ("p2os", "aros", "arcos")} == set(
        Firmware
    )
