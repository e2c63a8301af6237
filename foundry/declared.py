"""The declaration of a world's records before the first record."""

from collections.abc import Iterable, Mapping
from enum import Enum
from types import UnionType
from typing import Annotated, Any, Literal, TypeAlias, Union, get_args, get_origin

import msgspec

_ID = "id"
Id: TypeAlias = Annotated[int, _ID]
"""A whole number that identifies something, such as an agent. It is not a quantity, so it gets no curve in plots."""


class Actions(msgspec.Struct, frozen=True, kw_only=True):
    """The possible decisions of one kind: a label from a closed set, or a number from a range.

    Attributes:
        labels: the labels; empty for a number.
        low: the least number, or null.
        high: the largest number, or null.
        whole: whether only whole numbers are allowed.
        idle: the label or number that does nothing, or null.
    """

    labels: tuple[str, ...] = ()
    low: float | None = None
    high: float | None = None
    whole: bool = True
    idle: str | float | None = None


class Declared(msgspec.Struct, frozen=True, kw_only=True):
    """The declaration of a world's records before the first record (`sweep.yaml`).

    Attributes:
        form: the kind of records, which selects the code that converts them to arrays.
        streams: the keys of each record file and their types, by the file's name without its suffix. Types are
            `integer`, `number`, `id`, `text`, `flag`, `label` and `other`, with `?` if null is allowed.
    """

    form: str
    actions: dict[str, Actions] = {}
    streams: dict[str, dict[str, str]] = {}


_KINDS: dict[type, str] = {int: "integer", float: "number", str: "text", bool: "flag"}


def keys_of(records: Iterable[type[Any]]) -> dict[str, dict[str, str]]:
    """Return the keys and types of each record file, as in `Declared.streams`.

    If lines of a file have several classes, a key that some classes lack may be null, and a key with several types has
    the type `other`.
    """
    found: dict[str, dict[str, str]] = {}
    for one in records:
        keys = {field.encode_name: _type_of(field.type) for field in msgspec.structs.fields(one)}
        found[one.stream] = _joined(found[one.stream], keys) if one.stream in found else keys
    return found


def _joined(one: Mapping[str, str], other: Mapping[str, str]) -> dict[str, str]:
    def joined(key: str) -> str:
        kinds = {keys[key] for keys in (one, other) if key in keys}
        plain = {kind.removesuffix("?") for kind in kinds}
        optional = "?" if key not in one or key not in other or any(kind.endswith("?") for kind in kinds) else ""
        return (plain.pop() if len(plain) == 1 else "other") + optional

    return {key: joined(key) for key in {**one, **other}}


def _type_of(annotation: Any) -> str:
    choices = [one for one in get_args(annotation) if one is not type(None)] or [annotation]
    is_union = get_origin(annotation) in (Union, UnionType)
    optional = "?" if is_union and len(choices) < len(get_args(annotation)) else ""
    if not is_union:
        choices = [annotation]
    names = {_type_name(one) for one in choices}
    return (names.pop() if len(names) == 1 else "other") + optional


def _type_name(annotation: Any) -> str:
    if get_origin(annotation) is Literal or (isinstance(annotation, type) and issubclass(annotation, Enum)):
        return "label"
    if get_origin(annotation) is Annotated and _ID in annotation.__metadata__:
        return _ID
    return _KINDS.get(annotation, "other")
