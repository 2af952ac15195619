"""Rows: mistakes of installation, each refused with a reason or put right."""

from __future__ import annotations

import shlex
from dataclasses import dataclass

from tools.field.field_row import FieldRow, Outcome
from tools.field.field_stage import UNIT, FieldStage
from tools.field.guest import Guest
from tools.field.installation_rows import RULES, robot_configuration

PLACE = "/root/mistake"
"""Folder of the robot's file, its map beside it."""
INSTALLED_MAP = "/etc/patrol/my_map"
CONFIG = "/etc/patrol/robot1.toml"
SETTLED_S = 20.0
"""Time in which a service would be started again several times, s."""
_BORDER = "printf 'closed = {}\\ncorner_radius = 0.5\\nvertices = {}\\n' > {}/border.toml"
THROUGH_A_WALL = _BORDER.format("false", "[[5.0, 13.4], [5.0, 3.75]]", "my_map")


def _off_the_map(folder: str) -> str:
    """Return a shell line that moves a map's border off it."""
    return _BORDER.format("true", "[[100, 100], [110, 100], [110, 110]]", folder)


@dataclass(frozen=True, slots=True)
class Mistake:
    """One mistake.

    shell: lines that make it in PLACE. words: of the refusal; empty if it is put right, which
    ``holds`` (shell lines) must then confirm.
    """

    name: str
    what: str
    shell: str
    words: str = ""
    holds: str = "patrol agent /etc/patrol/robot1.toml --print-config > /dev/null"

    @property
    def must(self) -> str:
        """What ``patrol install`` must do."""
        return f"refused: {self.words}" if self.words else "installed, and works"

    def run(self, stage: FieldStage, outcome: Outcome) -> None:
        """Install with the mistake made."""
        guest = stage.workbench()
        prepare(guest)
        guest.run(f"cd {PLACE}\n{self.shell}")
        done = guest.attempt(f"cd {PLACE} && patrol install robot1.toml")
        said = next((line for line in done.output.splitlines() if self.words in line), "")
        if self.words:
            outcome.require(done.status == 1, f"status {done.status}")
            outcome.require(bool(said), f"said {done.output.strip()[-200:]}")
            outcome.note(f"{self.words}{said.partition(self.words)[2]}".split("; ")[0])
        else:
            outcome.require(done.status == 0, f"status {done.status}: {done.output.strip()[-200:]}")
            held = guest.attempt(f"cd {PLACE}\n{self.holds}")
            outcome.require(held.status == 0, f"{self.holds}: {held.output.strip()[-200:]}")
            outcome.note(" ".join(held.output.split())[-100:] or "holds")


def prepare(guest: Guest) -> None:
    """Make PLACE anew: the robot's file without mistakes, its map beside it."""
    guest.run(f"rm -rf {PLACE} /etc/patrol && mkdir {PLACE} && cp -r /root/my_map {PLACE}/")
    guest.write(f"{PLACE}/robot1.toml", robot_configuration())


def _edit(old: str, new: str) -> str:
    """Return a shell line that changes the robot's file."""
    return f"sed -i {shlex.quote(f's|{old}|{new}|')} robot1.toml"


def _map_at(folder: str) -> str:
    return _edit('folder = "my_map"', f'folder = "{folder}"')


