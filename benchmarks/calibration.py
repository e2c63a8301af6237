"""Measures what the statistics promise, on simulated runs whose truth is known: `python benchmarks/calibration.py`."""

import itertools
import math
import sys
import tempfile
from collections.abc import Callable
from pathlib import Path
from typing import TypeAlias

import numpy as np
from measuring import Stopwatch, print_table, print_title
from scipy.special import stdtr
from simulated_runs import CASES, PAIRED_CASES, coverage, false_positives

from analysis import analyze
from analysis.stats.contrasts import ALPHA, contrasts
from analysis.stats.equivalence import equivalence_p
from analysis.stats.fingerprint import swap_p
from analysis.stats.max_t import over_pairs, step_down_p
from analysis.stats.sequential import levels, sequential_p
from analysis.stats.sign_flip import sign_flip_p
from analysis.stats.stopping import error_of
from analysis.stats.testing import holm
from analysis.tables.signature_table import SignatureTable
from foundry.cli import run

SIZES = (5, 10, 20)
PAIRED_SIZES = (6, 8, 10, 12, 20)
DATA_SETS, PAIRED_DATA_SETS = 6_000, 3_000
TABLES = 1_000
EQUIVALENT_WITHIN = 0.1
LOOKS = (8, 12, 18, 26, 34)
COMPARISONS, EQUIVALENCES = 4_000, 2_000
MEASURES, DIFFERENT, FAMILIES = 11, 4, 300
COPIES = 100


def other_shapes(rng: np.random.Generator, shape: tuple[int, ...]) -> np.ndarray:
    """Return models of equal means, the first of which is normal and the others lognormal."""
    values = rng.lognormal(size=shape)
    values[0] = math.exp(0.5) + rng.normal(size=shape[1:])
    return values


NOISE = {
    "normal": lambda rng, shape: rng.normal(size=shape),
    "lognormal": lambda rng, shape: rng.lognormal(size=shape),
    "path efficiency": CASES[4].draw,
    "outcome 0 or 1": lambda rng, shape: (rng.random(shape) < 0.7).astype(float),
    "equal means, other shapes": other_shapes,
}
Draw: TypeAlias = Callable[[np.random.Generator, tuple[int, ...]], np.ndarray]
FAMILY_NOISE: dict[str, Draw] = {
    "normal": lambda rng, shape: rng.normal(size=shape),
    "lognormal": lambda rng, shape: rng.lognormal(size=shape),
    "half zero": lambda rng, shape: np.where(rng.random(shape) < 0.5, 0.0, rng.normal(size=shape)),
    "ties": lambda rng, shape: rng.integers(0, 4, size=shape).astype(float),
}
DIFFERENCES = {
    "normal": lambda rng, shape: rng.normal(size=shape),
    "lognormal, of two models": lambda rng, shape: rng.lognormal(size=shape) - rng.lognormal(size=shape),
    "path efficiency": PAIRED_CASES[-1].draw,
}
"""Differences whose mean is 0, in each seed."""
SMALL: dict[str, Callable[[np.random.Generator, tuple[int, ...], float], np.ndarray]] = {
    "one seed in ten fails": lambda rng, shape, mean: (rng.random(shape) < mean).astype(float),
    "normal, sd .05": lambda rng, shape, mean: np.clip(rng.normal(mean, 0.05, size=shape), mean - 0.2, mean + 0.2),
    "half zero": lambda rng, shape, mean: (rng.random(shape) < 0.5) * rng.uniform(mean, 3 * mean, size=shape),
}
"""Differences of a mean, by what they are like."""
UNSHARED = {"outcome 0 or 1"}
"""Noise that an effect of the seed would make something else of."""


def intervals() -> None:
    print_title("Coverage of the 95 % intervals in use", f"{DATA_SETS:,} data sets; error of a figure .003 to .005.")
    rows = []
    for case in CASES:
        found = [coverage(case, n, DATA_SETS, np.random.default_rng(n)) for n in SIZES]
        rows.append(
            [case.name, *(f"{one['covered']:.3f}" for one in found), *(f"{one['bootstrap']:.0%}" for one in found)]
        )
    heads = [f"n = {n}" for n in SIZES]
    print_table(["values", *heads, *(f"bootstrap-t, {head}" for head in heads)], rows)


def paired_intervals() -> None:
    print_title(
        "Coverage of 95 % intervals of a paired difference: by sign flips / by t and bootstrap-t, as of one mean",
        f"{PAIRED_DATA_SETS:,} data sets; error of a figure .004 to .006.",
    )
    rows = []
    for case in PAIRED_CASES:
        figures = [case.name]
        for n in PAIRED_SIZES:
            by_kind = [
                coverage(case, n, PAIRED_DATA_SETS, np.random.default_rng(n), beside_sign_flips=beside)["covered"]
                for beside in (True, False)
            ]
            figures.append(" / ".join(f"{covered:.3f}" for covered in by_kind))
        rows.append(figures)
    print_table(["differences", *(f"n = {n}" for n in PAIRED_SIZES)], rows)


