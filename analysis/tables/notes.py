"""Writes notes that warn readers of the tables."""

from collections import Counter
from collections.abc import Iterable, Iterator, Mapping, Sequence
from itertools import combinations

import pandas as pd

from analysis.form import FormAnalysis
from analysis.labelling import Labelling
from analysis.lines import COMPLETE
from analysis.prose import group_label, joined
from analysis.signatures import FAILURE_RATE
from analysis.stats.family import NO_BEHAVIOUR
from analysis.stats.intervals import FEWEST_FOR_CLAIMS
from analysis.stats.plan import DECLARED, EXPLORATORY
from analysis.stats.values import Group
from analysis.tables.comparison import Comparison
from analysis.tables.signature_table import SignatureTable
from foundry.canary import Canary, Verdict

_READABLE = "outcome.readable"
_FAILURE = FAILURE_RATE.partition(".")[0]
_READABLE_ENOUGH = 0.95


def notes_of(
    table: SignatureTable,
    compared: Comparison,
    differences: pd.DataFrame,
    forms: Mapping[Group, FormAnalysis],
    labellings: Sequence[Labelling],
) -> Iterator[str]:
    """Yield notes on incomplete runs, unreadable replies, repeated tests and worlds, one line each."""
    yield from _of_runs(table, compared, differences)
    yield from _copies(compared)
    yield from _unread(compared, forms)
    yield from _looks(differences)
    yield from _incomparable(table)
    by_name = {form.name: form for form in forms.values()}
    for form in by_name.values():
        yield from form.words.notes(table.frame, labellings)
    yield from _without_decisions(table)


def _of_runs(table: SignatureTable, compared: Comparison, differences: pd.DataFrame) -> list[str]:
    notes = []
    by_status = Counter(table.frame["status"])
    if by_status[COMPLETE] < len(table.frame):
        others = ", ".join(f"{count} {status}" for status, count in by_status.items() if status != COMPLETE)
        notes.append(f"{by_status[COMPLETE]} of {len(table.frame)} runs are complete; missing: {others}")
    is_compared = differences["headline"].any()
    if not is_compared and any(len(values) < FEWEST_FOR_CLAIMS for values in compared.values.values()):
        notes.append(f"fewer than {FEWEST_FOR_CLAIMS} seeds only describe these runs, so nothing is tested")
    return notes


def _incomparable(table: SignatureTable) -> list[str]:
    pairs = combinations(dict.fromkeys(table.questions), 2)
    apart = {
        name for questions, other in pairs if not questions.are_like(other) for name in (questions.world, other.world)
    }
    why = "general measures are not compared between worlds that ask different questions"
    return [f"{why}: {joined(sorted(apart))}"] if apart else []


def _unread(compared: Comparison, forms: Mapping[Group, FormAnalysis]) -> list[str]:
    notes = []
    for group, values in compared.values.items():
        readable = float(values[_READABLE].mean()) if _READABLE in values else 1.0
        if readable < _READABLE_ENOUGH:
            notes.append(
                f"{group_label(group)}: only {readable:.0%} of the action replies were readable; the others "
                f"{forms[group].words.unread}; foundry status shows examples"
            )
    return notes


def _copies(compared: Comparison) -> list[str]:
    """Return a note on groups whose seeds all have equal values, so that a test counts one run several times."""
    copied = []
    for group, values in compared.values.items():
        behaviour = [name for name in values.columns if name.partition(".")[0] not in (*NO_BEHAVIOUR, _FAILURE)]
        own = values[behaviour].dropna(how="all")
        if group not in compared.baselines and len(own) > 1 and (own.nunique(dropna=False) == 1).all():
            copied.append(group_label(group))
    why = "all seeds have equal values in every measure, so they show no more than one run"
    return [f"{joined(copied)}: {why}; with sampling_seed=null, each seed samples anew"] if copied else []


def doubtful_weights(canaries: Iterable[Sequence[Canary]]) -> list[str]:
    """Return a note on each model whose canary, in some runs, differed from the canary of its cached answers.

    Args:
        canaries: the canaries of each run.
    """
    differing: dict[str, list[str]] = {}
    runs: Counter[str] = Counter()
    for own in canaries:
        for canary in own:
            runs[canary.model] += 1
            if canary.verdict not in (None, Verdict.SAME):
                differing.setdefault(canary.model, []).append(f"canary {canary.verdict}: {canary.distance}")
    return [
        f"{model}: other weights, or another version of its server, may have answered {len(doubted)} of "
        f"{runs[model]} runs ({doubted[-1]})"
        for model, doubted in differing.items()
    ]


def unlike_published(validation: pd.DataFrame) -> list[str]:
    """Return notes on worlds that differ from their published versions."""
    pairs = zip(validation["world"], validation["differs"], strict=True)
    return [f"world {world} differs from the published world: {how}" for world, how in dict.fromkeys(pairs) if how]


def out_of_reach(differences: pd.DataFrame) -> list[str]:
    """Return a note on tests that have too few seeds to be significant."""
    tested = differences[differences["headline"].astype(bool) & differences["p"].notna()]
    notes = tested["out_of_reach"][tested["out_of_reach"] != ""]
    if notes.empty:
        return []
    which = "" if len(notes) == len(tested) else f"in {len(notes)} of {len(tested)} tests "
    declared = (tested["claim"] == DECLARED).any()
    advice = "a later look may" if declared else "run more seeds"
    return [f"{which}{notes.iloc[0]}: {advice}"]


def _looks(differences: pd.DataFrame) -> list[str]:
    rows = differences[differences["headline"].astype(bool) & (differences["claim"] == EXPLORATORY)]
    said = rows.sort_values("look")["note"].astype(str).str.extract(r"((?:\w+ )?undeclared look[^;]*)")
    looks = said[0].dropna()
    return [f"{looks.iloc[-1]}; foundry preregister declares looks before the runs"] if len(looks) else []


def _without_decisions(table: SignatureTable) -> list[str]:
    rows = zip(table.frame["world"], table.frame["status"], table.present, strict=True)
    worlds = dict.fromkeys(world for world, status, names in rows if status == COMPLETE and names == {FAILURE_RATE})
    return [f"world {world} recorded no decisions: its runs are listed, without signatures" for world in worlds]
