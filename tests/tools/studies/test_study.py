"""Studies: every combination run once, stored, and compared."""

import argparse
import csv
from pathlib import Path

import numpy as np
import pytest

from robot_agent.config import ConfigError
from robot_agent.patrol.settings import DEFAULT_MODIFIERS
from tests.tools.studies.study_result import result_of
from tools.commands import study as command
from tools.simulation.truth.truth import TruthError
from tools.studies.study import (
    Case,
    Result,
    StudyError,
    bench_run,
    configuration,
    read_study,
    run_study,
)
from tools.studies.study_cluster import ClusterError
from tools.studies.study_table import summarize, table

STUDIES = Path(command.__file__).parents[1] / "studies"
SMALL = """
[study]
duration = 4.0
seeds = 2
first_seed = 5

[vary]
robots = [1, 2]
"patrol.reversal_probability" = [0.0, 1.0]
"""


def write(tmp_path: Path, text: str) -> Path:
    path = tmp_path / "study.toml"
    path.write_text(text)
    return path


def test_every_combination_with_every_seed(tmp_path: Path) -> None:
    study = read_study(write(tmp_path, SMALL))
    assert [str(case) for case in study.cases] == [
        "robots 1, patrol.reversal_probability 0.0",
        "robots 1, patrol.reversal_probability 1.0",
        "robots 2, patrol.reversal_probability 0.0",
        "robots 2, patrol.reversal_probability 1.0",
    ]
    assert len(study.runs) == 8
    assert {run.seed for run in study.runs} == {5, 6}
    assert len({run.file_name for run in study.runs}) == 8


def test_killed_study_runs_only_what_is_missing(tmp_path: Path) -> None:
    study = read_study(write(tmp_path, SMALL.replace("seeds = 2", "seeds = 1")))
    out = tmp_path / "out"
    results = run_study(study, out, jobs=2)
    assert [result.run for result in results] == list(study.runs)
    files = sorted((out / "runs").iterdir())
    assert len(files) == 4
    files[0].unlink()  # as if it had been killed before its last run
    kept = {path: path.stat().st_mtime_ns for path in files[1:]}
    again = run_study(study, out, jobs=1)
    assert {path: path.stat().st_mtime_ns for path in kept} == kept
    for one, other in zip(results, again, strict=True):
        assert one.figures["border_distance_m"] == other.figures["border_distance_m"]


def test_damaged_result_is_an_error_naming_it(tmp_path: Path) -> None:
    study = read_study(write(tmp_path, "[study]\nduration = 2.0\nseeds = 1\n"))
    run_study(study, tmp_path, jobs=1)
    (path,) = (tmp_path / "runs").iterdir()
    path.write_text("{")
    with pytest.raises(StudyError, match=f"{path.name}: is damaged; delete it"):
        run_study(study, tmp_path, jobs=1)


