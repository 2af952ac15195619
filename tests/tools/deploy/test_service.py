"""An installation below a temporary root: files written, checks, refusals."""

import shutil
from pathlib import Path

import pytest

from robot_agent.config import ConfigError
from tools.cli import main
from tools.deploy.service import RULES, UNIT, DeploymentError, check_unit, deploy, this_program
from tools.preflight.finding import Verdict

needs_systemd = pytest.mark.skipif(
    shutil.which("systemd-analyze") is None, reason="systemd-analyze is not there"
)


@pytest.fixture
def config(tmp_path: Path) -> Path:
    path = tmp_path / "robot1.toml"
    path.write_text('[robot]\nname = "robot1"\n')
    return path


def test_writes_unit_rules_user_and_configuration(tmp_path: Path, config: Path) -> None:
    root = tmp_path / "root"
    done = deploy(root, [config], "patrol", this_program())
    names = {str(path.relative_to(root)) for path in done.written}
    assert names == {
        "etc/systemd/system/patrol@.service",
        "etc/udev/rules.d/60-patrol.rules",
        "etc/sysusers.d/patrol.conf",
        "etc/patrol/robot1.toml",
    }
    assert {path for path in root.rglob("*") if path.is_file()} == set(done.written)
    unit = (root / UNIT).read_text()
    assert f"ExecStart={this_program()} agent /etc/patrol/%i.toml" in unit
    assert "User=patrol" in unit
    assert "@PATROL@" not in unit
    assert "@USER@" not in unit


def test_existing_udev_rules_are_kept(tmp_path: Path, config: Path) -> None:
    rules = tmp_path / RULES
    rules.parent.mkdir(parents=True)
    rules.write_text("# mine\n")
    done = deploy(tmp_path, [config], "patrol", this_program())
    assert rules.read_text() == "# mine\n"
    assert done.kept == [rules]


@needs_systemd
def test_unit_passes_verification_and_exposure_limit(tmp_path: Path) -> None:
    done = deploy(tmp_path, [], "root", Path("/bin/true"))
    assert [finding.verdict for finding in done.findings] == [Verdict.OK] * 3
    assert done.fit
    exposure = next(finding for finding in done.findings if finding.subject == "exposure")
    assert float(exposure.text.split()[0]) < 3.0


@needs_systemd
def test_invalid_unit_is_a_failed_finding(tmp_path: Path) -> None:
    unit = tmp_path / "patrol@.service"
    unit.write_text("[Service]\nExecStart=/nowhere/patrol\n")
    verdicts = {finding.subject: finding.verdict for finding in check_unit(unit)}
    assert verdicts == {"unit": Verdict.FAILED, "exposure": Verdict.FAILED}


def test_bad_configurations_are_refused_before_anything_is_written(tmp_path: Path) -> None:
    bad = tmp_path / "robot1.toml"
    bad.write_text("[robot]\nnmae = 'x'\n")
    with pytest.raises(ConfigError, match="unknown key"):
        deploy(tmp_path / "root", [bad], "patrol", this_program())
    shutil.copytree(Path(__file__).parents[3] / "maps" / "paper_lab", tmp_path / "lab")
    bad.write_text("[map]\nfolder = 'lab'\n")
    with pytest.raises(DeploymentError, match=str(tmp_path / "lab")):
        deploy(tmp_path / "root", [bad], "patrol", this_program())
    assert not (tmp_path / "root").exists()


def test_command_prints_the_next_steps(
    tmp_path: Path, config: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    status = main(["install", str(config), "--root", str(tmp_path), "--user", "root"])
    out, err = capsys.readouterr()
    assert status == 0
    assert f"written  {tmp_path / UNIT}" in out
    assert "systemctl enable --now patrol@robot1" in err
