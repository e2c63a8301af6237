"""Runs a model of the `transformers` library: it answers prompts in batches, each with its own seed."""

from __future__ import annotations

import gc
import io
import time
from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from pathlib import Path
from typing import Any

import torch
import transformers
from jinja2 import TemplateError
from PIL import Image, UnidentifiedImageError
from safetensors import SafetensorError
from torch.nn.attention import SDPBackend, sdpa_kernel
from transformers import AutoConfig, AutoModelForCausalLM, AutoModelForImageTextToText, AutoProcessor, GenerationConfig

from foundry.errors import FoundryError, InputError, RequestError, ServerError
from foundry.models.base import ChatMessage, Reply, Request
from foundry.models.local.settings import Sampling
from foundry.texts import one_line
from foundry.worlds.base import LENGTH, STOPPED

LONGEST_REASON = 300
ATTENTION = [SDPBackend.FLASH_ATTENTION, SDPBackend.EFFICIENT_ATTENTION, SDPBackend.MATH]
"""All attention kernels but cuDNN's: with it, repeats of one call gave different texts, in half precision on an
H200.
"""
VERSIONS = f"transformers {transformers.__version__}, torch {torch.__version__}"


class SeededRows:
    """Chooses the next token of every row with a random generator for this row, so that the library chooses nothing.

    One uniform number per row and token is looked up in the row's cumulative distribution. Rounding depends on the
    batch, but changes a choice only if the number is next to a boundary.
    """

    def __init__(self, sampling: Sampling, seeds: Sequence[int]) -> None:
        self._sampling = sampling
        self._generators = [torch.Generator().manual_seed(seed) for seed in seeds]

    def __call__(self, input_ids: Any, scores: Any) -> Any:
        """Return new scores (rows, vocabulary): 0 for the chosen token of a row, -inf for all others."""
        chosen = self._chosen(scores.to(torch.float64 if scores.dtype == torch.float64 else torch.float32))
        return torch.full_like(scores, float("-inf")).scatter_(1, chosen, 0.0)

    def _chosen(self, scores: Any) -> Any:
        if self._sampling.temperature == 0:
            return scores.argmax(dim=1, keepdim=True)
        candidates = min(self._sampling.top_k or scores.shape[1], scores.shape[1])
        values, tokens = torch.topk(scores, candidates, dim=1)
        chances = _filtered_chances(values, self._sampling)
        draws = [torch.rand((1,), generator=generator, dtype=torch.float64) for generator in self._generators]
        drawn = torch.stack(draws).to(device=scores.device, dtype=scores.dtype)
        below = chances.cumsum(dim=1) <= drawn * chances.sum(dim=1, keepdim=True)
        last = (chances > 0).sum(dim=1, keepdim=True) - 1
        return tokens.gather(1, torch.minimum(below.sum(dim=1, keepdim=True), last))


def _filtered_chances(values: Any, sampling: Sampling) -> Any:
    """Return the tokens' probabilities, not normalised, (rows, kept); logits descend, and a dropped token gets 0."""
    chances = torch.softmax(values / sampling.temperature, dim=1)
    before = chances.cumsum(dim=1) - chances
    dropped = (before >= sampling.top_p) | (chances < sampling.min_p * chances[:, :1])
    dropped[:, 0] = False
    return chances.masked_fill(dropped, 0.0)


def quiet() -> None:
    """Let the library print errors only, since foundry uses the terminal."""
    transformers.logging.set_verbosity_error()
    transformers.logging.disable_progress_bar()


def device_of(asked: str) -> Any:
    """Return the device with this name; `auto` means a GPU if there is one."""
    if asked == "auto":
        asked = "cuda" if torch.cuda.is_available() else "mps" if torch.backends.mps.is_available() else "cpu"
    try:
        return torch.empty(0, device=asked).device
    except (RuntimeError, AssertionError) as error:
        reason = str(error).splitlines()[0]
        raise InputError(
            f"model.server.device={asked} cannot be used: {reason} Write auto, cpu, cuda or mps."
        ) from None


