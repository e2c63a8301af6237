"""The server of the page: what it serves, to whom, and what its own files may hold."""

import gzip
import http.client
import json
import re
import socket
from collections.abc import Iterator
from pathlib import Path
from typing import Any

import pytest

from foundry.errors import InputError
from foundry.storing.store import SweepFolder
from foundry.viewer.files import POLICY, ROOMS, STATIC
from foundry.viewer.http import is_loopback
from foundry.viewer.people.private import PAGE
from foundry.viewer.server import ViewServer, serving
from made_up_runs import sweep, whole_run


def ask(server: ViewServer, path: str, method: str = "GET", **headers: str) -> tuple[http.client.HTTPResponse, bytes]:
    """Send a path exactly as it is."""
    connection = http.client.HTTPConnection("127.0.0.1", server.server_port)
    try:
        connection.putrequest(method, path, skip_host="Host" in headers, skip_accept_encoding=True)
        for name, value in headers.items():
            connection.putheader(name.replace("_", "-"), value)
        connection.endheaders()
        response = connection.getresponse()
        return response, response.read()
    finally:
        connection.close()


def answered(server: ViewServer, path: str) -> Any:
    response, content = ask(server, path)
    assert response.status == 200
    return json.loads(content)


def test_it_listens_on_this_machine_alone_and_the_page_forbids_foreign_and_inline_scripts(server: ViewServer):
    assert server.server_address[0] == "127.0.0.1"
    assert [is_loopback(host) for host in ("127.0.0.1", "localhost", "::1", "0.0.0.0", "example.org")] == [True] * 3 + [
        False
    ] * 2
    response, content = ask(server, "/")
    policy = response.getheader("Content-Security-Policy") or ""
    assert "default-src 'none'; script-src 'self'; style-src 'self'" in policy
    assert "unsafe" not in policy
    assert b"<script src=" in content
    assert response.getheader("X-Content-Type-Options") == "nosniff"
    response, _ = ask(server, "/files/made-up/report.html")
    assert response.status == 200
    assert (response.getheader("Content-Security-Policy") or "").startswith("sandbox ")


@pytest.fixture(scope="module")
def beside_a_secret(tmp_path_factory: pytest.TempPathFactory) -> Iterator[ViewServer]:
    folder = tmp_path_factory.mktemp("secret")
    made = sweep(folder / "made up")
    (folder / "secret.html").write_text("secret", encoding="utf-8")
    with serving(made.path) as server:
        (made.path / "linked.html").symlink_to(folder / "secret.html")  # before, it would not even be opened
        yield server


@pytest.mark.parametrize(
    "path",
    [
        "/files/made-up/../../etc/passwd", "/files/made-up/..%2f..%2fsecret.html", "/files/made-up/%2e%2e/secret.html",
        "/files/made-up/%252e%252e/secret.html", "/files/made-up/..\\secret.html", "/files/made-up/..%5csecret.html",
        "/files/made-up//etc/passwd", "/files/made-up/runs/%00.html", "/files/../secret.html", "/files/made-up/",
        "/../secret.html", "/%2e%2e/server.py", "//etc/passwd", "/data/../secret.html", "/files/made-up/linked.html",
        "/files/made-up/sweep.yaml", "/vendor/../../server.py", "/source_http.py", "/files",
    ],
)  # fmt: skip
def test_nothing_outside_the_sweep_is_served(beside_a_secret: ViewServer, path: str):
    response, content = ask(beside_a_secret, path)
    assert response.status == 404
    assert set(json.loads(content)) == {"error"}


FOREIGN = ("evil.example", "evil.example:{port}", "127.0.0.1", "127.0.0.1:1", "", "localhost.evil.example:{port}")
OWN_NAMES = ("127.0.0.1:{port}", "localhost:{port}", "LOCALHOST:{port}", "[::1]:{port}")


@pytest.mark.parametrize("host", [*FOREIGN, *OWN_NAMES])
def test_its_own_names_are_answered_and_foreign_ones_refused(server: ViewServer, host: str):
    response, content = ask(server, "/data/sweeps", Host=host.format(port=server.server_port))
    assert (response.status, b"made" in content) == ((200, True) if host in OWN_NAMES else (403, False))


@pytest.mark.parametrize("method", ["POST", "PUT", "DELETE", "PATCH", "OPTIONS"])
def test_the_records_can_only_be_read(server: ViewServer, method: str):
    response, _ = ask(server, "/data/sweeps", method)
    assert response.status == 405
    assert response.getheader("Allow") == "GET, HEAD"


