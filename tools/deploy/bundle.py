"""Makes a folder to install a robot's computer from without a network: wheels and instructions.

For Debian 12 (Python 3.11, glibc 2.36) on x86-64 and arm64. Made by pip from the pinned versions.
"""

from __future__ import annotations

import hashlib
import subprocess
import sys
import tomllib
from collections.abc import Callable
from pathlib import Path

from maps.whole_file import write_whole

ROOT = Path(__file__).resolve().parents[2]
PYTHON = "3.11"
GLIBC = (17, 24, 27, 28, 31, 34, 35)
"""Minor versions of glibc 2 in wheel tags; Debian 12 runs all of them."""
ROOMS = ("drivers", "maps", "localization", "robot_agent", "tools")
DOCUMENTS = ("*.md", "*.png", "*.jpg")
"""Patterns of READMEs and their pictures."""
MACHINES = {"x86_64": "x86-64", "aarch64": "arm64"}
"""Debian's name of a machine by pip's."""

INSTRUCTIONS = """\
Border patrol: installation on a robot's computer without a network
===================================================================

Debian 12, x86-64 or arm64. Needs the Debian packages python3 and python3-venv.
Copy this folder to the robot, then as root:

    cd FOLDER
    sha256sum --check --quiet SHA256SUMS
    python3 -m venv /opt/patrol
    /opt/patrol/bin/pip install --no-index --find-links wheels \\
        --find-links wheels/$(uname -m) border-patrol
    ln -sf /opt/patrol/bin/patrol /usr/local/bin/patrol

    patrol ports                       # lines for /etc/udev/rules.d/60-patrol.rules
    patrol install robot1.toml         # the service, see documents/tools/deploy/README.md
    patrol doctor /etc/patrol/robot1.toml
"""


class BundleError(ValueError):
    """The bundle cannot be made; the message holds pip's message and a remedy."""


def make_bundle(
    target: Path, machines: list[str], report: Callable[[str], None] = lambda _: None
) -> list[Path]:
    """Fill a folder with wheels for machines, instructions and documents; return all files.

    report: called with each step's name. Raises BundleError, and OSError if the folder cannot be
    written.
    """
    if not (ROOT / "pyproject.toml").exists():
        raise BundleError(f"{ROOT}: no pyproject.toml: run this from a checkout")
    wheels = target / "wheels"
    wheels.mkdir(parents=True, exist_ok=True)
    report("building the wheel of border-patrol")
    _pip("wheel", "--no-deps", "--wheel-dir", str(wheels), str(ROOT))
    for machine in machines:
        report(f"downloading its dependencies for {MACHINES[machine]}")
        _pip("download", *download_arguments(machine, wheels / machine))
    write_whole(target / "INSTALL.txt", INSTRUCTIONS)
    for document in documents():
        copy = target / "documents" / document.relative_to(ROOT)
        write_whole(copy, document.read_bytes())
    sums = [f"{_digest(path)}  {path.relative_to(target)}\n" for path in _files(target)]
    write_whole(target / "SHA256SUMS", "".join(sums))
    return _files(target)


def download_arguments(machine: str, target: Path) -> list[str]:
    """Return pip's arguments to download the dependencies for a machine into a folder."""
    platforms = [f"manylinux_2_{minor}_{machine}" for minor in GLIBC]
    platforms.append(f"manylinux2014_{machine}")
    return [
        *("--only-binary", ":all:", "--python-version", PYTHON, "--implementation", "cp"),
        *(
            part
            for name in (*platforms, f"manylinux2014_{machine}")
            for part in ("--platform", name)
        ),
        *("--constraint", str(ROOT / "tools" / "constraints.txt"), "--dest", str(target)),
        *dependencies(),
    ]


def documents() -> list[Path]:
    """Return the documents: those of the root, and READMEs with pictures of every room."""
    found = [ROOT / name for name in ("README.md", "CHANGELOG.md", "LICENSE")]
    for room in ROOMS:
        found += [path for kind in DOCUMENTS for path in (ROOT / room).rglob(kind)]
    return sorted(found)


def dependencies() -> list[str]:
    """Return the requirements of the onboard part, as in pyproject.toml."""
    project = tomllib.loads((ROOT / "pyproject.toml").read_text())["project"]
    found: list[str] = project["dependencies"]
    return found


def _pip(*arguments: str) -> None:
    command = [
        sys.executable,
        "-P",
        "-m",
        "pip",
        "--disable-pip-version-check",
        "--quiet",
        *arguments,
    ]
    done = subprocess.run(command, capture_output=True, text=True, check=False)
    if done.returncode:
        message = " ".join(done.stderr.split()[-60:])
        raise BundleError(f"pip {arguments[0]}: {message}; is a package index reachable?")


def _files(target: Path) -> list[Path]:
    return sorted(
        path for path in target.rglob("*") if path.is_file() and path.name != "SHA256SUMS"
    )


def _digest(path: Path) -> str:
    return hashlib.sha256(path.read_bytes()).hexdigest()
