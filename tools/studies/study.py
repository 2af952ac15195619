"""Studies: many benches over seeds and settings, resumable, compared in one table.

A study file holds the common settings and the varied ones:

    [study]
    map = "paper_lab"        # folder or shipped name
    border = "border"
    duration = 900.0         # s of each run
    seeds = 20               # runs of each case
    first_seed = 1
    sensing = "bytes"        # or "ideal": the decision layer alone, all seeds of a case at once
    all_knowing = false      # with ideal: also the intruder who sees all robots, in the second half
    truth = "plain"          # what robots and world really are: a shipped truth or a TOML file

    [vary]                   # every combination is a case
    robots = [3, 5]
    "patrol.reversal_probability" = [0.0, 0.25, 0.5]

``[vary]`` may also name ``map``, ``border``, ``truth`` and ``faults`` (each value as for
``bench --fault``, several separated by blanks), and with ideal sensing ``clock_error``, s by which
the robots' clocks are wrong at most, and ``clock_gain``, s a day that they gain or lose at most,
both drawn for each robot; ``clock_drift_known``: whether ``patrol.clock_drift`` of each robot says
what its clock gains. Any other key is one of a robot's configuration.
"""

from __future__ import annotations

import hashlib
import json
from collections.abc import Callable, Iterator, Sequence
from concurrent.futures import as_completed
from dataclasses import dataclass
from functools import partial
from itertools import product
from pathlib import Path
from typing import Annotated, Any

import cv2
import msgspec
import tomli_w

from maps.border import BorderError
from maps.map_folder import load_map_folder
from maps.toml_text import TomlError, read_toml
from maps.whole_file import write_whole
from robot_agent.config import AgentConfig, find_map, parse_config
from tools.batch.batch import Batch, is_possible
from tools.batch.batch_bench import MOMENTS, run_batch
from tools.batch.wrong_clocks import wrong_clocks
from tools.bench.bench_fault import BenchFaultError, check_robots, draw_faults
from tools.bench.sensing import Sensing, bench
from tools.logs.recorded_config import changed_config
from tools.simulation.truth.truth import load_truth, truth_names
from tools.studies.study_cluster import run_on_cluster
from tools.studies.worker_pool import worker_pool

ROBOTS = "robots"
MAP = "map"
BORDER = "border"
FAULTS = "faults"
TRUTH = "truth"
CLOCK_ERROR, CLOCK_GAIN = "clock_error", "clock_gain"
CLOCK_DRIFT_KNOWN = "clock_drift_known"
_CLOCKS = (CLOCK_ERROR, CLOCK_GAIN)
_BENCH_KEYS = (ROBOTS, MAP, BORDER, FAULTS, TRUTH, *_CLOCKS, CLOCK_DRIFT_KNOWN)
RUNS_FOLDER = "runs"
_ROBOTS_TOGETHER = 400
"""Of all runs of a batch: their logs take 1 MB for each robot and 1000 s."""

Setting = int | float | str | bool | tuple[str, ...]


class StudyError(ValueError):
    """A study cannot be run; the message, one line, names file, key and remedy."""


class StudySettings(msgspec.Struct, frozen=True, kw_only=True, forbid_unknown_fields=True):
    """Common settings of all runs of a study."""

    map: str = "paper_lab"
    border: str = "border"
    duration: Annotated[float, msgspec.Meta(gt=0.0)] = 900.0
    """Simulated time of each run, s."""
    seeds: Annotated[int, msgspec.Meta(ge=1)] = 20
    first_seed: Annotated[int, msgspec.Meta(ge=0)] = 1
    sensing: Sensing = Sensing.BYTES
    all_knowing: bool = False
    """Whether the intruder who sees all robots is among the figures; needs ideal sensing."""
    truth: str | None = None
    """Name or file; None for the one of the command."""


class StudyFile(msgspec.Struct, frozen=True, kw_only=True, forbid_unknown_fields=True):
    """Content of a study file."""

    study: StudySettings = StudySettings()
    vary: dict[str, list[Setting]] = {}


