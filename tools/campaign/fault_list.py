"""All faults, in the order of the table."""

from __future__ import annotations

from collections.abc import Sequence

from tools.campaign.chosen import chosen
from tools.campaign.computer_fault_list import COMPUTER_FAULTS
from tools.campaign.fault import Expected, Fault, FaultError, do_nothing
from tools.campaign.line_fault_list import LINE_FAULTS
from tools.campaign.robot_fault_list import ROBOT_FAULTS

FAULTS: tuple[Fault, ...] = (
    Fault("none", "nothing at all", do_nothing, do_nothing, Expected.MAY_PATROL),
    *LINE_FAULTS,
    *ROBOT_FAULTS,
    *COMPUTER_FAULTS,
)


def chosen_faults(names: Sequence[str]) -> list[Fault]:
    """Return the faults with these names, all if ``names`` is empty; raises FaultError."""
    return chosen(
        FAULTS, names, lambda name, known: FaultError(f"no fault {name!r}; faults are {known}")
    )
