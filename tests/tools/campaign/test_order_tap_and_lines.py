"""Line faults, the order tap and the cable, on the emulated base."""

from __future__ import annotations

import os
from pathlib import Path

import numpy as np
import pytest

from drivers.emulation.fault_plan import FaultPlan
from drivers.emulation.line_faults import LineFaults
from drivers.p2os.emulator.emulator import P2osEmulator
from drivers.p2os.emulator.make import PIONEER_2DX
from tools.campaign.order_tap import OrderTap
from tools.simulation.cable import Cable

SYNC0 = bytes.fromhex("FAFB03000000")
SYNC1 = bytes.fromhex("FAFB03010001")
SYNC2 = bytes.fromhex("FAFB03020002")
OPEN = bytes.fromhex("FAFB03010001")
STOP = bytes.fromhex("FAFB031D001D")
CLOSE = bytes.fromhex("FAFB03020002")
ENABLE = bytes.fromhex("FAFB06043B0100053B")
DISABLE = bytes.fromhex("FAFB06043B0000043B")
VEL_300 = bytes.fromhex("FAFB060B3B2C01373C")
VEL_0 = bytes.fromhex("FAFB060B3B00000B3B")
RVEL_MINUS_20 = bytes.fromhex("FAFB06151B1400291B")


@pytest.fixture
def base() -> P2osEmulator:
    return P2osEmulator(PIONEER_2DX)


def test_line_without_faults_passes_everything(base: P2osEmulator) -> None:
    line = LineFaults(base, FaultPlan(), np.random.default_rng(1))
    line.feed(SYNC0, 0.0)
    assert b"".join(item.data for item in line.pop_output(1.0)) == SYNC0
    assert line.baud == 9600


def test_deaf_line_drops_input_and_mute_line_drops_output(base: P2osEmulator) -> None:
    line = LineFaults(base, FaultPlan(), np.random.default_rng(1))
    line.deaf = True
    line.feed(SYNC0, 0.0)
    assert line.pop_output(1.0) == []
    line.deaf, line.mute = False, True
    line.feed(SYNC0, 1.0)
    assert line.pop_output(2.0) == []
    line.mute = False
    assert line.pop_output(3.0) == [], "what was sent meanwhile is lost"


def test_corrupted_packet_differs_in_one_byte(base: P2osEmulator) -> None:
    line = LineFaults(base, FaultPlan(), np.random.default_rng(1))
    line.spoilt = 1.0
    line.feed(SYNC0, 0.0)
    received = b"".join(item.data for item in line.pop_output(1.0))
    assert len(received) == len(SYNC0)
    assert sum(a != b for a, b in zip(received, SYNC0, strict=True)) == 1


def test_tap_detects_orders_to_stand(base: P2osEmulator) -> None:
    tap = OrderTap(base)
    assert tap.is_standing
    for t, (packet, stands) in enumerate(
        (
            (VEL_300, False),
            (VEL_0, True),
            (RVEL_MINUS_20, False),
            (STOP, True),
            (VEL_300, False),
            (ENABLE, False),
            (DISABLE, True),
            (VEL_300, False),
            (CLOSE, True),
        )
    ):
        tap.feed(packet, float(t))
        assert tap.is_standing is stands, packet.hex()
    assert (tap.first_order, tap.first_at) == ("VEL 300", 0.0)
    tap.forget()
    assert tap.first_order == ""
    tap.feed(RVEL_MINUS_20, 20.0)
    assert (tap.first_order, tap.first_at) == ("RVEL -20", 20.0)


def test_new_session_clears_the_first_order(base: P2osEmulator) -> None:
    tap = OrderTap(base)
    tap.feed(VEL_300 + SYNC0 + SYNC1 + SYNC2 + OPEN, 1.0)
    assert base.session_open, "the tap passes on what it reads"
    assert tap.first_order == ""
    tap.feed(STOP, 2.0)
    assert (tap.first_order, tap.first_at) == ("STOP", 2.0)


def test_cable_keeps_its_name_over_unplugging(base: P2osEmulator, tmp_path: Path) -> None:
    cable = Cable(base, tmp_path / "base")
    client = os.open(cable.path, os.O_RDWR | os.O_NOCTTY)
    cable.pull()
    assert not cable.path.exists()
    with pytest.raises(OSError, match="Input/output error"):
        os.write(client, SYNC0)
    os.close(client)
    base.feed(SYNC0, 0.0)
    cable.pump(1.0)
    cable.put_back()
    assert cable.path.is_char_device()
    assert base.pop_output(2.0) == [], "what the device said meanwhile is lost"
    cable.pull()
    cable.pull()


def test_slow_line_delays_everything(base: P2osEmulator) -> None:
    line = LineFaults(base, FaultPlan(), np.random.default_rng(1))
    line.late = 0.5
    line.feed(SYNC0, 0.0)
    assert line.pop_output(0.4) == []
    late = line.pop_output(1.0)
    assert b"".join(item.data for item in late) == SYNC0
    assert all(item.t >= 0.5 for item in late)


def test_frozen_line_repeats_the_last_packet(base: P2osEmulator) -> None:
    line = LineFaults(base, FaultPlan(), np.random.default_rng(1))
    line.feed(SYNC0, 0.0)
    line.pop_output(1.0)
    line.frozen = True
    line.feed(SYNC1, 1.0)
    assert b"".join(item.data for item in line.pop_output(2.0)) == SYNC0
