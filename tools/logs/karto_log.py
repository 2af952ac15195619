"""Karto logs: what Player's ``kartowriter`` driver writes of position2d and laser devices.

Elements of XML, though no parser of XML takes the files, as backslashes escape quotation marks.
``DrivePose`` is odometry, ``RangeScan`` a scan, ``LocalizedRangeScan`` one with the drive's pose,
``LaserRangeFinder`` the laser's mount. m, rad, s; the axes are X to the left, Y up and Z ahead.
"""

from __future__ import annotations

import math
import re

import numpy as np

from maps.input_limits import MAX_BEAMS
from maps.pose import Pose, wrap_angle
from tools.logs.carmen_lines import LaserParameters, OdometryLine, ScanLine

_LOOKED_AT = 2000  # characters in which the root element must begin
# A scan of a sonar has attributes, those read here have none.
_ELEMENT = re.compile(
    r"<(DrivePose|RangeScan|LocalizedRangeScan|LaserRangeFinder)>(.*?)</\1>", re.DOTALL
)
_DEVICE = re.compile(r"<(?:Device)?ID>([^<]*)<")
_READING = re.compile(r"<float>([^<]*)</float>")
_WHOLE_TURN = 6.4  # rad; and a little


def is_karto_log(text: str) -> bool:
    """Whether a text is a Karto log."""
    return "<KartoLogger" in text[:_LOOKED_AT]


def karto_elements(text: str) -> list[tuple[int, str]]:
    """Return the elements of drive and first laser, each with the number of its first line."""
    found, line, counted = [], 1, 0
    laser = ""
    for match in _ELEMENT.finditer(text):
        line += text.count("\n", counted, match.start())
        counted = match.start()
        if match.group(1) != "DrivePose":
            device = "".join(_DEVICE.findall(match.group(2))[:1])
            laser = laser or device
            if device != laser:
                continue
        found.append((line, match.group()))
    return found


def parse_karto_element(
    element: str, parameters: LaserParameters
) -> OdometryLine | ScanLine | None:
    """Decode one element; None for a laser's mount, which changes the parameters.

    Raises ValueError.
    """
    kind = element[1 : element.index(">")]
    if kind == "LaserRangeFinder":
        parameters.ahead, parameters.left, parameters.turned = _pose(element)
        return None
    t = _number(element, "Time")
    if kind == "DrivePose":
        return OdometryLine(t, _pose(element))
    readings = np.array(_READING.findall(element), dtype=np.float64)
    first, last = _number(element, "MinAngle"), _number(element, "MaxAngle")
    count = len(readings)
    if not (2 <= count <= MAX_BEAMS and 0.0 < last - first <= _WHOLE_TURN):
        raise ValueError(f"{kind} with {count} beams from {first:g} to {last:g} rad")
    pose = _pose(element) if kind == "LocalizedRangeScan" else None
    return ScanLine(
        kind="laser",
        t=t,
        readings=readings,
        reach=math.inf,
        angle_min=first,
        angle_increment=(last - first) / (count - 1),
        laser=None if pose is None else pose.compose(parameters.mount),
        robot=pose,
    )


def _pose(element: str) -> Pose:
    place, _, turn = element.partition("<Orientation>")
    heading = 2.0 * math.atan2(_number(turn, "Y"), _number(turn, "W"))
    return Pose(_number(place, "Z"), _number(place, "X"), wrap_angle(heading))


def _number(element: str, name: str) -> float:
    """Return the number in the first child of a name; raises ValueError."""
    found = re.search(rf"<{name}>([^<]*)</{name}>", element)
    value = math.nan if found is None else float(found.group(1))
    if not abs(value) < 1e10:
        raise ValueError(f"{name} is not a finite number of a log")
    return value