def test_command_prints_the_table_and_writes_runs_and_plot(
    tmp_path: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    parser = argparse.ArgumentParser()
    command.configure(parser)
    path = write(tmp_path, SMALL.replace("seeds = 2", "seeds = 1"))
    out = tmp_path / "out"
    assert command.run(parser.parse_args([str(path), "-o", str(out), "--jobs", "2"])) == 0
    assert "idleness_worst_s" in capsys.readouterr().out
    with (out / "runs.csv").open() as file:
        rows = list(csv.DictReader(file))
    assert [row["robots"] for row in rows] == ["1", "1", "2", "2"]
    assert {row["contacts"] for row in rows} == {"0"}
    assert "</svg>" in (out / "study.svg").read_text()


@pytest.mark.parametrize(
    ("text", "error", "words"),
    [
        ("[study]\nseeds = 0\n", StudyError, "study.toml: .*seeds.*; correct the value"),
        ("[study]\nseed = 1\n", StudyError, "unknown field `seed`"),
        ("[study\n", StudyError, "study.toml: is not TOML"),
        ("[vary]\nrobots = []\n", StudyError, "vary.robots: is empty"),
        ("[vary]\nrobots = [0]\n", StudyError, "vary.robots: 0 robots"),
        ('[vary]\n"patrol.speed" = [1.0]\n', ConfigError, "patrol.speed: unknown key"),
    ],
)
def test_bad_study_is_an_error_naming_the_key(
    text: str, error: type[Exception], words: str, tmp_path: Path
) -> None:
    with pytest.raises(error, match=words):
        read_study(write(tmp_path, text))


def test_absent_study_is_an_error_naming_it(tmp_path: Path) -> None:
    with pytest.raises(StudyError, match=r"none\.toml: cannot be read"):
        read_study(tmp_path / "none.toml")


def test_interval_of_the_mean() -> None:
    summary = summarize(np.array([1.0, 2.0, 3.0]))
    assert summary is not None
    assert summary.mean == 2.0
    assert summary.half_width == pytest.approx(4.3027 / np.sqrt(3), rel=1e-3)  # t(0.975, 2)
    single = summarize(np.array([7.0]))
    assert single is not None
    assert str(single) == "7"
    assert summarize(np.array([])) is None


def test_table_has_a_row_of_summaries_per_case() -> None:
    def result(probability: float, seed: int, worst: float | None) -> Result:
        case = Case((("patrol.reversal_probability", probability),))
        return result_of(case, seed, worst)

    rows = table([result(0.0, 1, 10.0), result(0.5, 1, None), result(0.0, 2, 14.0)])
    first, second = rows.values()
    assert first["idleness_worst_s"] is not None
    assert first["idleness_worst_s"].mean == 12.0
    assert first["idleness_worst_s"].runs == 2
    assert second["idleness_worst_s"] is None


def test_maps_borders_and_faults_vary_too(tmp_path: Path) -> None:
    text = """
[study]
duration = 4.0
seeds = 1

[vary]
robots = [3]
map = ["paper_lab", "intel_lab"]
border = ["border", "open"]
faults = ["", "any1:dead@1..3 robot2:stuck@2"]
"""
    study = read_study(write(tmp_path, text))
    assert len(study.runs) == 8
    assert {(Path(run.map_folder).name, run.border) for run in study.runs} == {
        (name, border) for name in ("paper_lab", "intel_lab") for border in ("border", "open")
    }
    assert study.cases[1].faults == ["any1:dead@1..3", "robot2:stuck@2"]
    assert not study.cases[1].settings
    with pytest.raises(StudyError, match="there is no such robot"):
        read_study(write(tmp_path, text.replace("robot2", "robot7")))


def test_truths_vary_too_and_a_file_is_beside_the_study(tmp_path: Path) -> None:
    (tmp_path / "mine.toml").write_text('like = "plain"\nabout = "mine"\n')
    text = '[study]\nduration = 2.0\nseeds = 1\n[vary]\ntruth = ["octagon", "mine.toml"]\n'
    study = read_study(write(tmp_path, text))
    assert [run.truth for run in study.runs] == ["octagon", str(tmp_path / "mine.toml")]
    assert bench_run(study.runs[0]).figures["truth"] == "octagon"
    with pytest.raises(TruthError, match="nowhere"):
        read_study(write(tmp_path, text.replace("octagon", "nowhere")))


def test_a_robots_file_is_common_to_all_cases(tmp_path: Path) -> None:
    study = read_study(write(tmp_path, SMALL), config="[gate]\nmax_speed = 0.2\n", truth="ideal")
    run = study.runs[0]
    assert configuration(run.case, "study", run.changes, run.config).gate.max_speed == 0.2
    assert run.truth == "ideal"


def test_study_on_a_cluster_has_the_same_results_as_local(tmp_path: Path) -> None:
    distributed = pytest.importorskip("distributed")
    text = "[study]\nduration = 4.0\nseeds = 1\nsensing = 'ideal'\n[vary]\nrobots = [1, 2]\n"
    study = read_study(write(tmp_path, text))
    here = run_study(study, tmp_path / "here", jobs=1)
    with distributed.LocalCluster(
        n_workers=1, threads_per_worker=1, processes=False, dashboard_address=None
    ) as cluster:
        there = run_study(study, tmp_path / "there", jobs=1, cluster=cluster.scheduler_address)
    for one, other in zip(here, there, strict=True):
        assert one.run == other.run
        assert one.figures["border_distance_m"] == other.figures["border_distance_m"]


def test_absent_cluster_is_an_error(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    pytest.importorskip("distributed")
    monkeypatch.setattr("tools.studies.study_cluster.CONNECT_S", 0.5)
    study = read_study(write(tmp_path, SMALL))
    with pytest.raises(ClusterError, match=r"no Dask scheduler at tcp://127\.0\.0\.1:1"):
        run_study(study, tmp_path / "out", jobs=1, cluster="tcp://127.0.0.1:1")


def test_lists_vary_too_and_are_labelled_by_their_difference(tmp_path: Path) -> None:
    names = list(DEFAULT_MODIFIERS)
    choices = [names, names[1:], [*names[1:4], *names[5:]], []]
    path = tmp_path / "modifiers.toml"
    path.write_text(
        f"""[study]
duration = 5.0
seeds = 1
sensing = "ideal"
[vary]
"patrol.modifiers" = {choices}
"""
    )
    study = read_study(path, ["patrol.reversal_probability=0"])
    assert [str(case) for case in study.cases] == [
        "patrol.modifiers default",
        "patrol.modifiers -standoff",
        "patrol.modifiers -standoff -common_turns",
        "patrol.modifiers none",
    ]
    configs = [configuration(run.case, "test", run.changes) for run in study.runs]
    assert [list(config.patrol.modifiers) for config in configs] == choices
    assert {config.patrol.reversal_probability for config in configs} == {0.0}
    assert study.runs[0].file_name != read_study(path).runs[0].file_name
    assert len(run_study(study, tmp_path / "out", jobs=1)) == 4


def test_a_changed_setting_that_does_not_exist_is_named(tmp_path: Path) -> None:
    path = tmp_path / "one.toml"
    path.write_text("[study]\nseeds = 1\n")
    with pytest.raises(ConfigError, match=r"patrol\.magic: unknown key"):
        read_study(path, ["patrol.magic=1"])


@pytest.mark.parametrize("path", sorted(STUDIES.glob("*.toml")), ids=lambda path: path.stem)
def test_every_shipped_study_is_in_order(path: Path) -> None:
    assert read_study(path, truth="rough").runs


CLOCKS = """
[study]
duration = 2.0
seeds = 1
sensing = "ideal"

[vary]
clock_error = [0.0, 10.0]
"""


def test_wrong_clocks_are_cases_of_ideal_sensing_alone(tmp_path: Path) -> None:
    study = read_study(write(tmp_path, CLOCKS))
    assert [case.clocks for case in study.cases] == [(0.0, 0.0), (10.0, 0.0)]
    assert len(run_study(study, tmp_path, jobs=1)) == 2
    with pytest.raises(StudyError, match=r"vary.clock_error: needs sensing = \"ideal\""):
        read_study(write(tmp_path, CLOCKS.replace('sensing = "ideal"', "")))
    with pytest.raises(StudyError, match="no number of seconds from 0 on"):
        read_study(write(tmp_path, CLOCKS.replace("10.0", "-1.0")))


def test_cases_that_differ_by_seed_and_faults_alone_have_the_figures_they_have_alone(
    tmp_path: Path,
) -> None:
    both = SMALL.replace("[vary]", 'sensing = "ideal"\n[vary]\nfaults = ["", "robot1:dead@1"]')
    study = read_study(write(tmp_path, both))
    for result in run_study(study, tmp_path, jobs=1):
        alone = bench_run(result.run).figures
        for key in ("idleness_s", "action_share", "border_distance_m"):
            assert result.figures[key] == alone[key]
