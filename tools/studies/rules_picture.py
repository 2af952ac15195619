"""Draws a rule file: its fuzzy sets, and maps of the winning action."""

from __future__ import annotations

import math
from collections.abc import Mapping
from pathlib import Path

import numpy as np
from matplotlib.axes import Axes
from matplotlib.backends.backend_agg import FigureCanvasAgg
from matplotlib.colors import BoundaryNorm, ListedColormap
from matplotlib.figure import Figure
from matplotlib.patches import Patch
from numpy.typing import NDArray

from maps.whole_file import whole_file
from robot_agent.patrol.actions import Action
from robot_agent.patrol.fuzzy import MamdaniSystem, Variable
from robot_agent.patrol.rules import load_rules
from robot_agent.patrol.supervisor import Supervisor

_NEIGHBOR_STATES = {  # gamma at which a decision map is drawn
    -1.0: "patrolling on my left",
    0.0: "not patrolling",
    1.0: "patrolling on my right",
}
_COLORS = {
    Action.REACH_FRONTIER: "#4477aa",
    Action.KEEP_GOING: "#ccbb44",
    Action.PATROL_CLOCKWISE: "#228833",
    Action.PATROL_COUNTER_CLOCKWISE: "#aa3377",
    Action.AVOID_TEAMMATE: "#ee6677",
}
_ACTIONS = tuple(Action)
_GRID_COLUMNS = 12
_STEP = 0.025  # m between the points of a decision map
_BEYOND = 1.25  # end of an axis, in multiples of the last corner of a set
_FAR = {"distance_from_left_end": math.inf, "distance_from_right_end": math.inf}
_PLACES = {  # rows of decision maps on an open border
    "far from both ends": _FAR,
    "at the left end": _FAR | {"distance_from_left_end": 0.0},
    "at the right end": _FAR | {"distance_from_right_end": 0.0},
}


def draw_rules(
    rules: Path, png: Path, *, reading: str, safety_distance: float, open_border: bool
) -> None:
    """Write a PNG of a rule file in one reading.

    First the fuzzy sets of each input and of the outputs; then, for each neighbor state, the
    winning action over distance from border and from neighbor. An open border also has such a row
    for each of its ends.

    Raises RulesError as ``load_rules`` does; OSError if it cannot be written.
    """
    system = load_rules(
        rules, reading=reading, safety_distance=safety_distance, open_border=open_border
    )
    variables = _variables(system)
    places = _PLACES if open_border else {"": _FAR}
    columns = 3 if open_border else 4
    set_rows = math.ceil(len(variables) / columns)
    rows = set_rows + len(places)
    figure = Figure(figsize=(13.0, 3.4 * rows + 0.8), layout="constrained")
    grid = figure.add_gridspec(rows, _GRID_COLUMNS)
    for number, variable in enumerate(variables):
        row, column = divmod(number, columns)
        width = _GRID_COLUMNS // columns
        _draw_sets(figure.add_subplot(grid[row, width * column : width * (column + 1)]), variable)
    for row, (place, ends) in enumerate(places.items(), start=set_rows):
        for column, gamma in enumerate(_NEIGHBOR_STATES):
            axes = figure.add_subplot(grid[row, 4 * column : 4 * column + 4])
            _draw_decisions(axes, system, gamma, ends, place)
    kind = "open" if open_border else "closed"
    figure.suptitle(f"{rules.name}, reading {reading}, {kind} border")
    handles = [Patch(color=_COLORS[a], label=a.value.replace("_", " ")) for a in _ACTIONS]
    figure.legend(handles=handles, loc="outside lower center", ncols=len(handles))
    FigureCanvasAgg(figure)
    with whole_file(png) as part:
        figure.savefig(part, dpi=100, format="png")


