"""Arguments, contents and instructions of the bundle; the download needs a network: not tested."""

from pathlib import Path

from tools.deploy.bundle import (
    GLIBC,
    INSTRUCTIONS,
    ROOT,
    dependencies,
    documents,
    download_arguments,
)


def test_download_arguments_name_pinned_wheels_of_the_machine(tmp_path: Path) -> None:
    arguments = download_arguments("aarch64", tmp_path)
    assert arguments[arguments.index("--python-version") + 1] == "3.11"
    assert "manylinux2014_aarch64" in arguments
    assert f"manylinux_2_{max(GLIBC)}_aarch64" in arguments
    assert not any("x86_64" in argument for argument in arguments)
    constraints = Path(arguments[arguments.index("--constraint") + 1])
    assert "numpy==" in constraints.read_text()


def test_dependencies_are_those_of_the_onboard_part() -> None:
    names = dependencies()
    assert {"numpy", "pyserial", "eclipse-zenoh"} <= set(names)
    assert not {"aiohttp", "matplotlib", "pytest"} & set(names)


def test_instructions_use_no_network() -> None:
    assert "--no-index" in INSTRUCTIONS
    assert "http" not in INSTRUCTIONS


def test_documents_hold_those_named_by_the_instructions() -> None:
    names = {str(path.relative_to(ROOT)) for path in documents()}
    assert "tools/deploy/README.md" in names
    assert "documents/tools/deploy/README.md" in INSTRUCTIONS
    assert {"README.md", "tools/monitor/monitor.png"} <= names
    assert not any(name.startswith((".venv", "tests")) for name in names)
