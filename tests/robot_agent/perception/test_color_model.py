"""The colour model recognizes the team's colour at any brightness, and no other."""

from __future__ import annotations

import numpy as np
import pytest

from robot_agent.perception.color_model import ColorTable, log_chromaticity
from robot_agent.perception.color_settings import ColorModelSettings, ColorSettings

MAGENTA = np.array((150, 40, 225))
TABLE = ColorTable(ColorSettings())


def is_team(color: object, table: ColorTable = TABLE) -> bool:
    pixel = np.clip(np.asarray(color), 0, 255).astype(np.uint8).reshape(1, 1, 3)
    return bool(table.mask(pixel)[0, 0])


@pytest.mark.parametrize("strength", [0.3, 0.5, 0.8, 1.0, 1.1])
def test_team_colour_is_recognized_at_any_brightness(strength: float) -> None:
    assert is_team(MAGENTA * strength)


@pytest.mark.parametrize(
    "other",
    [(40, 40, 200), (50, 160, 60), (190, 90, 40), (40, 190, 220), (128, 128, 128), (140, 170, 215),
     (170, 60, 110), (3, 0, 5), (255, 255, 255), (0, 0, 0)],
)  # fmt: skip
def test_other_colours_are_not_recognized(other: tuple[int, int, int]) -> None:
    assert not is_team(other)


def test_a_pixel_goes_to_the_likelier_of_two_teams() -> None:
    crimson = np.array((95, 40, 220))
    alone = ColorTable(ColorSettings(band=ColorModelSettings(covariance=(0.1, 0.0, 0.1))))
    assert is_team(crimson, alone)
    mean = tuple(log_chromaticity(crimson[None])[0].tolist())
    theirs = ColorModelSettings(mean=mean, covariance=(0.01, 0.0, 0.01))
    ours = ColorModelSettings(covariance=(0.1, 0.0, 0.1))
    both = ColorTable(ColorSettings(band=ours, others=(theirs,)))
    assert not is_team(crimson, both)
    assert is_team(MAGENTA, both)


def test_covariance_not_positive_definite_raises() -> None:
    with pytest.raises(ValueError, match="positive definite"):
        ColorModelSettings(covariance=(0.01, 0.02, 0.01))