@dataclass(frozen=True)
class Case:
    """One combination of the varied settings, in the order of the study file."""

    values: tuple[tuple[str, Setting], ...]

    @property
    def robots(self) -> int:
        """Number of robots. Raises ValueError for what is no number."""
        return int(str(self.get(ROBOTS, 3)))

    @property
    def faults(self) -> list[str]:
        """The faults of each run, as ``bench --fault`` takes them."""
        return str(self.get(FAULTS, "")).split()

    def get(self, key: str, default: Setting) -> Setting:
        """Return the case's value of a key, else the default."""
        return dict(self.values).get(key, default)

    @property
    def clocks(self) -> tuple[float, float]:
        """Greatest error of the clocks, s, and gain, s a day; raises ValueError for no number."""
        error, gain = (float(str(self.get(key, 0.0))) for key in _CLOCKS)
        return error, gain

    @property
    def settings(self) -> dict[str, Setting]:
        """Changes of the default configuration by dotted key."""
        return {key: value for key, value in self.values if key not in _BENCH_KEYS}

    def __str__(self) -> str:
        return (
            ", ".join(f"{key} {setting_label(key, value)}" for key, value in self.values)
            or "defaults"
        )


@dataclass(frozen=True)
class Run:
    """One bench of a study."""

    case: Case
    seed: int
    map_folder: str
    border: str
    duration: float
    sensing: Sensing = Sensing.BYTES
    changes: tuple[str, ...] = ()
    """Common changes of the configuration, ``section.key=value``."""
    config: str = ""
    """Common configuration that these change, TOML."""
    truth: str = "plain"
    all_knowing: bool = False

    @property
    def file_name(self) -> str:
        """Name of the run's result file: a digest of everything the result depends on."""
        content = (
            *(self.case.values, self.seed, self.map_folder, self.border, self.duration),
            *(str(self.sensing), *self.changes),
            *(self.config, self.truth, *(["all-knowing"] if self.all_knowing else [])),
        )
        digest = hashlib.sha256(repr(content).encode()).hexdigest()
        return f"{digest[:16]}.json"


@dataclass(frozen=True)
class Study:
    """A checked study."""

    settings: StudySettings
    cases: tuple[Case, ...]
    runs: tuple[Run, ...]


@dataclass(frozen=True)
class Result:
    """One run with its figures, as ``patrol bench --json`` writes them."""

    run: Run
    figures: dict[str, Any]


def read_study(
    path: Path, changes: Sequence[str] = (), config: str = "", truth: str = "plain"
) -> Study:
    """Read and check a study file; a map folder is relative to it, or a shipped name.

    changes: ``section.key=value``, common to all cases. config: the configuration that these
    change, TOML. truth: where the file names none. Raises StudyError for the file; MapError,
    BorderError, TruthError and ConfigError for maps, borders, truths and settings it names.
    """
    try:
        content = msgspec.convert(read_toml(path.read_bytes()), StudyFile)
    except OSError as error:
        raise StudyError(f"{path}: cannot be read ({error.strerror}); give a TOML file") from None
    except TomlError as error:
        raise StudyError(f"{path}: is not TOML: {error}; correct that line") from None
    except msgspec.ValidationError as error:
        raise StudyError(f"{path}: {error}; correct the value") from None
    settings = content.study
    if settings.sensing is not Sensing.IDEAL and (key := _ideal_key(content)):
        raise StudyError(f'{path}: {key}: needs sensing = "ideal"; change one of them')
    for key, choices in content.vary.items():
        if not choices:
            raise StudyError(f"{path}: vary.{key}: is empty; list the values to try")
    cases = tuple(
        Case(tuple(zip(content.vary, values, strict=True)))
        for values in product(*content.vary.values())
    )
    common = tuple(changes)
    for case in cases:
        _check(case, path, common, config)
    borders = {case: _border_of(case, settings, path.parent) for case in cases}
    for folder, border in set(borders.values()):
        if load_map_folder(folder, border).border is None:
            raise BorderError(f"{folder}: has no {border}.toml to patrol; add one")
    seeds = range(settings.first_seed, settings.first_seed + settings.seeds)
    runs = tuple(
        Run(
            case,
            seed,
            str(borders[case][0].resolve()),
            borders[case][1],
            settings.duration,
            settings.sensing,
            common,
            config,
            _truth_of(case, settings, truth, path.parent),
            settings.all_knowing,
        )
        for seed in seeds  # outermost: an interrupted study has results of every case
        for case in cases
    )
    return Study(settings, cases, runs)


