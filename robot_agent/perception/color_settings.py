"""Settings of the team's colour and of the band that carries it."""

from __future__ import annotations

from typing import Annotated

import msgspec


class ColorModelSettings(msgspec.Struct, frozen=True, kw_only=True, forbid_unknown_fields=True):
    """One colour in log chromaticity, which is independent of brightness.

    Coordinates: ln(red / green) and ln(blue / green), of the camera's raw values. `patrol calibrate
    color` estimates both fields. Default: fluorescent magenta, which is rare indoors. Raises
    ValueError if the covariance is not positive definite.
    """

    mean: Annotated[
        tuple[float, float],
        msgspec.Meta(
            description="Means of ln(red / green) and ln(blue / green); `patrol calibrate color`"
        ),
    ] = (1.5, 1.16)
    covariance: Annotated[
        tuple[float, float, float],
        msgspec.Meta(
            description="Variance of the first, covariance, variance of the second of `mean`"
        ),
    ] = (0.03, 0.0, 0.03)

    def __post_init__(self) -> None:
        """Check that the covariance is positive definite."""
        first, both, second = self.covariance
        if first <= 0.0 or second <= 0.0 or first * second <= both * both:
            raise ValueError("covariance must be positive definite: var, covariance, var")


class ColorSettings(msgspec.Struct, frozen=True, kw_only=True, forbid_unknown_fields=True):
    """The team's band, and the colours of other teams' bands."""

    band: ColorModelSettings = ColorModelSettings()
    others: Annotated[
        tuple[ColorModelSettings, ...],
        msgspec.Meta(
            description="Other teams' colours, tables of `mean` and `covariance`: a pixel counts as"
            " the likeliest"
        ),
    ] = ()
    band_height: Annotated[
        float,
        msgspec.Meta(
            gt=0.0,
            description="Height of the band, from its lower to its upper edge",
            extra={"unit": "m"},
        ),
    ] = 0.12
    band_width: Annotated[
        float,
        msgspec.Meta(
            gt=0.0,
            description="Width of the band as seen, mean over headings",
            extra={"unit": "m"},
        ),
    ] = 0.50
    band_middle: Annotated[
        float,
        msgspec.Meta(
            gt=0.0,
            description="Height of the band's middle above the floor",
            extra={"unit": "m"},
        ),
    ] = 0.30
