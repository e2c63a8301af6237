"""A model without a server: it gives the answers that another sweep recorded."""

import hashlib
from collections.abc import Iterable, Mapping, Sequence
from functools import lru_cache
from pathlib import Path
from typing import Any

import msgspec

from foundry.errors import InputError, RequestError, not_found
from foundry.models.base import Model, Reply, Request, RunContext, Source, logged
from foundry.records import Call
from foundry.storing.store import RunFolder, SweepFolder

_KEPT_SEEDS = 8
"""Maximum number of seeds whose answers stay in memory."""


def reply_of(call: Call) -> Reply:
    """Return the reply of a logged call; the reply says that it comes from the cache, so it costs nothing."""
    return Reply(
        text=call.text,
        thinking=call.thinking,
        ending=call.ending,
        prompt_tokens=call.prompt_tokens,
        output_tokens=call.output_tokens,
        cached_tokens=call.cached_tokens,
        timings=call.timings,
        logprobs=call.logprobs or (),
        attempts=call.attempts,
        host=call.host,
        server_version=call.server_version,
        served_model=call.served_model,
        remote=call.remote,
        cached=True,
        source=Source(model=call.model, digest=call.digest, parameters=call.parameters, key=call.key),
    )


def question_key(kind: str, seed: int, messages: Iterable[Mapping[str, Any]]) -> bytes:
    """Return a hash of the kind, the sampling seed and the messages of a question; images count by their SHA-256."""
    lines = [(line["role"], line["content"], line.get("images_sha256", [])) for line in messages]
    return hashlib.blake2b(msgspec.json.encode((kind, seed, lines)), digest_size=20).digest()


class ReplayModel(Model):
    """Answers each question as in a recorded sweep; a question that was not asked there ends the run.

    Two questions are the same if their kind, sampling seed and messages are equal, images included. So another prompt
    or world only gets an answer if it asks the same question.
    """

    def __init__(self, name: str, recorded: str, of: str | None = None) -> None:
        self.name = name
        path, of = _split(recorded, of)
        self._sweep = SweepFolder.open(path)
        self._runs = _chosen(self._sweep, of)
        self._of = self._runs[0].config()["model"]["name"]
        self.table = lru_cache(_KEPT_SEEDS)(self._table)

    def parameters(self) -> dict[str, Any]:
        """Return the name of the model whose answers are replayed, and the hash of its sweep."""
        return {"replays": self._of, "sweep": self._sweep.sweep.definition}

    def in_run(self, context: RunContext) -> Model:
        """Return a model for a run; it answers from the recorded runs that have the same sampling seed."""
        seeds = {run.calls_seed for run in self._runs}
        if context.calls_seed not in seeds:
            raise InputError(
                f"'{self._sweep.path}' holds no run of '{self._of}' whose calls have the seed {context.calls_seed}: "
                f"it has {_some(sorted(seeds))}."
            )
        return Replayed(self, context.calls_seed)

    async def ask(self, request: Request) -> Reply:
        """Return the answer to a request from the records of all replayed runs."""
        return AnswerTable(self._sweep.path, self._runs).reply(request)

    def _table(self, calls_seed: int) -> "AnswerTable":
        return AnswerTable(self._sweep.path, [run for run in self._runs if run.calls_seed == calls_seed])


class Replayed(Model):
    """Gives the recorded answers to calls of one seed; the records are read at the first request."""

    def __init__(self, model: ReplayModel, calls_seed: int) -> None:
        self.name = model.name
        self._model = model
        self._calls_seed = calls_seed

    def parameters(self) -> dict[str, Any]:
        """Return the name of the model whose answers are replayed, and the hash of its sweep."""
        return self._model.parameters()

    async def ask(self, request: Request) -> Reply:
        """Answer a request."""
        return (await self.ask_all([request]))[0]

    async def ask_all(self, requests: Sequence[Request]) -> list[Reply]:
        """Return a reply for each request, in the same order; this is faster than an asyncio task per request."""
        table = self._model.table(self._calls_seed)
        return [table.reply(request) for request in requests]


class AnswerTable:
    """The recorded answers of some runs of a sweep, by question."""

    def __init__(self, path: Path, runs: Sequence[RunFolder]) -> None:
        self._path = path
        self._replies: dict[bytes, tuple[str, Reply]] = {}
        self._disputed: dict[bytes, tuple[str, str]] = {}
        self._asked: dict[tuple[int, int, str, int], str] = {}
        for run in runs:
            for call in run.calls():
                self._add(run.id, call)

    def _add(self, run: str, call: Call) -> None:
        key, reply = question_key(call.kind, call.seed, call.messages), reply_of(call)
        self._asked.setdefault((call.step, call.agent, call.kind, call.seed), run)
        first, known = self._replies.setdefault(key, (run, reply))
        if (known.text, known.ending) != (reply.text, reply.ending):
            self._disputed[key] = (first, run)

    def reply(self, request: Request) -> Reply:
        """Return the recorded answer to a request."""
        key = question_key(request.kind, request.seed, map(logged, request.messages))
        what = f"the {request.kind} question of agent {request.agent} at step {request.step}"
        if key in self._disputed:
            raise RequestError(
                f"'{self._path}' has different answers to {what}, in the runs {' and '.join(self._disputed[key])}. "
                "Name one of these runs with model.of=<run>."
            )
        if key not in self._replies:
            raise RequestError(
                f"'{self._path}' holds no answer to {what} (sampling seed {request.seed}): {self._why(request)}."
            )
        return self._replies[key][1]

    def _why(self, request: Request) -> str:
        run = self._asked.get((request.step, request.agent, request.kind, request.seed))
        return "no run asked this question" if run is None else f"run {run} asked this question with another prompt"


def _split(recorded: str, of: str | None) -> tuple[Path, str | None]:
    """Return the folder and the model in a text such as "outputs/pilot@llama3.2"; `of`, if given, names the model."""
    parts = recorded.split("@")
    for count in range(1, len(parts)):
        folder = Path("@".join(parts[:count]))
        if of is None and folder.is_dir():
            return folder, "@".join(parts[count:])
    return Path(recorded), of


def _chosen(sweep: SweepFolder, of: str | None) -> list[RunFolder]:
    runs = sweep.runs()
    models: dict[str, list[RunFolder]] = {}
    for run in runs:
        models.setdefault(str(run.config()["model"]["name"]), []).append(run)
    if of is None:
        if len(models) > 1:
            raise InputError(
                f"'{sweep.path}' holds several models: say which one answers, as in model=replay/{sweep.path}@"
                f"{next(iter(models))}. It has: {', '.join(sorted(models))}."
            )
        return runs
    chosen = models.get(of) or [run for run in runs if run.id == of]
    if not chosen:
        raise not_found(f"Model or run of '{sweep.path}'", of, models)
    return chosen


def _some(numbers: Sequence[int]) -> str:
    shown = ", ".join(map(str, numbers[:8]))
    return f"{shown} ... {numbers[-1]}" if len(numbers) > 8 else shown
