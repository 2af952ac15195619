"""No onboard code receives anything from the network, so nothing on it can move a robot.

The sockets of running agents are checked in tests/tools/demo/test_demo.py and
tests/robot_agent/process/test_telemetry.py; here the source code is.
"""

import ast
from pathlib import Path

ROOT = Path(__file__).parents[1]
WAYS_IN = {
    *("bind", "listen", "accept", "create_server", "recvfrom"),
    *("declare_subscriber", "declare_queryable", "declare_querier", "declare_advanced_subscriber"),
}
EMULATED = "drivers/emulation/port.py"


def calls(path: Path) -> set[str]:
    """Return the names of all functions and methods a file calls."""
    functions = [
        node.func for node in ast.walk(ast.parse(path.read_text())) if isinstance(node, ast.Call)
    ]
    return {f.attr if isinstance(f, ast.Attribute) else getattr(f, "id", "") for f in functions}


def imports(path: Path) -> set[str]:
    found = set()
    for node in ast.walk(ast.parse(path.read_text())):
        if isinstance(node, ast.ImportFrom) and node.module:
            found.add(node.module)
        elif isinstance(node, ast.Import):
            found |= {alias.name for alias in node.names}
    return found


def onboard_files() -> list[Path]:
    rooms = ("drivers", "maps", "localization", "robot_agent")
    return [path for room in rooms for path in (ROOT / room).rglob("*.py")]


def test_no_onboard_code_receives_from_the_network():
    ways = {
        str(path.relative_to(ROOT)): found
        for path in onboard_files()
        if (found := calls(path) & WAYS_IN)
    }
    assert set(ways) <= {EMULATED}, "only the emulated port, which is no part of an agent, listens"


def test_no_onboard_code_imports_the_emulated_port():
    agent = [path for path in onboard_files() if "emula" not in path.name]
    users = [str(path) for path in agent if "drivers.emulation.port" in imports(path)]
    assert [user for user in users if not user.endswith("line_faults.py")] == []


def test_only_telemetry_uses_the_network():
    users = {
        str(path.relative_to(ROOT))
        for path in onboard_files()
        if imports(path) & {"zenoh", "aiohttp", "http", "urllib.request", "socketserver"}
    }
    assert users == {"robot_agent/process/telemetry.py"}
