"""Searches everything that was asked, answered, remembered and said in the runs of a sweep, and noted of them."""

from __future__ import annotations

import re
import sqlite3
import threading
import zlib
from collections.abc import Collection, Iterator
from contextlib import closing
from dataclasses import dataclass
from typing import Any

import msgspec

from foundry.errors import InputError, RecordError
from foundry.storing.matching import place_of
from foundry.storing.notes import notes_of
from foundry.storing.standing import text_of, unread_by_place
from foundry.storing.store import RunFolder, SweepFolder

EVERY = "every"
UNREADABLE = "unreadable"
"""Replies that could not be read; where there is no reply, why."""
KINDS = ("prompt", "reply", "reasoning", "memory", "message", UNREADABLE)
"""What is indexed, and can be searched alone; an unreadable reply is a reply too."""
NOTE = "note"
"""What people noted; it is searched as it stands, for it changes."""
MOST = 50
"""Hits that are shown of a search."""
_COUNTED = 1000
_OF_STEP = {"message": "message", "memory": "memory", "reasoning": "reasoning", "message_reasoning": "reasoning"}
_BEFORE, _AFTER = 60, 140
_UNSPACED = re.compile(r"([\u3040-\u30ff\u3400-\u9fff\uf900-\ufaff])")
"""Signs of scripts without spaces, each of which is a word of its own in the index."""
_TOKENS = 'tokenize="unicode61 remove_diacritics 2"'
_SCHEMA = f"""
CREATE TABLE IF NOT EXISTS runs (id INTEGER PRIMARY KEY, run TEXT UNIQUE, beginning TEXT);
CREATE TABLE IF NOT EXISTS moments
  (id INTEGER PRIMARY KEY, run INTEGER, step INTEGER, agent INTEGER, kind INTEGER, said BLOB);
CREATE VIRTUAL TABLE IF NOT EXISTS words USING fts5(text, content='', {_TOKENS});
"""
_Moment = tuple[int, int, str, str]
_Hit = list[Any]


@dataclass(frozen=True)
class Query:
    """What is searched.

    Attributes:
        kind: one of KINDS, "note", or "every".
        words: words; `fire*` begins with fire, and what stands in double quotes follows one another. Unreadable replies
            are all found where there is no word.
        runs: ids of the only runs that are searched; None for all.
    """

    kind: str = EVERY
    words: str = ""
    runs: Collection[str] | None = None


