"""The effect of an edit on how often each choice is made: its share with the edit minus its share without."""

from typing import Any

import numpy as np
import pandas as pd

from analysis.arrays import FloatArray
from analysis.probes.choices import Answers, Chosen, MomentKey
from analysis.probes.comparing import by_seed
from analysis.probes.probe_declaring import EVERYTHING, Family
from analysis.stats.intervals import estimate
from analysis.stats.sign_flip import sign_flip_p
from analysis.stats.testing import p_of_row

COLUMNS = (
    "model", "edit", "leaves", "kind", "choice", "moments", "seeds", "before", "after", "change", "low", "high", "p",
)  # fmt: skip


def changes_of(answers: Answers, declared: Family = EVERYTHING) -> pd.DataFrame:
    """Return a table with the effect of each edit on the share of each choice, over the moments that it changes.

    For an edit of the kind `equivariance`, `before` is the share expected after the edit. p is corrected over the
    declared rows; other rows have no `p_holm`.
    """
    rows = []
    for subject, change in answers.edited():
        about = {"model": answers.names[subject], "edit": change.name, "leaves": change.leaves}
        rows += [about | row for row in _rows(answers.expected(subject, change), answers.of(subject, change.name))]
    frame = pd.DataFrame(rows, columns=list(COLUMNS)).assign(p_holm=np.nan)
    declared.correct(frame)
    return frame


def _rows(before: Chosen, after: Chosen) -> list[dict[str, Any]]:
    keys = sorted(before.keys() & after.keys())
    choices = sorted({(key.kind, choice) for key in keys for chosen in (before, after) for choice in chosen[key]})
    return [_row(before, after, [key for key in keys if key.kind == kind], kind, choice) for kind, choice in choices]


def _row(before: Chosen, after: Chosen, keys: list[MomentKey], kind: str, choice: str) -> dict[str, Any]:
    was, now = (_shares(chosen, keys, choice) for chosen in (before, after))
    change = now - was
    estimated = estimate(change, -1.0, 1.0, beside_sign_flips=True)
    p = p_of_row(sign_flip_p, change) if change.any() else np.nan
    return {"kind": kind, "choice": choice, "moments": len(keys), "seeds": estimated.n, "before": was.mean(),
            "after": now.mean(), "change": estimated.mean, "low": estimated.low, "high": estimated.high,
            "p": p}  # fmt: skip


def _shares(chosen: Chosen, keys: list[MomentKey], choice: str) -> FloatArray:
    return by_seed({key: chosen[key][choice] / chosen[key].total() for key in keys})
