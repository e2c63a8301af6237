"""Everything an Ollama server was seen to answer to one chat call, as data."""

import hashlib
from collections.abc import Callable, Mapping
from dataclasses import dataclass, field
from typing import Any

import msgspec
from aiohttp import web


@dataclass(frozen=True)
class ChatCase:
    text: str = ""
    thinking: str | None = None
    done: bool = True
    done_reason: str = "stop"
    prompt_tokens: int | None = None
    output_tokens: int | None = None
    status: int = 200
    error: str | None = None
    headers: Mapping[str, str] = field(default_factory=dict)
    raw: bytes | None = None
    cut: bool = False
    drop: bool = False
    hang: bool = False
    held: bool = False
    delay_s: float = 0.0


@dataclass
class FakeModel:
    name: str
    digest: str = "a1" * 32
    capabilities: tuple[str, ...] = ("completion",)
    context_length: int = 262144
    size: int = 2_500_000_000
    parameter_size: str = "4.0B"
    quantization: str = "Q4_K_M"
    modified_at: str = "2026-09-01T12:00:00Z"
    more: Mapping[str, Any] = field(default_factory=dict)

    @property
    def details(self) -> dict[str, Any]:
        return {
            "format": "gguf",
            "parameter_size": self.parameter_size,
            "quantization_level": self.quantization,
            "context_length": self.context_length,
        }

    @property
    def row(self) -> dict[str, Any]:
        names = {"name": self.name, "model": self.name, "modified_at": self.modified_at}
        capabilities = list(self.capabilities)
        size = {"size": self.size, "digest": self.digest}
        return {**names, **size, "details": self.details, "capabilities": capabilities, **self.more}

    @property
    def shown(self) -> dict[str, Any]:
        info = {"general.architecture": "fake", "fake.context_length": self.context_length}
        capabilities = list(self.capabilities)
        return {"details": self.details, "model_info": info, "capabilities": capabilities}


@dataclass
class Counts:
    chats: int = 0
    loads: int = 0
    unloads: int = 0
    in_flight: int = 0
    most_in_flight: int = 0


def default_models() -> list[FakeModel]:
    """Return the default model, one with the tag `latest`, one that sees and one that thinks."""
    return [
        FakeModel("qwen3:4b-instruct-2507-q4_K_M"),
        FakeModel("llama3.2:latest", "b2" * 32, context_length=131072),
        FakeModel("qwen2.5vl:3b", "c3" * 32, ("completion", "vision"), 128000),
        FakeModel("qwen3:4b", "d4" * 32, ("completion", "thinking"), 40960),
    ]


Body = dict[str, Any]
Answerer = Callable[[Body], str | ChatCase]

EMPTY = ChatCase(text="")
ONLY_THINKING = ChatCase(text="", thinking="Hmm, the fire ...", done_reason="length")
ABORTED = ChatCase(text="no no no no", done=False)
ABORTED_500 = ChatCase(status=500, error="prediction aborted, token repeat limit reached")
RUNNER_DIED = ChatCase(status=500, error="an error was encountered while running the model: unexpected EOF")
BAD_OPTION = ChatCase(status=500, error='option "seed" must be of type integer')
BAD_FORMAT = ChatCase(status=500, error='invalid format: expected "json" or a JSON Schema')
ERROR_WITH_200 = ChatCase(error="llama-server process no longer running")
CUT = ChatCase(text="This reply never ends well.", cut=True)
DROPPED = ChatCase(drop=True)
HANGING = ChatCase(hang=True)


def refused(status: int, error: str) -> ChatCase:
    return ChatCase(status=status, error=error)


CHARACTERS_PER_TOKEN = 4
LOAD_OPTIONS = ("num_ctx", "num_batch", "num_gpu", "main_gpu", "use_mmap", "num_thread", "draft_num_predict")
THINK_LEVELS = (None, False, True, "low", "medium", "high", "max")
INTEGER_OPTIONS = ("seed", "num_ctx", "num_predict", "num_keep", "top_k", "num_thread", "num_batch", "num_gpu")


def estimated_tokens(body: Mapping[str, Any]) -> int:
    return sum(len(m["content"]) for m in body["messages"]) // CHARACTERS_PER_TOKEN + 8


def context_of(body: Mapping[str, Any]) -> int:
    return int(body.get("options", {}).get("num_ctx") or 4096)


def load_key(body: Mapping[str, Any]) -> tuple[Any, ...]:
    """Return the options that a loaded model is bound to; others make the server load it again."""
    return tuple(body.get("options", {}).get(option) for option in LOAD_OPTIONS)


