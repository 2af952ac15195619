"""Header of a run: everything besides the events that its outcome depends on."""

from __future__ import annotations

import platform
from collections.abc import Mapping
from dataclasses import dataclass, field
from importlib.metadata import PackageNotFoundError, version
from pathlib import Path

from maps.map_folder import MapFolder
from maps.map_identity import identity
from robot_agent.config import AgentConfig, format_config
from robot_agent.recording.arithmetic import arithmetic, processor

SCHEMA_VERSION = 4
DEPENDENCIES = ("numpy", "opencv-python-headless", "filterpy")
"""Libraries whose arithmetic affects decisions.

shapely and scikit-fuzzy only check loaded files (self-crossing borders, fuzzy sets): another
version may refuse a file, but changes no decision.
"""
_BOOT_ID = Path("/proc/sys/kernel/random/boot_id")


@dataclass(frozen=True, slots=True)
class RunHeader:
    """Data written once, at the head of a recording."""

    robot: str
    team: str
    seed: int
    software_version: str
    start_wall_ns: int  # wall clock at agent time 0, a label only (ns since 1970)
    start_monotonic_ns: int = 0  # the host's monotonic clock at agent time 0
    source: str = "live"  # live, bench, or the log it was converted from
    schema_version: int = SCHEMA_VERSION
    map_hash: str = ""  # SHA-256 of the map's files, empty for no map
    border_hash: str = ""  # SHA-256 of the border's file, empty for no border
    versions: str = ""  # of Python and the libraries, e.g. "python 3.11.2, numpy 2.3.5"
    processor: str = ""  # of the computer, a label only
    arithmetic: str = ""  # what decides how it rounds, see ``arithmetic.arithmetic``
    boot: str = ""  # of the host: two runs with the same share the monotonic clock
    configuration: bytes = b""  # effective configuration, TOML
    map_files: Mapping[str, bytes] = field(default_factory=dict)  # the map folder's files


def header_of_run(
    config: AgentConfig,
    folder: MapFolder,
    *,
    source: str,
    start_wall_ns: int,
    start_monotonic_ns: int | None = None,
) -> RunHeader:
    """Return the header of a run on this machine.

    start_wall_ns, start_monotonic_ns: clocks at agent time 0, ns; no monotonic start if the run's
    times are not of this host's clock.
    """
    map_hash, border_hash = identity(folder.files)
    return RunHeader(
        robot=config.robot.name,
        team=config.robot.team,
        seed=config.robot.seed,
        software_version=version("border-patrol"),
        start_wall_ns=start_wall_ns,
        start_monotonic_ns=start_monotonic_ns or 0,
        source=source,
        map_hash=map_hash,
        border_hash=border_hash,
        versions=versions(),
        processor=processor(),
        arithmetic=arithmetic(),
        boot="" if start_monotonic_ns is None else boot_id(),
        configuration=format_config(config).encode(),
        map_files=folder.files,
    )


def versions() -> str:
    """Return the versions of Python and of the libraries that decisions depend on."""
    found = [f"python {platform.python_version()} {platform.machine()}"]
    for name in DEPENDENCIES:
        try:
            found.append(f"{name} {version(name)}")
        except PackageNotFoundError:
            found.append(f"{name} missing")
    return ", ".join(found)


def same_versions(recorded: str) -> bool:
    """Return whether a recording was made with the versions of this process.

    Further libraries that earlier recordings name are ignored; True for one that names none.
    """
    named = set(recorded.split(", ")) if recorded else None
    return named is None or named.issuperset(versions().split(", "))


def same_arithmetic(header: RunHeader) -> bool:
    """Return whether a recording's numbers were rounded as this process does, to the last bit.

    False for one that does not tell: numbers may differ.
    """
    return header.arithmetic == arithmetic() and same_versions(header.versions)


def boot_id() -> str:
    """Return the unique id of this host's boot; empty where it is not available."""
    try:
        return _BOOT_ID.read_text().strip()
    except OSError:
        return ""
