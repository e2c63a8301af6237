"""Models behind any server that speaks OpenAI's API of chat completions."""

import time
from collections.abc import Mapping
from dataclasses import replace
from functools import partial
from typing import Any

import msgspec

from foundry.canary import TOKENS
from foundry.errors import BackendError, InputError, RequestError, not_found
from foundry.models.base import Loaded, Model, ModelInfo, Reply, Request
from foundry.models.http.hosts import agreed, parse_url, parse_urls
from foundry.models.http.http_model import HttpModel, schemas_of
from foundry.models.http.logprobs import checked_logprobs
from foundry.models.http.pausing import requested_wait
from foundry.models.http.transport import OK, Origin
from foundry.models.openai import openai_wire
from foundry.models.openai.openai_server import Secret, is_llama_server, listed_info, loaded_in
from foundry.models.openai.openai_wire import ChatSettings, refusal
from foundry.models.serving import HttpServing, read_settings

OPTIONS = frozenset(
    {
        *("temperature", "top_p", "presence_penalty", "frequency_penalty", "stop"),
        *("max_tokens", "max_completion_tokens", "reasoning_effort", "verbosity", "service_tier"),
    }
)
RESERVED = OPTIONS | {"model", "messages", "stream", "response_format", "n", "seed"}
"""Keys that the setting `extra` must not contain: foundry sets them from other settings or for each call."""
SAMPLED = frozenset({"top_p", "presence_penalty", "frequency_penalty", "stop", "max_tokens", "max_completion_tokens"})
"""Options that canary calls leave out or set themselves."""
DETAILS = (None, "low", "high", "auto")
WAYS_ON = (
    "Start the server, set model.server.base_url or OPENAI_BASE_URL to its address with /v1, "
    "or try scripted models: foundry model=scripted/random"
)


class OpenAIServing(HttpServing, frozen=True, kw_only=True):
    """Settings for calls to servers with OpenAI's API, as in `conf/model/openai.yaml`."""

    base_url: str | list[str]
    api_key_env: str | None
    lists_models: bool
    one_fingerprint: bool = True


