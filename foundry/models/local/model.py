"""Models of the `transformers` library, loaded into this process."""

from __future__ import annotations

import asyncio
import time
from collections.abc import Mapping, Sequence
from pathlib import Path
from typing import TYPE_CHECKING, Any

import msgspec

from foundry.errors import InputError, not_found
from foundry.models.base import ModelInfo, Reply, Request
from foundry.models.local.batches import Batches
from foundry.models.local.settings import LocalServing, Sampling
from foundry.models.serving import ServedModel, read_settings

if TYPE_CHECKING:
    from types import ModuleType

    from foundry.models.local.engine import Engine

DTYPES = ("auto", "float32", "bfloat16", "float16", "float64")


class TransformersModel(ServedModel):
    """Answers in batches, across agents and runs; a reply depends on its prompt and seed, not on the batch.

    That holds up to rounding, which differs with the shape of a batch: in half precision a text may then take
    another turn, as on any server that works on several calls at once.
    """

    in_process = True
    replaceable = False

    def __init__(
        self,
        *,
        weights: str,
        name: str,
        dtype: str,
        options: Mapping[str, Any],
        server: Mapping[str, Any],
        template: Mapping[str, Any] | None = None,
        revision: str | None = None,
    ) -> None:
        """Take the settings of `conf/model/hf.yaml`; nothing is loaded.

        Args:
            weights: a folder, or the id of a model that was downloaded.
            name: name in tables and records.
            dtype: precision of the weights.
            options: how tokens are drawn, see `Sampling`.
            server: how the model is run, see `LocalServing`; decides no answer.
            template: handed to the chat template.
            revision: branch, tag or commit of an id.
        """
        if not weights.strip():
            raise InputError("model.weights is empty: write model=hf/<folder or id>.")
        if dtype not in DTYPES:
            raise not_found("model.dtype", dtype, DTYPES)
        self.name = name
        self.server: LocalServing = read_settings(server, LocalServing)
        self._weights, self._revision = weights, revision
        self._dtype = dtype
        self._sampling = _sampling(options)
        self._template = dict(template or {})
        self._engine: Engine | None = None
        self._batches: Batches[Request, Reply] = Batches(self._answer, self.server.batch_size)

    @property
    def longest_reply(self) -> int | None:
        """The option `max_new_tokens`."""
        return self._sampling.max_new_tokens

    def parameters(self) -> dict[str, Any]:
        """Return everything beside weights, messages and seed that decides an answer."""
        return {"dtype": self._dtype, "options": msgspec.to_builtins(self._sampling), "template": self._template}

    async def ask(self, request: Request) -> Reply:
        """Answer one request in a batch with others that have as many images."""
        started = time.perf_counter()
        images = sum(len(message.images) for message in request.messages)
        reply = await self._batches.ask(request, images)
        total = time.perf_counter() - started
        queued = max(0.0, total - reply.timings["output"])
        timings = {**reply.timings, "total": total, "latency": total, "queue": queued}
        return msgspec.structs.replace(reply, timings=timings)

    async def inspect(self) -> ModelInfo:
        """Read what the model's files say, and hash them.

        Raises:
            InputError: they are not there or not a model that chats, or the device is not.
        """
        return await asyncio.to_thread(self._inspect)

    async def warm_up(self) -> None:
        """Load the weights."""
        await self._batches.run(self._load)

    async def unload(self) -> None:
        """Free the memory."""
        await self.close()

    async def close(self) -> None:
        """Free the memory and end the thread; a later call loads the weights again."""
        self._batches.close()
        engine, self._engine = self._engine, None
        if engine is not None:
            engine.close()

    def _inspect(self) -> ModelInfo:
        module = _engine_module()
        folder = self._folder()
        from foundry.models.local import weights as transformers_weights

        described = module.Description.read(folder)
        module.device_of(self.server.device)
        return ModelInfo(
            name=self.name,
            digest=transformers_weights.digest(folder),
            server_version=module.VERSIONS,
            capabilities=("completion", *(("vision",) if described.sees else ())),
            context_length=described.context_length,
        )

    def _load(self) -> Engine:
        if self._engine is None:
            self._engine = _engine_module().Engine(
                self._folder(),
                dtype=self._dtype,
                device=self.server.device,
                sampling=self._sampling,
                template=self._template,
            )
        assert self._engine is not None
        return self._engine

    def _answer(self, requests: Sequence[Request]) -> Sequence[Reply | Exception]:
        return self._load().answer(requests)

    def _folder(self) -> Path:
        from foundry.models.local import weights as transformers_weights

        return transformers_weights.find_folder(self._weights, self._revision)


def _engine_module() -> ModuleType:
    try:
        from foundry.models.local import engine as transformers_engine
    except ImportError as error:
        raise InputError(
            f"model=hf/... needs the library {error.name}, which is not installed: pip install 'foundry-worlds[hf]'"
        ) from error
    return transformers_engine


def _sampling(options: Mapping[str, Any]) -> Sampling:
    try:
        return msgspec.convert(dict(options), Sampling)
    except msgspec.ValidationError as error:
        raise InputError(f"model.options: {error}. Options are: {', '.join(Sampling.__struct_fields__)}.") from None