def test_head_sends_no_body_which_the_next_answer_would_begin_with(server: ViewServer):
    response, content = ask(server, "/data/sweeps", "HEAD")
    assert response.status == 200
    assert int(response.getheader("Content-Length") or 0) > 0
    assert content == b""
    host = f"Host: 127.0.0.1:{server.server_port}"
    asked = f"HEAD / HTTP/1.1\r\n{host}\r\n\r\nGET / HTTP/1.1\r\n{host}\r\nConnection: close\r\n\r\n"
    with socket.create_connection(("127.0.0.1", server.server_port)) as connection:
        connection.sendall(asked.encode())
        received = b"".join(iter(lambda: connection.recv(1 << 16), b""))
    head, _, rest = received.partition(b"\r\n\r\n")
    assert b"Content-Length" in head and rest.startswith(b"HTTP/1.1 200 OK\r\n")


def test_long_answers_are_compressed_for_those_who_can_read_that(server: ViewServer, made_up: SweepFolder):
    path = f"/data/run/made-up/{made_up.runs()[0].id}/decisions/0/0"
    plain, packed = ask(server, path), ask(server, path, Accept_Encoding="gzip")
    assert packed[0].getheader("Content-Encoding") == "gzip"
    assert gzip.decompress(packed[1]) == plain[1]
    assert len(packed[1]) < len(plain[1]) / 2


def test_damaged_records_are_said_to_be_so(tmp_path: Path):
    made = sweep(tmp_path / "damaged")
    folder = made.runs()[0]
    whole_run(folder)
    folder.stream_path("steps").write_bytes(folder.steps_bytes().replace(b'"action":"move"', b'"action":7'))
    with serving(made.path) as server:
        response, content = ask(server, f"/data/run/damaged/{folder.id}/frames/0")
    assert response.status == 409
    assert b"cannot be read" in content


def test_a_new_sweep_is_seen_without_a_restart(tmp_path: Path):
    sweep(tmp_path / "one")
    with serving(tmp_path) as server:
        sweep(tmp_path / "two")
        assert {one["name"] for one in answered(server, "/data/sweeps")["sweeps"]} == {"one", "two"}


@pytest.mark.parametrize(
    "path", ["search/every/a%00b", "search/{%22words%22:%22a%5Cu0000b%22}", "search/{%22kind%22:1}"]
)
def test_an_address_that_nobody_can_read_is_answered_in_one_line(
    path: str, made_up: SweepFolder, server: ViewServer, capfd: pytest.CaptureFixture[str]
):
    response, content = ask(server, f"/data/sweep/made-up/{path}")
    assert response.status in (200, 404), content
    assert b"\n" not in content and capfd.readouterr().err == ""


def test_an_error_of_its_own_is_an_answer_and_no_traceback(
    server: ViewServer, capfd: pytest.CaptureFixture[str], monkeypatch: pytest.MonkeyPatch
):
    monkeypatch.setattr(server, "resources", None)
    response, content = ask(server, "/data/sweeps")
    assert response.status == 500 and b"The server failed to answer (AttributeError: " in content
    assert capfd.readouterr().err == ""


def test_a_length_that_is_no_number_of_bytes_is_refused(server: ViewServer):
    own = {"Origin": f"http://127.0.0.1:{server.server_port}", "Content_Length": "9" * 5_000}
    response, content = ask(server, "/data/sweep/made-up/notes", "POST", **own)
    assert response.status == 404 and b"must state its length" in content


def test_a_port_that_is_taken_is_said_in_one_line(made_up: SweepFolder):
    with socket.socket() as taken:
        taken.bind(("127.0.0.1", 0))
        taken.listen()
        with pytest.raises(InputError, match="Choose another --port"):
            ViewServer(made_up.path, port=taken.getsockname()[1])


OWN = sorted(
    path
    for folder in (STATIC, *ROOMS.values(), PAGE)
    for path in folder.rglob("*.*")
    if path.suffix in (".js", ".css", ".html") and path.parent.name != "vendor"
)
MARKUP = re.compile(
    r"innerHTML|outerHTML|insertAdjacentHTML|document\.write|\beval\(|new Function|setAttribute\(\"(style|on)|srcdoc|"
    r"createContextualFragment|DOMParser"
)


@pytest.mark.parametrize("path", OWN, ids=lambda path: path.relative_to(STATIC.parent).as_posix())
def test_no_text_can_become_markup_or_code_nothing_is_fetched_from_anywhere_and_no_file_is_long(path: Path):
    text = path.read_text(encoding="utf-8")
    assert MARKUP.findall(text) == []
    assert [url for url in re.findall(r"https?://[^\s\"')]+", text) if "www.w3.org" not in url] == []
    assert len(text.splitlines()) <= 500


@pytest.mark.parametrize("folder", [STATIC, PAGE], ids=["view", "play"])
def test_the_page_repeats_the_policy_of_the_server(folder: Path):
    page = (folder / "index.html").read_text(encoding="utf-8")
    assert f'<meta http-equiv="Content-Security-Policy" content="{POLICY}">' in page
    assert re.findall(r"<script(?! src=)|<style|\son\w+=", page) == []
