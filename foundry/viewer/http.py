"""The common part of all page servers: access control, answers and errors."""

import contextlib
import gzip
import ipaddress
import os
import sys
import threading
import webbrowser
from collections.abc import Callable, Iterator
from contextlib import contextmanager
from http import HTTPStatus
from http.server import BaseHTTPRequestHandler, ThreadingHTTPServer
from pathlib import Path
from typing import Any, TypeVar

import msgspec

from foundry.errors import InputError, RecordError
from foundry.texts import one_line
from foundry.viewer.files import MEDIA_TYPES, POLICY
from foundry.viewer.run_view import JSON, Resource

LOOPBACK = "127.0.0.1"
USUAL_PORTS = (*range(8600, 8620), 0)
"""Ports in the order in which the server tries to get them; 0 stands for any free port."""
MOST_DIGITS = 18
_COMPRESS_FROM = 1 << 10
_COMPRESSIBLE = ("text/", "application/json", "application/octet-stream", "image/svg+xml")
_HEADERS = {
    "X-Content-Type-Options": "nosniff",
    "Referrer-Policy": "no-referrer",
    "Cross-Origin-Resource-Policy": "same-origin",
    "Cross-Origin-Opener-Policy": "same-origin",
    "Cache-Control": "no-cache",
}


class PageServer(ThreadingHTTPServer):
    """A server that listens from its creation on, and answers requests while `serve_forever` runs.

    Args:
        handler: class that answers a request.
        host: the address to listen on.
        port: 0 for any free port; None for the first free port of `USUAL_PORTS`, so that links stay valid.

    Raises:
        InputError: the port is not free, or the machine does not have this address.
    """

    daemon_threads = True
    request_queue_size = 64
    allow_reuse_address = os.name == "posix"  # on Windows, two servers could share a port

    def __init__(self, handler: "type[PageHandler]", *, host: str = LOOPBACK, port: int | None = 0) -> None:
        self.host = host
        *taken, last = USUAL_PORTS if port is None else (port,)
        for usual in taken:
            with contextlib.suppress(OSError):  # the next port is tried, and the last error is reported
                super().__init__((host, usual), handler)
                return
        try:
            super().__init__((host, last), handler)
        except (OSError, OverflowError) as error:
            problem = f"The address {host}:{last} is not free ({error}). Choose another --port or --host."
            raise InputError(problem) from error

    @property
    def url(self) -> str:
        """Address of the page, with the host and the port of this server."""
        host = LOOPBACK if _is_wildcard(self.host) else self.host
        return f"http://{host}:{self.server_port}/"

    def handle_error(self, request: Any, client_address: Any) -> None:
        """Print an error, unless the page was closed before it got its answer."""
        if not isinstance(sys.exception(), ConnectionError):
            super().handle_error(request, client_address)

    def knows(self, host: str) -> bool:
        """Return whether a Host header names this server. Another name may mean an attack (DNS rebinding)."""
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


class PageHandler(BaseHTTPRequestHandler):
    """Answers the requests of pages with a resource or an error."""

    server: PageServer
    protocol_version = "HTTP/1.1"
    server_version = "foundry"
    sys_version = ""
    timeout = 60
    wbufsize = -1  # head and body in one packet; each of two packets would wait for the browser's confirmation
    disable_nagle_algorithm = True

    def log_message(self, format: str, *args: object) -> None:
        """Print no line per request, because the command prints its own output."""

    def is_known(self) -> bool:
        """Return whether the request uses a name of this server; if not, answer it with an error."""
        if known := self.server.knows(self.headers.get("Host", "")):
            return known
        self.send_problem(HTTPStatus.FORBIDDEN, f"This server answers only requests to {self.server.url}.")
        return False

    def body(self, longest: int) -> bytes:
        """Return the body of the request, or raise InputError if its length is unknown or too large."""
        length = whole_number(self.headers.get("Content-Length", ""))
        if length is None or length > longest:
            self.close_connection = True
            raise InputError(f"A request must state its length, which may be at most {longest:,} bytes.")
        return self.rfile.read(length)

    def answering(self, answer: Callable[[], None], status_of_input: HTTPStatus) -> None:
        """Send the answer, or an error in one line; the terminal shows no traceback.

        Args:
            answer: a function that sends the answer.
            status_of_input: status of the error if the request is invalid.
        """
        try:
            answer()
        except ConnectionError:
            raise
        except InputError as error:
            self._end_with(status_of_input, str(error))
        except RecordError as error:
            self._end_with(HTTPStatus.CONFLICT, str(error))
        except Exception as error:  # noqa: BLE001 - the boundary: a page must get an answer
            message = f"The server failed to answer ({type(error).__name__}: {error})."
            self._end_with(HTTPStatus.INTERNAL_SERVER_ERROR, one_line(message))

    def _end_with(self, status: HTTPStatus, message: str) -> None:
        """Send an error and close the connection, on which a part of the request may be unread."""
        self.close_connection = True
        self.send_problem(status, message)

    @property
    def is_own_page(self) -> bool:
        """Return whether the request comes from a page of this server."""
        return self.headers.get("Origin", "") == f"http://{self.headers['Host']}"

    def send_file(self, file: Path | None, asked: str, policy: str) -> None:
        """Send a file, or raise InputError if there is none."""
        if file is None:
            raise InputError(f"There is nothing at '{asked}'.")
        self.send(HTTPStatus.OK, Resource(file.read_bytes(), MEDIA_TYPES[file.suffix]), policy)

    def send_problem(self, status: HTTPStatus, message: str) -> None:
        """Send an error."""
        self.send(status, Resource(msgspec.json.encode({"error": message}), JSON))

    def send(self, status: HTTPStatus, resource: Resource, policy: str = POLICY) -> None:
        """Send an answer."""
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


def whole_number(text: str) -> int | None:
    """Return a text as a whole number; None if it is no whole number, or has too many digits."""
    return int(text) if text.isdecimal() and len(text) <= MOST_DIGITS else None


def is_loopback(host: str) -> bool:
    """Return whether an address is reachable only from this machine."""
    return host == "localhost" or (_is_address(host) and ipaddress.ip_address(host).is_loopback)


def open_in_browser(url: str) -> bool:
    """Open the page in a browser if there is a display; without a display, a text browser would block the terminal."""
    has_display = not sys.platform.startswith("linux") or any(
        os.environ.get(name) for name in ("DISPLAY", "WAYLAND_DISPLAY")
    )
    return has_display and webbrowser.open(url)


S = TypeVar("S", bound=PageServer)


@contextmanager
def running(server: S) -> Iterator[S]:
    """Run a server in a thread while the block of `with` runs."""
    thread = threading.Thread(target=server.serve_forever, kwargs={"poll_interval": 0.05}, daemon=True)
    thread.start()
    try:
        yield server
    finally:
        server.shutdown()
        server.server_close()
        thread.join()
