"""Pages at an unguessable address where people answer questions."""

import hmac
import secrets
from collections.abc import Callable
from http import HTTPStatus
from pathlib import Path
from typing import Any, TypeVar
from urllib.parse import unquote, urlsplit

import msgspec

from foundry.errors import InputError
from foundry.viewer.files import POLICY, inside, static_file
from foundry.viewer.http import LOOPBACK, PageHandler, PageServer
from foundry.viewer.run_view import JSON, Resource

SHARED = ("style.css", "dom.js", "icon.svg")
"""Files of the viewer's page that the pages for people use too."""
PAGE = Path(__file__).resolve().parent / "page"
LONGEST = 1 << 20
"""Maximum size of an answer, bytes."""
T = TypeVar("T")


class PrivateServer(PageServer):
    """A page server with a secret token in its address. Anyone who has the address can use the page."""

    def __init__(self, handler: "type[PrivateHandler]", *, host: str = LOOPBACK, port: int | None = 0) -> None:
        self.token = secrets.token_urlsafe(16)
        super().__init__(handler, host=host, port=port)

    @property
    def url(self) -> str:
        """Address of the page; anyone who has it can use the page."""
        return f"{super().url}{self.token}/"


class PrivateHandler(PageHandler):
    """Answers only requests whose path contains the secret token."""

    server: PrivateServer
    index: str
    """Name of the page's file in this folder."""

    def do_GET(self) -> None:
        """Answer a request for a page, script or data, if its path begins with the secret token."""
        self._within(self.answer_get)

    def do_POST(self) -> None:
        """Process data that the page sends."""
        self._within(self._post)

    def answer_get(self, path: str) -> None:
        """Answer a request; `path` is the rest of its address after the token. By default, send a file of the page."""
        file = static_file(path) if path in SHARED else inside(PAGE, path or self.index)
        self.send_file(file, path, POLICY + "; frame-ancestors 'none'")

    def answer_post(self, path: str, body: bytes) -> Any:
        """Process the data `body` that the page sends to the address `path`; return the answer for the page.

        Raises:
            InputError: the data are invalid.
        """
        raise NotImplementedError

    def send_json(self, value: Any) -> None:
        """Send a value as JSON."""
        self.send(HTTPStatus.OK, Resource(msgspec.json.encode(value), JSON))

    def _within(self, answer: Callable[[str], None]) -> None:
        if not self.is_known():
            return
        token, _, path = unquote(urlsplit(self.path).path).removeprefix("/").partition("/")
        if not hmac.compare_digest(token.encode(), self.server.token.encode()):
            self.close_connection = True
            self.send_problem(HTTPStatus.NOT_FOUND, "This address is wrong. Use the address that the terminal shows.")
            return
        self.answering(lambda: answer(path), HTTPStatus.CONFLICT)

    def _post(self, path: str) -> None:
        if "Origin" in self.headers and not self.is_own_page:
            raise InputError("Only this page can send answers. Open the address that the terminal shows.")
        self.send_json(self.answer_post(path, self.body(LONGEST)))


def read(body: bytes, kind: type[T]) -> T:
    """Return the data that the page sent, or raise InputError if their type is not `kind`."""
    try:
        return msgspec.json.decode(body, type=kind)
    except (msgspec.DecodeError, UnicodeDecodeError) as error:
        raise InputError(f"The data that the page sent cannot be read: {error}") from error