@dataclass(frozen=True)
class Description:
    """The files of a model without its weights.

    Attributes:
        processor: converts messages to tensors; a tokenizer, or a processor that also handles images.
    """

    processor: Any
    config: Any

    @classmethod
    def read(cls, folder: Path) -> Description:
        """Read the files in a model's folder."""
        quiet()
        try:
            config = AutoConfig.from_pretrained(folder, local_files_only=True)
            processor = AutoProcessor.from_pretrained(folder, local_files_only=True)
        except (OSError, ValueError, KeyError) as error:
            raise InputError(f"The model in '{folder}' cannot be read: {_reason(error)}") from error
        except ImportError as error:
            raise InputError(f"The model in '{folder}' needs an additional library: {_reason(error)}") from error
        description = cls(processor, config)
        if description.template is None:
            raise InputError(f"The model in '{folder}' has no chat template. Name a model that was trained for chat.")
        return description

    @property
    def tokenizer(self) -> Any:
        """The tokenizer, which is part of the processor if the model takes images."""
        return getattr(self.processor, "tokenizer", self.processor)

    @property
    def sees(self) -> bool:
        """True if the model takes images."""
        return getattr(self.processor, "image_processor", None) is not None

    @property
    def template(self) -> Any:
        """The chat template, which converts messages to one text; None if the model has none."""
        return getattr(self.processor, "chat_template", None) or self.tokenizer.chat_template

    @property
    def context_length(self) -> int | None:
        """The longest context in tokens, or None where unknown."""
        length = getattr(self.config.get_text_config(), "max_position_embeddings", None)
        return length if isinstance(length, int) else None


