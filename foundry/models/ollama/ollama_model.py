"""Models served by Ollama."""

import asyncio
import time
from collections.abc import Mapping
from dataclasses import replace
from typing import Any

import msgspec

from foundry.canary import TOKENS
from foundry.errors import BackendError, InputError, ServerError, not_found
from foundry.models.base import Loaded, Model, ModelInfo, Reply, Request
from foundry.models.http.hosts import agreed
from foundry.models.http.http_model import HttpModel, schemas_of
from foundry.models.http.logprobs import checked_logprobs
from foundry.models.http.pausing import requested_wait
from foundry.models.http.transport import OK, Origin, name_in
from foundry.models.ollama import ollama_wire
from foundry.models.ollama.ollama_server import (
    WAYS_ON,
    described,
    full_tag,
    installed_row,
    loaded_in,
    parse_hosts,
    refusal,
)
from foundry.models.ollama.ollama_wire import ChatSettings
from foundry.models.serving import HttpServing, Seconds, read_settings

LOAD_OPTIONS = frozenset({"num_ctx", "num_batch", "num_gpu", "main_gpu", "use_mmap", "num_thread", "draft_num_predict"})
SAMPLER_OPTIONS = frozenset(
    {
        *("num_predict", "num_keep", "stop", "temperature", "top_k", "top_p", "min_p", "typical_p"),
        *("repeat_penalty", "repeat_last_n", "presence_penalty", "frequency_penalty"),
    }
)
LOOK_UP_S = 30.0
"""Timeout for requests to the server that ask for no reply of the model, such as for its version, seconds."""
THINK_LEVELS = (False, True, "low", "medium", "high", "max")


class OllamaServing(HttpServing, frozen=True, kw_only=True):
    """Settings for calls to Ollama servers, as in `conf/model/ollama.yaml`."""

    hosts: str | list[str]
    warm_up_timeout_s: Seconds
    keep_alive: str | float
    remote: bool = False


