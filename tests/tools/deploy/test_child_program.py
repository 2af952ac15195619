"""Child processes run this checkout's code, whatever the working directory holds."""

from __future__ import annotations

import hashlib
import os
import shutil
import subprocess
import sys
from pathlib import Path

import pytest

import tools
from tools.deploy import child_program
from tools.deploy.child_program import environment, program

POOL = """
from tools.studies.soak import slope
from tools.studies.worker_pool import worker_pool

if __name__ == "__main__":
    with worker_pool(1) as pool:
        print(pool.submit(slope, [(0.0, 0.0), (1.0, 2.0), (2.0, 4.0)]).result())
"""


@pytest.fixture
def elsewhere(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> Path:
    """Return a working directory with failing packages of the same names."""
    for name in ("tools", "drivers", "robot_agent", "pip"):
        (tmp_path / name).mkdir()
        (tmp_path / name / "__init__.py").write_text("raise RuntimeError('not ours')\n")
    monkeypatch.chdir(tmp_path)
    return tmp_path


def test_folder_named_tools_in_the_working_directory_is_not_imported(elsewhere: Path) -> None:
    bare = subprocess.run(
        [sys.executable, "-m", "tools.cli", "--version"], capture_output=True, text=True
    )
    assert "not ours" in bare.stderr
    done = subprocess.run(
        program("tools.cli", "--version"), env=environment(), capture_output=True, text=True
    )
    assert (done.returncode, done.stderr) == (0, "")


def test_environment_runs_this_checkouts_code(elsewhere: Path) -> None:
    command = [sys.executable, "-P", "-c", "import tools; print(tools.__file__)"]
    done = subprocess.run(command, env=environment(), capture_output=True, text=True)
    assert done.stdout.strip() == tools.__file__


def test_demo_runs_beside_packages_of_the_same_names(elsewhere: Path) -> None:
    demo = program("tools.cli", "demo", "--robots", "1", "--duration", "3", "--headless")
    done = subprocess.run(
        [*demo, "--record", str(elsewhere / "run")],
        env=environment(),
        capture_output=True,
        text=True,
    )
    assert done.returncode == 0, done.stderr
    assert (elsewhere / "run" / "robot1.mcap").exists()


def test_worker_processes_run_beside_packages_of_the_same_names(elsewhere: Path) -> None:
    done = subprocess.run(
        [sys.executable, "-P", "-c", POOL], env=environment(), capture_output=True, text=True
    )
    assert done.stdout == "2.0\n", done.stderr


def test_users_pythonpath_follows_this_checkout(monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setenv("PYTHONPATH", os.pathsep.join(("", "/mine", "")))
    assert environment()["PYTHONPATH"] == os.pathsep.join((str(child_program.ROOT), "/mine"))


def test_installed_package_is_not_added_to_the_pythonpath(
    monkeypatch: pytest.MonkeyPatch,
) -> None:
    monkeypatch.delenv("PYTHONPATH", raising=False)
    monkeypatch.setattr(child_program.sysconfig, "get_path", lambda _: str(child_program.ROOT))
    assert environment()["PYTHONPATH"] == ""


def test_run_script_starts_the_checkouts_code(elsewhere: Path) -> None:
    checkout = elsewhere / "checkout"
    (checkout / "tools").mkdir(parents=True)
    (checkout / ".venv" / "bin").mkdir(parents=True)
    for name in ("pyproject.toml", "tools/constraints.txt", "tools/run"):
        shutil.copy(child_program.ROOT / name, checkout / name)
    sources = [checkout / "pyproject.toml", checkout / "tools" / "constraints.txt"]
    stamp = hashlib.sha256(b"".join(path.read_bytes() for path in sources)).hexdigest()
    (checkout / ".venv" / "installed-from").write_text(stamp)
    python = checkout / ".venv" / "bin" / "python"
    python.write_text('#!/bin/sh\necho "$@"\n')
    python.chmod(0o755)
    command = [sys.executable, str(checkout / "tools" / "run"), "demo", "--headless"]
    done = subprocess.run(command, capture_output=True, text=True)
    assert done.stdout == "-P -m tools.start demo --headless\n", done.stderr
