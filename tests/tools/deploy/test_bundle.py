"""What the bundle asks pip for; the download itself needs a network and is a command."""

from pathlib import Path

from tools.deploy.bundle import (
    GLIBC,
    INSTRUCTIONS,
    ROOT,
    dependencies,
    documents,
    download_arguments,
)


def test_asks_for_pinned_wheels_of_the_robots_machine(tmp_path: Path) -> None:
    arguments = download_arguments("aarch64", tmp_path)
    assert arguments[arguments.index("--python-version") + 1] == "3.11"
    assert "manylinux2014_aarch64" in arguments
    assert f"manylinux_2_{max(GLIBC)}_aarch64" in arguments
    assert not any("x86_64" in argument for argument in arguments)
    constraints = Path(arguments[arguments.index("--constraint") + 1])
    assert "numpy==" in constraints.read_text()


def test_takes_what_runs_on_the_robot_and_no_more() -> None:
    names = dependencies()
    assert {"numpy", "pyserial", "eclipse-zenoh"} <= set(names)
    assert not {"aiohttp", "matplotlib", "pytest"} & set(names)


def test_instructions_use_no_network() -> None:
    assert "--no-index" in INSTRUCTIONS
    assert "http" not in INSTRUCTIONS


def test_carries_what_the_instructions_refer_to() -> None:
    names = {str(path.relative_to(ROOT)) for path in documents()}
    assert "tools/deploy/README.md" in names
    assert "documents/tools/deploy/README.md" in INSTRUCTIONS
    assert {"README.md", "tools/monitor/monitor.png"} <= names
    assert not any(name.startswith((".venv", "tests")) for name in names)
