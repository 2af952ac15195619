"""The groups of figures by their names on the command line."""

from __future__ import annotations

from collections.abc import Callable, Iterator
from pathlib import Path

from tools.benchmark.agent import (
    agent_process,
    decision_step,
    response_on_the_line,
    stop_without_agent,
)
from tools.benchmark.color import color
from tools.benchmark.drivers import drivers
from tools.benchmark.field import field
from tools.benchmark.figure import Figure
from tools.benchmark.localization import localization
from tools.benchmark.network import operator_page, telemetry
from tools.benchmark.patrol import patrol_bench, supervisor
from tools.benchmark.recordings import replay_speed, report_speed

GROUPS: dict[str, Callable[[Path], Iterator[Figure]]] = {
    "agent": agent_process,
    "response": response_on_the_line,
    "field": field,
    "stop": stop_without_agent,
    "supervisor": supervisor,
    "decision": decision_step,
    "patrol": patrol_bench,
    "replay": replay_speed,
    "report": report_speed,
    "localization": localization,
    "drivers": drivers,
    "telemetry": telemetry,
    "page": operator_page,
    "color": color,
}