def _ideal_key(content: StudyFile) -> str | None:
    """Return the first key of a study file that only ideal sensing has; None without one."""
    if content.study.all_knowing:
        return "study.all_knowing"
    ideal = (*_CLOCKS, CLOCK_DRIFT_KNOWN)
    return next((f"vary.{key}" for key in ideal if key in content.vary), None)


def _check(case: Case, path: Path, changes: tuple[str, ...], config: str) -> None:
    settings = configuration(case, str(path), changes, config)
    robots = case.get(ROBOTS, 3)
    if not isinstance(robots, int) or isinstance(robots, bool):
        raise StudyError(
            f"{path}: vary.{ROBOTS}: {robots!r} is no number of robots; give 1 or more"
        )
    if case.robots < 1:
        raise StudyError(f"{path}: vary.{ROBOTS}: {case.robots} robots; give 1 or more")
    for key in _CLOCKS:
        value = case.get(key, 0.0)
        if not isinstance(value, int | float) or isinstance(value, bool) or value < 0.0:
            raise StudyError(f"{path}: vary.{key}: {value!r} is no number of seconds from 0 on")
    if not isinstance(case.get(CLOCK_DRIFT_KNOWN, False), bool):
        raise StudyError(f"{path}: vary.{CLOCK_DRIFT_KNOWN}: give true or false")
    try:
        faults = draw_faults(case.faults, _team(case), seed=0)
        check_robots(faults, _team(case))
    except BenchFaultError as error:
        raise StudyError(f"{path}: vary.{FAULTS}: {error}") from None
    if any(case.clocks) and not is_possible(settings, faults):
        raise StudyError(f"{path}: vary.{CLOCK_ERROR}: not with this supervisor or fault; leave it")


def _team(case: Case) -> list[str]:
    return [f"robot{number}" for number in range(1, case.robots + 1)]


def _border_of(case: Case, settings: StudySettings, base: Path) -> tuple[Path, str]:
    """Return map folder and border of a case."""
    folder = find_map(str(case.get(MAP, settings.map)), base)
    return folder, str(case.get(BORDER, settings.border))


def _truth_of(case: Case, settings: StudySettings, default: str, base: Path) -> str:
    """Return the name or absolute file of a case's truth; a file is relative to the study's."""
    name = str(case.get(TRUTH, settings.truth or default))
    if name not in truth_names() and (base / name).is_file():
        name = str((base / name).resolve())
    return load_truth(name).name


def configuration(
    case: Case, source: str, changes: Sequence[str] = (), config: str = ""
) -> AgentConfig:
    """Return the configuration of a case's robots, ``changes`` applied before the case's settings.

    config: the configuration that both change, TOML.

    Raises ConfigError for an unknown key, naming ``source``.
    """
    tree: dict[str, Any] = {}
    for key, value in case.settings.items():
        *sections, name = key.split(".")
        table = tree
        for section in sections:
            table = table.setdefault(section, {})
        table[name] = value
    if not changes and not config:
        return parse_config(tomli_w.dumps(tree).encode(), source)
    varied = [f"{key}={_shown(value)}" for key, value in case.settings.items()]
    return changed_config(config.encode(), source, [*changes, *varied])


def setting_label(key: str, value: Setting) -> str:
    """Return a setting for people: of a list what it has more and less than the default one."""
    if not isinstance(value, tuple):
        return str(value)
    if not value:
        return "none"
    default: Any = AgentConfig()
    for name in key.split("."):
        default = getattr(default, name)
    added = [f"+{name}" for name in value if name not in default]
    left_out = [f"-{name}" for name in default if name not in value]
    return " ".join((*added, *left_out)) or ("default" if value == default else "reordered")


def _shown(value: Setting) -> str:
    """Return a setting in TOML syntax, strings without quotes."""
    if isinstance(value, tuple):
        return str(list(value))
    return str(value).lower() if isinstance(value, bool) else str(value)


def run_study(
    study: Study,
    folder: Path,
    jobs: int,
    progress: Callable[[float], None] = lambda _: None,
    cluster: str | None = None,
) -> list[Result]:
    """Run the runs without a result in the folder; return all results in the study's order.

    jobs: local processes at a time; cluster: address of a Dask scheduler, used instead. Each result
    is written when its run ends, so a killed study can be resumed. Raises StudyError for a damaged
    result, ClusterError for an unusable cluster.
    """
    runs_folder = folder / RUNS_FOLDER
    runs_folder.mkdir(parents=True, exist_ok=True)
    results = {run: result for run in study.runs if (result := _stored(runs_folder, run))}
    missing = [run for run in study.runs if run not in results]
    progress(len(results))
    execute = partial(_execute, jobs=jobs)
    if cluster is not None:
        execute = partial(run_on_cluster, run=bench_run, address=cluster)
    for result in execute(missing):
        _store(runs_folder, result)
        results[result.run] = result
        progress(len(results))
    return [results[run] for run in study.runs]


