"""Requests, settings and small stand-ins for the tests of models."""

from __future__ import annotations

import asyncio
from collections.abc import Awaitable, Callable
from pathlib import Path
from typing import Any, TypeVar

import pytest
import yaml

import ollama_cases as cases
from foundry.models.base import ChatMessage, Model, Reply, Request
from foundry.models.ollama import OllamaModel
from ollama_server import OllamaServer

T = TypeVar("T")
YAML = Path(__file__).parents[2] / "conf" / "model" / "ollama.yaml"
MakeRequest = Callable[..., Request]
MakeModel = Callable[..., OllamaModel]


class Scripted(Model):
    """Does what it is told, call by call: returns a reply, raises an error or runs a coroutine function."""

    def __init__(self, *script: Reply | BaseException | Callable[[], Awaitable[Reply]]) -> None:
        self.name = "scripted"
        self.script = list(script)
        self.asked: list[Request] = []

    async def ask(self, request: Request) -> Reply:
        """Do the next thing of the script; its last one for ever."""
        self.asked.append(request)
        step = self.script.pop(0) if len(self.script) > 1 else self.script[0]
        if isinstance(step, BaseException):
            raise step
        return step if isinstance(step, Reply) else await step()

    def parameters(self) -> dict[str, Any]:
        """Return nothing."""
        return {}


@pytest.fixture
def scripted() -> type[Scripted]:
    return Scripted


@pytest.fixture
def make_request() -> MakeRequest:
    def make(*contents: str, seed: int = 7, kind: str = "action", images: tuple[bytes, ...] = ()) -> Request:
        texts = contents or ("Where do you go?",)
        messages = tuple(ChatMessage("user", text, images) for text in texts)
        return Request(messages=messages, seed=seed, kind=kind, observation={}, step=1, agent=0)

    return make


@pytest.fixture
def make_model() -> MakeModel:
    """The shipped settings for these hosts, changed by keyword; those of `server` and `options` one by one."""

    def make(hosts: str | list[str], **changes: Any) -> OllamaModel:
        settings = yaml.safe_load(YAML.read_text("utf-8"))
        del settings["_target_"]
        settings["server"] |= {"hosts": hosts, **changes.pop("server", {})}
        settings["options"] |= changes.pop("options", {})
        return OllamaModel(**{**settings, **changes})

    return make


@pytest.fixture
def run() -> Callable[..., Any]:
    """Run one thing with a model and close the model in the same event loop."""

    def run_and_close(model: Model, work: Callable[[Model], Awaitable[T]]) -> T:
        async def whole() -> T:
            try:
                return await work(model)
            finally:
                await model.close()

        return asyncio.run(whole())

    return run_and_close


@pytest.fixture
def ask(make_model, make_request, run):
    """Ask a server that answers like this once, and return what it got and what it gave."""

    def ask_once(answer, *contents, request=None, **changes):
        with OllamaServer(answer if callable(answer) else cases.in_turn(answer)) as server:
            asked = make_model(server.url, **changes)
            reply = run(asked, lambda m: m.ask(request or make_request(*contents)))
            return reply, server.bodies[0]

    return ask_once
