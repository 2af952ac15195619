"""What the service can read and write: its user is not the one who installs it.

The unit hides the user's home (0700 for others), has a /tmp of its own, and may write below its
state folder only.
"""

from __future__ import annotations

import os
import pwd
import stat
from collections.abc import Iterator
from pathlib import Path

from robot_agent.config import AgentConfig
from robot_agent.process.key_rights import KEY
from tools.preflight.finding import Finding, failed, ok

STATE = Path("/var/lib/patrol")
"""The unit's StateDirectory: all that the service may write."""
_PRIVATE = (Path("/tmp"), Path("/var/tmp"))  # noqa: S108 - named because it must not be used


def examine_paths(config: AgentConfig, user: str) -> list[Finding]:
    """Check every path of a configuration outside /etc/patrol as the service's user meets it.

    The paths are as they are written. Map, rules and model may be relative: they are copied.
    """
    findings = [
        *(_examine_read(key, path, user) for key, path in _paths_read(config)),
        *(_examine_write(key, path) for key, path in _paths_written(config)),
    ]
    wrong = [finding for finding in findings if finding is not None]
    return wrong or [ok("paths", f"the service's user {user} can read and write what it needs")]


def _paths_read(config: AgentConfig) -> Iterator[tuple[str, str]]:
    for key, path in (
        ("map.folder", config.map.folder),
        ("patrol.rules_file", config.patrol.rules_file),
        ("telemetry.keys", config.telemetry.keys and f"{config.telemetry.keys}/{KEY}"),
    ):
        if path.startswith(("/", "~")) or (path and key == "telemetry.keys"):
            yield key, path


def _paths_written(config: AgentConfig) -> Iterator[tuple[str, str]]:
    for key, path in (
        ("recorder.folder", config.recorder.folder),
        ("memory.file", config.memory.file),
    ):
        if path:
            yield key, path


def _examine_read(key: str, path: str, user: str) -> Finding | None:
    if path.startswith("~"):
        return failed(key, f"{path}: ~ is another home for {user}", "write the whole path")
    if not path.startswith("/"):
        remedy = f"copy them to a folder that {user} alone may read, and write its whole path"
        return failed(key, f"{path}: keys are not copied with the robot's file", remedy)
    real = Path(path).resolve()
    if any(real.is_relative_to(private) for private in _PRIVATE):
        return failed(key, f"{path}: the service has a /tmp of its own", f"move it below {STATE}")
    for place in (*reversed(real.parents), real):
        if not place.exists():
            return failed(key, f"{place}: is not there", "correct the path")
        if not may_read(place, user):
            remedy = f"move it below {STATE}, or give {user} the right to read it"
            return failed(key, f"{path}: user {user} may not read {place}", remedy)
    return None


def _examine_write(key: str, path: str) -> Finding | None:
    if Path(path).is_absolute() and Path(os.path.normpath(path)).is_relative_to(STATE):
        return None
    remedy = f"write a path below {STATE}"
    return failed(key, f"{path}: the service may write below {STATE} only", remedy)


def may_read(path: Path, user: str) -> bool:
    """Return whether a user may read a file, or read and enter a folder.

    A user that does not exist yet has the rights of others.
    """
    about = path.stat()
    needed = 0o5 if stat.S_ISDIR(about.st_mode) else 0o4
    rights = about.st_mode & 0o7
    try:
        entry = pwd.getpwnam(user)
    except KeyError:
        return rights & needed == needed
    if entry.pw_uid == 0:
        return True
    if entry.pw_uid == about.st_uid:
        rights = about.st_mode >> 6 & 0o7
    elif about.st_gid in os.getgrouplist(user, entry.pw_gid):
        rights = about.st_mode >> 3 & 0o7
    return rights & needed == needed
