"""Notes through the server: who may write, what is refused, and what takes them along."""

import base64
import gzip
import http.client
import json
from collections.abc import Iterator
from pathlib import Path
from typing import Any

import msgspec
import pytest

from commands import foundry
from foundry.storing.notes import notes_of
from foundry.storing.store import SweepFolder
from foundry.trust.bundling import write_bundle
from foundry.trust.unbundling import unpack_bundle
from foundry.viewer.search import Query, TextSearch
from foundry.viewer.server import ViewServer, serving
from made_up_runs import sweep, whole_run


@pytest.fixture
def made(tmp_path: Path) -> SweepFolder:
    found = sweep(tmp_path / "noted", models=("first",), seeds=(0, 1))
    whole_run(found.runs()[0])
    return found


@pytest.fixture
def served(made: SweepFolder) -> Iterator[ViewServer]:
    with serving(made.path) as running:
        yield running


@pytest.fixture(scope="module")
def unchanged(tmp_path_factory: pytest.TempPathFactory) -> Iterator[tuple[ViewServer, SweepFolder]]:
    """A server of a sweep of which no note is taken."""
    found = sweep(tmp_path_factory.mktemp("refused") / "noted", models=("first",), seeds=(0, 1))
    with serving(found.path) as running:
        yield running, found


def written(made: SweepFolder, **keys: Any) -> dict[str, Any]:
    given = {"who": "Ada", "run": made.runs()[0].id, "step": 3, "agent": 1, "text": "It turned back.", "tags": ["odd"]}
    return {**given, **keys}


def send(server: ViewServer, body: Any, sweep: str = "noted", **headers: str) -> tuple[int, Any]:
    """Send what the page sends, as the page does unless told otherwise."""
    connection = http.client.HTTPConnection("127.0.0.1", server.server_port)
    content = body if isinstance(body, bytes) else json.dumps(body).encode()
    given = {"Origin": server.url.rstrip("/"), "Content-Type": "application/json", **headers}
    try:
        connection.request("POST", f"/data/sweep/{sweep}/notes", content, given)
        response = connection.getresponse()
        return response.status, json.loads(response.read())
    finally:
        connection.close()


def test_a_note_is_written_changed_and_deleted(served: ViewServer, made: SweepFolder):
    status, found = send(served, written(made))
    assert status == 200
    (note,) = found["notes"]
    assert {key: note[key] for key in written(made)} == written(made) and note["when"].endswith("+00:00")
    _, found = send(served, written(made, note=note["note"], text="It came back.", tags=[]))
    assert [(one["text"], one["tags"], one["note"]) for one in found["notes"]] == [("It came back.", [], note["note"])]
    _, found = send(served, written(made, note=note["note"], text="", tags=[], deleted=True))
    assert found == {"notes": [], "unread": []}


@pytest.mark.parametrize(
    ("body", "said"),
    [
        ({"run": "elsewhere"}, "Run 'elsewhere' not found."),
        ({"note": "unknown"}, "Note 'unknown' not found."),
        ({"moment": 0}, "'noted' is not a probe: it has runs, but no moments."),
        ({"text": " ", "tags": []}, "The note is empty. Write a text or a tag."),
        ({"tags": ["two words"]}, "The note cannot be read: "),
        ({"step": -1}, "The note cannot be read: "),
        ({"text": "x" * 10_001}, "The note cannot be read: "),
        ({"text": "\ud800"}, "The note cannot be read: "),
        (b'{"who": ', "The note cannot be read: "),
        (b"[" * 10_000, "The note cannot be read: "),
        (b"x" * 70_000, "A request must state its length, which may be at most 65,536 bytes."),
    ],
)
def test_what_is_no_note_is_refused_in_one_line(unchanged: tuple[ViewServer, SweepFolder], body: Any, said: str):
    served, made = unchanged
    status, found = send(served, body if isinstance(body, bytes) else written(made, **body))
    assert status == 404 and found["error"].startswith(said) and "\n" not in found["error"]
    assert notes_of(made.path).notes == []


@pytest.mark.parametrize(
    "headers", [{"Origin": "http://evil.example"}, {"Origin": "null"}, {"Origin": ""}, {"Host": "evil.example"}]
)
def test_a_foreign_page_writes_nothing(unchanged: tuple[ViewServer, SweepFolder], headers: dict[str, str]):
    served, made = unchanged
    assert send(served, written(made), **headers)[0] == 403
    assert notes_of(made.path).notes == []


def test_who_looks_from_another_machine_writes_nothing(unchanged: tuple[ViewServer, SweepFolder]):
    _, made = unchanged
    with serving(made.path, host="0.0.0.0") as server:
        assert send(server, written(made))[0] == 403
    assert notes_of(made.path).notes == []


def test_a_search_finds_notes_beside_texts(served: ViewServer, made: SweepFolder):
    send(served, written(made, text="Der Rauch über dem Café"))
    search = TextSearch(made)
    hit = [made.runs()[0].id, 3, 1, "note", "Der Rauch über dem Café odd Ada", None]
    assert search.find(Query("note", "uber caf*"))["hits"] == [hit]
    assert search.find(Query("note", "rauch smoke"))["count"] == 0
    assert search.find(Query("every", "odd"))["hits"][0] == hit
    search.close()


def test_a_bundle_takes_notes_along_when_asked_without_what_was_edited_away(
    served: ViewServer, made: SweepFolder, tmp_path: Path
):
    _, found = send(served, written(made, text="a name that was taken out"))
    send(served, written(made, note=found["notes"][0]["note"], text="It turned back."))
    write_bundle(made.path, tmp_path / "without.tar.zst")
    write_bundle(made.path, tmp_path / "with.tar.zst", notes=True)
    for name in ("without", "with"):
        unpack_bundle(tmp_path / f"{name}.tar.zst", tmp_path / name)
    assert not (tmp_path / "without" / "notes.jsonl").exists()
    assert notes_of(tmp_path / "with") == notes_of(made.path)
    assert b"taken out" not in (tmp_path / "with" / "notes.jsonl").read_bytes()


def test_what_becomes_of_notes_is_told(served: ViewServer, made: SweepFolder, tmp_path: Path):
    send(served, written(made))
    for asked, said in (([], "Notes left out; add --notes to include them: 1."), (["--notes"], "Notes included: 1.")):
        done = foundry("view", str(made.path), "--export", f"page{len(asked)}", *asked, cwd=tmp_path)
        assert (done.returncode, done.stdout.splitlines()[-1]) == (0, said)
        notes = tmp_path / f"page{len(asked)}" / "data" / "sweep" / "noted" / "notes.js"
        packed = base64.b64decode(notes.read_text(encoding="ascii").split('"')[5])
        assert len(msgspec.json.decode(gzip.decompress(packed))["notes"]) == len(asked)
        done = foundry("bundle", str(made.path), f"noted{len(asked)}.tar.zst", *asked, cwd=tmp_path)
        assert (done.returncode, done.stdout.splitlines()[-1]) == (0, said)
