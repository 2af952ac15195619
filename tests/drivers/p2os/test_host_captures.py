"""What independent clients sent to emulated robots, sent to them again: a real base's answers."""

from __future__ import annotations

import math
from collections.abc import Callable
from dataclasses import replace
from typing import TYPE_CHECKING

import pytest

from drivers.p2os.config_packet import decode_config
from drivers.p2os.emulator.emulator import P2osEmulator
from drivers.p2os.emulator.firmware import Firmware
from drivers.p2os.emulator.make import PIONEER_2DX
from drivers.p2os.extended_packets import decode_encoder, decode_io
from drivers.p2os.framing import PacketFramer
from drivers.p2os.sip import Sip, decode_sip

if TYPE_CHECKING:
    from conftest import Capture

PIONEER_3DX_SH = replace(PIONEER_2DX, subclass="p3dx-sh", distance_count=0.001, range_count=0.001)
HOSTS = ("host-soar-arcos-base", "host-player-base-and-laser", "host-carmen-laser-and-base")


class Replay:
    """A client's bytes fed to an emulated robot in an ideal world, at the times recorded."""

    def __init__(self, capture: Capture, firmware: Firmware) -> None:
        make = PIONEER_2DX if firmware is Firmware.P2OS else PIONEER_3DX_SH
        self.emulator = P2osEmulator(make, firmware=firmware)
        self.packets: list[tuple[float, bytes]] = []
        self.distance = self.rotation = 0.0
        self._framer = PacketFramer()
        self._now = 0.0
        for t, data in capture.side("host->robot"):
            self._run(t)
            self.emulator.feed(data, t)
        self._run(self._now + 1.0)

    @property
    def sips(self) -> list[Sip]:
        decoded = (decode_sip(packet) for _, packet in self.packets)
        return [sip for sip in decoded if sip is not None]

    def times(self, packet_type: int) -> list[float]:
        return [t for t, packet in self.packets if packet[0] == packet_type]

    def _run(self, end: float) -> None:
        while self._now < end:
            self._now = min(self._now + 0.01, end)
            distance, rotation = self.emulator.advance(self._now)
            self.emulator.turn_odometer(distance, rotation)
            self.distance += abs(distance)
            self.rotation += abs(rotation)
            for sent in self.emulator.pop_output(self._now):
                self.packets += [(sent.t, p) for p in self._framer.feed(sent.data)]


@pytest.fixture
def replay(read_capture: Callable[[str], Capture]) -> Callable[..., Replay]:
    return lambda name, firmware=Firmware.P2OS: Replay(read_capture(name), firmware)


@pytest.mark.parametrize("firmware", list(Firmware))
@pytest.mark.parametrize("name", HOSTS)
def test_each_client_finds_a_robot_that_knows_all_it_asks_for(
    replay: Callable[..., Replay], name: str, firmware: Firmware
) -> None:
    done = replay(name, firmware)
    assert [packet[0] for _, packet in done.packets[:3]] == [0, 1, 2]
    assert done.emulator.counters.sessions == 1
    assert done.emulator.counters.unknown_commands == 0
    assert done.emulator.framer.counters.bad_checksum == 0
    assert done.emulator.velocity == (0.0, 0.0)
    # Player was killed: its session stays open.
    assert done.emulator.session_open == (name == "host-player-base-and-laser")


def test_soar_gets_arcos_reports_config_encoders_and_pins(replay: Callable[..., Replay]) -> None:
    done = replay("host-soar-arcos-base", Firmware.ARCOS)
    assert done.sips
    for sip in done.sips:  # the fields that its reader needs, else it drops the packet
        assert sip.tail.battery_decivolts is not None
        assert sip.tail.charge_state == 0
        assert sip.tail.turn_rate_decidegrees_s is not None
        assert sip.flags & 0x2 == 0x2
    assert max(sip.tail.turn_rate_decidegrees_s or 0 for sip in done.sips) == 200
    configs = [config for _, p in done.packets if (config := decode_config(p)) is not None]
    assert [config.subclass for config in configs] == ["p3dx-sh"]
    for packet_type, asked_at in ((0x90, 21.788), (0xF0, 22.046)):
        times = done.times(packet_type)
        assert times[0] == pytest.approx(asked_at, abs=0.35)
        # At 9600 baud the line has no room for both in some cycles.
        assert 5.0 * (28.34 - asked_at) < len(times) < 10.5 * (28.34 - asked_at)
    assert len(done.times(0x32)) + len(done.times(0x33)) == pytest.approx(10.0 * 8.26, abs=2)
    pins = [io for _, p in done.packets if p[0] == 0xF0 and (io := decode_io(p)) is not None]
    assert (len(pins[0].inputs), len(pins[0].outputs), len(pins[0].analog_counts)) == (4, 1, 9)
    ticks = [e for _, p in done.packets if p[0] == 0x90 and (e := decode_encoder(p)) is not None]
    assert ticks[-1].right_ticks > ticks[-1].left_ticks > 0
    assert done.distance == pytest.approx(0.2 * (25.268 - 22.234), abs=0.02)
    assert done.rotation == pytest.approx(math.radians(20.0) * (27.277 - 25.268), abs=0.03)


@pytest.mark.parametrize("firmware", [Firmware.P2OS, Firmware.AROS])
def test_reports_of_other_firmware_end_before_what_soar_needs(
    replay: Callable[..., Replay], firmware: Firmware
) -> None:
    done = replay("host-soar-arcos-base", firmware)
    assert all(sip.tail.turn_rate_decidegrees_s is None for sip in done.sips)


@pytest.mark.parametrize(
    ("name", "ways"),
    [("host-player-base-and-laser", (3.5, 4.5)), ("host-carmen-laser-and-base", (1.0, 3.0))],
)
def test_wheel_speeds_of_player_and_carmen_are_driven(
    replay: Callable[..., Replay], name: str, ways: tuple[float, float]
) -> None:
    done = replay(name)
    assert ways[0] < done.distance < ways[1]
    assert done.rotation > 0.5
    gaps = [b - a for a, b in zip(done.times(0x32), done.times(0x32)[1:], strict=False)]
    assert min(gaps) > 0.08
