"""Names, differences and figures of a study's cases."""

from __future__ import annotations

from itertools import product
from pathlib import Path

import cv2
import pytest

from tests.tools.studies.study_result import result_of
from tools.commands.study import print_table
from tools.report.style import FORMATS
from tools.studies.case_names import CaseNames
from tools.studies.study import Case, Result
from tools.studies.study_difference import differences, write_differences
from tools.studies.study_markdown import write_markdown
from tools.studies.study_plot import plot_figures, plot_study
from tools.studies.study_table import table

PROBABILITY = "patrol.reversal_probability"
CASES = [
    Case((("robots", robots), ("map", place), ("truth", "plain"), (PROBABILITY, probability)))
    for robots, place, probability in product((3, 5), ("paper_lab", "intel_lab"), (0.0, 0.1, 0.25))
]


def results() -> list[Result]:
    """Return runs that differ by 100 s and more a seed, and by 10 s a probability."""
    return [
        result_of(case, seed, 100.0 * seed + 10.0 * CASES.index(case) + seed * seed)
        for seed in (1, 2, 3)
        for case in CASES
    ]


def test_what_all_cases_share_is_the_title_and_the_rest_is_short() -> None:
    names = CaseNames(CASES)
    assert names.title == "truth plain"
    assert names.column_key == "reversal probability"
    assert (names.row(CASES[-1]), names.column(CASES[-1])) == ("robots 5, map intel_lab", "0.25")


def test_last_parts_that_are_not_unique_stay_whole() -> None:
    names = CaseNames([Case((("base.url", "a"), ("laser.url", url))) for url in ("b", "c")])
    assert (names.title, names.column_key) == ("base.url a", "laser.url")


def test_study_without_variation_has_one_column() -> None:
    names = CaseNames([Case((("robots", 3),))])
    assert (names.title, names.column_key) == ("robots 3", "")
    assert names.column(Case((("robots", 3),))) == "all"
    assert differences([result_of(Case((("robots", 3),)), 1, 2.0)], names) == []


def test_differences_are_paired_by_seed(tmp_path: Path) -> None:
    names = CaseNames(CASES)
    found = differences(results(), names)
    assert len(found) == 8, "two of each three probabilities, for four places and sizes"
    for each in found:
        assert names.row(each.case) == names.row(each.base)
        assert names.column(each.base) == "0.0"
        worst = each.figures["idleness_worst_s"]
        assert worst is not None
        assert worst.mean == {"0.1": 10.0, "0.25": 20.0}[names.column(each.case)]
        assert worst.half_width == pytest.approx(0.0), "what the seed does is not in it"
    write_differences(found, names, tmp_path / "differences.csv")
    lines = (tmp_path / "differences.csv").read_text().splitlines()
    assert lines[0] == "case,setting,less,figure,mean,half_width,seeds"
    assert '"robots 3, map paper_lab",0.1,0.0,idleness_average_s,10.0,0.0,3' in lines


def test_seed_without_a_figure_is_no_pair() -> None:
    one, two = CASES[0], CASES[1]
    runs = [
        result_of(one, 1, 5.0),
        result_of(two, 1, 7.0),
        result_of(one, 2, 5.0),
        result_of(two, 2, None),
    ]
    (found,) = differences(runs, CaseNames([one, two]))
    worst = found.figures["idleness_worst_s"]
    assert worst is not None
    assert (worst.mean, worst.runs) == (2.0, 1)


def test_table_of_three_varied_keys_fits_a_terminal(
    capsys: pytest.CaptureFixture[str], monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.setenv("COLUMNS", "80")
    print_table(table(results()), CaseNames(CASES), "mean")
    shown = capsys.readouterr().out
    assert "truth plain" in shown
    assert "reversal" in shown
    lines = shown.splitlines()
    at = next(number for number, line in enumerate(lines) if "idleness_worst_s" in line)
    assert "robots 3, map paper_lab" in lines[at + 1]
    assert max(map(len, lines)) <= 80
    assert "…" not in shown


def test_markdown_has_a_table_for_each_combination_and_a_line_for_each_value(
    tmp_path: Path,
) -> None:
    write_markdown(table(results()), CaseNames(CASES), tmp_path / "study.md")
    lines = (tmp_path / "study.md").read_text().splitlines()
    at = lines.index("robots 3, map intel_lab:")
    assert lines[at + 2].startswith("| reversal probability | idleness average s |")
    assert lines[at + 3].count("---") == lines[at + 2].count("|") - 1
    assert [line.split(" | ")[0] for line in lines[at + 4 : at + 7]] == ["| 0.0", "| 0.1", "| 0.25"]
    assert len([line for line in lines if line.startswith("| reversal")]) == 4


def test_figures_are_written_in_every_format(tmp_path: Path) -> None:
    plot_study(table(results()), CaseNames(CASES), tmp_path)
    assert "</svg>" in (tmp_path / "study.svg").read_text()
    assert (tmp_path / "study.pdf").read_bytes().startswith(b"%PDF")
    picture = cv2.imread(str(tmp_path / "study.png"))
    assert picture is not None
    assert picture.shape[1] == 2250


def test_each_figure_can_be_had_alone(tmp_path: Path) -> None:
    assert "pdf" in FORMATS
    files = plot_figures(table(results()[:3]), CaseNames(CASES[:3]), tmp_path, "pdf")
    assert tmp_path / "idleness_worst_s.pdf" in files
    assert set(files) == set(tmp_path.iterdir())