class TextSearch:
    """The texts of a sweep's runs that have ended, indexed when somebody first searches them.

    The index lies in the sweep's folder, can be deleted, and is taken up where it was left.

    Args:
        sweep: the sweep.
    """

    def __init__(self, sweep: SweepFolder) -> None:
        self.sweep = sweep
        self._indexed: set[str] = set()
        self._thread: threading.Thread | None = None
        self._stop = threading.Event()
        self._problem = ""
        self._unread: dict[str, str] = {}

    def close(self) -> None:
        """Stop indexing after the run that is being read."""
        self._stop.set()
        if self._thread is not None:
            self._thread.join()

    def find(self, query: Query) -> dict[str, Any]:
        """Return the moments whose text has all words: notes, then texts in the order of the runs as they were indexed.

        Raises:
            InputError: no such kind, no word, or no place for the index.
        """
        known = (EVERY, *KINDS, NOTE)
        if query.kind not in known:
            raise InputError(f"There are no texts of the kind '{query.kind}'. There are: {', '.join(known)}.")
        phrases = _phrases(query.words)
        if not phrases and (query.kind != UNREADABLE or query.words):
            raise InputError(f"'{query.words}' holds no word to search for.")
        noted = self._noted(query, phrases) if query.kind in (EVERY, NOTE) else []
        if query.kind == NOTE:
            return {"hits": noted[:MOST], "count": len(noted), "more": False, "indexed": 0, "runs": 0, "unread": []}
        due = self._begin()
        if self._problem:
            raise InputError(self._problem)
        try:
            found = self._found(query, phrases)
        except sqlite3.Error as error:
            raise InputError(f"'{self.sweep.search_file}' cannot be searched: {error}. It can be deleted.") from error
        indexed = len(self._indexed)
        return {
            **found,
            "hits": [*noted, *found["hits"]][:MOST],
            "count": len(noted) + found["count"],
            "indexed": indexed,
            "runs": indexed + due,
            "unread": list(self._unread.values()),
        }

    def _noted(self, query: Query, phrases: str) -> list[_Hit]:
        """Return the notes that have all words, in their text, their tags or who wrote them."""
        notes = [note for note in notes_of(self.sweep.path).notes if query.runs is None or note.run in query.runs]
        texts = [" ".join([note.text, *note.tags, note.who]) for note in notes]
        with closing(sqlite3.connect(":memory:")) as connection:
            connection.execute(f"CREATE VIRTUAL TABLE words USING fts5(text, {_TOKENS})")
            connection.executemany("INSERT INTO words (text) VALUES (?)", [(_spaced(text),) for text in texts])
            rows = connection.execute("SELECT rowid FROM words WHERE words MATCH ? ORDER BY rowid", (phrases,))
            places = [row - 1 for (row,) in rows]
        return [
            [note.run, note.step, note.agent, NOTE, _part(texts[at], query.words), note.moment]
            for at, note in ((at, notes[at]) for at in places)
        ]

    def _open(self) -> sqlite3.Connection:
        file = self.sweep.search_file
        try:
            file.parent.mkdir(exist_ok=True)
            connection = sqlite3.connect(file, timeout=60, isolation_level=None)
            connection.executescript(f"PRAGMA journal_mode=WAL; PRAGMA synchronous=OFF; {_SCHEMA}")
        except (OSError, sqlite3.Error) as error:
            raise InputError(f"The texts cannot be indexed in '{file}': {error}.") from error
        return connection

    def _begin(self) -> int:
        """Index on in a thread; returns how many runs are still to come."""
        places = [place for place, run in enumerate(self.sweep.sweep.runs) if run.id not in self._indexed]
        due = [run for run in self.sweep.runs_of(places) if run.ended]
        if due and (self._thread is None or not self._thread.is_alive()):
            self._problem = ""
            with closing(self._open()) as connection:
                known = {run: beginning for run, beginning in connection.execute("SELECT run, beginning FROM runs")}
            self._indexed |= {run.id for run in due if known.get(run.id) == run.beginning}
            due = [run for run in due if run.id not in self._indexed]
            if due:
                self._thread = threading.Thread(target=self._index, args=(due,), daemon=True)
                self._thread.start()
        return len(due)

    def _index(self, due: list[RunFolder]) -> None:
        try:
            with closing(self._open()) as connection:
                for run in due:
                    if self._stop.is_set():
                        return
                    try:
                        _add(connection, run)
                    except RecordError as error:
                        connection.execute("ROLLBACK")
                        self._unread[run.id] = str(error)
                    self._indexed.add(run.id)
        except (InputError, sqlite3.Error) as error:
            self._problem = f"The texts could not be indexed: {error}"

    def _found(self, query: Query, phrases: str) -> dict[str, Any]:
        kinds = {EVERY: KINDS, "reply": ("reply", UNREADABLE)}.get(query.kind, (query.kind,))
        conditions = ["kind IN (SELECT value FROM json_each(:kinds))"]
        conditions += ["words MATCH :phrases"] * bool(phrases)
        conditions += ["runs.run IN (SELECT value FROM json_each(:runs))"] * (query.runs is not None)
        texts, order = (
            ("words JOIN moments ON moments.id = words.rowid", "words.rowid") if phrases else ("moments", "moments.id")
        )
        found = f"FROM {texts} JOIN runs ON runs.id = moments.run WHERE {' AND '.join(conditions)}"
        values = {
            "kinds": _json([KINDS.index(kind) for kind in kinds]),
            "phrases": phrases,
            "runs": _json(list(query.runs or ())),
        }
        with closing(self._open()) as connection:
            rows = connection.execute(
                f"SELECT runs.run, step, agent, kind, said {found} ORDER BY {order} LIMIT {MOST}", values
            ).fetchall()
            (count,) = connection.execute(
                f"SELECT count(*) FROM (SELECT 1 {found} LIMIT {_COUNTED + 1})", values
            ).fetchone()
        hits = [
            [run, step, agent, KINDS[of], _part(zlib.decompress(said).decode(), query.words)]
            for run, step, agent, of, said in rows
        ]
        return {"hits": hits, "count": min(count, _COUNTED), "more": count > _COUNTED}


