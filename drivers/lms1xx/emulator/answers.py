"""What an emulated LMS 1xx says of itself when it is read: text, counters, fields."""

from __future__ import annotations

from drivers.lms1xx.fields import FieldWriter

EVENTS = ("LMDscandata", "LFErec", "LIDoutputstate", "LIDinputstate")
"""What a client may subscribe to; only scans are ever sent."""

_READY = 1  # SCdevicestate
_MEASURING = 7  # STlms
_FIELDS = 48  # of the field evaluation, all empty

_TEXTS = {"FirmwareVersion": "V1.80.2  ", "LocationName": "not defined"}
_NUMBERS = {"ODoprh": (0x456, 4), "ODpwrc": (0x3F, 4), "SCdevicestate": (_READY, 1)}
_NAME, _VERSION = "LMS111_FieldEval", "V1.80.2"


def answer(name: str, writer: FieldWriter) -> bool:
    """Write the value of a variable that never changes; return whether there is one."""
    if name in _TEXTS:
        writer.text(_TEXTS[name])
    elif name in _NUMBERS:
        writer.unsigned(*_NUMBERS[name])
    elif name == "DeviceIdent":
        writer.text(_NAME).text(_VERSION)
    elif name == "STlms":
        writer.unsigned(_MEASURING, 2).unsigned(0, 1)
    elif name == "LIDinputstate":
        for _version_and_inputs in range(6):
            writer.unsigned(0, 2)
    elif name.startswith("field") and name[5:].isdecimal() and int(name[5:]) < _FIELDS:
        writer.unsigned(0, 1)
    else:
        return False
    return True
