"""The CPU limit with either version of cgroups."""

from __future__ import annotations

from pathlib import Path

import pytest

from tools.campaign.cpu_limit import CpuLimit, CpuLimitError


def test_cgroups_v2_get_quota_and_period_in_one_file(tmp_path: Path) -> None:
    (tmp_path / "cgroup.controllers").write_text("cpu")
    limit = CpuLimit(0.2, tmp_path)
    limit.hold(4711)
    (group,) = (path for path in tmp_path.iterdir() if path.is_dir())
    assert (group / "cpu.max").read_text() == "2000 10000"
    assert (group / "cgroup.procs").read_text() == "4711"


def test_cgroups_v1_get_quota_and_period_in_two_files(tmp_path: Path) -> None:
    (tmp_path / "cpu").mkdir()
    CpuLimit(0.5, tmp_path).hold(4711)
    (group,) = (tmp_path / "cpu").iterdir()
    assert (group / "cpu.cfs_period_us").read_text() == "10000"
    assert (group / "cpu.cfs_quota_us").read_text() == "5000"
    assert (group / "cgroup.procs").read_text() == "4711"


def test_missing_permission_gives_an_error_with_remedy(tmp_path: Path) -> None:
    with pytest.raises(CpuLimitError, match="systemd-run"):
        CpuLimit(0.2, tmp_path / "nowhere")
