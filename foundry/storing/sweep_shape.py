"""Which shapes `sweep.yaml` may have: what reads it then finds mappings, lists, texts and numbers where it looks."""

from __future__ import annotations

import datetime
from typing import Annotated, Any, TypeAlias

import msgspec

from foundry.declared import Declared
from foundry.expansion import models_in

Number: TypeAlias = Annotated[int, msgspec.Meta(ge=0)]
_INTEGERS = range(-(2**63), 2**64)
"""What a record can hold of them."""


class _Named(msgspec.Struct):
    name: str
    target: str | None = msgspec.field(default=None, name="_target_")


class _Record(msgspec.Struct):
    frames: bool | Number = False


class _Past(msgspec.Struct):
    before: Number | None
    prompt: _Named
    seed: Number


class _Fork(msgspec.Struct):
    sweep: str
    run: str
    at: Number
    records_sha256: dict[str, str]
    past: list[_Past]


class _Config(msgspec.Struct):
    world: _Named
    model: _Named
    prompt: _Named
    sampling_seed: Number | None
    record: _Record | msgspec.UnsetType = msgspec.UNSET
    fork: _Fork | msgspec.UnsetType = msgspec.UNSET
    baselines: list[str] | msgspec.UnsetType = msgspec.UNSET


class _Condition(msgspec.Struct):
    factors: dict[str, Any]
    seeds: list[Number]
    config: _Config
    declared: Declared | msgspec.UnsetType = msgspec.UNSET


class _Run(msgspec.Struct):
    id: str
    condition: int
    seed: Number


class _Cache(msgspec.Struct):
    path: str | None


class _Settings(msgspec.Struct):
    """Where and how a sweep was run; tools that only read it need none of that."""

    cache: _Cache | msgspec.UnsetType = msgspec.UNSET
    runner: dict[str, Any] | msgspec.UnsetType = msgspec.UNSET
    record: _Record | msgspec.UnsetType = msgspec.UNSET


class _Model(msgspec.Struct):
    name: str
    digest: str | None
    server_version: str | None = None
    weights: str | None = None
    remote: str | None = None


class _Asked(msgspec.Struct):
    asked: list[str]
    when: str | None
    runs: Number


class _Content(msgspec.Struct):
    asked: list[str]
    models: list[_Model]
    settings: _Settings
    conditions: list[_Condition]
    runs: list[_Run]
    history: list[_Asked] | msgspec.UnsetType = msgspec.UNSET
    plan: str | msgspec.UnsetType = msgspec.UNSET


class _Server(msgspec.Struct):
    """What is looked at of how a model is reached, before the model is built."""

    workers: Annotated[int, msgspec.Meta(ge=1)] | None = None
    base_url: str | list[str] | None = None
    hosts: str | list[str] | None = None
    api_key_env: str | None = None


class _Part(msgspec.Struct):
    """What is looked at of a model, and of those that it is made of."""

    name: str = ""
    server: _Server | None = None


def check_shape(content: Any) -> None:
    """Check what `sweep.yaml` holds.

    Raises:
        ValueError: it has another shape, or a value that no record holds.
    """
    try:
        msgspec.convert(content, _Content)
        # The greatest seed stands for all, which are numbers from 0 and may be very many.
        few = [{**one, "seeds": [max(one["seeds"], default=0)]} for one in content["conditions"]]
        _check_plain([content["settings"], *few], set())
        for condition in content["conditions"]:
            for model in models_in(condition["config"]["model"]):
                msgspec.convert(model, _Part)
    except msgspec.ValidationError as error:
        raise ValueError(str(error)) from error


def _check_plain(value: Any, seen: set[int]) -> None:
    """Check that a value is one of JSON's; what stands in several places, as YAML's aliases have it, once."""
    if isinstance(value, dict | list):
        if id(value) in seen:
            return
        seen.add(id(value))
        inner = value if isinstance(value, list) else [*_names(value), *value.values()]
        for part in inner:
            _check_plain(part, seen)
    elif isinstance(value, bytes | set | datetime.date) or (isinstance(value, int) and value not in _INTEGERS):
        raise ValueError(f"{str(value)[:40]} is no value of a setting")


def _names(value: dict[Any, Any]) -> list[str]:
    odd = [key for key in value if not isinstance(key, str)]
    if odd:
        raise ValueError(f"{odd[0]!r} is no name of a setting")
    return list(value)