def _add(connection: sqlite3.Connection, run: RunFolder) -> None:
    """Add the texts of a run in one transaction, unless another process has by now; those of an earlier try go."""
    connection.execute("BEGIN IMMEDIATE")
    known = connection.execute("SELECT id, beginning FROM runs WHERE run = ?", (run.id,)).fetchone()
    if known is None or known[1] != run.beginning:
        if known is not None:
            connection.execute("DELETE FROM moments WHERE run = ?", (known[0],))
            connection.execute("DELETE FROM runs WHERE id = ?", (known[0],))
        (last,) = connection.execute("SELECT max(rowid) FROM words").fetchone()
        place = connection.execute("INSERT INTO runs (run, beginning) VALUES (?, ?)", (run.id, run.beginning)).lastrowid
        for number, (step, agent, kind, text) in enumerate(_texts(run), (last or 0) + 1):
            content = zlib.compress(text.encode(errors="replace"), 1)
            connection.execute(
                "INSERT INTO moments VALUES (?, ?, ?, ?, ?, ?)",
                (number, place, step, agent, KINDS.index(kind), content),
            )
            connection.execute("INSERT INTO words (rowid, text) VALUES (?, ?)", (number, _spaced(text)))
    connection.execute("COMMIT")


def _texts(run: RunFolder) -> Iterator[_Moment]:
    """Yield step, agent, kind and text of everything that a run's records say in words."""
    for line in run.steps_bytes().splitlines():
        record = _step_of(line, run)
        for key, kind in _OF_STEP.items():
            if isinstance(text := record.get(key), str) and text.strip():
                yield record["step"], record["agent"], kind, text
    unread = unread_by_place(run)
    for call in run.calls():
        said = {"prompt": "\n".join(_contents(call.messages)), "reasoning": call.thinking or ""}
        is_unread = unread.get(place_of(call), [False]).pop(0)
        said |= {UNREADABLE: text_of(call)} if is_unread else {"reply": call.text}
        yield from ((call.step, call.agent, kind, text) for kind, text in said.items() if text.strip())


def _step_of(line: bytes, run: RunFolder) -> dict[str, Any]:
    try:
        return msgspec.json.decode(line, type=dict[str, Any])
    except (msgspec.DecodeError, UnicodeDecodeError) as error:
        raise RecordError(f"{run.stream_path('steps')} cannot be read: {error}") from error


def _contents(messages: list[dict[str, Any]]) -> Iterator[str]:
    """Yield the texts of a prompt; images have none."""
    for message in messages:
        content = message.get("content")
        if isinstance(content, str):
            yield content
        elif isinstance(content, list):
            yield from (str(part["text"]) for part in content if "text" in part)


def _spaced(text: str) -> str:
    return _UNSPACED.sub(r" \1 ", text)


def _json(values: list[Any]) -> str:
    return msgspec.json.encode(values).decode()


def _phrases(words: str) -> str:
    """Return words as FTS5 asks for them: all of them, each a phrase of its own, so that no sign has a meaning."""
    parts = re.findall(r'"([^"]*)"|([^\s"]+)', words.replace("\0", " "))
    asked = [(phrase or word.rstrip("*"), word.endswith("*")) for phrase, word in parts]
    return " ".join(f'"{_spaced(text)}"{"*" if start else ""}' for text, start in asked if re.search(r"\w", text))


def _part(text: str, words: str) -> str:
    """Return the part of a text around the first of the words, as far as it is found as it was typed."""
    first = re.search(r"\w+", words)
    at = max(0, text.casefold().find(first[0].casefold())) if first else 0
    start, end = max(0, at - _BEFORE), at + _AFTER
    return f"{'…' if start else ''}{text[start:end]}{'…' if end < len(text) else ''}"
