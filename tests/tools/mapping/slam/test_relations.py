"""Relations files and the error against them."""

from __future__ import annotations

import gzip
import math
from pathlib import Path

import pytest

from maps.pose import Pose
from tools.mapping.slam.relations import (
    Relation,
    RelationsError,
    read_relations,
    relation_error,
    synchronize,
)

LINES = "# t1 t2 x y z roll pitch yaw\n100.5 102.0 1.0 -0.5 0 0 0 1.5\n\n103 101 2 0 0 0 0 -7\n"


@pytest.mark.parametrize("packed", [False, True])
def test_relations_are_read_with_the_time_offset(tmp_path: Path, packed: bool) -> None:
    path = tmp_path / "place.relations"
    data = LINES.encode()
    path.write_bytes(gzip.compress(data) if packed else data)
    first, second = read_relations(path, offset=100.0)
    assert first == Relation(0.5, 2.0, Pose(1.0, -0.5, 1.5))
    assert second.pose.theta == pytest.approx(math.tau - 7.0)


@pytest.mark.parametrize(
    ("text", "said"),
    [
        ("1 2 0 0 0 0 0 0\n1 2 3\n", "line 2: 3 fields instead of 8"),
        ("1 2 0 0 0 0 0 north\n", "line 1: could not convert string to float: 'north'"),
        ("1 2 0 0 0 0 0 nan\n", "line 1: a number is not finite"),
        ("# nothing\n", "no relation in the file"),
    ],
)
def test_invalid_file_is_named_with_the_line(tmp_path: Path, text: str, said: str) -> None:
    path = tmp_path / "bad.relations"
    path.write_text(text)
    with pytest.raises(RelationsError, match=said) as caught:
        read_relations(path)
    assert str(path) in str(caught.value)


def test_unreadable_file_is_named(tmp_path: Path) -> None:
    with pytest.raises(RelationsError, match=r"absent.relations: cannot be read"):
        read_relations(tmp_path / "absent.relations")
    cut = tmp_path / "cut.gz"
    cut.write_bytes(gzip.compress(LINES.encode() * 100)[:60])
    with pytest.raises(RelationsError, match=r"cut.gz: cannot be read .*copy it again"):
        read_relations(cut)


def test_error_is_independent_of_the_maps_frame() -> None:
    frame = Pose(10.0, -3.0, 2.0)
    relations = [
        Relation(0.0, 1.0, Pose(1.0, 0.0, 0.0)),
        Relation(1.0, 0.0, Pose(-1.0, 0.0, 0.0)),
        Relation(0.0, 9.0, Pose(0.0, 0.0, 0.0)),
    ]
    poses = {0.0: frame, 1.0: frame.compose(Pose(1.03, 0.04, math.radians(2.0)))}
    error = relation_error(relations, poses.get)
    assert (error.count, error.outside) == (2, 1)
    assert error.median_deg == pytest.approx(2.0)
    assert error.mean_m == pytest.approx(0.05, abs=0.02)
    exact = relation_error(relations[:1], poses.get)
    assert exact.mean_m == exact.rmse_m == pytest.approx(0.05)
    assert "0.220 m" in exact.table()
    assert "mean 0.0500 m" in exact.table()


def test_relations_are_synchronized_by_the_stamps() -> None:
    stamps = [0.3 * n for n in range(100)]
    still = Pose(0.0, 0.0, 0.0)
    exact = [Relation(stamps[n], stamps[n + 3], still) for n in range(50)]
    late = [Relation(r.start + 0.004, r.end + 0.004, still) for r in exact]
    for moved, true in zip(synchronize(late, stamps), exact, strict=True):
        assert (moved.start, moved.end) == pytest.approx((true.start, true.end), abs=1e-9)
    far = [Relation(r.start + 0.1, r.end + 0.1, still) for r in exact]
    assert synchronize(far, stamps) == far


def test_relations_of_another_time_are_refused() -> None:
    with pytest.raises(RelationsError, match="none of the 1 relations lies in the log's time"):
        relation_error([Relation(5.0, 6.0, Pose(0.0, 0.0, 0.0))], lambda _: None)
