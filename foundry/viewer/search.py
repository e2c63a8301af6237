"""Searches all prompts, replies, memories, messages and notes of a sweep's runs."""

import re
import sqlite3
import threading
import zlib
from collections import Counter
from collections.abc import Collection, Iterator
from contextlib import closing
from typing import Annotated, Any

import msgspec

from foundry.errors import InputError, RecordError
from foundry.records import Outcome
from foundry.storing.matching import place_of
from foundry.storing.notes import Note, notes_of
from foundry.storing.standing import is_unread, outcomes_by_place, text_of
from foundry.storing.store import RunFolder, SweepFolder

EVERY = "every"
UNREADABLE = "unreadable"
"""Kind of searched text: unreadable replies. If a call failed, its text is the reason for the failure."""
KINDS = ("prompt", "reply", "reasoning", "memory", "message", UNREADABLE)
"""The kinds of indexed texts; an unreadable reply also counts as a reply."""
NOTE = "note"
"""Kind of searched text: notes that people write. Notes are not in the index, because people may change them."""
MOST = 50
"""Maximum number of results that the server sends at once."""
SPEAKERS = 10
"""Maximum number of agents in the list of agents with the most results."""
_OF_STEP = {"message": "message", "memory": "memory", "reasoning": "reasoning", "message_reasoning": "reasoning"}
_BEFORE, _AFTER = 60, 140
_UNSPACED = re.compile(r"([\u3040-\u30ff\u3400-\u9fff\uf900-\ufaff])")
"""Characters of Japanese and Chinese, which have no spaces between words; each character is a word in the index."""
_TOKENS = 'tokenize="unicode61 remove_diacritics 2"'
_SCHEMA = f"""
CREATE TABLE IF NOT EXISTS runs (id INTEGER PRIMARY KEY, run TEXT UNIQUE, beginning TEXT);
CREATE TABLE IF NOT EXISTS moments
  (id INTEGER PRIMARY KEY, run INTEGER, step INTEGER, agent INTEGER, kind INTEGER, outcome INTEGER, said BLOB);
CREATE INDEX IF NOT EXISTS places ON moments (kind, run, agent, step, outcome);
CREATE VIRTUAL TABLE IF NOT EXISTS words USING fts5(text, content='', {_TOKENS});
"""
_OUTCOMES = [str(outcome) for outcome in Outcome]
_Moment = tuple[int, int, str, str, str]
_Hit = list[Any]


class Query(msgspec.Struct, frozen=True, forbid_unknown_fields=True):
    """A search request, which finds the texts that fit all its fields. A request without words must use another field.

    Attributes:
        kind: one of KINDS, "note", or "every".
        words: all of them must occur; `fire*` matches beginnings of words, and double quotes mark a phrase.
        runs: mask of the runs to search, as `CatalogedSweep.runs_of_mask` reads it; "" for all runs.
        outcome: outcome of the decision; "" for any.
        agent: id of the agent; None for any.
        first: the first step; None for the beginning.
        last: the last step; None for the end.
        skip: number of results to leave out, because the page already has them.
    """

    kind: str = EVERY
    words: str = ""
    runs: str = ""
    outcome: str = ""
    agent: int | None = None
    first: int | None = None
    last: int | None = None
    skip: Annotated[int, msgspec.Meta(ge=0)] = 0

    @property
    def narrows(self) -> bool:
        """Whether fields other than `words`, such as `agent`, exclude some texts."""
        return self.kind != EVERY or bool(self.outcome) or (self.agent, self.first, self.last) != (None, None, None)