class OllamaModel(HttpModel):
    """Calls `/api/chat` of one or more equal Ollama servers."""

    settings: ChatSettings

    def __init__(
        self,
        *,
        name: str,
        think: bool | str,
        options: Mapping[str, Any],
        server: Mapping[str, Any],
        format: str | None = None,
        schemas: Mapping[str, Any] | None = None,
        logprobs: int | None = None,
    ) -> None:
        """Take the settings that `conf/model/ollama.yaml` describes."""
        _check_settings(name, think, options)
        self._schemas = schemas_of(format, schemas)
        self.name = name
        self.server: OllamaServing = read_settings(server, OllamaServing)
        if name.casefold().endswith((":cloud", "-cloud")) and not self.server.remote:
            raise InputError(_remote_line(name, "Ollama's cloud"))
        self.settings = ChatSettings(
            model=name,
            think=think,
            options={key: value for key, value in options.items() if value is not None},
            schemas=self._schemas,
            logprobs=checked_logprobs(logprobs),
        )
        self._versions: dict[str, str] = {}
        self._reach(parse_hosts(self.server.hosts), WAYS_ON)

    @property
    def longest_reply(self) -> int | None:
        """Maximum number of tokens of a reply (`num_predict`); None without a limit, as for a negative value."""
        limit = self.settings.options.get("num_predict")
        return int(limit) if isinstance(limit, int) and limit > 0 else None

    @property
    def context_length(self) -> int | None:
        """The option `num_ctx`."""
        return self.settings.options.get("num_ctx")

    def parameters(self) -> dict[str, Any]:
        """Return all fields of a call except messages, seed and keep_alive, with a schema per kind of question."""
        return ollama_wire.chat_parameters(self.settings)

    async def ask(self, request: Request) -> Reply:
        """Answer one request with one call, once the server may be called; `RetriedModel` repeats failed calls."""
        body = ollama_wire.chat_body(self.settings, request, self.server.keep_alive)
        with self._pool.least_loaded() as host:
            origin = self._origin(host)
            await self._pauses[host].over(origin)
            started = time.perf_counter()
            content = await self._chat(origin, body, self.server.read_timeout_s)
            latency_s = time.perf_counter() - started
            origin = self._origin(host)
            reply = ollama_wire.read_reply(content, request, self.settings, origin, latency_s=latency_s)
            if reply.remote is not None and not self.server.remote:
                raise ServerError(_remote_line(self.name, reply.remote))
            return reply

    def canary_models(self, likeliest: int | None) -> Mapping[str, Model]:
        """Return a copy of the model for canary calls to each server, by base URL; its load options are the same."""
        loading = {key: value for key, value in self.settings.options.items() if key in LOAD_OPTIONS}
        greedy = {**loading, "temperature": 0, "repeat_penalty": 1.0, "num_predict": TOKENS}
        return self._on_each_host(replace(self.settings, options=greedy, schemas=None, logprobs=likeliest))

    async def inspect(self) -> ModelInfo:
        """Ask every server about the model."""
        infos = dict(zip(self.hosts, await asyncio.gather(*map(self._inspect_on, self.hosts)), strict=True))
        info = agreed(infos, f"Run `ollama pull {self.name}` on each host, or name one host.")
        self._versions = {host: each.server_version or "" for host, each in infos.items()}
        _check_abilities(self.settings, info)
        return info

    async def warm_up(self) -> None:
        """Load the model on every server. Loading may take longer than any call."""
        await asyncio.gather(*map(self._load, self.hosts))

    async def loaded(self) -> Loaded:
        """Ask every server about the loaded model."""
        return Loaded.of_all([self._loaded_in(await self._object(host, "GET", "/api/ps")) for host in self.hosts])

    def _loaded_in(self, running: Mapping[str, Any]) -> Loaded:
        models = running.get("models")
        rows = [row for row in models if isinstance(row, dict)] if isinstance(models, list) else []
        tag = full_tag(self.name).casefold()
        return next((loaded_in(row) for row in rows if str(row.get("name")).casefold() == tag), Loaded())

    async def unload(self) -> None:
        """Let every server free the model's memory."""
        body = ollama_wire.unload_body(self.name)
        origins = map(self._origin, self.hosts)
        await asyncio.gather(*(self._chat(origin, body, self.server.read_timeout_s) for origin in origins))

    async def _inspect_on(self, host: str) -> ModelInfo:
        try:
            row = installed_row(await self._object(host, "GET", "/api/tags"), self.name, host)
            shown = await self._object(host, "POST", "/api/show", {"model": row["model"]})
            version = await self._version(host)
        except BackendError as error:
            raise InputError(error.problem, advice=error.advice) from error
        info = described(self.name, row, shown, version, host)
        if info.remote is not None and not self.server.remote:
            raise InputError(_remote_line(self.name, info.remote))
        return info

    async def _load(self, host: str) -> None:
        body = ollama_wire.load_body(self.settings, self.server.keep_alive)
        origin = self._origin(host)
        ollama_wire.read_object(await self._chat(origin, body, self.server.warm_up_timeout_s), origin)
        self._versions[host] = await self._version(host)

    async def _version(self, host: str) -> str:
        return name_in((await self._object(host, "GET", "/api/version")).get("version")) or ""

    async def _object(self, host: str, method: str, path: str, body: Mapping[str, Any] | None = None) -> dict[str, Any]:
        content, origin = None if body is None else msgspec.json.encode(body), self._origin(host)
        return ollama_wire.read_object(await self._send(origin, method, path, LOOK_UP_S, content), origin)

    async def _chat(self, origin: Origin, body: Mapping[str, Any], read_timeout_s: float) -> bytes:
        return await self._send(origin, "POST", "/api/chat", read_timeout_s, msgspec.json.encode(body))

    async def _send(
        self, origin: Origin, method: str, path: str, read_timeout_s: float, content: bytes | None = None
    ) -> bytes:
        response = await self._transport.send(origin, method, path, read_timeout_s=read_timeout_s, content=content)
        pause, wait_s = self._pauses[origin.host], requested_wait(response.headers)
        pause.note(wait_s, origin)
        if response.status != OK:
            raise pause.judged(refusal(origin, response.status, response.content, wait_s), origin)
        return response.content

    def _origin(self, host: str) -> Origin:
        return Origin(host=host, model=self.name, version=self._versions.get(host))


def _check_settings(name: str, think: bool | str, options: Mapping[str, Any]) -> None:
    if not name.strip():
        raise InputError("model.name is empty. List the installed models with: foundry doctor")
    if think not in THINK_LEVELS:
        raise not_found("model.think", str(think), [str(level).lower() for level in THINK_LEVELS])
    if "seed" in options:
        raise InputError("model.options.seed is set for each call; use seed= or sampling_seed= instead.")
    for option in options:
        if option not in LOAD_OPTIONS | SAMPLER_OPTIONS:
            raise not_found("Ollama option", option, LOAD_OPTIONS | SAMPLER_OPTIONS)
    num_ctx = options.get("num_ctx")
    if not isinstance(num_ctx, int) or num_ctx < 1:
        raise InputError(f"model.options.num_ctx must be a number of tokens; got {num_ctx}.")


def _remote_line(name: str, remote: str) -> str:
    return (
        f"Model '{name}' does not run on the host: calls go to {remote}. "
        "Name a local model, or allow this with model.server.remote=true."
    )


def _check_abilities(settings: ChatSettings, info: ModelInfo) -> None:
    if info.context_length is not None and settings.num_ctx > info.context_length:
        raise InputError(
            f"Model '{info.name}' takes at most {info.context_length} tokens, but options.num_ctx is "
            f"{settings.num_ctx}. Set model.options.num_ctx={info.context_length} or less."
        )
    if settings.think and "thinking" not in info.capabilities:
        raise InputError(
            f"Model '{info.name}' cannot think, but model.think is {settings.think}. Use model.think=false."
        )
