"""The READMEs: a short root README, an index of rooms, only existing files, commands and links."""

import re
from collections.abc import Iterator
from pathlib import Path

import pytest

from robot_agent.config import FIXED_KEYS, RENAMED_KEYS
from robot_agent.process.settings_list import list_settings
from tests.tools.command_actions import command_actions
from tools.cli import COMMANDS, ROOMS

ROOT = Path(__file__).parents[1]
INDEX = ROOT / "README.md"
TOOLS = ROOT / "tools" / "README.md"
AGENT = ROOT / "robot_agent" / "README.md"
PAGES = [INDEX, *sorted(path for room in ROOMS for path in (ROOT / room).rglob("*.md"))]
"""The READMEs, and pages of figures beside them."""
MAX_LINES, MAX_WORDS = 150, 1500
"""Of a README. Figures that do not fit stand on pages of their own beside it."""

LINK = re.compile(r"!?\[[^\]]*\]\(([^)\s]+)\)")
TICKS = re.compile(r"`([^`\n]+)`")
PATH = re.compile(r"\.?[\w@.+-]+(?:/[\w@.+-]+)+/?|[\w@+-]+\.(?:py|toml|txt|md)")
COMMAND = re.compile(r"(?:\bpatrol|\./tools/run) (\w+)\b")
OPTION = re.compile(r"(?<![\w-])--[a-z][a-z0-9-]*")
MADE = {"map.yaml", "map.pgm", "map.png", "border.toml", "zones.toml"}
"""Files of a map folder, wherever that is."""
ELSEWHERE = {"../shared/data", "acschaefer/ple"}
"""Recorded data beside the checkout, and another project."""
EXAMPLES = re.compile(r"(?:out|keys|my_map|robot\d|ROBOT|RULES|FILE|FLOOR_PLAN|INSTALL)\b.*")
"""Files that a reader makes or receives."""


def identity(path: Path) -> str:
    return str(path.relative_to(ROOT))


def rooms_of(parent: Path) -> list[Path]:
    return sorted(each.parent for each in parent.glob("*/__init__.py"))


def commands_in(text: str) -> Iterator[tuple[str, str]]:
    """Yield command and rest of each command line in a code block or in backticks."""
    text = text.replace("\\\n", " ")  # a backslash continues the line
    blocks = [line.split("#")[0] for line in re.findall(r"^    (.+)$", text, re.MULTILINE)]
    for code in [*blocks, *TICKS.findall(text)]:
        for use in re.split(r"&&|\|\|", code):
            found = COMMAND.search(use)
            if found:
                yield found[1], use[found.end() :].split(" -- ")[0]


def anchors(text: str) -> set[str]:
    """Return the link anchors of a page's headings."""
    heads = re.findall(r"^#+ (.+)$", text, re.MULTILINE)
    return {re.sub(r"[^\w -]", "", head.lower()).replace(" ", "-") for head in heads}


def links(page: Path) -> list[str]:
    return [link for link in LINK.findall(page.read_text()) if "://" not in link]


def linked_files(page: Path) -> set[Path]:
    return {(page.parent / link.split("#")[0]).resolve() for link in links(page)}


def options_of(command: str) -> set[str]:
    return {name for action in command_actions(command) for name in action.option_strings}


@pytest.mark.parametrize("page", [page for page in PAGES if page.name == "README.md"], ids=identity)
def test_a_readme_is_short(page):
    text = page.read_text()
    assert len(text.splitlines()) < MAX_LINES
    assert len(text.split()) < MAX_WORDS


@pytest.mark.parametrize("page", PAGES, ids=identity)
def test_a_page_is_linked_from_the_readme_beside_it(page):
    assert page.name == "README.md" or page in linked_files(page.parent / "README.md")


def test_the_index_names_every_room():
    assert {ROOT / room / "README.md" for room in ROOMS} <= linked_files(INDEX)
    assert {room / "README.md" for room in rooms_of(ROOT / "tools")} <= linked_files(TOOLS)
    shown = linked_files(AGENT) | {
        AGENT.parent / name for name in re.findall(r"^\| `(\w+)/`", AGENT.read_text(), re.MULTILINE)
    }
    for room in rooms_of(ROOT / "robot_agent"):
        assert {room, room / "README.md"} & shown, room


def test_every_command_is_in_the_tables():
    for table in (INDEX, TOOLS):
        named = set(re.findall(r"`patrol (\w+)", table.read_text()))
        assert named >= set(COMMANDS), table


@pytest.mark.parametrize("page", PAGES, ids=identity)
def test_begins_with_a_title_and_a_paragraph(page):
    title, empty, first = page.read_text().splitlines()[:3]
    assert title.startswith("# ")
    assert not empty
    assert first[:1].isalpha()


@pytest.mark.parametrize("page", PAGES, ids=identity)
def test_links_have_existing_targets(page):
    for link in links(page):
        name, _, anchor = link.partition("#")
        target = (page.parent / name).resolve() if name else page
        assert target.exists(), link
        assert not anchor or anchor in anchors(target.read_text()), link


@pytest.mark.parametrize("page", PAGES, ids=identity)
def test_commands_and_their_options_exist(page):
    for command, rest in commands_in(page.read_text()):
        if command in ("COMMAND", "ANYTHING"):
            continue
        assert command in COMMANDS, f"patrol {command}"
        given = {*OPTION.findall(rest)} - {"--help"}
        assert given <= options_of(command), f"patrol {command}{rest}"


@pytest.mark.parametrize("page", PAGES, ids=identity)
def test_files_exist(page):
    """A path in backticks exists in the repository or in the page's own folder."""
    for words in TICKS.findall(page.read_text()):
        name = words.split("::")[0]
        if not PATH.fullmatch(name) or name in MADE | ELSEWHERE or EXAMPLES.fullmatch(name):
            continue
        assert (ROOT / name).exists() or (page.parent / name).exists(), name


@pytest.mark.parametrize("page", PAGES, ids=identity)
def test_no_path_of_one_machine_is_named(page):
    assert not re.search(r"/work/|/tmp/|/home/|/root/", page.read_text())


@pytest.mark.parametrize("page", PAGES, ids=identity)
def test_quoted_tests_exist(page):
    for path, name in re.findall(r"`(tests/[\w/]+\.py)::(\w+)`", page.read_text()):
        assert f"def {name}(" in (ROOT / path).read_text(), f"{path}::{name}"


@pytest.mark.parametrize("page", PAGES, ids=identity)
def test_settings_exist(page):
    keys = {setting.key for setting in list_settings()}
    sections = {key.split(".")[0] for key in {*keys, *RENAMED_KEYS, *FIXED_KEYS}} - {"map"}
    named = re.findall(r"`([a-z_]+(?:\.[a-z_]+)+)\b(?!\.\w)", page.read_text())
    for key in named:
        if key.split(".")[0] in sections and not key.endswith((".py", ".toml", ".md")):
            section = any(each.startswith(f"{key}.") for each in keys)
            assert key in keys or section, key
