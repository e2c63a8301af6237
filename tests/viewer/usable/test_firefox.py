"""The main path through the viewer in Firefox: its console stays free of errors, and nothing outside is asked for.

Firefox has no window and is spoken to by WebDriver BiDi, which it answers itself: no driver stands between. The
protocol: https://w3c.github.io/webdriver-bidi/.
"""

import asyncio
import contextlib
import json
import re
import shutil
import subprocess
from collections.abc import Iterator
from itertools import count
from pathlib import Path
from typing import Any

import aiohttp
import pytest

from browser import is_inside
from foundry.viewer.export import export
from made_up_runs import STEPS
from viewer.usable.conftest import Forms

pytestmark = pytest.mark.firefox

NAMES = ("firefox-esr", "firefox")
KEYS = {"Enter": "\ue007", "Escape": "\ue00c", "ArrowLeft": "\ue012", "ArrowRight": "\ue014", "Home": "\ue011"}
NOTHING_OUTSIDE = """
user_pref("network.proxy.type", 1);
user_pref("network.proxy.http", "127.0.0.1");
user_pref("network.proxy.http_port", 9);
user_pref("network.proxy.ssl", "127.0.0.1");
user_pref("network.proxy.ssl_port", 9);
user_pref("app.normandy.enabled", false);
user_pref("datareporting.policy.dataSubmissionEnabled", false);
"""
"""What is not on this machine is asked of a proxy that is not there."""
LEFT = "AbortError: The operation was aborted. "
"""What Firefox says of a page that is left while it asks for something; the pages themselves take nothing back."""
LOOK = """new Promise((found) => {
  const look = () => (%s) ? found(true) : setTimeout(look, 30);
  look();
})"""


class Firefox:
    """A page of Firefox.

    Attributes:
        errors: what its console was told to be an error.
        asked: addresses that it asked for.
    """

    def __init__(self, socket: aiohttp.ClientWebSocketResponse, loop: asyncio.AbstractEventLoop) -> None:
        self.errors: list[str] = []
        self.asked: list[str] = []
        self._socket = socket
        self._loop = loop
        self._numbers = count(1)
        self._do("session.new", capabilities={})
        self._do("session.subscribe", events=["log.entryAdded", "network.beforeRequestSent"])
        self._context = self._do("browsingContext.getTree")["contexts"][0]["context"]

    @classmethod
    @contextlib.contextmanager
    def started(cls, folder: Path) -> "Iterator[Firefox]":
        """Start Firefox with a profile of its own in a folder; at the end, fail when a page logged an error.

        It fails as well when a page asked for anything outside this machine.
        """
        program = next(filter(None, map(shutil.which, NAMES)), None)
        if program is None:
            pytest.skip(f"none of {', '.join(NAMES)} is installed")
        (folder / "user.js").write_text(NOTHING_OUTSIDE, encoding="utf-8")
        command = [program, "--headless", "--no-remote", "--profile", str(folder), "--remote-debugging-port", "0"]
        process = subprocess.Popen(command, stdout=subprocess.DEVNULL, stderr=subprocess.PIPE, text=True)
        loop = asyncio.new_event_loop()
        try:
            session, socket = loop.run_until_complete(_connected(_address(process)))
            try:
                firefox = cls(socket, loop)
                yield firefox
            finally:
                loop.run_until_complete(socket.close())
                loop.run_until_complete(session.close())
        finally:
            process.kill()
            process.communicate()
            loop.close()
        assert firefox.errors == [], firefox.errors
        assert [url for url in firefox.asked if not is_inside(url)] == []

    def goto(self, url: str) -> None:
        """Load an address anew, even where it differs from the present one behind its # alone."""
        for address in ("about:blank", url):
            self._do("browsingContext.navigate", context=self._context, url=address, wait="complete")

    def evaluate(self, expression: str) -> Any:
        """Return the value of an expression of JavaScript, a promise's when it is kept."""
        told = f"Promise.resolve({expression}).then((value) => JSON.stringify(value ?? null))"
        found = self._do("script.evaluate", expression=told, target={"context": self._context}, awaitPromise=True)
        if found["type"] == "exception":
            raise AssertionError(found["exceptionDetails"]["text"])
        return json.loads(found["result"]["value"])

    def wait_for(self, expression: str) -> None:
        """Wait until an expression is true, as long as pytest lets the test run."""
        self.evaluate(LOOK % expression)

    def click(self, selector: str) -> None:
        self.wait_for(_one(selector))
        self.evaluate(f"{_one(selector)}.click()")

    def press(self, *keys: str) -> None:
        pressed = [{"type": kind, "value": KEYS.get(key, key)} for key in keys for kind in ("keyDown", "keyUp")]
        actions = [{"type": "key", "id": "key", "actions": pressed}]
        self._do("input.performActions", context=self._context, actions=actions)

    def write(self, selector: str, text: str) -> None:
        """Write into a field, and send it off."""
        self.evaluate(f"{_one(selector)}.focus()")
        self.press(*text, "Enter")

    def _do(self, method: str, **parameters: Any) -> dict[str, Any]:
        return self._loop.run_until_complete(self._answer(method, parameters))

    async def _answer(self, method: str, parameters: dict[str, Any]) -> dict[str, Any]:
        """Send a command; take note of what happens until it is answered."""
        number = next(self._numbers)
        await self._socket.send_json({"id": number, "method": method, "params": parameters})
        while (told := await self._socket.receive_json()).get("id") != number:
            self._note(told)
        if told["type"] == "error":
            raise AssertionError(f"{method}: {told['message']}")
        return dict(told["result"])

    def _note(self, told: dict[str, Any]) -> None:
        happened = told["params"]
        if told["method"] == "network.beforeRequestSent":
            self.asked.append(happened["request"]["url"])
        elif happened["level"] == "error" and happened["text"] != LEFT:
            self.errors.append(happened["text"])


