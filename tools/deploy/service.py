"""Installs the agent on a machine: service started at boot, udev rules, user, configurations.

Files are written below a root folder, so that an installation can be inspected beforehand.
"""

from __future__ import annotations

import os
import re
import shutil
import subprocess
import sys
from collections.abc import Sequence
from dataclasses import dataclass, field
from pathlib import Path

from maps.map_folder import MAP_FILE
from maps.whole_file import write_whole
from robot_agent.config import AgentConfig, load_config, parse_config
from tools.deploy.service_paths import examine_paths
from tools.preflight.doctor import NeverDrivesError, load_patrol_map
from tools.preflight.finding import Finding, Verdict, failed, ok, warning

DEPLOY = Path(__file__).parent
UNIT = Path("etc/systemd/system/patrol@.service")
RULES = Path("etc/udev/rules.d/60-patrol.rules")
USER = Path("etc/sysusers.d/patrol.conf")
MODULES = Path("etc/modules-load.d/patrol.conf")
SERIAL_DRIVERS = ("usbserial", "ftdi_sio", "pl2303", "cp210x", "cdc_acm")
"""Kernel modules of the usual adapters. Loaded before the service: its device filter knows only the
kinds of devices whose driver is there when it starts."""
CAMERA_DRIVERS = ("videodev", "uvcvideo")
CONFIGS = Path("etc/patrol")
_IMAGE_FOLDER = re.compile(rb"^(image:\s*['\"]?)[^\n]*/", re.MULTILINE)
"""Of a map's description: begin of the line that names the image, and the image's folder."""
ACTIVATION = (
    ("systemd-sysusers",),
    ("systemctl", "restart", "systemd-modules-load.service"),
    ("systemctl", "daemon-reload"),
    ("udevadm", "control", "--reload"),
    ("udevadm", "trigger", "--subsystem-match=tty"),
)
"""Commands by which a running system takes over an installation."""
RUNNING_SYSTEMD = Path("/run/systemd/system")
MAX_EXPOSURE = 3.0
"""Largest exposure, of 10, that `systemd-analyze security` may give the unit."""


class DeploymentError(ValueError):
    """A configuration cannot be installed; the message names it and a remedy."""


@dataclass(slots=True)
class Deployment:
    """Files written, files kept, and the findings of the checks."""

    written: list[Path] = field(default_factory=list)
    kept: list[Path] = field(default_factory=list)
    findings: list[Finding] = field(default_factory=list)

    @property
    def fit(self) -> bool:
        """Whether no check has failed."""
        return not any(finding.verdict is Verdict.FAILED for finding in self.findings)


def deploy(root: Path, configs: Sequence[Path], user: str, program: Path) -> Deployment:
    """Write unit, udev rules, user and configurations below ``root``, and check them.

    Map, rules and model that a configuration names relative to itself are copied with it. Existing
    udev rules are kept, since they name this robot's adapters. Raises DeploymentError and
    the errors of ``load_config``, before anything is written.
    """
    loaded = {path: _drivable(path) for path in configs}
    beside = {path: _files_beside(path, config) for path, config in loaded.items()}
    done = Deployment()
    text = (DEPLOY / UNIT.name).read_text()
    text = text.replace("@PATROL@", str(program)).replace("@USER@", user)
    _write(done, root / UNIT, text)
    _write(done, root / USER, f'u {user} - "Border patrol" /var/lib/patrol\nm {user} dialout\n')
    cameras = any(config.camera.url.startswith("/dev/") for config in loaded.values())
    modules = (*SERIAL_DRIVERS, *(CAMERA_DRIVERS if cameras else ()))
    _write(done, root / MODULES, "# For patrol@.service\n" + "".join(f"{m}\n" for m in modules))
    if (root / RULES).exists():
        done.kept.append(root / RULES)
    else:
        _write(done, root / RULES, (DEPLOY / RULES.name).read_text())
    for path, config in loaded.items():
        _write(done, root / CONFIGS / path.name, path.read_text())
        for file in beside[path]:
            _write(done, root / CONFIGS / file, _movable(path.parent / file))
        done.findings += examine_paths(config, user)
    done.findings += [_program(program), *check_unit(root / UNIT)]
    return done


