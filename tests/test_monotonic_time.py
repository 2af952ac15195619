"""The onboard code does not read the wall clock, so a jump of it changes no decision."""

import ast
from pathlib import Path

ROOT = Path(__file__).parents[1]
ROOMS = ("drivers", "maps", "localization", "robot_agent")
WALL_CLOCK = {
    *("time.time", "time.time_ns", "time.ctime", "time.localtime", "time.gmtime"),
    *("time.strftime", "datetime.now", "datetime.utcnow", "datetime.today", "date.today"),
    *("time.clock_gettime", "time.clock_gettime_ns"),
}
LABELS = {
    ("robot_agent/process/runtime.py", "time.time_ns"),
    ("robot_agent/process/runtime.py", "time.time"),
    ("robot_agent/process/telemetry.py", "time.time"),
    ("robot_agent/recording/run_files.py", "datetime.now"),
}
"""The only readings: the start's labels telemetry and recordings, and names the file; the others
tell a person that the clock is not set or does not fit the certificates. No decision depends on
them."""


def wall_clock_readings(path: Path) -> set[str]:
    """Return the names by which a file reads the wall clock."""
    found = set()
    for node in ast.walk(ast.parse(path.read_text())):
        if isinstance(node, ast.Attribute):
            name = ".".join(ast.unparse(node).split(".")[-2:])
            if name in WALL_CLOCK:
                found.add(name)
        elif isinstance(node, ast.ImportFrom) and node.module == "time":
            found |= {f"time.{a.name}" for a in node.names} & WALL_CLOCK
    return found


def test_onboard_code_reads_the_wall_clock_for_labels_only():
    readings = {
        (str(path.relative_to(ROOT)), name)
        for room in ROOMS
        for path in (ROOT / room).rglob("*.py")
        for name in wall_clock_readings(path)
    }
    assert readings == LABELS