def _one(selector: str) -> str:
    return f"document.querySelector({json.dumps(selector)})"


def _address(process: subprocess.Popen[str]) -> str:
    assert process.stderr is not None
    for line in process.stderr:
        if found := re.search(r"ws://\S+", line):
            return f"{found.group()}/session"
    raise AssertionError(f"Firefox ended with {process.wait()} before it listened")


async def _connected(address: str) -> tuple[aiohttp.ClientSession, aiohttp.ClientWebSocketResponse]:
    session = aiohttp.ClientSession()
    return session, await session.ws_connect(address, max_msg_size=0)


@pytest.fixture(scope="module")
def firefox(tmp_path_factory: pytest.TempPathFactory) -> Iterator[Firefox]:
    with Firefox.started(tmp_path_factory.mktemp("profile")) as page:
        yield page


def at_step(step: int) -> str:
    return f"document.querySelector('.where')?.textContent === 'step {step} of {STEPS}'"


def rows(many: int) -> str:
    return f"document.querySelectorAll('tr[data-run]').length === {many}"


def open_sweep(firefox: Firefox, url: str) -> None:
    """Open the page of the 2D sweep, and wait until nothing on it moves any more."""
    firefox.goto(f"{url}#/sweep/grid")
    firefox.wait_for(f"{rows(4)} && {_one('.matrix td button')} && {_one('.gallery')}")


def test_runs_are_filtered_opened_stepped_and_played(firefox: Firefox, forms: Forms):
    open_sweep(firefox, forms.server.url)
    firefox.write("[aria-label='Filter and search']", "second")
    firefox.wait_for(rows(2))
    firefox.click("tr[data-run] a")
    firefox.wait_for(at_step(1))
    firefox.press("ArrowRight", "]")
    firefox.wait_for(f"{at_step(2)} && {_one('.inspector .facts')}")
    firefox.press("+", "+", "+", " ")
    firefox.wait_for(f"document.querySelector('.where').textContent === 'after step {STEPS} of {STEPS}'")
    assert firefox.evaluate("location.hash.endsWith('agent=0')")


@pytest.mark.parametrize("form", ["grid", "rounds", "camera"])
def test_runs_side_by_side_show_where_they_part(firefox: Firefox, forms: Forms, form: str):
    firefox.goto(f"{forms.server.url}#/{forms.compared(form)}")
    firefox.wait_for(_one(".chips > *"))
    firefox.wait_for("document.querySelectorAll('.column .facts, .column .quote').length > 1")
    assert firefox.evaluate("document.querySelectorAll('.panel').length") == 2


def test_a_probe_is_gone_through_by_keys(firefox: Firefox, forms: Forms):
    firefox.goto(f"{forms.server.url}#/sweep/probe")
    firefox.wait_for(_one(".moment .choices"))
    firefox.press("j", "e")
    firefox.wait_for("location.hash.includes('edit=no_fire') && document.querySelectorAll('.map svg').length === 2")


def test_an_exported_page_is_opened_from_its_files(firefox: Firefox, forms: Forms, tmp_path: Path):
    open_sweep(firefox, export(forms.grid.path, tmp_path / "page").page.as_uri())
    firefox.click("tr[data-run] a")
    firefox.wait_for(at_step(1))
    firefox.press("]")
    firefox.wait_for(_one(".inspector .quote"))
