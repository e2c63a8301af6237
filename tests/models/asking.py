"""Requests, settings and small stand-ins for the tests of models."""

import asyncio
from collections.abc import Awaitable, Callable
from pathlib import Path
from typing import Any, TypeVar

import yaml

import ollama_cases as cases
from foundry.models.base import ChatMessage, Model, Reply, Request
from foundry.models.ollama.ollama_model import OllamaModel
from foundry.models.openai.openai_model import OpenAIModel
from ollama_server import OllamaServer
from openai_server import OpenAIServer

T = TypeVar("T")
CONF = Path(__file__).parents[2] / "conf"


def shipped_settings(backend: str) -> dict[str, Any]:
    """Return the settings of `conf/model/<backend>.yaml`, not resolved, with the schemas it takes from elsewhere."""
    settings: dict[str, Any] = yaml.safe_load((CONF / "model" / f"{backend}.yaml").read_text("utf-8"))
    del settings["_target_"]
    settings["server"]["canary"] = False
    return {**settings, "schemas": yaml.safe_load((CONF / "schema" / "grid.yaml").read_text("utf-8"))}


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
        return {}


def make_request(*contents: str, seed: int = 7, kind: str = "action", images: tuple[bytes, ...] = ()) -> Request:
    texts = contents or ("Where do you go?",)
    messages = tuple(ChatMessage("user", text, images) for text in texts)
    return Request(messages=messages, seed=seed, kind=kind, observation={}, step=1, agent=0)


def make_model(hosts: str | list[str], **changes: Any) -> OllamaModel:
    """The shipped settings for these hosts, changed by keyword; those of `server` and `options` one by one."""
    settings = shipped_settings("ollama")
    settings["server"] |= {"hosts": hosts, **changes.pop("server", {})}
    settings["options"] |= changes.pop("options", {})
    return OllamaModel(**{**settings, **changes})


def run(model: Model, work: Callable[[Model], Awaitable[T]]) -> T:
    """Run one thing with a model and close the model in the same event loop."""

    async def whole() -> T:
        try:
            return await work(model)
        finally:
            await model.close()

    return asyncio.run(whole())


def ask(answer, *contents, request=None, **changes):
    """Ask a server that answers like this once, and return what it got and what it gave."""
    with OllamaServer(answer if callable(answer) else cases.in_turn(answer)) as server:
        reply = run(make_model(server.url, **changes), lambda m: m.ask(request or make_request(*contents)))
        return reply, server.bodies[0]


def make_openai(base_url: str | list[str], **changes: Any) -> OpenAIModel:
    """The shipped settings for these base URLs, changed by keyword; those of `server` and `options` one by one."""
    settings = shipped_settings("openai") | {"served": "a", "name": "openai/a"}
    settings["server"] |= {"base_url": base_url, **changes.pop("server", {})}
    settings["options"] |= changes.pop("options", {})
    return OpenAIModel(**{**settings, **changes})


def ask_openai(answer, *, request=None, key=None, **changes):
    """Ask a server that answers like this once, and return what it got and what it gave."""
    with OpenAIServer(answer if callable(answer) else lambda body: answer, key=key) as server:
        reply = run(make_openai(server.base_url, **changes), lambda m: m.ask(request or make_request()))
        return reply, server.bodies[0]
