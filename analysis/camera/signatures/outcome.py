"""Outcome: how many of a model's replies could be used."""

from __future__ import annotations

from analysis.any.signatures.outcome import MEASURES as ALL
from analysis.any.signatures.outcome import outcome_shares
from analysis.camera.run import CameraRun

NAME = "outcome"

READABLE_TOO = False

MEASURES = {name: one for name, one in ALL.items() if not name.startswith("message_")}

HEADLINE = ("readable", "repaired")


def measure(run: CameraRun) -> dict[str, float]:
    """Return the outcomes of a run's calls: the same measures, without those of messages, which nobody sends.

    All are NaN without decisions. Denominator: n_decisions.
    """
    return {**outcome_shares(run.outcome), "n_decisions": float(run.decisions)}
