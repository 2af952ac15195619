"""The doctor in the service's sandbox: the properties are those of the unit."""

from pathlib import Path

import pytest

from tools.cli import main
from tools.deploy import service_sandbox
from tools.deploy.service_sandbox import read_unit, sandbox_command

UNIT = """\
[Unit]
Description=Border patrol agent %i

[Service]
Type=notify
ExecStart=/opt/patrol/bin/patrol agent /etc/patrol/%i.toml
Restart=on-failure
RestartSec=1
WatchdogSec=3
# Kept from the homes.
ProtectHome=read-only
SystemCallFilter=@system-service
SystemCallFilter=~@privileged @resources
CapabilityBoundingSet=
NewProperty=of a later unit

[Install]
WantedBy=multi-user.target
"""


def test_sandbox_has_the_units_properties_but_those_of_start_and_end():
    command = sandbox_command(UNIT, ["doctor", "/etc/patrol/robot1.toml"])
    end = command.index("--")
    assert command[end + 1 :] == ["/opt/patrol/bin/patrol", "doctor", "/etc/patrol/robot1.toml"]
    assert [word for word in command[:end] if word.startswith("--property=")] == [
        "--property=ProtectHome=read-only",
        "--property=SystemCallFilter=@system-service",
        "--property=SystemCallFilter=~@privileged @resources",
        "--property=CapabilityBoundingSet=",
        "--property=NewProperty=of a later unit",
    ]


def test_shipped_unit_gives_its_user_devices_and_memory():
    command = sandbox_command(read_unit(), ["doctor"])
    for line in (
        *("User=patrol", "DevicePolicy=closed", "DeviceAllow=char-ttyUSB rw", "MemoryMax=300M"),
        *("PrivateTmp=yes", "ProtectSystem=strict", "SystemCallFilter=@system-service"),
    ):
        assert f"--property={line}" in command
    assert not any("%i" in word or "@USER@" in word for word in command)


def test_without_systemd_one_line_says_so(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch, capsys: pytest.CaptureFixture[str]
):
    monkeypatch.setattr(service_sandbox, "RUNNING_SYSTEMD", tmp_path / "none")
    assert main(["doctor", "--as-service", str(tmp_path / "robot1.toml")]) == 1
    assert capsys.readouterr().err == (
        "patrol doctor: systemd is not running here, and it makes the sandbox: run it there\n"
    )