def _execute(runs: Sequence[Run], jobs: int) -> Iterator[Result]:
    with worker_pool(jobs) as pool:
        groups = [pool.submit(bench_runs, group) for group in _together(runs)]
        for future in as_completed(groups):
            yield from future.result()


def _together(runs: Sequence[Run]) -> list[list[Run]]:
    """Return the runs in groups that one process does at once: in a batch if they can be."""
    groups: dict[object, list[Run]] = {}
    for run in runs:
        key = _common_to_batch(run) if _fits_batch(run) else run
        groups.setdefault(key, []).append(run)
    return [
        group[first : first + count]
        for group in groups.values()
        for count in (max(1, _ROBOTS_TOGETHER // group[0].case.robots),)
        for first in range(0, len(group), count)
    ]


def _common_to_batch(run: Run) -> object:
    """Return what the runs of a batch share: all but seed, faults and clocks."""
    without = (FAULTS, *_CLOCKS, CLOCK_DRIFT_KNOWN)
    return tuple(pair for pair in run.case.values if pair[0] not in without)


def _fits_batch(run: Run) -> bool:
    """Whether a run can be one of a batch: ideal sensing, fuzzy rules, lasting faults."""
    config = configuration(run.case, "study", run.changes, run.config)
    faults = draw_faults(run.case.faults, _team(run.case), run.seed)
    return run.sensing is Sensing.IDEAL and is_possible(config, faults)


def bench_runs(runs: Sequence[Run]) -> list[Result]:
    """Execute runs that differ by seed, faults and clocks: as a batch if they can be one.

    A single run is one only if nothing else can do it.
    """
    first = runs[0]
    needs_batch = first.all_knowing or any(first.case.clocks)
    if not _fits_batch(first) or (len(runs) == 1 and not needs_batch):
        return [bench_run(run) for run in runs]
    cv2.setNumThreads(1)
    folder = load_map_folder(Path(first.map_folder), first.border)
    batch = Batch(
        folder,
        first.case.robots,
        [run.seed for run in runs],
        configuration(first.case, "study", first.changes, first.config),
        faults=[draw_faults(run.case.faults, _team(run.case), run.seed) for run in runs],
        clocks=[
            clock
            for run in runs
            for clock in wrong_clocks(
                run.case.robots,
                run.seed,
                *run.case.clocks,
                drift_known=bool(run.case.get(CLOCK_DRIFT_KNOWN, False)),
            )
        ],
    )
    moments = MOMENTS if first.all_knowing else 0
    # The tables have the settled intruder only, of the second half.
    figures = run_batch(batch, first.duration, moments=moments, since=first.duration / 2.0)
    return [Result(run, own) for run, own in zip(runs, figures, strict=True)]


def bench_run(run: Run) -> Result:
    """Execute one run in this process."""
    cv2.setNumThreads(1)  # one process per core uses them all
    folder = load_map_folder(Path(run.map_folder), run.border)
    config = configuration(run.case, "study", run.changes, run.config)
    figures = bench(
        run.sensing,
        folder,
        run.case.robots,
        run.seed,
        run.duration,
        config=config,
        faults=draw_faults(run.case.faults, _team(run.case), run.seed),
        truth=load_truth(run.truth),
    )
    return Result(run, figures)


def _store(folder: Path, result: Result) -> None:
    """Write a result atomically."""
    content = {
        "case": dict(result.run.case.values),
        "seed": result.run.seed,
        "figures": result.figures,
    }
    write_whole(folder / result.run.file_name, json.dumps(content))


def _stored(folder: Path, run: Run) -> Result | None:
    path = folder / run.file_name
    if not path.is_file():
        return None
    try:
        return Result(run, json.loads(path.read_text(encoding="utf-8"))["figures"])
    except (ValueError, KeyError):
        raise StudyError(f"{path}: is damaged; delete it, the run will be done again") from None
