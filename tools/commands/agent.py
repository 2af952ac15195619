"""``patrol agent ROBOT.toml``: the onboard process.

The service is ready at once: what takes long, the imports, comes after.
"""

from __future__ import annotations

import argparse
import gc
import sys
import time
from pathlib import Path
from typing import NoReturn

from robot_agent.process.service_notifier import ServiceNotifier
from robot_agent.process.start_backoff import StartBackoff


def configure(parser: argparse.ArgumentParser) -> None:
    """Declare the options."""
    parser.epilog = "example: patrol agent robot1.toml --record run.mcap"
    parser.add_argument("config", type=Path, metavar="ROBOT.toml", help="the robot's configuration")
    parser.add_argument("--record", type=Path, metavar="REC.mcap", help="record to this file")
    parser.add_argument(
        "--print-config", action="store_true", help="print the effective configuration and end"
    )
    parser.add_argument(
        "--list-settings",
        action=_ListSettings,
        nargs=0,
        help="print every key with its default, unit and meaning, and end",
    )


class _ListSettings(argparse.Action):
    """Print the settings and exit, as ``--help`` does: no configuration file is needed."""

    def __call__(self, parser: argparse.ArgumentParser, *_: object) -> NoReturn:
        from robot_agent.process.settings_list import format_settings, list_settings

        print(format_settings(list_settings()))
        parser.exit()


def run(options: argparse.Namespace) -> int:
    """Run one robot until SIGINT or SIGTERM.

    A configuration that can never patrol ends it with a status of its own, with which the service
    is not started again.
    """
    if options.print_config:
        from robot_agent.config import format_config, load_config

        print(format_config(load_config(options.config)), end="")
        return 0
    backoff = StartBackoff()
    wait_for_start(backoff)
    gc.disable()  # a start only adds objects: looking for others costs a tenth of its time
    from tools.deploy.onboard_process import run_robot

    status = run_robot(options.config, options.record)
    if status == 0:
        backoff.ended_well()
    return status


def wait_for_start(backoff: StartBackoff) -> None:
    """Tell the service manager that the service is up; make the pause after failed starts."""
    pause = backoff.begin(time.monotonic())
    notifier = ServiceNotifier()
    if not pause:
        notifier.starting()
        return
    words = f"failed {backoff.failed} times within a minute of its start, waits {pause:g} s"
    notifier.starting(words)
    print(f"patrol agent: {words}", file=sys.stderr, flush=True)
    time.sleep(pause)
