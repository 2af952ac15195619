"""One line per event, with a priority where the system's journal reads."""

import io

from robot_agent.messages.foxglove import Log, timestamp_at
from robot_agent.messages.log_level import LogLevel
from robot_agent.messages.streams import encode
from robot_agent.process.journal import Journal

EVENT = encode(
    Log(timestamp=timestamp_at(1.0, 0), level=LogLevel.WARNING, message="holds\nit", name="gate")
)


def test_line_for_a_terminal() -> None:
    out = io.StringIO()
    Journal(out, {}).write(EVENT)
    assert out.getvalue() == "warning: gate: holds it\n"


def test_a_line_for_the_systems_journal() -> None:
    out = io.StringIO()
    Journal(out, {"JOURNAL_STREAM": "8:123"}).write(EVENT)
    assert out.getvalue() == "<4>gate: holds it\n"


def test_closed_output_is_ignored() -> None:
    class Gone(io.StringIO):
        def write(self, _text: str) -> int:
            raise BrokenPipeError

    Journal(Gone(), {}).write(EVENT)
