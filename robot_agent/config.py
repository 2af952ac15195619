"""Configuration of one robot: a TOML file over defaults in code, strict at every depth."""

from __future__ import annotations

import math
import re
from collections.abc import Iterator
from pathlib import Path
from typing import Annotated, Any

import msgspec
import tomli_w

from drivers.camera_source import CameraSettings
from drivers.lms200.settings import LaserSettings
from drivers.p2os.model import ModelFileError, UnknownModelError, load_model, load_model_file
from drivers.p2os.settings import BaseSettings
from drivers.scanner import DEFAULT_KIND, ScannerSettings
from localization.settings import LocalizationSettings
from maps.map_folder import MAP_FILE
from maps.toml_text import TomlError, leaves, read_toml
from robot_agent.motion.gate_settings import GateSettings
from robot_agent.motion.teleop import TeleopSettings
from robot_agent.patrol.settings import PatrolSettings
from robot_agent.perception.settings import PerceptionSettings
from robot_agent.pose.pose_memory import MemorySettings, RememberedPose
from robot_agent.pose.start_pose import StartPose

MODEL_FILE_SUFFIX = ".toml"
"""A ``base.model`` that ends so is a file, any other the name of a shipped model."""
KeyPart = Annotated[str, msgspec.Meta(pattern=r"^[A-Za-z0-9_-]+$")]


_FORMER_KEYS = read_toml(Path(__file__).with_name("former_keys.toml").read_bytes())
RENAMED_KEYS: dict[str, str] = _FORMER_KEYS["renamed"]
"""Keys of earlier configuration files with their present names."""
FIXED_KEYS: dict[str, Any] = _FORMER_KEYS["fixed"]
"""Keys of earlier configuration files that are constants now, with the value."""


SHIPPED_MAPS = Path(__file__).resolve().parent.parent / "maps"
"""Folder of the maps that come with the product."""
_PATHS = (
    *(("recorder", "folder"), ("memory", "file"), ("patrol", "rules_file"), ("telemetry", "keys")),
)
"""Section and key of the paths that are always files or folders of one's own."""


class ConfigError(ValueError):
    """An unusable configuration; the message names file, key and remedy."""


class RobotSettings(msgspec.Struct, frozen=True, kw_only=True, forbid_unknown_fields=True):
    """Name, team and random seed of this robot."""

    name: Annotated[
        KeyPart,
        msgspec.Meta(description="Name of this robot, which no other of the team has"),
    ] = "robot1"
    team: Annotated[KeyPart, msgspec.Meta(description="Name of the team")] = "team"
    seed: Annotated[int, msgspec.Meta(ge=0, description="Seed of all the agent's random draws")] = 0


class MapSettings(msgspec.Struct, frozen=True, kw_only=True, forbid_unknown_fields=True):
    """Map and border of the patrol."""

    folder: Annotated[
        str,
        msgspec.Meta(
            description="Map folder, relative to the configuration file, or name of a shipped map"
        ),
    ] = "paper_lab"
    border: Annotated[str, msgspec.Meta(description="Border file of the folder, without .toml")] = (
        "border"
    )


class TelemetrySettings(msgspec.Struct, frozen=True, kw_only=True, forbid_unknown_fields=True):
    """Endpoint and keys of telemetry."""

    operator: Annotated[
        str,
        msgspec.Meta(
            pattern=r"^$|^(tcp|tls)/[^/\s]+:\d{1,5}$",
            description="Endpoint the operator listens on, e.g. tcp/192.168.1.10:7447; empty: no"
            " telemetry",
        ),
    ] = ""
    keys: Annotated[
        str,
        msgspec.Meta(
            description="Folder of this robot's keys, as `patrol keys` makes it; needed for tls/",
        ),
    ] = ""

    def __post_init__(self) -> None:
        """Raise ValueError for a TLS endpoint without keys."""
        if self.operator.startswith("tls/") and not self.keys:
            raise ValueError(
                f"operator {self.operator} needs keys, the folder of this robot's keys"
            )


class RecorderSettings(msgspec.Struct, frozen=True, kw_only=True, forbid_unknown_fields=True):
    """Folder and disk space of the flight recorder."""

    folder: Annotated[
        str, msgspec.Meta(description="Folder of the recordings; empty: none is made")
    ] = ""
    keep_mb: Annotated[
        float,
        msgspec.Meta(
            gt=0.0,
            description="Space that all runs of this robot in the folder may take; the oldest but"
            " the last three are deleted",
            extra={"unit": "MB"},
        ),
    ] = 4000.0
    leave_free_mb: Annotated[
        float,
        msgspec.Meta(
            ge=0.0,
            description="Space of the disk never taken: runs are deleted, then recording pauses,"
            " before that",
            extra={"unit": "MB"},
        ),
    ] = 200.0


class AgentConfig(msgspec.Struct, frozen=True, kw_only=True, forbid_unknown_fields=True):
    """All settings of one agent."""

    robot: RobotSettings = RobotSettings()
    map: MapSettings = MapSettings()
    start: StartPose | None = None
    memory: MemorySettings = MemorySettings()
    remembered: RememberedPose | None = None
    """Content of the file of ``memory`` at the start: filled in by ``patrol agent``."""
    base: BaseSettings = BaseSettings()
    laser: ScannerSettings = LaserSettings()
    camera: CameraSettings = CameraSettings()
    localization: LocalizationSettings = LocalizationSettings()
    perception: PerceptionSettings = PerceptionSettings()
    patrol: PatrolSettings = PatrolSettings()
    gate: GateSettings = GateSettings()
    telemetry: TelemetrySettings = TelemetrySettings()
    recorder: RecorderSettings = RecorderSettings()
    teleop: TeleopSettings = TeleopSettings()


