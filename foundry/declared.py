"""The declaration that a world makes about its records, before it writes the first record."""

from collections.abc import Iterable, Mapping
from enum import Enum
from types import UnionType
from typing import Annotated, Any, Literal, TypeAlias, Union, get_args, get_origin

import msgspec

_ID = "id"
Id: TypeAlias = Annotated[int, _ID]
"""A whole number that identifies something, such as an agent, so that plots draw no curve of it."""


class Actions(msgspec.Struct, frozen=True, kw_only=True):
    """The possible decisions for one kind of question: one of several labels, or a number from a range.

    Attributes:
        labels: the labels; empty if the decision is a number.
        low: the smallest number; null for no limit.
        high: the largest number; null for no limit.
        whole: whether the number must be whole.
        idle: the label or number that does nothing; null if there is none.
    """

    labels: tuple[str, ...] = ()
    low: float | None = None
    high: float | None = None
    whole: bool = True
    idle: str | float | None = None


class Declared(msgspec.Struct, frozen=True, kw_only=True):
    """A world's declaration about its records, which foundry writes to `sweep.yaml` before the first record.

    Attributes:
        form: name of the form of records, by which foundry finds the code for them.
        actions: possible decisions, by kind of question.
        streams: type of each key, by the record file's name without suffix. Types are `integer`, `number`, `id`,
            `text`, `flag`, `label` and `other`, with `?` if null is allowed.
    """

    form: str
    actions: dict[str, Actions] = {}
    streams: dict[str, dict[str, str]] = {}


_KINDS: dict[type, str] = {int: "integer", float: "number", str: "text", bool: "flag"}


def keys_of(records: Iterable[type[Any]]) -> dict[str, dict[str, str]]:
    """Return the type of each key of each record file, as in `Declared.streams`.

    A file may contain records of several classes. Then a key that some of them lack may be null, and a key with several
    types has the type `other`.
    """
    by_kind: dict[str, dict[str, str]] = {}
    for record in records:
        keys = {field.encode_name: _type_of(field.type) for field in msgspec.structs.fields(record)}
        by_kind[record.stream] = _joined(by_kind[record.stream], keys) if record.stream in by_kind else keys
    return by_kind


def _joined(first: Mapping[str, str], other: Mapping[str, str]) -> dict[str, str]:
    def joined(key: str) -> str:
        kinds = {keys[key] for keys in (first, other) if key in keys}
        plain = {kind.removesuffix("?") for kind in kinds}
        optional = "?" if key not in first or key not in other or any(kind.endswith("?") for kind in kinds) else ""
        return (plain.pop() if len(plain) == 1 else "other") + optional

    return {key: joined(key) for key in {**first, **other}}


def _type_of(annotation: Any) -> str:
    choices = [choice_type for choice_type in get_args(annotation) if choice_type is not type(None)] or [annotation]
    is_union = get_origin(annotation) in (Union, UnionType)
    optional = "?" if is_union and len(choices) < len(get_args(annotation)) else ""
    if not is_union:
        choices = [annotation]
    names = {_type_name(choice) for choice in choices}
    return (names.pop() if len(names) == 1 else "other") + optional


def _type_name(annotation: Any) -> str:
    if get_origin(annotation) is Literal or (isinstance(annotation, type) and issubclass(annotation, Enum)):
        return "label"
    if get_origin(annotation) is Annotated and _ID in annotation.__metadata__:
        return _ID
    return _KINDS.get(annotation, "other")
