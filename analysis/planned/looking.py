"""Counts how often each pair of groups was tested as its seeds grew, and says what that makes of 5 %."""

from __future__ import annotations

import datetime
from collections.abc import Iterator, Sequence
from pathlib import Path
from typing import TypeAlias, cast

import pandas as pd

from analysis.stats.contrasts import ALPHA
from analysis.stats.plan import EXPLORATORY
from analysis.stats.stopping import error_of
from foundry.storing.looks import LookedAt, looks_of, write_looks

_Pair: TypeAlias = tuple[str, ...]
_PAIR = ("factor", "level", "reference", "context")
_ORDINALS = ("", "", "second", "third", "fourth", "fifth", "sixth", "seventh", "eighth", "ninth", "tenth")


def counted(contrasts: pd.DataFrame, folder: Path) -> pd.DataFrame:
    """Return the contrasts with the number of looks at each that was not declared; a new look is kept in the folder.

    The same number of seeds again is no new look.

    Args:
        contrasts: the table of contrasts.
        folder: of the sweep.

    Raises:
        RecordError: what was kept of earlier looks cannot be read.
    """
    known = looks_of(folder)
    before = set(map(_key, known))
    new = [one for one in _looks(contrasts) if _key(one) not in before]
    if new:
        write_looks(folder, [*known, *new])
    sizes = _sizes([*known, *new])
    undeclared = (contrasts["claim"] == EXPLORATORY) & contrasts["p"].notna()
    pairs = [sizes.get(pair, []) for pair in contrasts[list(_PAIR)].astype(str).itertuples(index=False, name=None)]
    rows = zip(contrasts["look"], contrasts["note"], pairs, undeclared, contrasts["headline"], strict=True)
    told = [
        (len(own), "; ".join(filter(None, (note, said(own) if headline else "")))) if counts else (look, note)
        for look, note, own, counts, headline in rows
    ]
    return contrasts.assign(look=[look for look, _ in told], note=[note for _, note in told])


def said(sizes: Sequence[int]) -> str:
    """Return what several looks at growing data, at these numbers of pairs, make of 5 %; "" for a single one."""
    if len(sizes) < 2:
        return ""
    which = f"{_ORDINALS[len(sizes)]} look" if len(sizes) < len(_ORDINALS) else f"look {len(sizes)}"
    return f"{which}, none declared: {ALPHA:.0%} is {error_of(tuple(sorted(sizes)), ALPHA):.0%}"


def _looks(contrasts: pd.DataFrame) -> Iterator[LookedAt]:
    """Yield the pairs of groups that were tested, with the most pairs of seeds that any measure has."""
    now = datetime.datetime.now(datetime.UTC).isoformat(timespec="seconds")
    tested = contrasts[contrasts["p"].notna()]
    for pair, pairs in tested.groupby(list(_PAIR), sort=False)["n_pairs"].max().items():
        factor, level, reference, context = map(str, cast(_Pair, pair))
        yield LookedAt(factor=factor, level=level, reference=reference, context=context, pairs=int(pairs), at=now)


def _key(look: LookedAt) -> tuple[_Pair, int]:
    return (look.factor, look.level, look.reference, look.context), look.pairs


def _sizes(looks: Sequence[LookedAt]) -> dict[_Pair, list[int]]:
    sizes: dict[_Pair, list[int]] = {}
    for pair, pairs in map(_key, looks):
        sizes.setdefault(pair, []).append(pairs)
    return sizes
