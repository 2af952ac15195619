"""The hazard table of robot_agent/motion/README.md names existing tests."""

import re
from pathlib import Path

ROOT = Path(__file__).parents[1]
README = ROOT / "robot_agent" / "motion" / "README.md"
NAMED = re.compile(r"`(tests/[\w/]+\.py)(?:::(\w+))?`")


def test_every_hazard_has_a_test_that_exists():
    section = README.read_text().split("## Hazards")[1]
    rows = [line for line in section.splitlines() if line.startswith("| ")][2:]
    assert len(rows) >= 12
    assert all(NAMED.search(row) for row in rows)
    for file, test in NAMED.findall(section):
        code = (ROOT / file).read_text()
        assert not test or f"def {test}(" in code, (file, test)
