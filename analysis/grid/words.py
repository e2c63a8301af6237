"""What is said of runs of 2D worlds: who labelled their messages, and what unread replies come to."""

from __future__ import annotations

from collections.abc import Iterable, Sequence

import pandas as pd

from analysis.form import Words
from analysis.labelling import Labelling
from analysis.prose import joined

_SIGNATURE = "warning"
_UNLABELLED, _MESSAGES = f"{_SIGNATURE}.n_unlabelled", f"{_SIGNATURE}.n_messages"


def _notes(runs: pd.DataFrame, labellings: Sequence[Labelling]) -> list[str]:
    """Return who said which messages were warnings, how well that agrees with readers, and how many have no label."""
    if _UNLABELLED not in runs:
        return []
    missing, said = (int(runs[name].sum()) for name in (_UNLABELLED, _MESSAGES))
    why = " or ".join(dict.fromkeys(one.unlabelled for one in labellings))
    notes = [f"{missing} of {said} messages have no label ({why}); what depends on them is missing"] if missing else []
    return [*dict.fromkeys(labelling.brief() for labelling in labellings), *notes]


def _held_against_readers(labellings: Iterable[Labelling]) -> list[str]:
    return list(dict.fromkeys(one.note() for one in labellings))


def _methods(labellings: Sequence[Labelling]) -> list[str]:
    labellers = joined(dict.fromkeys(one.labeller for one in labellings))
    return [f"Messages were labelled as warnings or not by {labellers}."]


def _limits(labellings: Sequence[Labelling]) -> list[str]:
    notes = " ".join(f"{note[0].upper()}{note[1:]}." for note in _held_against_readers(labellings))
    return [f"The warnings of these runs were labelled by no reader. {notes}"]


def _doubts(labellings: Sequence[Labelling]) -> dict[str, str]:
    doubts = list(dict.fromkeys(filter(None, (labelling.doubt() for labelling in labellings))))
    return {_SIGNATURE: joined(doubts)} if doubts else {}


WORDS = Words(
    unread="count as staying, which shows in idle rate, stability, clustering and exploration",
    unread_decision="and left the agent where it was",
    notes=_notes,
    methods=_methods,
    limits=_limits,
    doubts=_doubts,
)
