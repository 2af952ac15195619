"""The limits of all that is read from files and from the network, in one place.

Whatever is larger is refused by its reader before memory or time is spent on it. All values ours:
several times what the largest robot, map or recording at hand needs, and small beside a laptop's.
"""

from __future__ import annotations

MAX_NUMBER = 1e9
"""Largest magnitude of a number in telemetry, in whatever unit: its square is far from overflow."""
MAX_COUNT = 2**53 - 1
"""Largest counter: every reader, JavaScript too, holds it exactly."""
MAX_SECONDS = 2**32 - 1
"""Largest whole second of a time stamp: what viewers hold, until 2106."""
MAX_WORD = 128
"""Characters of a name, state or identifier."""
MAX_TEXT = 4096
"""Characters of a text for people."""
MAX_BEAMS = 4096
MAX_PARTICLES = 1000
MAX_TRACKS = 200
MAX_PARTS = 32
"""Parts of one thing: counters of a device, shapes and facts of a track."""
MAX_PAYLOAD_BYTES = 256 * 1024
"""One payload of telemetry; the largest real one, 200 particles, has a tenth of this."""
MAX_MESSAGE_BYTES = 1024 * 1024
"""One message of the network, before it is known what it is."""
MAX_QUEUE_BYTES = 4 * 1024 * 1024
"""Payloads of one robot that wait for the network: many seconds of its telemetry."""
MAX_RECORDER_QUEUE_BYTES = 64 * 1024 * 1024
"""Payloads of a team that wait for the disk."""
MAX_PICTURE_TEXT = 192 * 1024
"""Characters of a picture in a payload, base64."""
MAX_PICTURE_PIXELS = 4096 * 4096
"""Pixels of a camera's picture: the largest that a robot asks its camera for."""

MAX_DESCRIPTION_BYTES = 1024 * 1024
"""A text that people write: configuration, map description, border, floor plan."""
MAX_NUMBER_TEXT = 2**63
"""Largest integer of such a text: none of ours needs more, and a float holds it."""
MAX_DEPTH = 8
"""Nesting of a map's description, which has two levels."""
MAX_CELLS = 36_000_000
"""Cells of a map: 300 m x 300 m at 0.05 m."""
MAX_MAP_NUMBER = 1e12
"""Largest magnitude of a number in a map's description."""
MAX_COORDINATE_M = 1e5
"""Largest magnitude of a number in a border's file, m."""
MAX_BORDER_M = 10_000.0
"""Length of a border, m."""
MAX_BORDER_PIECES = 2000
"""Vertices of a border, and its segments and arcs."""
MAX_ZONES = 200
MAX_ZONE_VERTICES = 200
MAX_ZONE_NAME = 60
"""Characters of a zone's name: it is shown beside other words."""
MAX_LOG_BYTES = 96 * 1024 * 1024
"""Text of a log, decompressed; a day of a laser at 5 Hz has less."""
MAX_RECORD_BYTES = 64 * 1024 * 1024
"""One record of a recording: a chunk, decompressed, or a map's image; ours have 256 kB."""
MAX_PAUSE_S = 3600.0
"""Time between two messages of a log or recording; more is a clock that was set."""
MAX_DURATION_S = 2 * 86_400.0
"""Duration of a log, and of what one report is drawn of: it samples ten times a second."""
MAX_RECORDING_S = 1e7
"""Time in a recording: four months, which a robot may run."""

BAD_DATA = (ArithmeticError, AttributeError, LookupError, RecursionError, TypeError, ValueError)
"""What a computation raises on data it was not made for; none of them means a broken program."""