def refusal_of(body: Mapping[str, Any], model: FakeModel) -> ChatCase | None:
    think = body.get("think")
    if think not in THINK_LEVELS:
        return refused(400, f"invalid think value: {think!r}")
    if think and "thinking" not in model.capabilities:
        return refused(400, f'"{model.name}" does not support thinking')
    for option, value in body.get("options", {}).items():
        if option in INTEGER_OPTIONS and not isinstance(value, int | float):
            return refused(500, f'option "{option}" must be of type integer')
    if not (body.get("format") in (None, "", "json") or isinstance(body["format"], dict)):
        return BAD_FORMAT
    if "vision" not in model.capabilities and any(message.get("images") for message in body["messages"]):
        return refused(400, f'"{model.name}" does not support multimodal requests')
    return None


def overflow_of(body: Mapping[str, Any]) -> ChatCase | None:
    """Return what becomes of a prompt longer than its context: a refusal, or with `truncate` a silent cut."""
    tokens, num_ctx = estimated_tokens(body), context_of(body)
    if tokens <= num_ctx:
        return None
    if body.get("truncate", True):
        return truncated(num_ctx)
    inner = {"code": 400, "message": f"request ({tokens} tokens) exceeds the available context size ({num_ctx})"}
    return refused(400, msgspec.json.encode({"error": {**inner, "type": "exceed_context_size_error"}}).decode())


def busy(retry_after: str | None = None) -> ChatCase:
    headers = {} if retry_after is None else {"Retry-After": retry_after}
    text = "server busy, please try again.  maximum pending requests exceeded"
    return ChatCase(status=503, error=text, headers=headers)


def truncated(num_ctx: int, text: str = "I saw only the end.") -> ChatCase:
    """Return the reply to a prompt that was silently cut to half the context."""
    return ChatCase(text=text, prompt_tokens=num_ctx // 2 + 2)


def in_turn(*cases: Any) -> Callable[[Body], Any]:
    """Return an answerer that gives these in their order and then the last one for ever."""
    left = list(cases)
    return lambda body: left.pop(0) if len(left) > 1 else left[0]


def grid_answer(body: Mapping[str, Any]) -> str:
    """Return a valid reply of a 2D world's agent, decided by the prompt and the seed alone."""
    seed = body.get("options", {}).get("seed")
    state = msgspec.json.encode([body["messages"], seed], order="deterministic")
    number = int.from_bytes(hashlib.blake2b(state, digest_size=8).digest(), "little")
    if '"action":' not in body["messages"][-1]["content"]:
        reply = {"message": f"I note {number % 1000}.", "reasoning": "Someone is near."}
    elif number % 4 == 0:
        reply = {"action": "stay", "memory": f"stayed {number % 97}", "reasoning": "It is fine here."}
    else:
        direction = ("up", "down", "left", "right")[(number >> 8) % 4]
        memory = f"went {direction}"
        reply = {"action": "move", "direction": direction, "memory": memory, "reasoning": "To look around."}
    return msgspec.json.encode(reply).decode()


def held(body: Mapping[str, Any]) -> ChatCase:
    return ChatCase(text=grid_answer(body), held=True)


def body_key(body: Body) -> bytes:
    return msgspec.json.encode(body, order="deterministic")


def chat_reply(body: Body, case: ChatCase, elapsed_s: float, worked_s: float) -> Body:
    if case.error is not None:
        return {"error": case.error}
    message = {"role": "assistant", "content": case.text}
    if case.thinking is not None:
        message["thinking"] = case.thinking
    reply = {"model": body["model"], "created_at": "2026-09-01T12:00:00Z", "message": message, "done": case.done}
    return (
        reply | {"done_reason": case.done_reason, **_metrics(body, case, elapsed_s, worked_s)} if case.done else reply
    )


def _metrics(body: Body, case: ChatCase, elapsed_s: float, worked_s: float) -> dict[str, int]:
    """Return the metrics; what is left of the total is the wait, which has no field of its own."""
    prompt = estimated_tokens(body) if case.prompt_tokens is None else case.prompt_tokens
    output = len(case.text) // 4 + 1 if case.output_tokens is None else case.output_tokens
    return {
        "total_duration": int(elapsed_s * 1e9),
        "load_duration": 0,
        "prompt_eval_count": prompt,
        "prompt_eval_duration": 0,
        "eval_count": output,
        "eval_duration": int(min(worked_s, elapsed_s) * 1e9),
    }


def json_response(value: Body, status: int = 200) -> web.Response:
    return web.Response(body=msgspec.json.encode(value), status=status, content_type="application/json")


async def send(request: web.BaseRequest, case: ChatCase, reply: Body) -> web.StreamResponse:
    content = msgspec.json.encode(reply) if case.raw is None else case.raw
    if case.drop and not case.cut:
        content = b""
    half = content[: len(content) // 2] if case.cut else content
    if not case.drop:
        headers = {"Content-Type": "application/json", **case.headers}
        return web.Response(body=half, status=case.status, headers=headers)
    response = web.StreamResponse(headers={"Content-Length": str(len(content) + 1)})
    if case.cut:
        await response.prepare(request)
        await response.write(half)
    if request.transport is not None:
        request.transport.close()
    return response