def decision_map(
    system: MamdaniSystem,
    border: NDArray[np.float64],
    neighbor: NDArray[np.float64],
    gamma: float,
    ends: Mapping[str, float],
) -> NDArray[np.intp]:
    """Return the winning action, (neighbors, borders), as its index in the order of Action.

    border (borders,), neighbor (neighbors,): distances, m; gamma: neighbor state; ends: distances
    from the border's ends by input, m. Ties are resolved as without a present action.
    """
    winners = np.empty((len(neighbor), len(border)), dtype=np.intp)
    for (row, column), _ in np.ndenumerate(winners):
        inputs = {
            "distance_from_border": float(border[column]),
            "distance_from_neighbor": float(neighbor[row]),
            "neighbor_state": gamma,
            **ends,
        }
        choice = Supervisor(system, minimum_dwell=0.0).choose(0.0, inputs)
        winners[row, column] = _ACTIONS.index(choice.winner)
    return winners


def sets_figure(system: MamdaniSystem) -> Figure:
    """Return the fuzzy sets of each input and of the outputs, the paper's figure 2."""
    variables = _variables(system)
    columns = math.ceil(len(variables) / 2)
    figure = Figure(figsize=(5.5 * columns, 6.5), layout="constrained")
    for axes, variable in zip(figure.subplots(2, columns).ravel(), variables, strict=False):
        _draw_sets(axes, variable)
    for axes in figure.axes[len(variables) :]:
        axes.set_visible(False)
    return figure


def _variables(system: MamdaniSystem) -> list[Variable]:
    return [*system.inputs, Variable("level of each output", system.outputs[0].sets)]


def _draw_sets(axes: Axes, variable: Variable) -> None:
    lowest, highest = _span(variable)
    for name, fuzzy_set in variable.sets.items():
        corners = {fuzzy_set.a, fuzzy_set.b, fuzzy_set.c, fuzzy_set.d}
        x = sorted({lowest, highest} | {c for c in corners if lowest <= c <= highest})
        axes.plot(x, [fuzzy_set(value) for value in x], label=name.replace("_", " "))
    axes.set_title(variable.name.replace("_", " "))
    axes.set_xlabel("m" if variable.name.startswith("distance") else "")
    axes.set_xlim(lowest, highest)
    axes.set_ylim(0.0, 1.6)  # room for the legend
    axes.set_yticks([0.0, 0.5, 1.0])
    axes.grid(alpha=0.3)
    long_names = max(map(len, variable.sets)) > 10
    axes.legend(loc="upper center", ncols=1 if long_names else 3, fontsize="x-small")


def _span(variable: Variable) -> tuple[float, float]:
    """Return the range of a variable to draw: beyond its last corner if a set is unbounded."""
    sets = variable.sets.values()
    corners = [x for s in sets for x in (s.a, s.b, s.c, s.d)]
    finite = [x for x in corners if math.isfinite(x)]
    beyond = _BEYOND if math.inf in corners else 1.0
    return min(finite), max(finite) * beyond


def _draw_decisions(
    axes: Axes, system: MamdaniSystem, gamma: float, ends: Mapping[str, float], place: str
) -> None:
    spans = {variable.name: _span(variable)[1] for variable in system.inputs}
    border = np.arange(_STEP / 2, spans["distance_from_border"], _STEP, dtype=np.float64)
    neighbor = np.arange(_STEP / 2, spans["distance_from_neighbor"], _STEP, dtype=np.float64)
    axes.pcolormesh(
        border,
        neighbor,
        decision_map(system, border, neighbor, gamma, ends),
        cmap=ListedColormap([_COLORS[action] for action in _ACTIONS]),
        norm=BoundaryNorm(np.arange(len(_ACTIONS) + 1) - 0.5, len(_ACTIONS)),
        shading="nearest",
    )
    state = f"neighbor {_NEIGHBOR_STATES[gamma]}"
    axes.set_title(f"{state}, {place}" if place else state, fontsize="medium")
    axes.set_xlabel("distance from border, m")
    axes.set_ylabel("distance from neighbor, m")
