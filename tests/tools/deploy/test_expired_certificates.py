"""Certificates that have ended: agent, doctor and monitor tell it."""

from __future__ import annotations

import shutil
import subprocess
import time
from contextlib import closing
from pathlib import Path

import pytest

from robot_agent.config import TelemetrySettings
from robot_agent.process.key_rights import rights_trouble
from robot_agent.process.telemetry import Telemetry
from tests.tools.deploy.test_certificates import wait_until
from tools.deploy.certificates import KEY, OPERATOR, make_keys
from tools.deploy.child_program import environment, program
from tools.monitor.alarm import Severity
from tools.monitor.certificate_watch import CertificateWatch
from tools.monitor.endpoint import free_endpoint
from tools.monitor.operator import Operator
from tools.preflight.doctor_keys import examine_keys, examine_operator
from tools.preflight.finding import Verdict

DAY_S = 86400.0


@pytest.fixture
def keys(tmp_path: Path) -> Path:
    """The operator and bob have valid certificates, anna's ended yesterday."""
    make_keys(tmp_path, "north", ["bob"], ["127.0.0.1"])
    make_keys(tmp_path, "north", ["anna"], [], days=-1)
    return tmp_path


@pytest.fixture
def endpoint() -> str:
    return free_endpoint().replace("tcp/", "tls/")


def test_robots_own_is_told_by_agent_and_doctor(keys: Path, endpoint: str) -> None:
    settings = TelemetrySettings(operator=endpoint, keys=str(keys / "anna"))
    with (
        closing(Operator(endpoint, keys=keys / "operator")),
        closing(Telemetry(settings, robot="anna", team="north")) as telemetry,
    ):
        telemetry.publish("pose", b"{}")
        wait_until(lambda: bool(telemetry.failed), "the trouble")
        assert "anna/certificate.pem was valid until" in telemetry.failed
        assert "`patrol keys`" in telemetry.failed
        wait_until(lambda: telemetry.dropped == 1, "what no operator took")
        assert telemetry.sent == 0
        finding = examine_operator(settings)
        assert "certificates do not fit" in finding.text
    finding = examine_keys(str(keys / "anna"))
    assert (finding.verdict, "set the clock" in finding.remedy) == (Verdict.WARNING, True)


def test_operators_own_is_told_by_monitor_and_the_robots_doctor(keys: Path, endpoint: str) -> None:
    shutil.rmtree(keys / OPERATOR)
    make_keys(keys, "north", ["bob"], ["127.0.0.1"], days=-1)
    [condition] = CertificateWatch(keys / OPERATOR).conditions()
    assert condition.severity is Severity.CRITICAL
    assert "no robot can report: " in condition.text
    with closing(Operator(endpoint, keys=keys / OPERATOR)):
        settings = TelemetrySettings(operator=endpoint, keys=str(keys / "bob"))
        finding = examine_operator(settings)
    assert "certificates do not fit (certificate has expired)" in finding.text
    assert "set both clocks" in finding.remedy


def test_end_in_a_month_is_told_by_monitor_and_doctor(keys: Path) -> None:
    def wall() -> float:
        return time.time() + 3630 * DAY_S

    [first, second] = CertificateWatch(keys / OPERATOR, wall).conditions()
    assert first.severity is second.severity is Severity.WARNING
    finding = examine_keys(str(keys / "bob"), wall)
    assert (finding.verdict, "only" in finding.text) == (Verdict.WARNING, True)
    assert examine_keys(str(keys / "bob")).verdict is Verdict.OK
    assert examine_keys("").verdict is Verdict.SKIPPED
    assert examine_keys(str(keys / "nobody")).verdict is Verdict.WARNING
    assert list(CertificateWatch(None).conditions()) == []


def test_valid_certificates_pass_the_doctors_trial(keys: Path, endpoint: str) -> None:
    with closing(Operator(endpoint, keys=keys / "operator")):
        settings = TelemetrySettings(operator=endpoint, keys=str(keys / "bob"))
        finding = examine_operator(settings)
    assert (finding.verdict, finding.text) == (Verdict.OK, f"{endpoint} answers")


def test_certificates_of_the_future_are_told_with_the_clock(keys: Path) -> None:
    def wall() -> float:
        return -DAY_S  # certificates of `patrol keys` are valid from 1970 on

    finding = examine_keys(str(keys / "bob"), wall)
    assert (finding.verdict, "valid from 1970" in finding.text) == (Verdict.WARNING, True)
    assert "set the clock" in finding.remedy
    conditions = list(CertificateWatch(keys / OPERATOR, wall).conditions())
    assert all("set the clock" in condition.text for condition in conditions)
    assert {condition.severity for condition in conditions} == {Severity.CRITICAL}


@pytest.mark.parametrize("mode", [0o640, 0o604, 0o644, 0o600, 0o400])
def test_private_key_that_others_may_read_is_told_in_one_line_with_the_remedy(
    keys: Path, mode: int
) -> None:
    readable = mode not in (0o600, 0o400)
    for name in ("bob", OPERATOR):
        (keys / name / KEY).chmod(mode)
    told = rights_trouble(keys / "bob")
    assert ("chmod 600" in told) == readable
    finding = examine_keys(str(keys / "bob"))
    assert finding.verdict is (Verdict.WARNING if readable else Verdict.OK)
    assert ("chmod 600" in finding.remedy) == readable
    conditions = list(CertificateWatch(keys / OPERATOR).conditions())
    assert [condition.kind for condition in conditions] == (["keys key.pem"] if readable else [])
    assert rights_trouble(keys / "nobody") == ""


def test_key_that_the_user_cannot_read_is_told_by_the_doctor(keys: Path) -> None:
    (keys / "bob" / KEY).unlink()
    finding = examine_keys(str(keys / "bob"))
    assert finding.verdict is Verdict.WARNING
    assert "cannot read the private key" in finding.text
    assert "chown patrol" in finding.remedy


def test_agent_tells_that_others_may_read_its_key(keys: Path, tmp_path: Path) -> None:
    (keys / "bob" / KEY).chmod(0o644)
    robot = tmp_path / "robot.toml"
    robot.write_text(
        f'[telemetry]\noperator = "tls/127.0.0.1:9"\nkeys = "{keys / "bob"}"\n'
        '[base]\nurl = "/dev/none-such"\n[laser]\nurl = "/dev/none-such"\n'
    )
    with subprocess.Popen(
        program("tools.cli", "agent", str(robot)),
        env=environment(),
        stderr=subprocess.PIPE,
        text=True,
    ) as agent:
        assert agent.stderr is not None
        first = agent.stderr.readline()
        agent.terminate()
        agent.stderr.read()
    assert "other users of this computer may read this private key (644)" in first
