"""Fault injection on lines: rates as configured, reproducible, no other faults."""

from __future__ import annotations

import numpy as np
import pytest

from drivers.emulation.fault_plan import FaultPlan, FaultSpecError, Span, parse_faults
from drivers.emulation.line_faults import LineFaults
from drivers.emulation.timed_bytes import TimedBytes


class Echo:
    """A device that sends received bytes back at once."""

    baud = 9600

    def __init__(self) -> None:
        self.heard = b""
        self._output: list[TimedBytes] = []

    def feed(self, data: bytes, t: float) -> None:
        self.heard += data
        self._output.append(TimedBytes(t, data))

    def pop_output(self, t: float) -> list[TimedBytes]:
        output, self._output = self._output, []
        return output


def faulty(spec: str, seed: int = 1) -> tuple[LineFaults, Echo]:
    device = Echo()
    return LineFaults(device, parse_faults(spec), np.random.default_rng(seed)), device


def sent_through(spec: str, pieces: int = 200, seed: int = 1) -> tuple[bytes, LineFaults, Echo]:
    """Feed 50 bytes every 0.1 s; return what comes back until the end."""
    line, device = faulty(spec, seed)
    back = b""
    for number in range(pieces):
        t = 0.1 * number
        line.feed(bytes((number % 256,)) * 50, t)
        back += b"".join(item.data for item in line.pop_output(t))
    back += b"".join(item.data for item in line.pop_output(1e9))
    return back, line, device


def test_every_fault_is_parsed_from_its_specification() -> None:
    spec = (
        "drop=0.01, corrupt=.001,duplicate=0.02,split=0.1,delay=0.05:0.2,"
        "silence=5:8,cut=12:15,silence=20:21,reset=20,reset=2.5"
    )
    assert parse_faults(spec) == FaultPlan(
        drop=0.01,
        corrupt=0.001,
        duplicate=0.02,
        split=0.1,
        delay=0.05,
        delay_time=0.2,
        silences=(Span(5.0, 8.0), Span(20.0, 21.0)),
        cuts=(Span(12.0, 15.0),),
        resets=(2.5, 20.0),
    )
    assert parse_faults("") == FaultPlan()


@pytest.mark.parametrize(
    "part",
    [
        *("drop", "drop=", "drop=x", "drop=-0.1", "drop=1.5", "drop=0.1:2", "delay=0.1"),
        *("silence=5", "silence=8:5", "cut=3:3", "reset=1:2", "melt=0.5", "drop=nan", "drop=1e-3"),
    ],
)
def test_bad_specifications_name_the_part_and_a_remedy(part: str) -> None:
    with pytest.raises(FaultSpecError) as failure:
        parse_faults(f"split=0.1,{part}")
    assert f"'{part}'" in str(failure.value)
    assert "use e.g. drop=0.01" in str(failure.value)


def test_without_faults_everything_passes_in_time() -> None:
    line, device = faulty("")
    line.feed(b"hello", 1.0)
    assert line.pop_output(1.0) == [TimedBytes(1.0, b"hello")]
    assert device.heard == b"hello"
    assert line.counters.passed_bytes == 10
    assert line.baud == 9600


def test_dropped_bytes_match_the_probability_and_the_counter() -> None:
    back, line, device = sent_through("drop=0.1")
    assert len(device.heard) == pytest.approx(9000, rel=0.03)
    assert len(back) == pytest.approx(8100, rel=0.03)
    assert line.counters.dropped_bytes == 10000 - len(back)


def test_corrupted_bytes_differ_in_one_bit() -> None:
    _, line, device = sent_through("corrupt=0.1")
    sent = b"".join(bytes((number % 256,)) * 50 for number in range(200))
    wrong = [a ^ b for a, b in zip(sent, device.heard, strict=True) if a != b]
    assert len(wrong) == pytest.approx(1000, rel=0.1)
    assert all(difference.bit_count() == 1 for difference in wrong)
    assert line.counters.corrupted_bytes >= len(wrong)


def test_duplicates_come_twice() -> None:
    back, line, device = sent_through("duplicate=1")
    assert len(device.heard) == 20000
    assert len(back) == 4 * 10000
    assert line.counters.duplicates == 200 + 200  # here a duplicate is one item


def test_split_writes_arrive_completely() -> None:
    line, device = faulty("split=1")
    line.feed(b"0123456789", 1.0)
    assert 1 <= len(device.heard) < 10
    line.pop_output(1.5)
    assert device.heard == b"0123456789"
    assert line.counters.splits >= 1


def test_delayed_writes_keep_their_order() -> None:
    line, device = faulty("delay=1:0.5")
    line.feed(b"first", 0.0)
    line.feed(b"second", 0.1)
    line.pop_output(0.4)
    assert device.heard == b""
    line.pop_output(0.55)
    assert device.heard == b"first"
    line.pop_output(0.65)
    assert device.heard == b"firstsecond"


def test_silence_drops_bytes_both_ways_while_it_lasts() -> None:
    back, line, device = sent_through("silence=5:8")
    assert len(device.heard) == (200 - 30) * 50
    assert back == device.heard
    assert line.counters.silenced_bytes == 30 * 50


def test_cuts_and_resets_happen_once_each_at_their_time() -> None:
    line, _ = faulty("cut=2:3,reset=5,reset=5")
    log: list[tuple[str, float]] = []
    line.on_cut = lambda t: log.append(("cut", t))
    line.on_restored = lambda t: log.append(("restored", t))
    line.on_reset = lambda t: log.append(("reset", t))
    for step in range(100):
        line.pop_output(100.0 + 0.1 * step)
    assert [name for name, _ in log] == ["cut", "restored", "reset", "reset"]
    assert [t for _, t in log] == pytest.approx([102.0, 103.0, 105.0, 105.0], abs=0.11)
    assert (line.counters.cuts, line.counters.resets) == (1, 2)


def test_same_seed_gives_same_faults_and_another_seed_others() -> None:
    spec = "drop=0.05,corrupt=0.05,duplicate=0.1,split=0.2,delay=0.1:0.3"
    first, again = sent_through(spec)[0], sent_through(spec)[0]
    assert first == again
    assert sent_through(spec, seed=2)[0] != first
