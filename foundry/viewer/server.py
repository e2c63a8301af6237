"""Serves the page and the records of a folder over HTTP; read-only, for this machine unless told otherwise."""

from __future__ import annotations

import gzip
import ipaddress
import math
import os
import sys
import threading
import time
import webbrowser
from collections.abc import Iterator, Sequence
from contextlib import contextmanager
from http import HTTPStatus
from http.server import BaseHTTPRequestHandler, ThreadingHTTPServer
from pathlib import Path
from typing import Any
from urllib.parse import unquote, urlsplit

import msgspec

from foundry.errors import InputError, RecordError
from foundry.viewer.files import MEDIA_TYPES, POLICY, REPORT_POLICY, inside, static_file
from foundry.viewer.forms import OUTSIDE, outside_script
from foundry.viewer.resources import Resources
from foundry.viewer.run_view import JSON, Resource

LOOPBACK = "127.0.0.1"
_COMPRESS_FROM = 1 << 10
_COMPRESSIBLE = ("text/", "application/json", "application/octet-stream", "image/svg+xml")
_HEADERS = {
    "X-Content-Type-Options": "nosniff",
    "Referrer-Policy": "no-referrer",
    "Cross-Origin-Resource-Policy": "same-origin",
    "Cross-Origin-Opener-Policy": "same-origin",
    "Cache-Control": "no-cache",
}


class ViewServer(ThreadingHTTPServer):
    """Listens once it is made; `serve_forever` answers.

    Args:
        root: a sweep's folder, or a folder of sweeps.
        host: the address to listen on.
        port: 0 takes a free one.
        trusted: further packages whose classes recorded worlds may be built of, where pictures are drawn again.

    Raises:
        InputError: the folder holds no sweep, or the address cannot be had.
    """

    daemon_threads = True
    request_queue_size = 64

    def __init__(self, root: Path, *, host: str = LOOPBACK, port: int = 0, trusted: Sequence[str] = ()) -> None:
        self.resources = Resources(root, trusted=trusted)
        self.host = host
        self.last_asked = -math.inf
        try:
            super().__init__((host, port), _Handler)
        except (OSError, OverflowError) as error:
            raise InputError(
                f"{host}:{port} cannot be listened on ({error}): choose another --port or --host."
            ) from error

    @property
    def url(self) -> str:
        """Where the page is."""
        host = LOOPBACK if _is_wildcard(self.host) else self.host
        return f"http://{host}:{self.server_port}/"

    def server_close(self) -> None:
        """Stop listening."""
        super().server_close()
        self.resources.close()

    def handle_error(self, request: Any, client_address: Any) -> None:
        """Say nothing of a page that was closed while it was answered."""
        if not isinstance(sys.exception(), ConnectionError):
            super().handle_error(request, client_address)

    def knows(self, host: str) -> bool:
        """Return whether a Host header names this server; other names are a foreign page's (DNS rebinding)."""
        name, _, port = host.rpartition(":")
        if port != str(self.server_port):
            return False
        name = name.strip("[]").lower()
        return name in (self.host, LOOPBACK, "localhost", "::1") or (_is_wildcard(self.host) and _is_address(name))


def _is_wildcard(host: str) -> bool:
    return host in ("0.0.0.0", "::", "")


def _is_address(name: str) -> bool:
    try:
        ipaddress.ip_address(name)
    except ValueError:
        return False
    return True


