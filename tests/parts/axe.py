"""Fails where axe finds something wrong with a page: `axe.check(page)`."""

from collections.abc import Iterator
from functools import lru_cache
from typing import Any

LOOKS = (("light", 1280, 900), ("dark", 400, 800))
"""How pages are looked at: the reader's scheme, width and height in CSS pixels."""
RULES = {"resultTypes": ["violations"], "rules": {"target-size": {"enabled": True}}}
"""All that axe asks by itself, and the size of what is pressed."""
PAINTED = "() => new Promise((done) => requestAnimationFrame(() => requestAnimationFrame(done)))"


@lru_cache(maxsize=1)
def _axe() -> Any:
    from axe_playwright_python.sync_playwright import Axe

    return Axe()


def check(page: Any) -> None:
    """Look at a page as it is now, light and wide, then dark and narrow; fail with look, rule, element and why."""
    texts: list[str] = []
    for scheme, width, height in LOOKS:
        page.emulate_media(color_scheme=scheme)
        page.set_viewport_size({"width": width, "height": height})
        page.evaluate(PAINTED)
        response = _axe().run(page, options=RULES).response
        texts += [f"{scheme}, {width} px: {line}" for line in _lines(response["violations"])]
    if texts:
        raise AssertionError("\n".join(texts))


def _lines(broken: list[dict[str, Any]]) -> Iterator[str]:
    for rule in broken:
        for node in rule["nodes"]:
            why = " ".join(node["failureSummary"].split())
            yield f"{rule['id']} at {' '.join(map(str, node['target']))} {node['html'][:150]}: {why}"
