"""Converts the data of a figure to a table in long form, for other programs."""

import dataclasses
from collections.abc import Iterable, Iterator, Mapping
from typing import Any

import numpy as np

_SCALARS = (str, bool, int, float, np.generic)
_LOOKS = ("index",)
"""Fields that are left out, because they only define the marker and the colour of a group."""


def csv_of(data: Iterable[Any]) -> str:
    """Return the data as CSV; fields that a row lacks are empty."""
    import pandas as pd

    return pd.DataFrame(list(rows_of(data))).to_csv(index=False, lineterminator="\n")


def rows_of(data: Iterable[Any], panel: str = "") -> Iterator[dict[str, Any]]:
    """Yield the rows of a table with the content of data classes.

    A tuple (title, list) stands for a panel: each row from the list has the title in its column `panel`.

    A field with one number or text becomes a column. A field with an array gives one row per element, with the index of
    the element as `position`, or as `row` and `column`. A group becomes its label.
    """
    for part in data:
        if dataclasses.is_dataclass(part):
            for row in _rows(part):
                yield {"panel": panel, **row} if panel else row
        elif isinstance(part, tuple) and part and isinstance(part[0], str):
            yield from rows_of([item for item in part[1:] if isinstance(item, (list, tuple))], part[0])
        elif isinstance(part, (list, tuple)):
            yield from rows_of(part, panel)


def _rows(part: Any) -> Iterator[dict[str, Any]]:
    values = {field.name: getattr(part, field.name) for field in dataclasses.fields(part) if field.name not in _LOOKS}
    if "shown" in values:
        values = {"group": values.pop("shown").label, **values}
    row = {name: value for name, value in values.items() if isinstance(value, _SCALARS)}
    arrays = {name: value for name, value in values.items() if isinstance(value, np.ndarray)}
    lists = {name: value for name, value in values.items() if isinstance(value, tuple) and value}
    yield from _expanded(row, arrays, {name: value for name, value in lists.items() if isinstance(value[0], _SCALARS)})


def _expanded(
    row: Mapping[str, Any], arrays: Mapping[str, Any], lists: Mapping[str, tuple[Any, ...]]
) -> Iterator[dict[str, Any]]:
    if not arrays:
        yield dict(row)
        return
    shape = next(iter(arrays.values())).shape
    along = [name for name, values in lists.items() if len(values) == shape[0]]
    names = ("position",) if len(shape) == 1 else ("row", "column")
    for place in np.ndindex(shape):
        yield {
            **row,
            **dict(zip(names, place, strict=True)),
            **{name: lists[name][place[0]] for name in along},
            **{name: values[place] for name, values in arrays.items() if values.shape == shape},
        }