def tests() -> None:
    print_title(
        "False positives of the whole comparison, nothing differs",
        f"{TABLES:,} tables of 3 models x 4 measures, a family of 12 tests; error of the last column .007.",
    )
    rows = []
    for name, draw in NOISE.items():
        for seeds in (6, 10, 20):
            shared = 0.0 if name in UNSHARED else 1.0
            found = false_positives(draw, np.random.default_rng(seeds), tables=TABLES, seeds=seeds, shared=shared)
            rows.append([name, seeds, f"{found.tests:,}", f"{found.alone:.3f}", f"{found.any_in_family:.3f}"])
    print_table(["noise", "seeds", "tests", "p <= .05", "family with any after the correction"], rows)


def families() -> None:
    print_title(
        f"Families of {MEASURES} correlated measures, of which the last model differs in {DIFFERENT} or in none",
        f"{FAMILIES} tables a row, exploratory; error of a false claim .013. Beside: Holm over all tests.",
    )
    rows = []
    for models, seeds in itertools.product((2, 3, 5), (6, 8, 10, 12, 16)):
        for (name, draw), effect in itertools.product(FAMILY_NOISE.items(), (0.0, 1.5)):
            found = _claims(draw, models, seeds, effect)
            shares = [f"{share:.3f}" if share >= 0 else "" for share in found]
            rows.append([models, seeds, name, f"{effect:g}", *shares])
    print_table(["models", "seeds", "noise", "sd", "false", "found", "false, Holm over all", "found"], rows)


def _claims(draw: Draw, models: int, seeds: int, effect: float) -> list[float]:
    """Return the share of tables with a false claim and that of true differences found, then the same by Holm alone."""
    rng = np.random.default_rng([models, seeds])
    pairs = list(itertools.combinations(range(models), 2))
    is_true = np.array([[second == models - 1 and m < DIFFERENT for m in range(MEASURES)] for _, second in pairs])
    is_true = (is_true & (effect > 0)).ravel()
    spread, counts = draw(np.random.default_rng(0), (10_000,)).std(), np.zeros((2, 2))
    for _ in range(FAMILIES):
        noise = draw(rng, (models, seeds, MEASURES + 1))
        values = (noise[..., :1] + noise[..., 1:]) / math.sqrt(2)  # correlated by .5
        values[-1, :, :DIFFERENT] += effect * math.sqrt(2) * spread  # in units of the sd of paired differences
        differences = [(values[second] - values[first]).T for first, second in pairs]
        inside = np.concatenate([step_down_p(one) for one in differences])
        ours = over_pairs(inside, np.repeat(np.arange(len(pairs)), MEASURES))
        for row, p in zip(counts, (ours, holm(sign_flip_p(np.concatenate(differences)))), strict=True):
            row += (p[~is_true] <= ALPHA).any(), (p[is_true] <= ALPHA).mean() if is_true.any() else -1.0
    return (counts / FAMILIES).ravel().tolist()


def copies() -> None:
    """Play one model again and again, and compare its runs with one another as if they were of several models."""
    print_title(
        "Claims between copies of one model, from the sweep to the summary",
        f"{COPIES} sweeps a row of +sweep=first with scripted/random; error .02.",
    )
    rows = []
    with tempfile.TemporaryDirectory() as folder:
        seeds = COPIES * 3 * 10
        run(
            [
                "+sweep=first",
                "model=scripted/random",
                f"seed=0-{seeds - 1}",
                f"output.dir={folder}/out",
                "analyze=false",
            ]
        )
        played = analyze(Path(folder) / "out", plots=False).table
    for models, each in itertools.product((2, 3), (8, 10)):
        claims = [_copies(played, start, models, each) for start in range(0, COPIES * models * each, models * each)]
        rows.append([models, each, f"{np.mean(claims):.2f}"])
    print_table(["copies", "seeds", "any claim"], rows)


