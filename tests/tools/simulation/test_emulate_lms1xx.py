"""An emulated robot with an LMS 111, for any client, the doctor included."""

from __future__ import annotations

import socket
from pathlib import Path

import pytest

from drivers.lms1xx.settings import LaserSettings
from maps.map_folder import MapFolder, load_map_folder
from robot_agent.config import find_map
from tests.tools.simulation.test_emulate import LIMIT, OPEN_PLACE, emulated
from tools.preflight.device_trial import run_trials
from tools.preflight.doctor_laser import LaserExamination
from tools.preflight.finding import Verdict
from tools.simulation.emulate import EmulateError, EmulateOptions, Emulation
from tools.simulation.truth.truth import load_truth


@pytest.fixture(scope="module")
def folder() -> MapFolder:
    return load_map_folder(find_map("paper_lab", Path()))


def address_of(url: str) -> tuple[str, int]:
    host, port = url.removeprefix("socket://").split(":")
    return host, int(port)


def test_a_client_of_another_hand_gets_scans(folder: MapFolder) -> None:
    options = EmulateOptions(pose=OPEN_PLACE, lms1xx="tcp:0")
    with (
        emulated(folder, options) as urls,
        socket.create_connection(address_of(urls["lms1xx"]), LIMIT) as client,
    ):
        client.settimeout(LIMIT)
        stream = client.makefile("rwb", buffering=0)

        def reply() -> list[bytes]:
            text = b""
            while not text.endswith(b"\x03"):
                text += stream.read(1) or b""
            assert text.startswith(b"\x02")
            return text[1:-1].split(b" ")

        for command, expected in (
            (b"sMN SetAccessMode 03 F4724744", b"sAN SetAccessMode 1"),
            (b"sRN LMPscancfg", b"sRA LMPscancfg 1388 1 1388 FFF92230 225510"),
            (b"sWN LMDscandatacfg 01 00 0 1 0 00 00 0 0 0 0 +1", b"sWA LMDscandatacfg"),
            (b"sMN Run", b"sAN Run 1"),
            (b"sEN LMDscandata 1", b"sEA LMDscandata 1"),
        ):
            stream.write(b"\x02" + command + b"\x03")
            assert b" ".join(reply()) == expected
        for _ in range(3):
            scan = reply()
            assert scan[:2] == [b"sSN", b"LMDscandata"]
            at = scan.index(b"DIST1")
            assert scan[at + 1 : at + 6] == [b"3F800000", b"0", b"FFF92230", b"1388", b"21D"]
            ahead = int(scan[at + 6 + 270], 16)
            assert ahead > 3000, "the corridor lies ahead"


def test_its_truth_alone_gives_a_robot_an_lms_111_on_a_free_port(folder: MapFolder) -> None:
    options = EmulateOptions(truth=load_truth("lms1xx"), pose=OPEN_PLACE)
    with emulated(folder, options) as urls:
        assert set(urls) == {"p2os", "lms1xx"}
        assert urls["lms1xx"].startswith("socket://127.0.0.1:")


def test_it_has_no_serial_line(folder: MapFolder) -> None:
    with pytest.raises(EmulateError, match="--lms1xx pty: it is on a network"):
        Emulation(folder, EmulateOptions(lms1xx="pty"))


def test_doctor_finds_it_fit(folder: MapFolder) -> None:
    with emulated(folder, EmulateOptions(pose=OPEN_PLACE, lms1xx="tcp:0")) as urls:
        examination = LaserExamination(LaserSettings(url=urls["lms1xx"]))
        assert examination.trial is not None
        run_trials([examination.trial], LIMIT)
        found = {finding.subject: finding for finding in examination.findings()}
    assert {finding.verdict for finding in found.values()} == {Verdict.OK}
    assert found["laser"].text == "LMS111_FieldEval V1.80.2, in CoLa A"
    assert "541 beams every 0.5 deg (50.0 possible)" in found["laser scans"].text
    assert "baud" not in found["laser line"].text


def test_doctor_says_what_to_check_where_no_scanner_answers() -> None:
    with socket.create_server(("127.0.0.1", 0)) as silent:
        url = f"socket://127.0.0.1:{silent.getsockname()[1]}"
        examination = LaserExamination(LaserSettings(url=url))
        assert examination.trial is not None
        run_trials([examination.trial], 0.5)
        found = examination.findings()[-1]
    assert found.verdict is Verdict.FAILED
    assert "laser.url is the address and port (2111 or 2112) of the scanner" in found.remedy
