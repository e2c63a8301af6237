"""Goes from page to page of the viewer in one browser page: loading all of it anew costs more than most tests."""

from collections.abc import Iterator, Sequence
from contextlib import contextmanager
from pathlib import Path
from typing import Any

from foundry.storing.store import SweepFolder
from foundry.viewer.server import serving

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


@contextmanager
def shown(page: Any, made: SweepFolder, address: str = "", trusted: Sequence[str] = ()) -> Iterator[str]:
    """Serve a sweep and show one of its pages; yield the server's address. A page is left before its server ends."""
    with serving(made.path, trusted=trusted) as server:
        go(page, server.url, address)
        yield server.url
        page.goto("about:blank")


def saved(page: Any, kind: str) -> bytes:
    with page.expect_download() as waiting:
        page.click(f"[data-save={kind}]")
    return Path(waiting.value.path()).read_bytes()