def load_config(path: Path) -> AgentConfig:
    """Read a robot's TOML file; the paths it names are relative to it.

    Raises:
        ConfigError: the file is missing, is not TOML, or has an unknown key, a wrong type or a
            value out of range, at any depth; or so has the model file that it names.
    """
    try:
        content = path.read_bytes()
    except OSError as error:
        raise ConfigError(
            f"{path}: cannot be read ({error.strerror}); give the path of a robot's TOML file"
        ) from error
    return _with_model_file(parse_config(content, str(path), path.parent), path)


def place_paths(table: dict[str, Any], folder: Path) -> None:
    """Make the paths in a configuration's table absolute: they are relative to its file's folder.

    ``map.folder`` and ``base.model`` stay, since they may be names of what is shipped.
    """
    for section, key in _PATHS:
        place = table.get(section)
        if isinstance(place, dict) and isinstance(path := place.get(key), str) and path:
            place[key] = str((folder / Path(path).expanduser()).absolute())


def parse_config(content: bytes, source: str, folder: Path | None = None) -> AgentConfig:
    """Decode a configuration; ``source`` names it in errors.

    folder: what paths are relative to; None leaves them as they are written.

    Raises:
        ConfigError: as ``load_config``.
    """
    try:
        table = read_toml(content)
    except TomlError as error:
        raise ConfigError(f"{source}: is not TOML: {error}; correct that line") from error
    if folder is not None:
        place_paths(table, folder)
    for place, value in leaves(table):
        if isinstance(value, float) and not math.isfinite(value):
            raise ConfigError(f"{source}: {place}: is {value}; write a finite number")
    if isinstance(table.get("laser"), dict):
        table["laser"].setdefault("kind", DEFAULT_KIND)
    try:
        return msgspec.convert(table, AgentConfig)
    except msgspec.ValidationError as error:
        raise ConfigError(_explain(source, str(error), table)) from error


def _with_model_file(config: AgentConfig, path: Path) -> AgentConfig:
    """Return the configuration with the content of its model file, if it names one.

    path: of the configuration file, whose folder the name is relative to.
    """
    model = config.base.model
    if model is None:
        return config
    try:
        if not model.endswith(MODEL_FILE_SUFFIX):
            load_model(model)
            return config
        content = load_model_file(path.parent / model)
    except (ModelFileError, UnknownModelError) as error:
        raise ConfigError(f"{path}: base.model: {error}") from error
    return msgspec.structs.replace(
        config, base=msgspec.structs.replace(config.base, model_file=content)
    )


def _explain(source: str, complaint: str, table: dict[str, Any]) -> str:
    """Turn msgspec's error about a table into «file: key: reason; remedy»."""
    reason, _, place = complaint.partition(" - at `$")
    section = place.rstrip("`").lstrip(".")
    unknown = re.match(r"Object contains unknown field `(.*)`", reason)
    if unknown:
        key = _full_key(".".join(part for part in (section, unknown[1]) if part), table)
        return f"{source}: {key}: {_former_key(key)}"
    return (
        f"{source}: {section or 'top level'}: {reason[:1].lower()}{reason[1:]}; correct the value"
    )


def _full_key(unknown: str, table: dict[str, Any]) -> str:
    """Return the first key of an unknown section if that existed before, else ``unknown``."""
    formerly = [key for key in (*RENAMED_KEYS, *FIXED_KEYS) if key.startswith(f"{unknown}.")]
    if not formerly:
        return unknown
    section: Any = table
    for name in unknown.split("."):
        section = section[name]
    return next(iter(_leaves(section, unknown)), unknown)


def _leaves(value: Any, place: str) -> Iterator[str]:
    """Yield the dotted keys of all values in a table that are no tables themselves."""
    if not isinstance(value, dict):
        yield place
        return
    for name, item in value.items():
        yield from _leaves(item, f"{place}.{name}")


def _former_key(key: str) -> str:
    """Return what is wrong with an unknown key (renamed, fixed, unknown), with the remedy."""
    if key in RENAMED_KEYS:
        return f"is called {RENAMED_KEYS[key]} now; rename it"
    if key in FIXED_KEYS:
        return f"is no setting any more but always {FIXED_KEYS[key]!r}; delete the line"
    return "unknown key; see `patrol agent --list-settings` for the known ones"


def format_config(config: AgentConfig) -> str:
    """Return the whole effective configuration as TOML; the inverse of ``parse_config``."""
    return tomli_w.dumps(_without_none(msgspec.to_builtins(config)))


def _without_none(value: Any) -> Any:
    """Drop None values, which TOML does not have; an absent key is read as None again."""
    if isinstance(value, dict):
        return {key: _without_none(item) for key, item in value.items() if item is not None}
    return value


def find_map(folder: str, relative_to: Path) -> Path:
    """Resolve a map's folder or shipped name to a path (which need not exist).

    A map beside the configuration wins over a shipped one of the same name; ``~`` is the user's
    home.
    """
    beside = relative_to / Path(folder).expanduser()
    shipped = SHIPPED_MAPS / folder
    is_name = Path(folder).name == folder
    if is_name and shipped.is_dir() and not (beside / MAP_FILE).is_file():
        return shipped
    return beside