AS_PATROL = f"set -o pipefail; sudo -u patrol patrol map check {INSTALLED_MAP} | tail -1"
MISTAKES = (
    Mistake("map-in-root", "map in root's home", _map_at("/root/my_map"), "may not read"),
    Mistake(
        "map-in-home",
        "map in a home that others may not enter",
        "install -d -m 700 /home/anna && cp -r my_map /home/anna/; " + _map_at("/home/anna/my_map"),
        "may not read",
    ),
    Mistake(
        "map-in-tmp",
        "map in /tmp, of which the service has its own",
        "cp -r my_map /tmp/; " + _map_at("/tmp/my_map"),  # noqa: S108 - a mistake
        "a /tmp of its own",
    ),
    Mistake("map-tilde", "map at ~", _map_at("~/my_map"), "another home"),
    Mistake(
        "map-above",
        "map in a folder above the file's",
        "rm -rf ../above && mv my_map ../above; " + _map_at("../above"),
        "lies above",
    ),
    Mistake("border-off-map", "border off the map", _off_the_map("my_map"), "leaves the map"),
    Mistake("border-wall", "border through a wall", THROUGH_A_WALL, "through a wall"),
    Mistake("start-off-map", "start off the map", _edit("x = 5.0", "x = 500.0"), "outside the map"),
    Mistake("not-a-number", "start at nan", _edit("theta = 0.0", "theta = nan"), "start.theta"),
    Mistake("infinite", "start at inf", _edit("x = 5.0", "x = inf"), "start.x"),
    Mistake(
        "recorder-elsewhere",
        "recordings in a folder that the service may not write",
        _edit('folder = "/var/lib/patrol"', 'folder = "/data"'),
        "may write below",
    ),
    Mistake("bom", "file with a byte order mark", "sed -i '1s/^/\\xef\\xbb\\xbf/' robot1.toml"),
    Mistake(
        "image-here",
        "map.yaml with image: ./map.pgm",
        "sed -i 's|^image:.*|image: ./map.pgm|' my_map/map.yaml",
        holds=AS_PATROL,
    ),
    Mistake(
        "image-absolute",
        "map.yaml with the image's whole path",
        f"sed -i 's|^image:.*|image: {PLACE}/my_map/map.pgm|' my_map/map.yaml",
        holds=AS_PATROL,
    ),
    Mistake(
        "same-name",
        "edited copy of the shipped paper_lab beside the file, its border off the map",
        f"mv my_map paper_lab; {_map_at('paper_lab')}; " + _off_the_map("paper_lab"),
        "leaves the map",
    ),
    Mistake(
        "no-serial-numbers",
        "udev rules left out",
        f"rm -f {RULES}",
        holds=f"! grep -v '^#' {RULES} | grep -q tty",
    ),
    Mistake("no-user", "user patrol missing", "userdel patrol", holds="id patrol"),
)


def _never_drives(stage: FieldStage, outcome: Outcome) -> None:
    guest = _installed(stage)
    guest.run(_off_the_map(INSTALLED_MAP))
    guest.attempt(f"systemctl start {UNIT}")
    stage.machine.guest.run(f"sleep {SETTLED_S:.0f}")
    state = guest.run(f"systemctl show {UNIT} -p ActiveState,ExecMainStatus,NRestarts")
    outcome.note(" ".join(state.split()))
    outcome.require("ActiveState=failed" in state, "it goes on")
    outcome.require("ExecMainStatus=78" in state, "not the status of a wrong configuration")
    outcome.require("NRestarts=0" in state, "it was started again")


def _recorder_folder(stage: FieldStage, outcome: Outcome) -> None:
    guest = _installed(stage)
    guest.run(
        f"systemctl stop {UNIT}; touch /var/lib/patrol/file; chown patrol: /var/lib/patrol/file;"
        f'sed -i \'s|"/var/lib/patrol"|"/var/lib/patrol/file/runs"|\' {CONFIG}'
    )
    guest.run(f"systemctl start {UNIT} && sleep {SETTLED_S:.0f}")
    state = guest.run(f"systemctl show {UNIT} -p ActiveState,NRestarts")
    outcome.note(" ".join(state.split()))
    outcome.require("ActiveState=active" in state, "the robot does not start")
    outcome.require("NRestarts=0" in state, "it was started again")
    said = [line.text for line in stage.journal() if line.text.startswith("recorder: ")]
    outcome.require(bool(said), "the journal does not say that nothing is recorded")
    outcome.note(said[-1] if said else "nothing said")


def _installed(stage: FieldStage) -> Guest:
    """Return the workbench's system with the robot installed, without mistakes."""
    guest = stage.workbench()
    prepare(guest)
    guest.run(f"cd {PLACE} && patrol install robot1.toml; systemctl reset-failed")
    return guest


MISTAKE_ROWS = (
    *(FieldRow(each.name, f"mistake: {each.what}", each.must, each.run) for each in MISTAKES),
    FieldRow(
        "never-drives",
        "mistake after the installation: the border moved off the map",
        "the service ends with status 78 and is not started again",
        _never_drives,
    ),
    FieldRow(
        "recorder-folder",
        "mistake after the installation: recordings below a file",
        "the service runs, the journal says so",
        _recorder_folder,
    ),
)