class _Handler(BaseHTTPRequestHandler):
    """Answers GET and HEAD; whatever else is asked for is refused."""

    server: ViewServer
    protocol_version = "HTTP/1.1"
    server_version = "foundry"
    sys_version = ""
    timeout = 60
    wbufsize = -1  # a head and its body in one packet: two would each wait for the browser to confirm the first
    disable_nagle_algorithm = True

    def do_GET(self) -> None:
        self._answer()

    def do_HEAD(self) -> None:
        self._answer()

    def _refuse(self) -> None:
        self.close_connection = True
        self._error(HTTPStatus.METHOD_NOT_ALLOWED, f"{self.command} is refused: the records can only be read.")

    do_POST = do_PUT = do_PATCH = do_DELETE = do_OPTIONS = do_TRACE = do_CONNECT = _refuse

    def log_message(self, format: str, *args: object) -> None:
        """Say nothing: the terminal belongs to the command."""

    def _answer(self) -> None:
        if not self.server.knows(self.headers.get("Host", "")):
            self._error(HTTPStatus.FORBIDDEN, f"This server is {self.server.url}, and answers to no other name.")
            return
        self.server.last_asked = time.monotonic()
        path = unquote(urlsplit(self.path).path)
        try:
            self._answer_path(path.removeprefix("/"))
        except InputError as error:
            self._error(HTTPStatus.NOT_FOUND, str(error))
        except RecordError as error:
            self._error(HTTPStatus.CONFLICT, str(error))

    def _answer_path(self, path: str) -> None:
        if path.startswith("data/"):
            resource = self.server.resources.get(path.removeprefix("data/"))
            self._send(HTTPStatus.OK, resource)
        elif path.startswith("files/"):
            _, sweep, *rest = path.split("/")
            root = self.server.resources.catalog.sweep(sweep).folder.path
            self._send_file(inside(root, "/".join(rest)), path, REPORT_POLICY)
        elif path.startswith(f"{OUTSIDE}/") and path.endswith("/page.js"):
            script = outside_script(path.split("/")[1])
            self._send_file(script.file if script else None, path, POLICY)
        else:
            self._send_file(static_file(path), path, POLICY + "; frame-ancestors 'none'")

    def _send_file(self, file: Path | None, asked: str, policy: str) -> None:
        if file is None:
            raise InputError(f"There is nothing at '{asked}'.")
        self._send(HTTPStatus.OK, Resource(file.read_bytes(), MEDIA_TYPES[file.suffix]), policy)

    def _error(self, status: HTTPStatus, message: str) -> None:
        self._send(status, Resource(msgspec.json.encode({"error": message}), JSON))

    def _send(self, status: HTTPStatus, resource: Resource, policy: str = POLICY) -> None:
        content, headers = resource.content, {**_HEADERS, "Content-Security-Policy": policy}
        compressible = resource.media_type.startswith(_COMPRESSIBLE) and len(content) >= _COMPRESS_FROM
        if compressible and "gzip" in self.headers.get("Accept-Encoding", ""):
            content, headers["Content-Encoding"] = gzip.compress(content, 1, mtime=0), "gzip"
        if status == HTTPStatus.METHOD_NOT_ALLOWED:
            headers["Allow"] = "GET, HEAD"
        self.send_response(status)
        for name, value in (
            headers | {"Content-Type": resource.media_type, "Content-Length": str(len(content))}
        ).items():
            self.send_header(name, value)
        self.end_headers()
        if self.command != "HEAD":
            self.wfile.write(content)


def is_loopback(host: str) -> bool:
    """Return whether only this machine can reach an address."""
    return host == "localhost" or (_is_address(host) and ipaddress.ip_address(host).is_loopback)


def open_in_browser(url: str) -> bool:
    """Open the page where there is a display; a browser of the terminal would take the terminal away."""
    has_display = not sys.platform.startswith("linux") or any(
        os.environ.get(name) for name in ("DISPLAY", "WAYLAND_DISPLAY")
    )
    return has_display and webbrowser.open(url)


@contextmanager
def serving(root: Path, *, host: str = LOOPBACK, port: int = 0, trusted: Sequence[str] = ()) -> Iterator[ViewServer]:
    """Serve from a thread as long as the block runs."""
    server = ViewServer(root, host=host, port=port, trusted=trusted)
    thread = threading.Thread(target=server.serve_forever, kwargs={"poll_interval": 0.05}, daemon=True)
    thread.start()
    try:
        yield server
    finally:
        server.shutdown()
        server.server_close()
        thread.join()