class Engine:
    """A loaded model. Only one thread may use an engine."""

    def __init__(
        self, folder: Path, *, dtype: str, device: str, sampling: Sampling, template: Mapping[str, Any]
    ) -> None:
        self._described = Description.read(folder)
        self._sampling = sampling
        self._template = dict(template)
        self._device = device_of(device)
        kind = AutoModelForImageTextToText if self._described.sees else AutoModelForCausalLM
        try:
            model = kind.from_pretrained(folder, dtype=dtype, local_files_only=True)
            self._model = model.to(self._device).eval()
        except (OSError, ValueError, RuntimeError, SafetensorError) as error:
            line = f"The weights in '{folder}' cannot be loaded on {self._device}: {_reason(error)}"
            raise ServerError(line) from error
        tokenizer = self._described.tokenizer
        tokenizer.padding_side = "left"
        if tokenizer.pad_token_id is None:
            tokenizer.pad_token = tokenizer.eos_token
        self._ends = _end_tokens(self._model.generation_config.eos_token_id, tokenizer.eos_token_id)
        self._generation = GenerationConfig(
            do_sample=False,
            max_new_tokens=sampling.max_new_tokens,
            eos_token_id=sorted(self._ends),
            pad_token_id=tokenizer.pad_token_id,
        )
        # The model's own defaults would replace settings that are open here: penalties, beams, forced tokens.
        self._model.generation_config = self._generation
        self.version = f"{VERSIONS}, {self._device}"

    def close(self) -> None:
        """Free the memory of the model."""
        del self._model
        gc.collect()
        if self._device.type == "cuda":
            torch.cuda.empty_cache()

    def answer(self, requests: Sequence[Request]) -> list[Reply | Exception]:
        """Return, for each request, the reply or, if there is no reply, an error with the cause."""
        results: dict[int, Reply | Exception] = {}
        for index, request in enumerate(requests):
            refusal = self._refusal(request)
            if refusal is not None:
                results[index] = refusal
        fitting = [index for index in range(len(requests)) if index not in results]
        if fitting:
            results.update(zip(fitting, self._generate([requests[index] for index in fitting]), strict=True))
        return [results[index] for index in range(len(requests))]

    def _refusal(self, request: Request) -> FoundryError | None:
        """Return an error if a request can never be answered, for example because its prompt is too long; else None."""
        try:
            tokens = int(self._encoded([request])["input_ids"].shape[1])
        except (TemplateError, UnidentifiedImageError) as error:
            return RequestError(f"The prompt cannot be given to the model: {_reason(error)}")
        longest = self._described.context_length
        if longest is not None and tokens + self._sampling.max_new_tokens > longest:
            return RequestError(
                f"A prompt of {tokens} tokens and a reply of up to {self._sampling.max_new_tokens} do not fit the "
                f"context of {longest}. Shorten the prompt, or lower model.options.max_new_tokens."
            )
        return None

    def _generate(self, requests: Sequence[Request]) -> list[Reply]:
        started = time.perf_counter()
        encoded = self._encoded(requests)
        rows = SeededRows(self._sampling, [request.seed for request in requests])
        try:
            with torch.inference_mode(), sdpa_kernel(ATTENTION):
                made = self._model.generate(
                    **encoded.to(self._device), generation_config=self._generation, logits_processor=[rows]
                )
        except torch.OutOfMemoryError as error:
            few = f"{self._device} has too little memory for {len(requests)} calls at once"
            raise ServerError(f"{few}. Lower model.server.batch_size.") from error
        seconds = time.perf_counter() - started
        width = encoded["input_ids"].shape[1]
        prompts = encoded["attention_mask"].sum(dim=1).tolist()
        outputs = made[:, width:].tolist()
        return [self._reply(output, prompt, seconds) for output, prompt in zip(outputs, prompts, strict=True)]

    def _reply(self, output: Sequence[int], prompt_tokens: int, seconds: float) -> Reply:
        end = next((index for index, token in enumerate(output) if token in self._ends), None)
        tokens = output if end is None else output[:end]
        return Reply(
            text=self._described.tokenizer.decode(tokens, skip_special_tokens=True),
            ending=LENGTH if end is None else STOPPED,
            prompt_tokens=prompt_tokens,
            output_tokens=len(tokens) + (end is not None),
            timings={"output": seconds},
            server_version=self.version,
        )

    def _encoded(self, requests: Sequence[Request]) -> Any:
        """Return the tensors of the prompts; each prompt is padded on the left to the longest."""
        template = self._described.template
        texts = [
            self._described.tokenizer.apply_chat_template(
                [self._message(message) for message in request.messages],
                chat_template=template if isinstance(template, str) else None,
                tokenize=False,
                add_generation_prompt=True,
                **self._template,
            )
            for request in requests
        ]
        # The template has already added every special token.
        settings: dict[str, Any] = {"padding": True, "return_tensors": "pt", "add_special_tokens": False}
        images = [[_picture(image) for message in r.messages for image in message.images] for r in requests]
        if any(images):
            return self._described.processor(text=texts, images=images, **settings)
        return self._described.tokenizer(text=texts, **settings)

    def _message(self, message: ChatMessage) -> dict[str, Any]:
        if message.images and not self._described.sees:
            raise TemplateError("it contains images, but the model has no vision.")
        if not self._described.sees:
            return {"role": message.role, "content": message.content}
        parts: list[dict[str, str]] = [{"type": "image"} for _ in message.images]
        return {"role": message.role, "content": [*parts, {"type": "text", "text": message.content}]}


def _reason(error: Exception) -> str:
    return one_line(error, LONGEST_REASON)


def _picture(image: bytes) -> Any:
    return Image.open(io.BytesIO(image)).convert("RGB")


def _end_tokens(*ids: int | list[int] | None) -> set[int]:
    return {
        token
        for token_ids in ids
        for token in (token_ids if isinstance(token_ids, list) else [token_ids])
        if token is not None
    }
