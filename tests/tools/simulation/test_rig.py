"""A rig is what its truth says, not what a model's file says."""

from __future__ import annotations

from pathlib import Path

import numpy as np
import pytest

from drivers.lms200.framing import encode_telegram
from drivers.lms200.telegrams import Command, Mode
from maps.map_folder import load_map_folder
from maps.pose import Pose
from robot_agent.config import find_map
from tools.simulation.fan import Fan
from tools.simulation.rig import RobotRig, make_rigs, sense
from tools.simulation.truth.truth import load_truth
from tools.simulation.world import World

PLACE = Pose(5.0, 13.4, 0.4)


def make_rig(name: str) -> RobotRig:
    """Make a robot of a truth in a world without noise; its laser scans."""
    folder = load_map_folder(find_map("paper_lab", Path()))
    world = World(folder.map, np.random.default_rng(1), load_truth("ideal").noise)
    [rig] = make_rigs(world, [PLACE], 0.0, load_truth(name))
    rig.laser.feed(encode_telegram(bytes((Command.MODE, Mode.CONTINUOUS)), 0), 0.0)
    return rig


def fan_of(name: str) -> Fan:
    rig = make_rig(name)
    for step in range(1, 100):
        rig.move(0.01 * step)
        if (fan := rig.next_fan(0.01 * step)) is not None:
            return fan
    raise AssertionError("no scan is due within 1 s")


def sip_of(name: str) -> bytes:
    rig = make_rig(name)
    rig.base.base.open_session()
    rig.move(0.1)
    rig.base.emit_sip(0.1)
    return b"".join(chunk.data for chunk in rig.base.pop_output(1.0))


def test_a_rig_without_bumpers_sends_fe_fe() -> None:
    assert b"\xfe\xfe" in sip_of("no_bumpers")
    assert b"\xfe\xfe" not in sip_of("plain")


def test_a_rig_on_its_charger_reports_a_charge() -> None:
    assert len(sip_of("charging")) > len(sip_of("plain"))
    assert make_rig("charging").base.battery.charge_state == 1


def test_a_scanner_that_looks_backwards_sees_what_is_behind() -> None:
    ahead, behind = fan_of("rough"), fan_of("scanner_backwards")
    assert np.cos(ahead.angles - PLACE.theta).min() > -0.02
    assert np.cos(behind.angles - PLACE.theta).max() < 0.02
    world = make_rig("plain").world
    behind = behind._replace(ends=None)
    seen = world.scans([behind])[0].ranges
    free = [
        world.free_way(x, y, angle)
        for x, y, angle in zip(behind.x, behind.y, behind.angles, strict=True)
    ]
    assert seen == pytest.approx(free)


@pytest.mark.parametrize("name", ["laser_mirrored", "laser_upside_down"])
def test_a_mirrored_or_overturned_laser_sees_the_left_first(name: str) -> None:
    assert fan_of(name).angles == pytest.approx(fan_of("rough").angles[::-1])


@pytest.mark.parametrize("degrees", [10, 45, 180])
def test_a_turned_laser_sees_in_its_own_direction(degrees: int) -> None:
    turned = fan_of(f"laser_turned_{degrees}").angles - fan_of("rough").angles
    assert np.cos(turned - np.radians(degrees)) == pytest.approx(1.0)


def test_a_laser_that_repeats_sends_the_same_scan_wherever_the_robot_goes() -> None:
    def scans(name: str) -> list[bytes]:
        rig = make_rig(name)
        sent = []
        for step, x in ((1, 5.0), (3100, 5.0), (3500, 6.0)):
            rig.place(Pose(x, 13.4, 0.4))
            for fine in range(300):
                rig.move(0.01 * (step + fine))
                sense([rig], 0.01 * (step + fine))
            output = rig.laser.pop_output(0.01 * (step + 300))
            sent.append(b"".join(chunk.data for chunk in output)[-732:])
        return sent

    _, here, there = scans("repeated_scan")
    assert here == there
    _, here, there = scans("plain")
    assert here != there


def test_an_unknown_subclass_is_what_the_base_says_it_is() -> None:
    assert make_rig("unknown_subclass").base.identity.subclass == "p9zz"


def test_a_transducer_that_is_not_there_hears_nothing() -> None:
    rig = make_rig("powerbot")
    rig.base.base.open_session()
    for step in range(1, 80):
        sense([rig], 0.01 * step)
    truth = rig.truth.base
    far = {number for number, echo in enumerate(rig.base._ranges) if echo > truth.sonar_far}
    assert far == set(truth.no_sonar) == {7, 15, 23, 31}


def test_a_robot_without_sonars_reports_none() -> None:
    rig = make_rig("seekur")
    for step in range(1, 80):
        sense([rig], 0.01 * step)
    assert rig.truth.base.sonar == ()
    assert b"\xfa\xfb" in sip_of("seekur")