class TextSearch:
    """The texts of a sweep's ended runs. The first search makes an index of all texts.

    The index is a file in the sweep's folder. You can delete the index. After an interruption, indexing continues.
    """

    def __init__(self, sweep: SweepFolder) -> None:
        self.sweep = sweep
        self._indexed: set[str] = set()
        self._thread: threading.Thread | None = None
        self._stop = threading.Event()
        self._problem = ""
        self._unread: dict[str, str] = {}

    def close(self) -> None:
        """Stop indexing after the current run."""
        self._stop.set()
        if self._thread is not None:
            self._thread.join()

    def find(self, query: Query, runs: Collection[str] | None = None) -> dict[str, Any]:
        """Return the texts that contain all words, with their moments: first notes, then other texts.

        Args:
            query: the request.
            runs: ids of the runs to search; None for all.

        Raises:
            InputError: the request has no word and no condition, or the index cannot be used.
        """
        known = (EVERY, *KINDS, NOTE)
        if query.kind not in known:
            raise InputError(f"Texts of kind '{query.kind}' do not exist. Available: {', '.join(known)}.")
        phrases = _phrases(query.words)
        if query.outcome and query.outcome not in _OUTCOMES:
            raise InputError(f"Outcome '{query.outcome}' does not exist. Available: {', '.join(_OUTCOMES)}.")
        if not phrases and (query.words or not query.narrows):
            raise InputError(f"'{query.words}' contains no word to search for. Give a word, or another condition.")
        noted = self._noted(query, phrases, runs) if query.kind in (EVERY, NOTE) else []
        if query.kind == NOTE:
            result = {"hits": noted[query.skip : query.skip + MOST], "count": len(noted), "agents": []}
            return {**result, "in_runs": Counter(hit[0] for hit in noted), "indexed": 0, "runs": 0, "unread": []}
        due = self._begin()
        if self._problem:
            raise InputError(self._problem)
        try:
            result = self._found(query, phrases, noted, runs)
        except sqlite3.Error as error:
            raise InputError(f"The index '{self.sweep.search_file}' is damaged ({error}). Delete it.") from error
        indexed = len(self._indexed)
        return {**result, "indexed": indexed, "runs": indexed + due, "unread": list(self._unread.values())}

    def _noted(self, query: Query, phrases: str, runs: Collection[str] | None) -> list[_Hit]:
        """Return the notes in whose text, tags and author all searched words occur."""
        notes = notes_of(self.sweep.path).notes
        notes = [note for note in notes if (runs is None or note.run in runs) and _is_asked(note, query)]
        texts = [" ".join([note.text, *note.tags, note.who]) for note in notes]
        with closing(sqlite3.connect(":memory:")) as connection:
            connection.execute(f"CREATE VIRTUAL TABLE words USING fts5(text, {_TOKENS})")
            connection.executemany("INSERT INTO words (text) VALUES (?)", [(_spaced(text),) for text in texts])
            meant, values = (" WHERE words MATCH ?", [phrases]) if phrases else ("", [])
            rows = connection.execute(f"SELECT rowid FROM words{meant} ORDER BY rowid", values)
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
            raise InputError(f"The index '{file}' of the texts cannot be written: {error}.") from error
        return connection

    def _begin(self) -> int:
        """Index the remaining runs in a thread; return their number."""
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
            self._problem = f"The texts cannot be indexed: {error}"

    def _found(self, query: Query, phrases: str, noted: list[_Hit], runs: Collection[str] | None) -> dict[str, Any]:
        """Return the results (first notes, then other texts), and their numbers: of all, per run, and per agent."""
        conditions, values = _conditions(query, phrases, runs)
        texts, order = (
            ("words JOIN moments ON moments.id = words.rowid", "words.rowid") if phrases else ("moments", "moments.id")
        )
        source = f"FROM {texts} JOIN runs ON runs.id = moments.run WHERE {' AND '.join(conditions)}"
        skip, notes = max(0, query.skip - len(noted)), noted[query.skip : query.skip + MOST]
        with closing(self._open()) as connection:
            part = f"ORDER BY {order} LIMIT {MOST - len(notes)} OFFSET {skip}"
            rows = connection.execute(f"SELECT runs.run, step, agent, kind, said {source} {part}", values).fetchall()
            counted = connection.execute(f"SELECT runs.run, agent, count(*) {source} GROUP BY 1, 2", values).fetchall()
        hits = [
            [run, step, agent, KINDS[of], _part(zlib.decompress(said).decode(), query.words)]
            for run, step, agent, of, said in rows
        ]
        in_runs, by_agent = Counter(hit[0] for hit in noted), Counter[int]()
        for run, agent, count in counted:
            in_runs[run] += count
            by_agent[agent] += count
        agents = by_agent.most_common(SPEAKERS)
        return {"hits": [*notes, *hits], "count": in_runs.total(), "in_runs": in_runs, "agents": agents}


def _conditions(query: Query, phrases: str, runs: Collection[str] | None) -> tuple[list[str], dict[str, Any]]:
    """Return the filters of a search for texts as SQL, and the values of their parameters."""
    kinds = {EVERY: KINDS, "reply": ("reply", UNREADABLE)}.get(query.kind, (query.kind,))
    optional = {
        "words MATCH :phrases": phrases or None,
        "runs.run IN (SELECT value FROM json_each(:runs))": None if runs is None else _json(list(runs)),
        "outcome = :outcome": _OUTCOMES.index(query.outcome) if query.outcome else None,
        "agent = :agent": query.agent,
        "step >= :first": query.first,
        "step <= :last": query.last,
    }
    asked = {condition: value for condition, value in optional.items() if value is not None}
    values = {re.findall(r":(\w+)", condition)[0]: value for condition, value in asked.items()}
    kinds_asked = "kind IN (SELECT value FROM json_each(:kinds))"
    return [kinds_asked, *asked], {"kinds": _json([KINDS.index(kind) for kind in kinds]), **values}


