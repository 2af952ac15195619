"""Settings of the team's colour and of the band that shows it."""

from __future__ import annotations

from typing import Annotated

import msgspec

Positive = Annotated[float, msgspec.Meta(gt=0.0)]


class ColorModelSettings(msgspec.Struct, frozen=True, kw_only=True, forbid_unknown_fields=True):
    """One colour in log chromaticity, which brightness does not change.

    Coordinates: ln(red / green) and ln(blue / green), of values as the camera gives them. mean:
    their means; covariance: (var of the first, covariance, var of the second). `patrol calibrate
    color` learns both. Raises ValueError if the covariance is none.
    """

    mean: tuple[float, float] = (1.5, 1.16)
    """Default: fluorescent magenta, which few things indoors have."""
    covariance: tuple[float, float, float] = (0.03, 0.0, 0.03)

    def __post_init__(self) -> None:
        """Check that the covariance is positive definite."""
        first, both, second = self.covariance
        if first <= 0.0 or second <= 0.0 or first * second <= both * both:
            raise ValueError("covariance must be positive definite: var, covariance, var")


class ColorSettings(msgspec.Struct, frozen=True, kw_only=True, forbid_unknown_fields=True):
    """The team's band, and colours of others that must not be taken for it; m and rad."""

    band: ColorModelSettings = ColorModelSettings()
    others: tuple[ColorModelSettings, ...] = ()
    """Other teams' colours: a pixel goes to the likeliest."""
    gate: Positive = 9.2
    """Squared Mahalanobis distance: 99 % of a colour's pixels."""
    band_height: Positive = 0.12
    """m from the band's lower to its upper edge."""
    band_width: Positive = 0.50
    """m across the band as seen, mean over headings."""
    band_middle: Positive = 0.30
    """m of the band's middle above the floor."""
    tilt_allowance: Positive = 0.06
    """rad the camera may pitch, or be mounted off level."""
    min_confidence: Annotated[float, msgspec.Meta(gt=0.0, lt=1.0)] = 0.3
    """Blobs of less are not told."""
    range: Positive = 4.0
    """m; beyond it no blob is believed, and its absence tells nothing."""
