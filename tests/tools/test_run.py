"""``tools/run`` makes the environment of a checkout: by uv where there is one, else by pip."""

from __future__ import annotations

import os
import shutil
import subprocess
import sys
from pathlib import Path

import pytest

ROOT = Path(__file__).parents[2]
STARTED = '#!/bin/sh\necho "started $@"\n'
UV = """#!/bin/sh
echo "$@" >> {log}
if [ "$1" = venv ]; then
    mkdir -p {checkout}/.venv/bin
    cp {checkout}/started {checkout}/.venv/bin/python
fi
exit {status}
"""


@pytest.fixture
def checkout(tmp_path: Path) -> Path:
    folder = tmp_path / "checkout"
    (folder / "tools").mkdir(parents=True)
    for name in ("pyproject.toml", "tools/constraints.txt", "tools/run"):
        shutil.copy(ROOT / name, folder / name)
    executable(folder / "started", STARTED)
    return folder


def executable(path: Path, text: str) -> None:
    path.write_text(text)
    path.chmod(0o755)


def run(checkout: Path, *words: str) -> subprocess.CompletedProcess[str]:
    """Run with only the programs in ``bin`` beside the checkout and the system's own."""
    path = f"{checkout.parent / 'bin'}:/usr/bin:/bin"
    environment = {**os.environ, "PATH": path, "PIP_NO_INDEX": "1", "PIP_RETRIES": "0"}
    return subprocess.run(
        [sys.executable, str(checkout / "tools" / "run"), *words],
        env=environment,
        capture_output=True,
        text=True,
        check=False,
    )


def install_uv(checkout: Path, status: int = 0) -> Path:
    log = checkout.parent / "uv.log"
    (checkout.parent / "bin").mkdir()
    text = UV.format(log=log, checkout=checkout, status=status)
    executable(checkout.parent / "bin" / "uv", text)
    return log


def test_uv_makes_the_environment_once(checkout: Path) -> None:
    log = install_uv(checkout)
    first = run(checkout, "bench", "--help")
    assert first.stdout == "started -P -m tools.start bench --help\n"
    assert "tools/run: making .venv with uv, once" in first.stderr
    venv, install = log.read_text().splitlines()
    assert venv.startswith("venv --seed --python")
    assert f"-c {checkout}/tools/constraints.txt" in install
    assert install.endswith(f"--editable {checkout}[operator,development]")
    again = run(checkout, "demo")
    assert (again.stdout, again.stderr) == ("started -P -m tools.start demo\n", "")
    assert len(log.read_text().splitlines()) == 2


def test_pip_is_tried_where_uv_fails_and_its_failure_is_told(checkout: Path) -> None:
    install_uv(checkout, status=1)
    (checkout / ".venv").touch()  # no folder can be made: venv fails at once
    done = run(checkout, "demo")
    assert done.returncode == 1
    assert "tools/run: uv could not" in done.stderr
    assert "trying pip" in done.stderr
    assert "could not make" in done.stderr
    assert "a package index is reachable" in done.stderr
