"""Measures what the tables of a probe promise where nothing differs: `python benchmarks/probe_calibration.py`.

Copies of one simulated policy are asked in the same moments under other names, under an edit, in formats and at values
of a quantity that it does not read, each time with draws of its own.
"""

import itertools
import sys
from collections import Counter
from collections.abc import Callable, Sequence

import numpy as np
from measuring import Stopwatch, print_table, print_title

from analysis.probes.choices import Answers, Asked, Change, Chosen, MomentKey, Subject
from analysis.probes.comparing import Compared
from analysis.probes.curves import curve_tables
from analysis.probes.formats import format_tables
from analysis.stats.sign_flip import upper_sign_flip_p
from analysis.stats.testing import holm

CHOICES = ("up", "down", "left", "right", "stay")
POLICIES = {"even": 50.0, "leaning": 0.5, "nearly settled": 0.1}
"""Concentration of the chances of each moment, a Dirichlet distribution."""
SEEDS, MOMENTS, REPEATS = (6, 10, 20), 8, 6
COPIES = 3
DATA_SETS, TABLES = 600, 100
VALUES = (1.0, 2.0, 3.0, 4.0)
FORMATS = ("none", "spread/0", "spread/1", "spread/2")

Ask = Callable[[], Chosen]


def policy(rng: np.random.Generator, seeds: int, concentration: float) -> Ask:
    """Return what asks a policy anew in the moments of a data set."""
    keys = [MomentKey(seed, "run", step, 0, "action", 0) for seed in range(seeds) for step in range(MOMENTS)]
    chances = rng.dirichlet(np.full(len(CHOICES), concentration), size=len(keys))

    def ask() -> Chosen:
        counts = rng.multinomial(REPEATS, chances)
        return {
            key: Counter(dict(zip(CHOICES, row, strict=True))) for key, row in zip(keys, counts.tolist(), strict=True)
        }

    return ask


def excess_p(first: Chosen, second: Chosen) -> float:
    """Return p of the excess of two sets of choices, as in the tables `agreement` and `edits`."""
    return float(upper_sign_flip_p(Compared.of(first, second, "").excesses()[None, :])[0])


def pairs(rng: np.random.Generator, seeds: int, concentration: float) -> list[float]:
    """Return p of each pair of copies."""
    ask = policy(rng, seeds, concentration)
    return [excess_p(*pair) for pair in itertools.combinations([ask() for _ in range(COPIES)], 2)]


def answers(ask: Ask, edits: Sequence[Change], formats: Sequence[str]) -> Answers:
    """Return what one model answers under edits, in formats."""
    subject = Subject("copy", "p", "")
    chosen = {Asked(subject, edit.name, one): ask() for edit in edits for one in formats}
    return Answers(chosen, {edit.name: edit for edit in edits}, tuple(formats), {subject: "copy"}, 0)


def format_p(rng: np.random.Generator, seeds: int, concentration: float) -> list[float]:
    """Return p of each row of the table `formats`."""
    unedited = [Change("none", "invariance")]
    return list(format_tables(answers(policy(rng, seeds, concentration), unedited, FORMATS))[0]["p"])


def slope_p(rng: np.random.Generator, seeds: int, concentration: float) -> list[float]:
    """Return p of each row of the table `steepness`."""
    moves = [Change(f"x={value}", "cause", moves="x", to=value) for value in VALUES]
    return list(curve_tables(answers(policy(rng, seeds, concentration), moves, ["none"]))[1]["p"])


def rates(found: Sequence[Sequence[float]]) -> list[str]:
    """Return the share of tests with p <= .05, and of families with any after Holm, each with its error."""
    alone = np.array([p <= 0.05 for family in found for p in family])
    any_of = np.array([(holm(np.array(family)) <= 0.05).any() for family in found])
    by_family = np.array([np.mean(np.array(family) <= 0.05) for family in found])
    error = by_family.std(ddof=1) / np.sqrt(len(found))
    return [f"{alone.mean():.3f} ± {error:.3f}", f"{any_of.mean():.3f} ± {any_of.std() / np.sqrt(len(found)):.3f}"]


def main() -> None:
    print_title(
        "False positives of a probe where nothing differs",
        f"{COPIES} copies; {MOMENTS} moments a seed, {REPEATS} repeats, {len(CHOICES)} choices; {DATA_SETS} data sets "
        f"of copies, {TABLES} of formats and of quantities; ± is the standard error.",
    )
    rows = []
    for (name, concentration), seeds in itertools.product(POLICIES.items(), SEEDS):
        rng = np.random.default_rng(seeds)
        rows.append([name, seeds])
        for measured, times in ((pairs, DATA_SETS), (format_p, TABLES), (slope_p, TABLES)):
            rows[-1] += rates([measured(rng, seeds, concentration) for _ in range(times)])
    heads = [
        f"{what}, {how}" for what in ("copies or edits", "formats", "slopes") for how in ("p <= .05", "any (Holm)")
    ]
    print_table(["policy", "seeds", *heads], rows)


if __name__ == "__main__":
    watch = Stopwatch()
    main()
    print(f"{watch.cost().wall_s:.0f} s in all", file=sys.stderr)
