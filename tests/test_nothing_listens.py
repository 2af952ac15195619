"""Nothing on the network moves a robot: nothing of what runs on it takes anything from there.

The sockets of running agents are looked at in tests/tools/demo/test_demo.py and
tests/robot_agent/process/test_telemetry.py; here, that no code could open another way in.
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
    """Return the names of all that a file calls."""
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


def test_no_code_on_the_robot_takes_anything_from_the_network():
    ways = {
        str(path.relative_to(ROOT)): found
        for path in onboard_files()
        if (found := calls(path) & WAYS_IN)
    }
    assert set(ways) <= {EMULATED}, "only the emulated port, which is no part of an agent, listens"


def test_no_agent_has_the_emulated_port():
    agent = [path for path in onboard_files() if "emula" not in path.name]
    users = [str(path) for path in agent if "drivers.emulation.port" in imports(path)]
    assert [user for user in users if not user.endswith("line_faults.py")] == []


def test_the_network_is_spoken_to_in_one_place():
    speakers = {
        str(path.relative_to(ROOT))
        for path in onboard_files()
        if imports(path) & {"zenoh", "aiohttp", "http", "urllib.request", "socketserver"}
    }
    assert speakers == {"robot_agent/process/telemetry.py"}
