"""What sonars make of the surfaces over their cones."""

from __future__ import annotations

import msgspec
import numpy as np
import pytest

from tools.simulation.sonar_echo import SonarEcho
from tools.simulation.truth.truth import load_truth

ROUGH = load_truth("rough").sonar
TRUE = msgspec.structs.replace(ROUGH, mirrors=1.0, false_echoes=0.0, crosstalk=0.0)


def echo_of(truth: object = TRUE) -> SonarEcho:
    return SonarEcho(truth, np.random.default_rng(1))  # type: ignore[arg-type]


def wall(degrees: float) -> np.ndarray:
    """Ranges over a cone to a flat wall 1 m away, turned by an angle off the perpendicular."""
    cone = echo_of().cone
    return np.cos(np.radians(degrees)) / np.cos(cone - np.radians(degrees))


@pytest.mark.parametrize(("degrees", "is_heard"), [(0, True), (30, True), (55, False)])
def test_a_flat_wall_is_heard_up_to_the_critical_angle(degrees: float, is_heard: bool) -> None:
    [echo] = echo_of().heard(wall(degrees)[None], 1, 5.0)
    assert (echo < 5.0) == is_heard


def test_a_thin_thing_before_a_steep_wall_is_heard() -> None:
    rays = wall(60)
    rays[2] = 0.5
    assert echo_of().heard(rays[None], 1, 5.0)[0] == pytest.approx(0.5)


def test_some_readings_are_false_and_never_too_far() -> None:
    truth = msgspec.structs.replace(TRUE, false_echoes=0.05)
    echoes = echo_of(truth).heard(np.full((16000, 5), 3.0), 16, 5.0)
    assert 0.04 < (echoes < 2.999).mean() < 0.06
    assert echoes.max() <= 3.0


def test_crosstalk_reads_a_neighbour() -> None:
    truth = msgspec.structs.replace(TRUE, crosstalk=1.0)
    rays = np.repeat(np.array([[1.0], [2.0], [3.0]]), 5, axis=1)
    assert echo_of(truth).heard(rays, 3, 5.0).tolist() == [1.0, 1.0, 2.0]
