"""Goes from page to page of the viewer in one browser page: loading all of it anew costs more than most tests."""

from pathlib import Path
from typing import Any

PLAYER_READY = "() => window.Foundry && Foundry.page && Foundry.page.clock && Foundry.page.clock.steps > 0"
SHOWN = "text => document.querySelector('.shown')?.textContent === text"
"""Whether the table of runs says that it shows these, such as "2 of 4 runs"."""
LEAVE = """address => {
  delete Foundry.page;
  document.getElementById('main').replaceChildren();
  history.replaceState(null, '', '#/nowhere');
  location.hash = `#/${address}`;
}"""


def go(page: Any, url: str, address: str = "") -> None:
    """Show an address of the viewer at `url`, and wait until the clock of a run is there."""
    if page.url.startswith(f"{url}#"):
        page.evaluate(LEAVE, address)
    else:
        page.goto("about:blank")
        page.goto(f"{url}#/{address}")
    if address.startswith(("run", "compare")):
        page.wait_for_function(PLAYER_READY)


def saved(page: Any, kind: str) -> bytes:
    """Return what the table of the runs is saved as: "csv" or "parquet"."""
    with page.expect_download() as waiting:
        page.click(f"[data-save={kind}]")
    return Path(waiting.value.path()).read_bytes()