def _files_beside(path: Path, config: AgentConfig) -> list[Path]:
    """Return the files, relative to a configuration, that it names so: map, rules, model.

    Raises DeploymentError for one that lies above its folder.
    """
    folder = Path(config.map.folder)
    named = [folder / name.name for name in sorted((path.parent / folder).glob("*.*"))]
    if folder.is_absolute() or not (path.parent / folder / MAP_FILE).is_file():
        named = []  # nothing to copy: it stays where it is, or is a shipped one
    named += [Path(name) for name in (config.patrol.rules_file, config.base.model or "") if name]
    files = [file for file in named if not file.is_absolute() and (path.parent / file).is_file()]
    for file in files:
        if ".." in file.parts:
            raise DeploymentError(
                f"{path}: {file} lies above this file, which will be in /{CONFIGS}: move it beside"
                " the file, or write its whole path"
            )
    return files


def _movable(file: Path) -> bytes:
    """Return a file's content; a map's image is named without folders, which may be absolute."""
    content = file.read_bytes()
    return _IMAGE_FOLDER.sub(rb"\1", content) if file.name == MAP_FILE else content


def _write(done: Deployment, path: Path, content: str | bytes) -> None:
    write_whole(path, content)
    done.written.append(path)


def _drivable(path: Path) -> AgentConfig:
    """Return a configuration, its paths as they are written: they will be relative to CONFIGS.

    Raises DeploymentError if it could never patrol.
    """
    try:
        load_patrol_map(load_config(path), path.parent)
    except NeverDrivesError as error:
        raise DeploymentError(f"{path}: can never patrol: {error}") from error
    return parse_config(path.read_bytes(), str(path))


def _program(program: Path) -> Finding:
    if not program.is_file():
        return failed("program", f"{program}: not there", "install the package, give --program")
    return ok("program", str(program))


def check_unit(unit: Path) -> list[Finding]:
    """Check a unit file with systemd-analyze: syntax, and exposure of the service.

    Returns one warning where systemd-analyze is not installed.
    """
    if shutil.which("systemd-analyze") is None:
        return [
            warning("unit", "systemd-analyze is not there to check it", "check it on the robot")
        ]
    # A template can only be checked under the name of an instance.
    instance = unit.with_name(unit.name.replace("@.", "@robot1."))
    shutil.copyfile(unit, instance)
    try:
        return [_verify(instance, unit), _exposure(instance)]
    finally:
        instance.unlink()


def _verify(instance: Path, unit: Path) -> Finding:
    done = _analyze("verify", "--man=no", "--recursive-errors=no", str(instance))
    complaints = [line for line in done.stderr.splitlines() if line.strip()]
    if done.returncode:
        return failed("unit", " | ".join(complaints) or "refused", f"correct {unit}")
    return ok("unit", "systemd-analyze verify accepts it")


def _exposure(instance: Path) -> Finding:
    done = _analyze(
        *("security", "--offline=true", f"--threshold={MAX_EXPOSURE * 10:.0f}", "--no-pager"),
        str(instance),
    )
    last = next(
        (line for line in reversed(done.stdout.splitlines()) if "exposure level" in line), ""
    )
    words = last.partition(":")[2].strip() or done.stderr.strip()
    if done.returncode:
        return failed("exposure", words, f"harden the unit to {MAX_EXPOSURE:g} or less of 10")
    return ok("exposure", f"{words.split()[0]} of 10")


def _analyze(*arguments: str) -> subprocess.CompletedProcess[str]:
    return subprocess.run(
        ["systemd-analyze", *arguments], capture_output=True, text=True, check=False, timeout=60
    )


def this_program() -> Path:
    """Return the ``patrol`` program of the running environment."""
    return Path(sys.executable).with_name("patrol")


def activate(root: Path) -> list[Finding]:
    """Make the user, load the drivers, have systemd and udev read what was written.

    Only on a running system, as root and below /; nothing is done, and said, anywhere else. The
    service is neither enabled nor started.
    """
    if root.resolve() != Path("/") or os.geteuid() != 0 or not RUNNING_SYSTEMD.is_dir():
        return []
    return [_activated(*step) for step in ACTIVATION]


def _activated(*command: str) -> Finding:
    words = " ".join(command)
    try:
        done = subprocess.run(command, capture_output=True, text=True, check=False, timeout=60)
    except OSError as error:
        return failed(command[0], f"{words}: {error.strerror}", "run it by hand")
    if done.returncode:
        return failed(command[0], f"{words}: {done.stderr.strip()}", "run it by hand")
    return ok(command[0], words)


def next_steps(names: Sequence[str], *, activated: bool) -> list[str]:
    """Return the commands that remain to be run for robots of these names."""
    return [
        *(() if activated else (" ".join(step) for step in ACTIVATION)),
        *(f"patrol doctor /etc/patrol/{name}.toml" for name in names or ["robot1"]),
        *(f"systemctl enable --now patrol@{name}" for name in names or ["robot1"]),
        *(f"journalctl -fu patrol@{name}" for name in names or ["robot1"]),
    ]