class OpenAIModel(HttpModel):
    """Calls `/chat/completions` of one or more equal servers."""

    settings: ChatSettings

    def __init__(
        self,
        *,
        served: str,
        name: str,
        options: Mapping[str, Any],
        server: Mapping[str, Any],
        extra: Mapping[str, Any] | None = None,
        seed_field: str | None = "seed",
        image_detail: str | None = None,
        format: str | None = None,
        schemas: Mapping[str, Any] | None = None,
        logprobs: int | None = None,
        schema_strict: bool = False,
        vision: bool | None = None,
        context_length: int | None = None,
        revision: str | None = None,
    ) -> None:
        """Take the settings of `conf/model/openai.yaml`."""
        extra = extra or {}
        _check_settings(served, options, extra, image_detail=image_detail, seed_field=seed_field)
        self._schemas = schemas_of(format, schemas)
        self.name = name
        self.server: OpenAIServing = read_settings(server, OpenAIServing)
        self.settings = ChatSettings(
            model=served,
            options={key: value for key, value in {**options, **extra}.items() if value is not None},
            seed_field=seed_field,
            image_detail=image_detail,
            schemas=self._schemas,
            logprobs=checked_logprobs(logprobs),
            schema_strict=schema_strict,
            context_length=context_length,
            revision=revision,
        )
        self._vision = vision
        self._secret = Secret.from_environment(self.server.api_key_env)
        self._reach(_base_urls(self.server.base_url), WAYS_ON, self._secret.headers)

    @property
    def longest_reply(self) -> int | None:
        """Maximum number of tokens of a reply, by the option `max_completion_tokens` or `max_tokens`; else None."""
        options = self.settings.options
        limit = options.get("max_completion_tokens", options.get("max_tokens"))
        return None if limit is None else int(limit)

    @property
    def context_length(self) -> int | None:
        """The setting `context_length`."""
        return self.settings.context_length

    def parameters(self) -> dict[str, Any]:
        """Return all fields of a call except messages and seed, with a schema per kind of question."""
        return openai_wire.chat_parameters(self.settings)

    async def ask(self, request: Request) -> Reply:
        """Answer one request with one call, as soon as the rate limit allows; `RetriedModel` repeats failed calls."""
        content = msgspec.json.encode(openai_wire.chat_body(self.settings, request))
        with self._pool.least_loaded() as host:
            origin = self._origin(host)
            await self._pauses[host].over(origin)
            started = time.perf_counter()
            answer = await self._send(origin, "POST", "/chat/completions", content)
            latency_s = time.perf_counter() - started
            return openai_wire.read_reply(answer, request, self.settings, origin, latency_s=latency_s)

    def canary_models(self, likeliest: int | None) -> Mapping[str, Model]:
        """Return, by base URL of each server, a copy of the model for canary calls; {} if no temperature is set."""
        options = self.settings.options
        if "temperature" not in options:
            return {}
        limit = "max_completion_tokens" if "max_completion_tokens" in options else "max_tokens"
        sent = {key: value for key, value in options.items() if key not in SAMPLED}
        greedy = {**sent, "temperature": 0, limit: TOKENS}
        return self._on_each_host(replace(self.settings, options=greedy, schemas=None, logprobs=likeliest))

    def weights_of(self, reply: Reply) -> Mapping[str, str]:
        """Return the model's name and the fingerprint in a reply, if they must stay the same in a sweep."""
        marks = {"model": reply.served_model, "fingerprint": reply.server_version}
        return {what: said for what, said in marks.items() if said} if self.server.one_fingerprint else {}

    async def inspect(self) -> ModelInfo:
        """Ask every server whether it lists the model, and a llama.cpp server also for its slots."""
        infos = {host: await self._inspect_on(host) for host in self.hosts}
        info = agreed(infos, "Name one server, or equal servers.")
        try:
            return replace(info, slots=(await self.loaded()).slots)
        except BackendError:  # it lists the model; later calls will show whether it answers
            return info

    async def loaded(self) -> Loaded:
        """Ask every llama.cpp server for its slots and their context; other servers report neither."""
        return Loaded.of_all([await self._loaded_on(host) for host in self.hosts])

    async def _loaded_on(self, host: str) -> Loaded:
        if not self.server.lists_models:
            return Loaded()
        listing = await self._send(self._origin(host), "GET", "/models")
        if not is_llama_server(listing, self.settings.model):
            return Loaded()
        root = self._origin(host.removesuffix("/v1"))
        read_timeout_s = self.server.read_timeout_s
        response = await self._transport.send(root, "GET", "/props", read_timeout_s=read_timeout_s)
        return loaded_in(response.content if response.status == OK else b"{}")

    async def _inspect_on(self, host: str) -> ModelInfo:
        listing = None
        if self.server.lists_models:
            try:
                listing = await self._send(self._origin(host), "GET", "/models")
            except RequestError as error:
                advice = "If the server has no list of models, use model.server.lists_models=false."
                raise InputError(error, advice=advice) from error
            except BackendError as error:
                raise InputError(error.problem, advice=error.advice) from error
        return listed_info(self.settings.model, self.name, listing, self._origin(host), vision=self._vision)

    async def _send(self, origin: Origin, method: str, path: str, content: bytes | None = None) -> bytes:
        """Return the body of a response with status 200, with the key removed; raise the error for any other status."""
        read_timeout_s = self.server.read_timeout_s
        response = await self._transport.send(origin, method, path, read_timeout_s=read_timeout_s, content=content)
        pause = self._pauses[origin.host]
        wait_s = requested_wait(response.headers)
        pause.note(wait_s, origin)
        if response.status == OK:
            return self._secret.removed_from_reply(response.content)
        refused = self._secret.removed(response.content)
        error = refusal(origin, response.status, refused, wait_s, key_env=self.server.api_key_env)
        raise pause.judged(error, origin)

    def _origin(self, host: str) -> Origin:
        return Origin(host=host, model=self.settings.model, server="The server")


def _base_urls(base_url: str | list[str]) -> tuple[str, ...]:
    forms = "http://127.0.0.1:8000/v1 or https://api.openai.com/v1"
    base_urls = parse_urls(base_url, partial(parse_url, what="model.server.base_url", port=80, forms=forms))
    if not base_urls:
        raise InputError(f"model.server.base_url is empty: write it as in {forms}, or set OPENAI_BASE_URL.")
    return base_urls


def _check_settings(
    served: str,
    options: Mapping[str, Any],
    extra: Mapping[str, Any],
    *,
    image_detail: str | None,
    seed_field: str | None,
) -> None:
    if not served.strip():
        raise InputError("model.served is empty: write model=openai/<name on the server>.")
    if image_detail not in DETAILS:
        raise not_found("model.image_detail", str(image_detail), ["null", "low", "high", "auto"])
    for option in options:
        if option not in OPTIONS:
            hint = f"An option of a particular server belongs in model.extra: +model.extra.{option}=..."
            raise not_found("Option", option, OPTIONS, hint)
    for field in extra:
        if field in RESERVED or field == seed_field:
            raise InputError(
                f"model.extra.{field} is refused, because foundry sets this field itself: for each call, or from "
                "another setting. Remove this field."
            )
