"""The report as one self-contained HTML page."""

from __future__ import annotations

import datetime
from collections.abc import Callable, Iterable, Sequence
from dataclasses import dataclass
from pathlib import Path
from typing import Any

import matplotlib as mpl
from jinja2 import Environment, FileSystemLoader, StrictUndefined
from markupsafe import Markup

from tools.report import style
from tools.report.blocks import Block, Figure
from tools.report.sections import SECTIONS
from tools.report.team import Team

_FOLDER = Path(__file__).parent


@dataclass(frozen=True, slots=True)
class _Tile:
    """A number of the headline."""

    label: str
    value: str
    worse: bool


@dataclass(frozen=True, slots=True)
class _Section:
    """The blocks below one title."""

    anchor: str
    title: str
    blocks: Sequence[Block]


def page(team: Team, figures: dict[str, Any], progress: Callable[[float], None]) -> str:
    """Return the page as HTML.

    figures: the report's numbers; progress: called with the number of sections done.
    """
    sections = []
    with mpl.rc_context(style.RC):
        for done, (anchor, title, build) in enumerate(SECTIONS):
            blocks = list(build(team, figures))
            progress(done + 1)
            if blocks:
                sections.append(_Section(anchor, title, blocks))
    templates = Environment(
        loader=FileSystemLoader(_FOLDER),
        autoescape=True,
        undefined=StrictUndefined,
        keep_trailing_newline=True,
    )
    return templates.get_template("page.html.j2").render(
        title=f"{', '.join(team.names)} on {team.folder.name}",
        subtitle=_subtitle(team),
        style=Markup((_FOLDER / "page.css").read_text()),  # noqa: S704 - a file of this package
        tiles=_tiles(figures),
        sections=sections,
    )


def figures_alone(team: Team, figures: dict[str, Any], folder: Path, form: str) -> list[Path]:
    """Write every figure of the report as a file in a format: svg, png or pdf; return the files.

    A file has the name of its section, with a number from the second one on.
    """
    files: list[Path] = []
    with mpl.rc_context(style.RC):
        for anchor, _, build in SECTIONS:
            drawn = [block.drawn for block in build(team, figures) if isinstance(block, Figure)]
            for number, figure in enumerate(drawn, 1):
                name = anchor if number == 1 else f"{anchor}-{number}"
                files.append(folder / f"{name}.{form}")
                style.save(figure, files[-1])
    return files


def _subtitle(team: Team) -> str:
    header = team.runs[0].header
    start = datetime.datetime.fromtimestamp(header.start_wall_ns / 1e9, datetime.UTC)
    border = team.folder.border
    parts = [
        f"{len(team.runs)} recording{'s' if len(team.runs) > 1 else ''}",
        f"{style.clock(team.end)} min",
        "no border" if border is None else f"border of {border.length:.1f} m",
        f"software {header.software_version}",
        f"source: {header.source}",
    ]
    if header.start_wall_ns > 1e18:
        parts.insert(0, start.strftime("%Y-%m-%d %H:%M UTC"))
    return " · ".join(parts)


def _tiles(figures: dict[str, Any]) -> list[_Tile]:
    """Return the headline numbers, marked where they miss their limits."""
    robots = figures["robots"]
    p99 = _largest(robot["border_distance_m"]["p99"] for robot in robots)
    reach = [robot["reach_s"] for robot in robots if robot["reach_s"] is not None]
    idle = figures["idleness_s"]
    shares = [robot["localization"]["health_share"].get("localized", 0.0) for robot in robots]
    processes = [robot["process"] for robot in robots if robot["process"]]
    stops = len(figures["incidents"])
    tiles = [
        _tile("distance from border, p99", p99, "{:.3f} m", worse=p99 is not None and p99 > 0.05),
        _tile("on the border after", max(reach) if reach else None, "{:.0f} s"),
        _tile("meetings", len(figures["meetings"]), "{:d}"),
        _tile("closest approach", figures["closest_m"], "{:.2f} m"),
        _tile("longest wait of a place", idle["worst"], "{:.0f} s"),
        _tile("localized", 100.0 * min(shares), "{:.1f} %", worse=min(shares) < 0.98),
        _tile("incidents", stops, "{:d}", worse=stops > 0),
    ]
    if processes:
        load = 100.0 * max(process["cpu_mean"] for process in processes)
        misses = sum(process["deadline_misses"] for process in processes)
        tiles.append(_tile("agent's load", load, "{:.1f} %", worse=load > 15.0))
        tiles.append(_tile("deadlines missed", misses, "{:d}", worse=misses > 0))
    return tiles


def _largest(values: Iterable[float | None]) -> float | None:
    return max((value for value in values if value is not None), default=None)


def _tile(label: str, value: float | None, form: str, *, worse: bool = False) -> _Tile:
    return _Tile(label, "–" if value is None else form.format(value), worse)
