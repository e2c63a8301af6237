"""Serves the page and the records of a folder over HTTP; by default read-only and only for this machine."""

import math
import time
from collections.abc import Iterator, Sequence
from contextlib import contextmanager
from http import HTTPStatus
from pathlib import Path
from urllib.parse import unquote, urlsplit

from foundry.viewer.files import MEDIA_TYPES, PALETTE, POLICY, REPORT_POLICY, inside, palette_script, static_file
from foundry.viewer.forms import OUTSIDE, outside_script
from foundry.viewer.http import LOOPBACK, PageHandler, PageServer, is_loopback, running
from foundry.viewer.resources import Resources
from foundry.viewer.run_view import IsWarning, Resource

LONGEST_NOTE = 1 << 16
"""Maximum size of a note, bytes."""


class ViewServer(PageServer):
    """Shows recorded runs.

    Args:
        root, trusted, is_warning: see `Resources`.
        host, port: see `PageServer`.
    """

    def __init__(
        self,
        root: Path,
        *,
        host: str = LOOPBACK,
        port: int | None = 0,
        trusted: Sequence[str] = (),
        is_warning: IsWarning | None = None,
    ) -> None:
        self.resources = Resources(root, trusted=trusted, is_warning=is_warning)
        self.last_asked = -math.inf
        super().__init__(_Handler, host=host, port=port)

    def server_close(self) -> None:
        """Stop listening."""
        super().server_close()
        self.resources.close()


class _Handler(PageHandler):
    """Answers GET and HEAD, accepts notes, and refuses all other requests."""

    server: ViewServer

    def do_GET(self) -> None:
        self._answer()

    def do_HEAD(self) -> None:
        self._answer()

    def _refuse(self) -> None:
        self.close_connection = True
        self.send_problem(HTTPStatus.METHOD_NOT_ALLOWED, f"{self.command} is refused: the page can only read records.")

    def do_POST(self) -> None:
        address = unquote(urlsplit(self.path).path).removeprefix("/data/")
        if not address.startswith("sweep/") or not address.endswith("/notes"):
            self._refuse()
        elif self._may_write():
            self.answering(lambda: self._take_note(address), HTTPStatus.NOT_FOUND)

    def _may_write(self) -> bool:
        """Return whether this page sent the request, on this machine; if not, send an error to the sender."""
        if not self.is_known():
            return False
        own = is_loopback(self.server.host) and self.is_own_page
        if not own:
            self.close_connection = True
            self.send_problem(
                HTTPStatus.FORBIDDEN, "Notes can be written only on this page, and only on the machine of the server."
            )
        return own

    def _take_note(self, address: str) -> None:
        sweep = address.split("/")[1]
        self.server.resources.take_note(sweep, self.body(LONGEST_NOTE))
        self.send(HTTPStatus.OK, self.server.resources.get(address))

    do_PUT = do_PATCH = do_DELETE = do_OPTIONS = do_TRACE = do_CONNECT = _refuse

    def _answer(self) -> None:
        if not self.is_known():
            return
        self.server.last_asked = time.monotonic()
        path = unquote(urlsplit(self.path).path)
        self.answering(lambda: self._answer_path(path.removeprefix("/")), HTTPStatus.NOT_FOUND)

    def _answer_path(self, path: str) -> None:
        if path.startswith("data/"):
            resource = self.server.resources.get(path.removeprefix("data/"))
            self.send(HTTPStatus.OK, resource)
        elif path.startswith("files/"):
            _, sweep, *rest = path.split("/")
            root = self.server.resources.catalog.sweep(sweep).folder.path
            self.send_file(inside(root, "/".join(rest)), path, REPORT_POLICY)
        elif path.startswith(f"{OUTSIDE}/") and path.endswith("/page.js"):
            script = outside_script(path.split("/")[1])
            self.send_file(script.file if script else None, path, POLICY)
        elif path == PALETTE:
            self.send(HTTPStatus.OK, Resource(palette_script(), MEDIA_TYPES[".js"]))
        else:
            self.send_file(static_file(path), path, POLICY + "; frame-ancestors 'none'")


@contextmanager
def serving(root: Path, *, host: str = LOOPBACK, trusted: Sequence[str] = ()) -> Iterator[ViewServer]:
    """Run a server of the viewer in a thread while the `with` block runs."""
    with running(ViewServer(root, host=host, trusted=trusted)) as server:
        yield server
