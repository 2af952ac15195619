"""What a person with a keyboard, a screen reader or weak eyes needs of a page, as checks."""

from __future__ import annotations

from pathlib import Path
from typing import Any

from tests.tools.monitor.browser import Browser

NAMED_ROLES = {
    *("button", "link", "textbox", "searchbox", "combobox", "slider", "checkbox", "img", "image"),
    *("dialog", "application", "region", "search", "table", "toolbar", "DisclosureTriangle"),
}
"""Roles of Chromium's tree that mean nothing without a name."""
LEAST_CONTRAST = 4.5
"""Of text on its ground: WCAG 2.2, 1.4.3, level AA."""

_SCRIPT = Path(__file__).with_suffix(".js").read_text()


def tree(browser: Browser) -> list[dict[str, Any]]:
    """Return the nodes of Chromium's own accessibility tree that are not ignored."""
    nodes = browser.driver.execute_cdp_cmd("Accessibility.getFullAXTree", {})["nodes"]
    return [node for node in nodes if not node.get("ignored")]


def role(node: dict[str, Any]) -> str:
    return str(node.get("role", {}).get("value", ""))


def name(node: dict[str, Any]) -> str:
    return str(node.get("name", {}).get("value", "")).strip()


def unnamed(browser: Browser) -> list[str]:
    """Return the roles of what has no name and needs one."""
    return [role(node) for node in tree(browser) if role(node) in NAMED_ROLES and not name(node)]


def names_of(browser: Browser, wanted: str) -> list[str]:
    """Return the names of all nodes of a role."""
    return [name(node) for node in tree(browser) if role(node) == wanted]


def poor_contrasts(browser: Browser) -> list[str]:
    """Return the visible texts whose contrast is below ``LEAST_CONTRAST``, with it."""
    script = f"{_SCRIPT}\nreturn poorContrasts({LEAST_CONTRAST})"
    return list(browser.driver.execute_script(script))


def small_targets(browser: Browser) -> list[str]:
    """Return the controls that are too small beside others (WCAG 2.2, 2.5.8)."""
    return list(browser.driver.execute_script(f"{_SCRIPT}\nreturn smallTargets()"))
