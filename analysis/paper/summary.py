"""Writes the findings in at most twelve sentences: declared comparisons only, each with its limitations."""

from collections import Counter
from collections.abc import Mapping, Sequence

import pandas as pd

from analysis.findings.ranking import findings
from analysis.paper.sentence import DIFFERENT, NOTHING, SAME, SILENT, Row, Sides, kind_of, sentence, why_silent
from analysis.prose import group_label, joined
from analysis.stats.plan import DECLARED
from analysis.tables.comparison import Comparison
from foundry.texts import counted

MOST = 12
"""Maximum number of sentences in a summary."""
EXPLORES = "Nothing was declared before the runs, so all findings are exploratory."
HELD_NOT = "No comparison follows the preregistration, so all findings are exploratory."


def summary(
    contrasts: pd.DataFrame,
    compared: Comparison,
    *,
    planned: bool = False,
    filtered: str = "",
    doubts: Mapping[str, str] | None = None,
    sides: Sides | None = None,
) -> tuple[str, ...]:
    """Return sentences: doubts about signatures, then the filter of the runs, then one sentence for each finding."""
    lead = [f"No measure of {signature} can be trusted: {why}." for signature, why in (doubts or {}).items()]
    lead += [f"These findings are based on only a part of the runs: {filtered}."] if filtered else []
    known = Sides.of(contrasts, compared, {}) if sides is None else sides
    return summary_of(contrasts, known, _alone(compared), lead, planned=planned)


def summary_of(
    contrasts: pd.DataFrame, sides: Sides, alone: str, lead: Sequence[str], *, planned: bool
) -> tuple[str, ...]:
    """Return the sentences `lead`, then one sentence for each finding."""
    rows = contrasts[contrasts["headline"].astype(bool)]
    if rows.empty:
        return (*lead, alone)
    declared = rows["claim"] == DECLARED
    rows = rows[declared] if declared.any() else rows
    if not declared.any():
        lead = [*lead, HELD_NOT if planned else EXPLORES]
    return (*lead, *_sentences(rows, sides, MOST - len(lead)))


def _alone(compared: Comparison) -> str:
    own = [group_label(group) for group in compared.groups if group not in compared.baselines]
    if len(own) == 1:
        return f"Nothing is compared, because {own[0]} is the only group. Differences from baselines are not tested."
    return "Nothing is compared: no two groups differ in only one setting and share a declared measure."


def _sentences(rows: pd.DataFrame, sides: Sides, most: int) -> list[str]:
    """Return a sentence for each finding, then for each other row, but at most `most` sentences.

    If sentences are left out, the last sentence says how many.
    """
    every = rows.sort_values("p_adjusted", kind="stable").to_dict("records")
    by_kind = {kind: [row for row in every if kind_of(row) == kind] for kind in (DIFFERENT, SAME, NOTHING, SILENT)}
    different = [finding for finding in findings(every) if finding.differs]
    sentences = [finding.sentence(sides) for finding in different]
    sentences += [sentence(row, sides) for kind in (SAME, NOTHING) for row in by_kind[kind]]
    silent = _silent(by_kind[SILENT], sides)
    if len(sentences) + len(silent) <= most:
        return [*sentences, *silent]
    shown = sentences[: most - 1]
    # A finding also covers its other pairs.
    left = {"finding": len(different) - len(shown)} if len(shown) < len(different) else {}
    others = [*by_kind[SAME], *by_kind[NOTHING]][max(0, len(shown) - len(different)) :]
    kinds = Counter(map(kind_of, [*others, *by_kind[SILENT]]))
    counts = joined(
        [*(counted(count, name) for name, count in left.items()), *(f"{count} {name}" for name, count in kinds.items())]
    )
    return [*shown, f"Further comparisons are in contrasts.md: {counts}."]


def _silent(rows: Sequence[Row], sides: Sides) -> list[str]:
    if not rows:
        return []
    if len(rows) == 1:
        return [sentence(rows[0], sides)]
    counts = Counter(map(why_silent, rows))
    why = joined(f"{count} because {why}" if len(counts) > 1 else f"because {why}" for why, count in counts.items())
    return [f"{len(rows)} comparisons could not be decided, {why}."]
