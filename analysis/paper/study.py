"""Describes a sweep in one line, and builds the command that tests its measures on new seeds."""

import shlex
from collections.abc import Collection, Iterable, Mapping, Sequence
from typing import Any

from analysis.prose import joined
from analysis.stats.plan import DECLARED, EXPLORATORY
from analysis.stats.sign_flip import fewest_pairs
from analysis.tables.comparison import Comparison
from foundry.texts import counted

_SIZES = ("agents", "steps", "rounds")
"""Settings of a world that say how large it is."""
_LEFT_OUT = ("seed", "output.dir", "until", "view")
"""Settings that the command for new seeds does not repeat: they get new values or change no result."""


def study(compared: Comparison, worlds: Sequence[Mapping[str, Any]], claims: Sequence[str]) -> str:
    """Describe a study in one line, such as "2 models x 20 seeds, world square, declared"."""
    own = [group for group in compared.groups if group not in compared.baselines]
    levels = {compared.group_columns[at]: len({group[at] for group in own}) for at in telling_apart(own)}
    seeds = max((len(compared.values[group]) for group in own), default=0)
    parts = [counted(count, column) for column, count in levels.items() if count > 1 or column == "model"]
    lines = [" x ".join([*parts, counted(seeds, "seed")])]
    names = list(dict.fromkeys(str(world["name"]) for world in worlds))
    if len(names) == 1:
        by_size = {key: {world.get(key) for world in worlds} for key in _SIZES}
        sizes = [f"{values.pop()} {key}" for key, values in by_size.items() if len(values) == 1 and None not in values]
        lines.append(f"world {names[0]}" + (f" ({', '.join(sizes)})" if sizes else ""))
    else:
        lines.append(f"worlds {joined(names)}")
    if claims:
        lines.append(DECLARED if DECLARED in claims else EXPLORATORY)
    return ", ".join(lines)


def on_new_seeds(
    asked: Sequence[Sequence[str]], seeds: Collection[int], measures: Sequence[str], pairs: int, alpha: float
) -> str:
    """Return the `foundry preregister` command that declares measures and repeats a sweep's settings with new seeds."""
    values: dict[str, list[str]] = {}
    for overrides in asked:
        for override in overrides:
            key, _, value = override.partition("=")
            if key not in _LEFT_OUT and value not in values.setdefault(key, []):
                values[key].append(value)
    count = new_seeds(len(seeds), pairs, alpha)
    first = max(seeds) + 1
    values.pop("-m", None)
    settings = [key if own == [""] else f"{key}={','.join(own)}" for key, own in values.items()]
    families = [part for measure in measures for part in ("--family", measure)]
    return shlex.join(["foundry", "preregister", "-m", *settings, f"seed={first}-{first + count - 1}", *families])


def new_seeds(seeds: int, pairs: int, alpha: float) -> int:
    """Return how many new seeds to run: as many as before, or more if tests of this number of pairs need more."""
    return max(seeds, fewest_pairs(alpha / max(pairs, 1)) or 0)


def telling_apart(rows: Sequence[Sequence[str]]) -> list[int]:
    """Return indices of columns in which no two different rows are equal: 0, and as few others as possible."""
    columns = list(range(len(rows[0]))) if rows else []
    for column in columns[:0:-1]:
        others = [at for at in columns if at != column]
        if len({tuple(row[at] for at in others) for row in rows}) == len(set(map(tuple, rows))):
            columns = others
    return columns


def short_contexts(contexts: Iterable[str]) -> dict[str, str]:
    """Shorten contexts to the settings in which they differ, such as `world=office, prompt=office` to `office`."""
    parts = {context: tuple(context.split(", ")) for context in dict.fromkeys(contexts)}
    if len(set(map(len, parts.values()))) > 1:
        return {context: context for context in parts}
    columns = telling_apart(list(parts.values()))
    return {context: ", ".join(own[at].partition("=")[2] for at in columns) for context, own in parts.items()}
