"""A real browser without a window, one a process: `with browser_page() as page: page.goto(path.as_uri())`."""

from __future__ import annotations

import asyncio
import atexit
import contextlib
import shutil
from collections.abc import Iterator, Sequence
from dataclasses import dataclass
from functools import lru_cache
from typing import TYPE_CHECKING
from urllib.parse import urlsplit

import pytest

if TYPE_CHECKING:
    from playwright.sync_api import Browser, Page

NAMES = ("chromium", "chromium-browser", "google-chrome", "google-chrome-stable")
FLAGS = (
    "--headless",
    "--no-sandbox",
    "--disable-gpu",
    "--enable-unsafe-swiftshader",  # WebGL without a graphics card
    "--no-first-run",
    "--disable-background-networking",
    "--disable-component-update",
    "--disable-sync",
    "--host-resolver-rules=MAP * ~NOTFOUND, EXCLUDE 127.0.0.1, EXCLUDE localhost",
)
INSIDE = ("127.0.0.1", "localhost")
NEVER_MS = 0
"""A page is waited for as long as pytest lets the test run, however busy the machine is."""


@dataclass(frozen=True)
class _Started:
    browser: Browser
    loop: asyncio.AbstractEventLoop


@lru_cache(maxsize=1)
def _started() -> _Started:
    from playwright.sync_api import sync_playwright

    found = next(filter(None, map(shutil.which, NAMES)), None)
    if found is None:
        pytest.skip(f"none of {', '.join(NAMES)} is installed")
    playwright = sync_playwright().start()
    browser = playwright.chromium.launch(executable_path=found, args=list(FLAGS), timeout=NEVER_MS)
    started = _Started(browser, asyncio.get_running_loop())
    asyncio._set_running_loop(None)

    def stop() -> None:
        with _running(started.loop):
            started.browser.close()
            playwright.stop()

    atexit.register(stop)
    return started


@contextlib.contextmanager
def _running(loop: asyncio.AbstractEventLoop | None) -> Iterator[None]:
    """Let the browser's loop be the running one; afterwards none is, so that other tests can run theirs."""
    before = asyncio._get_running_loop()
    asyncio._set_running_loop(loop)
    try:
        yield
    finally:
        asyncio._set_running_loop(before)


def put_aside() -> contextlib.AbstractContextManager[None]:
    """While a page stays open for later, let other tests run event loops of their own."""
    return _running(None)


def taken_up() -> contextlib.AbstractContextManager[None]:
    return _running(_started().loop)


@contextlib.contextmanager
def browser_page(
    *, width: int = 1280, height: int = 900, dark: bool = False, touch: bool = False, allowed_errors: Sequence[str] = ()
) -> Iterator[Page]:
    """Yield an empty page; at the end, fail when it logged an error or asked for anything outside this machine."""
    started = _started()
    errors: list[str] = []
    asked: list[str] = []
    with _running(started.loop):
        context = started.browser.new_context(
            viewport={"width": width, "height": height}, color_scheme="dark" if dark else "light", has_touch=touch
        )
        context.set_default_timeout(NEVER_MS)
        try:
            page = context.new_page()
            page.on("console", lambda message: errors.append(message.text) if message.type == "error" else None)
            page.on("pageerror", lambda error: errors.append(str(error)))
            page.on("request", lambda request: asked.append(request.url))
            yield page
        finally:
            context.close()
    told = [error for error in errors if not any(part in error for part in allowed_errors)]
    outside = [url for url in asked if not is_inside(url)]
    assert not told, told
    assert not outside, outside


def is_inside(url: str) -> bool:
    """Return whether an address is a file, part of the page itself, or served by this machine."""
    parts = urlsplit(url)
    return parts.scheme in ("file", "data", "blob", "about") or parts.hostname in INSIDE
