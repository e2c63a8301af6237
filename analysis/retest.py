"""Test-retest consistency: whether a model gives the same answer when it gets a prompt again.

This consistency describes the model, not the world. A sweep measures it if several runs differ only in `sampling_seed`.
Runs with different sampling seeds have equal prompts until their answers differ; later prompts may be equal again.
Prompts are equal if the log of calls has the same text and images for them. The consistency is therefore measured in
prompts that happened to repeat, most of them early in the runs.
"""

import hashlib
import json
import math
from collections import defaultdict
from collections.abc import Collection, Iterable, Iterator, Mapping, Sequence
from typing import Any

import msgspec
import numpy as np
import pandas as pd

from analysis.agreement import fleiss_kappa, pairwise_agreement
from analysis.any.general import choices, general_run
from analysis.arrays import IntArray
from analysis.form import Decisions
from analysis.load import further_factors, identity, measurable
from foundry.storing.matching import numbered, place_of
from foundry.storing.store import RunFolder, SweepFolder, without_servers


def retest(sweeps: Iterable[SweepFolder], runs: Collection[str] | None = None) -> pd.DataFrame:
    """Return the consistency of models over runs that differ only in `sampling_seed`.

    The table has a row per condition, seed and kind of call (`action` and `message` in 2D worlds, `move` in 3D ones).
    The first columns identify the runs, as in the table of signatures. An action is to stay or to go in a direction. A
    message only counts as sent or not sent, and a move only as its kind of command. In other worlds, the choices are
    the actions. A state is a prompt that one agent got at one step in at least two runs.

    - runs: number of compared runs. prompts: number of states. decisions: number of choices in these states.
    - agreement: share of equal pairs among the choices in a state, mean over the states; 0..1.
    - kappa: Fleiss' kappa over the states, -1..1: agreement beyond that of choices drawn from all states together.
      NaN if only one choice ever occurs.

    An unreadable reply counts as a separate choice; the columns that end in `_readable` leave it out. If no prompt
    repeats, all columns but the counts are NaN. The table has no rows if no runs differ only in `sampling_seed`.

    Args:
        sweeps: the sweeps.
        runs: ids of the runs to include; None for all.

    Source: Fleiss 1971.
    """
    folders = [folder for sweep in sweeps for folder in sweep.runs() if runs is None or folder.id in runs]
    groups: dict[str, list[RunFolder]] = defaultdict(list)
    for folder in folders:
        groups[_group_of(folder)].append(folder)
    rows = [row for group in groups.values() for row in _rows(group)]
    return pd.DataFrame(rows)


def _group_of(folder: RunFolder) -> str:
    config = folder.config()
    parts = {name: config[name] for name in ("world", "prompt", "seed")} | {"model": without_servers(config["model"])}
    return json.dumps(parts, sort_keys=True, default=str)


def _rows(group: Sequence[RunFolder]) -> Iterator[dict[str, Any]]:
    if len({folder.config()["sampling_seed"] for folder in group}) < 2:
        return
    codes: dict[str, int] = {}
    decisions = ((folder, _decisions(folder, codes)) for folder in group)
    # Runs whose calls have equal seeds have equal answers, so only one of them counts.
    complete = {folder.calls_seed: (folder, decided) for folder, decided in decisions if decided is not None}
    if len(complete) < 2:
        return
    folders, made = zip(*complete.values(), strict=True)
    first = folders[0]
    known = {**identity(first), **further_factors(first)}
    keys = {name: known[name] for name in known if name not in ("run", "status", "sampling_seed")}
    states = _states(folders)
    for kind in made[0]:
        mine = states.get(kind, {})
        every = counted(mine, [kinds[kind] for kinds in made], readable_only=False)
        readable = counted(mine, [kinds[kind] for kinds in made], readable_only=True)
        yield {**keys, "kind": kind, "runs": len(made), **summary(every), **_suffixed(summary(readable))}


def _decisions(folder: RunFolder, codes: dict[str, int]) -> Mapping[str, Decisions] | None:
    """Return the decisions of a run by kind of call; None if the run is not complete.

    `codes` numbers the choices; choices that it lacks are added to it.
    """
    whole = measurable(folder, folder.summary())
    if whole is None:
        return None
    form = whole.form
    return form.decided(whole.run) if form.decided else choices(general_run(folder, whole.records), codes)


State = tuple[int, int, int, bytes]
"""A state: step, agent, number of earlier questions of the kind in the step, and hash of the prompt."""


def _states(folders: Sequence[RunFolder]) -> dict[str, dict[State, list[int]]]:
    """Return for each kind of call the states that occur in at least two runs, with the indices of these runs."""
    by_state: dict[str, dict[State, list[int]]] = defaultdict(lambda: defaultdict(list))
    for index, folder in enumerate(folders):
        for ((step, agent, kind), again), call in numbered(folder.calls(), place_of):
            prompt = hashlib.blake2b(msgspec.json.encode(call.messages), digest_size=16).digest()
            by_state[kind][step, agent, again, prompt].append(index)
    return {kind: {state: runs for state, runs in states.items() if len(runs) > 1} for kind, states in by_state.items()}


def counted(states: Mapping[State, Sequence[int]], made: Sequence[Decisions], *, readable_only: bool) -> IntArray:
    """Count the choices in each state, (states, choices).

    The last column counts unreadable replies. `readable_only` sets it to 0. States with fewer than two choices are
    left out.
    """
    unread = 1 + max((int(decisions.choice.max(initial=0)) for decisions in made), default=0)
    counts = np.zeros((len(states), unread + 1), dtype=np.int64)
    for row, ((step, agent, again, _), runs) in enumerate(states.items()):
        for decisions in (made[index] for index in runs):
            place = (step - 1, agent, again)[: decisions.choice.ndim]
            counts[row, decisions.choice[place] if decisions.readable[place] else unread] += 1
    if readable_only:
        counts[:, unread] = 0
    return np.asarray(counts[counts.sum(axis=1) > 1])


def summary(counts: IntArray) -> dict[str, float]:
    """Return the measures of consistency.

    Args:
        counts: how often each choice was made in each state, (states, choices).
    """
    return {
        "prompts": float(len(counts)),
        "decisions": float(counts.sum()),
        "agreement": pairwise_agreement(counts),
        "kappa": fleiss_kappa(counts) if len(counts) else math.nan,
    }


def _suffixed(figures: Mapping[str, float]) -> dict[str, float]:
    return {f"{name}_readable": value for name, value in figures.items()}
