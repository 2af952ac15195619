"""The sources of the virtual machine's packages, from canned output of apt-get indextargets."""

from __future__ import annotations

import pytest

from tools.field.machine_image import debian_sources
from tools.field.trial_error import TrialError

LISTED = """\
mirror/debian/|bookworm|main|Debian
mirror/debian/|bookworm|main|Debian
mirror/debian/|bookworm-updates|main|Debian
mirror/debian/|bookworm|non-free|Debian
mirror/debian/|trixie|main|Debian
elsewhere/|bookworm|main|Somebody
"""


def test_only_debian_12s_main_packages_are_taken_each_source_once() -> None:
    assert debian_sources(LISTED) == [
        "deb mirror/debian/ bookworm main",
        "deb mirror/debian/ bookworm-updates main",
    ]


def test_a_machine_without_such_sources_is_told() -> None:
    with pytest.raises(TrialError, match="no packages of Debian 12"):
        debian_sources("mirror/ubuntu/|noble|main|Ubuntu\n")
