"""Zone files, and the names of places."""

from __future__ import annotations

from pathlib import Path

import pytest

from maps.input_limits import MAX_ZONE_VERTICES, MAX_ZONES
from maps.zone import Zone, ZoneError, zone_name
from maps.zone_file import ZONES_FILE, load_zones, read_zones, zones_text

SQUARE = ((0.0, 0.0), (4.0, 0.0), (4.0, 4.0), (0.0, 4.0))
HOOK = ((0.0, 0.0), (10.0, 0.0), (10.0, 10.0), (9.0, 10.0), (9.0, 1.0), (0.0, 1.0))


@pytest.mark.parametrize(
    ("x", "y", "name"),
    [(2.0, 0.5, "a"), (2.0, 3.0, "a"), (9.5, 9.0, "hook"), (5.0, 5.0, ""), (-1.0, 0.5, "")],
)
def test_place_has_the_name_of_the_first_zone_it_lies_in(x: float, y: float, name: str) -> None:
    assert zone_name([Zone("a", SQUARE), Zone("hook", HOOK)], x, y) == name


def test_zones_are_written_as_they_are_read() -> None:
    zones = (Zone('the "kitchen" \\ Küche', SQUARE), Zone("hook", HOOK))
    assert read_zones(zones_text(zones).encode(), "x") == zones


def test_shipped_zones_name_the_border_of_the_paper() -> None:
    folder = Path(__file__).resolve().parents[2] / "maps" / "paper_lab"
    zones = load_zones(folder)
    assert zone_name(zones, 4.0, 8.0) == "west corridor"


def test_folder_without_zones_has_none(tmp_path: Path) -> None:
    assert load_zones(tmp_path) == ()
    (tmp_path / ZONES_FILE).write_text("")
    assert load_zones(tmp_path) == ()


def zone(name: str = '"a"', polygon: str = "[[0, 0], [1, 0], [1, 1]]") -> str:
    return f"[[zone]]\nname = {name}\npolygon = {polygon}\n"


@pytest.mark.parametrize(
    ("text", "words"),
    [
        ("zone", "TOML|Expected|expected"),
        ("[[zone]]\nname = 'a'\n", "polygon"),
        (zone() + "colour = 'red'", "colour"),
        (zone("3"), "name"),
        (zone("''"), "name"),
        (zone("'" + 61 * "a" + "'"), "name"),
        (zone('"\\u001b[2J"'), "unprintable"),
        (zone('"  "'), "unprintable"),
        (zone() + zone(), "two zones are named 'a'"),
        (zone(polygon="[[0, 0], [1, 0]]"), "polygon"),
        (zone(polygon="[[0, 0], [1, 0, 2], [1, 1]]"), "polygon"),
        (zone(polygon="[[0, 0], [1, 1], [1, 0], [0, 1]]"), "lines cross"),
        (zone(polygon="[[0, 0], [1, 0], [2, 0]]"), "flat"),
        (zone(polygon="[[0, 0], [1, 0], [nan, 1]]"), "beyond"),
        (zone(polygon="[[0, 0], [1, 0], [inf, 1]]"), "beyond"),
        (zone(polygon="[[0, 0], [1e9, 0], [1, 1]]"), "beyond"),
        (zone(polygon=str([[k, k * k] for k in range(MAX_ZONE_VERTICES + 1)])), "polygon"),
        ("".join(zone(f"'{k}'") for k in range(MAX_ZONES + 1)), "zone"),
        ("[[" * 5000, "nested|Invalid|invalid|Expected|expected"),
    ],
)
def test_bad_file_is_one_line_that_names_it(text: str, words: str) -> None:
    with pytest.raises(ZoneError, match=words) as caught:
        read_zones(text.encode(), "folder/zones.toml")
    assert str(caught.value).startswith("folder/zones.toml: ")
    assert len(str(caught.value).splitlines()) == 1
    assert len(str(caught.value)) < 400