def _copies(played: SignatureTable, start: int, models: int, each: int) -> bool:
    """Return whether anything is claimed between runs of one model that are taken for several models'."""
    seed = played.frame["seed"].to_numpy() - start
    own = (seed >= 0) & (seed < models * each)
    frame = played.frame[own].reset_index(drop=True)
    place = seed[own]
    frame = frame.assign(model=[f"copy {number}" for number in place // each], seed=place % each)
    present = tuple(names for names, is_own in zip(played.present, own, strict=True) if is_own)
    return bool(contrasts(SignatureTable(frame, (), played.measures, present))["significant"].any())


def equivalence() -> None:
    print_title(
        "Two conditions said to be the same within 0.1 of a range of 1, at a true difference of the margin, and of 0",
        f"{EQUIVALENCES:,} contrasts a row; error .005 to .011. Beside: with a declared widest difference of 0.3.",
    )
    rows = []
    for (name, draw), mean in itertools.product(SMALL.items(), (EQUIVALENT_WITHIN, 0.0)):
        for seeds in (6, 10, 20, 29, 40):
            differences = draw(np.random.default_rng(seeds), (EQUIVALENCES, seeds), mean)
            shares = [
                np.mean([equivalence_p(row, EQUIVALENT_WITHIN, widest) <= ALPHA for row in differences])
                for widest in (1.0, 0.3)
                if np.abs(differences).max() <= widest
            ]
            rows.append([name, f"{mean:g}", seeds, *(f"{share:.3f}" for share in shares), *[""] * (2 - len(shares))])
    print_table(["differences", "true mean", "seeds", "said to be the same", "with 0.3 declared"], rows)


def fingerprints() -> None:
    print_title("Energy test of whole fingerprints, 8 measures", f"{TABLES:,} pairs of models; error .007.")
    rows = []
    for shift in (0.0, 0.5):
        for seeds in (6, 10, 20):
            rng = np.random.default_rng(seeds)
            found = [_energy_p(rng, seeds, shift) for _ in range(TABLES)]
            rows.append([f"{shift:g} sd in every measure", seeds, f"{np.mean(np.array(found) <= 0.05):.3f}"])
    print_table(["true difference", "seeds", "p <= .05"], rows)


def _energy_p(rng: np.random.Generator, seeds: int, shift: float) -> float:
    shared = rng.normal(size=(seeds, 8)) * math.sqrt(0.5)
    first, second = (shared + rng.normal(size=(seeds, 8)) * math.sqrt(0.5) for _ in range(2))
    return swap_p(first, second + shift)


def looks() -> None:
    shown = ", ".join(map(str, LOOKS))
    print_title(
        f"Declared looks at {shown} seeds", f"{COMPARISONS:,} comparisons a row; error of a share .003 to .008."
    )
    rows = []
    for name, draw in DIFFERENCES.items():
        for effect in (0.0, 0.5, 0.8, 1.0, 1.5) if name == "normal" else (0.0,):
            differences = draw(np.random.default_rng(LOOKS[-1]), (COMPARISONS, LOOKS[-1])) + effect
            for test, p_of in (("sign-flip", sign_flip_p), ("t", student_p)):
                found, seeds = _at_looks(np.array([p_of(differences[:, :n]) for n in LOOKS]))
                fixed = (p_of(differences) <= ALPHA).mean()
                rows.append([name, f"{effect:g}", test, f"{found:.3f}", f"{seeds:.1f}", f"{fixed:.3f}"])
    print_table(
        ["differences", "true, in sd", "test", "found", "seeds on average", f"found at {LOOKS[-1]} alone"], rows
    )


def families_at_looks() -> None:
    print_title(
        "False claims of a declared family at those looks, max-T in each pair and Holm over pairs",
        f"{TABLES:,} sweeps of 3 models x 2 measures, 6 tests, sign-flip; error .007.",
    )
    rows = []
    for shift in (0.0, 0.5, 1.0):
        values = np.random.default_rng(6).normal(size=(3, TABLES, LOOKS[-1], 2))
        values[2] += shift
        pairs = np.stack([values[1] - values[0], values[2] - values[0], values[2] - values[1]])
        corrected = np.array([[[step_down_p(one[:n].T) for one in pair] for pair in pairs] for n in LOOKS])
        p = sequential_p(LOOKS, corrected.reshape(len(LOOKS), -1)).reshape(3, TABLES, 2)
        claims = np.array([over_pairs(one.ravel(), np.repeat(np.arange(3), 2)) <= ALPHA for one in p.swapaxes(0, 1)])
        false = claims if shift == 0 else claims[:, :2]
        rows.append([f"{shift:g}", f"{false.any(axis=1).mean():.3f}", f"{claims.mean():.3f}"])
    print_table(["third model differs by", "any false claim", "share of tests claimed"], rows)


def undeclared_looks() -> None:
    print_title("Looks that nobody declared, each at .05", "20,000 comparisons a row, t; error .003.")
    drawn = np.random.default_rng(60).normal(size=(20_000, 60))
    cases = {"6 to 60, every seed": tuple(range(6, 61)), "10, 20, 30, 40": (10, 20, 30, 40), "8, 12, 18": (8, 12, 18)}
    rows = []
    for name, sizes in cases.items():
        found = np.array([student_p(drawn[:, :n]) <= ALPHA for n in sizes]).any(axis=0).mean()
        rows.append([name, f"{found:.3f}", f"{error_of(sizes, ALPHA):.3f}"])
    print_table(["looks at", "significant at any", "as the note says"], rows)


def student_p(differences: np.ndarray) -> np.ndarray:
    n = differences.shape[1]
    t = differences.mean(axis=1) / differences.std(axis=1, ddof=1) * math.sqrt(n)
    return 2 * stdtr(n - 1, -np.abs(t))


def _at_looks(p: np.ndarray) -> tuple[float, float]:
    found = p <= levels(LOOKS, np.array([ALPHA]))
    ended = np.where(found.any(axis=0), np.array(LOOKS)[found.argmax(axis=0)], LOOKS[-1])
    return float(found.any(axis=0).mean()), float(ended.mean())


if __name__ == "__main__":
    watch = Stopwatch()
    looks()
    families_at_looks()
    undeclared_looks()
    intervals()
    paired_intervals()
    tests()
    families()
    copies()
    equivalence()
    fingerprints()
    print(f"{watch.cost().wall_s:.0f} s in all", file=sys.stderr)
