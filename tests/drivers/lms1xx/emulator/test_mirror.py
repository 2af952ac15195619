from __future__ import annotations

import math

import numpy as np
import pytest

from drivers.lms1xx.emulator.mirror import EmulatedMirror, beam_delays


def test_turns_follow_each_other_and_look_ahead_in_their_middles() -> None:
    mirror = EmulatedMirror(50.0, 0.5)
    assert mirror.next_turn() is None, "it stands"
    mirror.start(1.0)
    for number in range(3):
        turn = mirror.next_turn()
        assert turn is not None
        assert turn.middle == pytest.approx(1.0 + (number + 0.5) * 0.02)
        assert turn.sweep_end - turn.middle == pytest.approx(0.0075)
        assert (turn.beams, turn.increment) == (541, pytest.approx(math.radians(0.5)))
        mirror.take()


def test_turns_that_nobody_looked_at_are_counted() -> None:
    mirror = EmulatedMirror(25.0, 0.25)
    mirror.start(0.0)
    mirror.skip_to(1.0)
    turn = mirror.next_turn()
    assert turn is not None
    assert mirror.number == 25
    assert turn.middle == pytest.approx(1.02)
    assert turn.beams == 1081


def test_beams_are_measured_counter_clockwise_in_three_quarters_of_a_turn() -> None:
    delays = beam_delays(541, math.radians(0.5), 0.02)
    assert (np.diff(delays) > 0.0).all()
    assert delays[-1] - delays[0] == pytest.approx(0.015)
    assert delays[270] == pytest.approx(0.0)
