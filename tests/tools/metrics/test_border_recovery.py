"""Recovery of the patrol with wrecks on the border."""

import numpy as np
import pytest
from numpy.typing import NDArray

from maps.border import Border
from maps.border_primitives import Segment
from tools.metrics.border_recovery import recovery_figures
from tools.metrics.border_visits import BorderVisits, border_visits
from tools.metrics.wreck import Wreck

T = np.arange(0.0, 200.0, 0.1)
SPEED = 0.7  # m/s


@pytest.fixture(scope="module")
def border() -> Border:
    return Border([Segment((0.0, 0.0), (30.0, 0.0))], closed=False)


def along(s: NDArray[np.float64]) -> NDArray[np.float64]:
    return np.column_stack((s, np.zeros_like(s)))


def visits_of(
    border: Border, places: list[NDArray[np.float64]], wrecks: list[Wreck]
) -> BorderVisits:
    return border_visits(border, places, T, [wreck[:2] for wreck in wrecks])


def test_time_until_the_rest_is_driven_again_is_measured(border: Border) -> None:
    wreck = Wreck(20.0, 0.0, "robot2", 50.0)
    # From 17.5 at t = 50 to 0 and back at 0.35 m/s; another beyond the wreck.
    left = along(17.5 * np.abs(((T - 50.0) / 50.0) % 2.0 - 1.0))
    right = along(26.0 + 4.0 * np.sin(T / 5.0))
    figures = recovery_figures(
        border, [left, right], visits_of(border, [left, right], [wreck]), [wreck], SPEED
    )
    after = figures["after_wrecks"]
    assert after["driven_again_s"] == pytest.approx(50.0, abs=2.0)
    assert after["laps"] == pytest.approx(after["driven_again_s"] / (30.0 / SPEED))
    assert (after["undriven_m"], after["abandoned_m"]) == (0.0, 0.0)
    (told,) = figures["wrecks"]
    assert told["stretch_m"] == pytest.approx([18.0, 22.0])


def test_stretch_between_wrecks_without_robots_is_abandoned(border: Border) -> None:
    wrecks = [Wreck(8.0, 0.0, "robot2", 50.0), Wreck(20.0, 0.0, "robot3", 60.0)]
    left = along(3.0 + 3.0 * np.sin(T / 5.0))
    after = recovery_figures(border, [left], visits_of(border, [left], wrecks), wrecks, SPEED)[
        "after_wrecks"
    ]
    assert after["since_s"] == pytest.approx(60.0)
    assert after["driven_again_s"] is not None
    assert after["abandoned_m"] == pytest.approx(8.0 + 8.0, abs=0.6)  # 10 to 18 m, 22 to 30 m


def test_undriven_stretch_gives_no_recovery_time(border: Border) -> None:
    wreck = Wreck(20.0, 0.0, "robot2", 50.0)
    standing = along(np.full_like(T, 10.0))
    after = recovery_figures(
        border, [standing], visits_of(border, [standing], [wreck]), [wreck], SPEED
    )["after_wrecks"]
    assert after["driven_again_s"] is None
    assert after["undriven_m"] == pytest.approx(17.5, abs=0.6)


@pytest.mark.parametrize(("robots", "crowded"), [(5, False), (12, True)])
def test_undriven_length_without_room_is_crowded(
    border: Border, robots: int, crowded: bool
) -> None:
    """All robots stand between an end and a wreck at 16 m, evenly spaced."""
    wreck = Wreck(16.0, 0.0, "robot20", 50.0)
    places = [along(np.full_like(T, 1.0 + 13.0 * k / (robots - 1))) for k in range(robots)]
    figures = recovery_figures(border, places, visits_of(border, places, [wreck]), [wreck], SPEED)
    after = figures["after_wrecks"]
    assert after["undriven_m"] > 3.0
    assert after["crowded_m"] == (after["undriven_m"] if crowded else 0.0)


def test_no_wreck_gives_no_figures(border: Border) -> None:
    assert recovery_figures(border, [], None, [], SPEED) == {"wrecks": []}