def _is_asked(note: Note, query: Query) -> bool:
    """Return whether a note fits a search for an outcome, agent and steps; no note has an outcome."""
    first, last = query.first or 0, query.last
    return (
        not query.outcome
        and (query.agent is None or note.agent == query.agent)
        and (note.step or 0) >= first
        and (last is None or (note.step is not None and note.step <= last))
    )


def _add(connection: sqlite3.Connection, run: RunFolder) -> None:
    """Add the texts of a run to the index, unless another process did so. A restarted run's old texts are replaced."""
    connection.execute("BEGIN IMMEDIATE")
    known = connection.execute("SELECT id, beginning FROM runs WHERE run = ?", (run.id,)).fetchone()
    if known is None or known[1] != run.beginning:
        if known is not None:
            connection.execute("DELETE FROM moments WHERE run = ?", (known[0],))
            connection.execute("DELETE FROM runs WHERE id = ?", (known[0],))
        (last,) = connection.execute("SELECT max(rowid) FROM words").fetchone()
        place = connection.execute("INSERT INTO runs (run, beginning) VALUES (?, ?)", (run.id, run.beginning)).lastrowid
        for number, (step, agent, kind, outcome, text) in enumerate(_texts(run), (last or 0) + 1):
            content = zlib.compress(text.encode(errors="replace"), 1)
            connection.execute(
                "INSERT INTO moments VALUES (?, ?, ?, ?, ?, ?, ?)",
                (number, place, step, agent, KINDS.index(kind), _OUTCOMES.index(outcome), content),
            )
            connection.execute("INSERT INTO words (rowid, text) VALUES (?, ?)", (number, _spaced(text)))
    connection.execute("COMMIT")


def _texts(run: RunFolder) -> Iterator[_Moment]:
    """Yield step, agent, kind, outcome and text of all texts in a run's records."""
    for line in run.steps_bytes().splitlines():
        record = _step_of(line, run)
        for key, kind in _OF_STEP.items():
            if isinstance(text := record.get(key), str) and text.strip():
                yield record["step"], record["agent"], kind, _outcome_of(record, key), text
    outcomes = outcomes_by_place(run)
    for call in run.calls():
        said = {"prompt": "\n".join(_contents(call.messages)), "reasoning": call.thinking or ""}
        outcome = outcomes.get(place_of(call), [Outcome.CHOSEN]).pop(0)
        said |= {UNREADABLE: text_of(call)} if is_unread(outcome) else {"reply": call.text}
        yield from ((call.step, call.agent, kind, outcome, text) for kind, text in said.items() if text.strip())


def _outcome_of(record: dict[str, Any], key: str) -> str:
    """Return the outcome of a reply, given a record and the key under which it contains a text of this reply."""
    names = ("message_outcome", "outcome") if key.startswith("message") else ("outcome",)
    known = (record[name] for name in names if record.get(name) in _OUTCOMES)
    return str(next(known, Outcome.CHOSEN))


def _step_of(line: bytes, run: RunFolder) -> dict[str, Any]:
    try:
        return msgspec.json.decode(line, type=dict[str, Any])
    except (msgspec.DecodeError, UnicodeDecodeError) as error:
        raise RecordError(f"{run.stream_path('steps')} cannot be read: {error}") from error


def _contents(messages: list[dict[str, Any]]) -> Iterator[str]:
    """Yield the texts of a prompt, without images."""
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
    """Return words in the syntax of FTS5. Each word becomes a quoted phrase, in which no character is special."""
    parts = re.findall(r'"([^"]*)"|([^\s"]+)', words.replace("\0", " "))
    asked = [(phrase or word.rstrip("*"), word.endswith("*")) for phrase, word in parts]
    return " ".join(f'"{_spaced(text)}"{"*" if start else ""}' for text, start in asked if re.search(r"\w", text))


def _part(text: str, words: str) -> str:
    """Return the part of a text around the first searched word; the beginning if this word is not in the text."""
    first = re.search(r"\w+", words)
    at = max(0, text.casefold().find(first[0].casefold())) if first else 0
    start, end = max(0, at - _BEFORE), at + _AFTER
    return f"{'…' if start else ''}{text[start:end]}{'…' if end < len(text) else ''}"
