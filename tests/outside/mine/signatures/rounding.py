"""Rounding: how often agents come past the first place."""

from forms.ring import RingRun

from analysis.formulas import mean
from analysis.measure import share

NAME = "rounding"

MEASURES = {"home": share("Steps that end in the first place (share)")}

HEADLINE = ("home",)


def measure(run: RingRun) -> dict[str, float]:
    """Return how often the first place is come to.

    - home: steps that end in the first place / steps; 0..1.

    NaN without decisions. Denominator: n_decisions.
    """
    found = (run.place_next == 0)[run.counted]
    return {"home": mean(found), "n_decisions": float(len(found))}
