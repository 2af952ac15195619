"""Preflight of the geometry: whether mount and wheels were measured or are the vendor's."""

from __future__ import annotations

from drivers.p2os.settings import BaseSettings
from drivers.scanner import ScannerSettings
from tools.preflight.finding import Finding, ok, warning

_REMEDY = (
    "`patrol record --teleop` a drive with turns both ways, then `patrol calibrate laser` and "
    "`patrol calibrate odometry`"
)


def examine_geometry(base: BaseSettings, laser: ScannerSettings) -> Finding:
    """Check that the laser's mount or the wheels are set, as calibration does."""
    mount = "set" if laser.mount is not None else "the model's"
    wheels = "set" if base.wheel_scale is not None else "as the base counts"
    text = f"laser mount {mount}, wheels {wheels}"
    if laser.mount is None and base.wheel_scale is None:
        return warning("geometry", f"{text}: neither was calibrated", _REMEDY)
    return ok("geometry", text)
