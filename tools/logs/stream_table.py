"""Any topic of a recording as CSV: one row per message, nested fields by dotted names."""

from __future__ import annotations

import csv
from pathlib import Path
from typing import Any

import msgspec

from maps.input_limits import BAD_DATA
from maps.whole_file import whole_file
from tools.logs.csv_cells import csv_cells
from tools.logs.recording import Recording, RecordingError


def stream_to_csv(recording: Recording, topic: str, target: Path) -> int:
    """Write a topic's messages; return their number.

    The first column is ``t``. Bytes of a link, and messages that are no JSON, are in hexadecimal.
    Raises RecordingError, naming
    the topics with messages, if the topic has none.
    """
    rows = [{"t": t, **_fields(topic, data)} for _topic, t, data in recording.messages((topic,))]
    if not rows:
        raise RecordingError(
            f"{recording.path}: has no message of {topic!r}; topics with messages are "
            f"{', '.join(_topics(recording))}"
        )
    columns = list(dict.fromkeys(name for row in rows for name in row))
    with whole_file(target) as part, part.open("w", newline="") as file:
        writer = csv.writer(file, lineterminator="\n")
        writer.writerow(csv_cells(columns))
        for row in rows:
            writer.writerow(csv_cells(row.get(name, "") for name in columns))
    return len(rows)


def _topics(recording: Recording) -> list[str]:
    return sorted({topic for topic, _t, _data in recording.messages(None)})


def _fields(topic: str, data: bytes) -> dict[str, Any]:
    if topic.endswith(("/rx", "/tx")):
        return {"hex": data.hex()}
    try:
        return dict(_flat("", msgspec.json.decode(data)))
    except BAD_DATA:
        return {"unreadable": data.hex()}


def _flat(name: str, value: Any) -> list[tuple[str, Any]]:
    """Return the leaves of a JSON value with their dotted names."""
    if isinstance(value, dict):
        children = list(value.items())
    elif isinstance(value, list):
        children = [(str(index), item) for index, item in enumerate(value)]
    else:
        return [(name, value)]
    prefix = f"{name}." if name else ""
    return [leaf for key, item in children for leaf in _flat(prefix + key, item)]
