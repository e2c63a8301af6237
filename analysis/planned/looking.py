"""Counts how often each pair of groups was tested while seeds were added, which makes tests at 5 % err more often."""

import datetime
import hashlib
import json
from collections.abc import Iterator, Mapping, Sequence
from pathlib import Path
from typing import Any, TypeAlias, cast

import pandas as pd

from analysis.measuring.runs import RunResult
from analysis.stats.contrasts import ALPHA
from analysis.stats.factors import find_factors, sides_of
from analysis.stats.plan import EXPLORATORY
from analysis.stats.stopping import error_of
from analysis.stats.values import Group
from analysis.tables.groups import PARTS, group_keys
from foundry.storing.preregistration import LookedAt, looks_of, write_looks
from foundry.storing.store import leaves, without_servers

_Pair: TypeAlias = tuple[str, ...]
_Side: TypeAlias = tuple[str, str, str]
_PAIR = ("factor", "level", "reference", "context")
_ORDINALS = ("", "", "second", "third", "fourth", "fifth", "sixth", "seventh", "eighth", "ninth", "tenth")


def settings_by_side(results: Sequence[RunResult], groups: pd.DataFrame) -> dict[_Side, str]:
    """Return a hash of each group's settings; the keys are the factor, level and context that identify the group."""
    own: dict[Group, Mapping[str, Any]] = {}
    for key, result in zip(group_keys(groups), results, strict=True):
        if not result.baseline:
            own.setdefault(key, result.config)
    columns = list(groups.columns)
    factors = find_factors(columns, own)
    return {side: _hash(config) for key, config in own.items() for side in sides_of(columns, key, factors)}


def _hash(config: Mapping[str, Any]) -> str:
    settings = sorted(leaves({part: without_servers(config[part]) for part in PARTS}))
    return hashlib.sha256(json.dumps(settings).encode()).hexdigest()[:12]


def counted(contrasts: pd.DataFrame, folder: Path, settings: Mapping[_Side, str]) -> pd.DataFrame:
    """Add to the contrasts how many looks each pair of groups had without a declaration; record them in the folder.

    An analysis of the same number of seeds is not a new look.

    Raises:
        RecordError: the record of earlier looks cannot be read.
    """
    known = looks_of(folder)
    earlier, looked = _sizes(known), list(_looks(contrasts, settings))
    new = [pairs for pairs in looked if pairs.pairs not in _sizes_of(pairs, earlier)]
    if new:
        write_looks(folder, [*known, *new])
    sizes = _sizes([*known, *new])
    undeclared = (contrasts["claim"] == EXPLORATORY) & contrasts["p"].notna()
    now = {_texts(look): _sizes_of(look, sizes) for look in looked}
    pairs = [now.get(pair, []) for pair in zip(*(contrasts[name].astype(str).tolist() for name in _PAIR), strict=True)]
    looks, notes, headlines = (contrasts[name].tolist() for name in ("look", "note", "headline"))
    rows = zip(looks, notes, pairs, undeclared, headlines, strict=True)
    sizes_now = [
        (len(own), "; ".join(filter(None, (note, error_after_looks(own) if headline else ""))))
        if counts
        else (look, note)
        for look, note, own, counts, headline in rows
    ]
    return contrasts.assign(look=[look for look, _ in sizes_now], note=[note for _, note in sizes_now])


def error_after_looks(sizes: Sequence[int]) -> str:
    """Return, in words, how often 5 % tests err after looks at these numbers of pairs; "" for a single look."""
    if len(sizes) < 2:
        return ""
    ordinal = f"{_ORDINALS[len(sizes)]} undeclared look" if len(sizes) < len(_ORDINALS) else ""
    which = ordinal or f"undeclared look {len(sizes)}"
    return f"{which}: tests at {ALPHA:.0%} wrongly find a difference in {error_of(tuple(sizes), ALPHA):.0%} of cases"


def _looks(contrasts: pd.DataFrame, settings: Mapping[_Side, str]) -> Iterator[LookedAt]:
    """Yield a look for each tested pair of groups; its size is the largest number of pairs of seeds in any measure."""
    now = datetime.datetime.now(datetime.UTC).isoformat(timespec="seconds")
    tested = contrasts[contrasts["p"].notna()]
    for pair, pairs in tested.groupby(list(_PAIR), sort=False)["n_pairs"].max().items():
        factor, level, reference, context = map(str, cast(_Pair, pair))
        sides = {settings[factor, side, context] for side in (level, reference)} if settings else ()
        yield LookedAt(
            factor=factor,
            level=level,
            reference=reference,
            context=context,
            pairs=int(pairs),
            at=now,
            settings=tuple(sorted(sides)),
        )


def _texts(look: LookedAt) -> _Pair:
    return look.factor, look.level, look.reference, look.context


def _sizes(looks: Sequence[LookedAt]) -> dict[_Pair, list[int]]:
    sizes: dict[_Pair, list[int]] = {}
    for look in looks:
        sizes.setdefault(look.settings or _texts(look), []).append(look.pairs)
    return sizes


def _sizes_of(look: LookedAt, sizes: Mapping[_Pair, list[int]]) -> list[int]:
    """Return all numbers of seeds with which a pair of groups was tested.

    Old records do not contain the settings of the groups, so old records are found by the names of the groups.
    """
    return sorted({size for key in (_texts(look), look.settings) for size in sizes.get(key, [])})
