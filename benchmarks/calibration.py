"""Measures error rates, coverage and power of the statistics on simulated runs with a known truth.

    python benchmarks/calibration.py             sweeps
    python benchmarks/calibration.py --probes    false positives in the tables of a probe

For the tables of a probe, copies of one simulated policy are asked in the same moments under different names, under an
edit, in formats, and at values of a quantity that the policy ignores. Each copy makes its own random choices.
"""

import argparse
import itertools
import math
import sys
import tempfile
from collections import Counter
from collections.abc import Callable, Sequence
from pathlib import Path
from typing import TypeAlias

import numpy as np
from measuring import Stopwatch, print_table, print_title
from scipy.special import stdtr
from simulated_runs import CASES, PAIRED_CASES, coverage, false_positives

from analysis import analyze
from analysis.probes.choices import Answers, Change, Chosen, MomentKey, ProbeCondition, Subject
from analysis.probes.comparing import Compared
from analysis.probes.curves import curve_tables
from analysis.probes.formats import format_tables
from analysis.stats.contrasts import ALPHA, contrasts
from analysis.stats.equivalence import equivalence_p
from analysis.stats.fingerprint import swap_p
from analysis.stats.max_t import over_pairs, step_down_p
from analysis.stats.sequential import levels, sequential_p
from analysis.stats.sign_flip import sign_flip_p, upper_sign_flip_p
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
TESTED_SEEDS = (6, 10, 20)
CHOICES = ("up", "down", "left", "right", "stay")
POLICIES = {"even": 50.0, "leaning": 0.5, "nearly settled": 0.1}
"""Concentration of the Dirichlet distribution from which the probabilities of the choices in each moment come."""
MOMENTS, REPEATS = 8, 6
COPIES_IN_PROBE = 3
COPY_DATA_SETS, PROBE_TABLES = 600, 100
QUANTITY_VALUES = (1.0, 2.0, 3.0, 4.0)
FORMATS = ("none", "spread/0", "spread/1", "spread/2")


def other_shapes(rng: np.random.Generator, shape: tuple[int, ...]) -> np.ndarray:
    """Return values of models with equal means; the first model is normal, the others are lognormal."""
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
Ask: TypeAlias = Callable[[], Chosen]
"""Function that asks a policy anew in all moments of a data set."""
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
"""Differences in each seed; their mean is 0."""
SMALL: dict[str, Callable[[np.random.Generator, tuple[int, ...], float], np.ndarray]] = {
    "one seed in ten fails": lambda rng, shape, mean: (rng.random(shape) < mean).astype(float),
    "normal, sd .05": lambda rng, shape, mean: np.clip(rng.normal(mean, 0.05, size=shape), mean - 0.2, mean + 0.2),
    "half zero": lambda rng, shape, mean: (rng.random(shape) < 0.5) * rng.uniform(mean, 3 * mean, size=shape),
}
"""Differences with a given mean, by their distribution."""
UNSHARED = {"outcome 0 or 1"}
"""Noise to which no effect of the seed can be added without a change of its distribution."""


def intervals() -> None:
    print_title("Coverage of the 95 % intervals in use", f"{DATA_SETS:,} data sets; error of a figure .003 to .005.")
    rows = []
    for case in CASES:
        shares = [coverage(case, n, DATA_SETS, np.random.default_rng(n)) for n in SIZES]
        covered, bootstrap = ([share[key] for share in shares] for key in ("covered", "bootstrap"))
        rows.append([case.name, *(f"{share:.3f}" for share in covered), *(f"{share:.0%}" for share in bootstrap)])
    heads = [f"n = {n}" for n in SIZES]
    print_table(["values", *heads, *(f"bootstrap-t, {head}" for head in heads)], rows)


def paired_intervals() -> None:
    print_title(
        "Coverage of 95 % intervals of a paired difference: by sign flips / by t and bootstrap-t, as for one mean",
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
        "False positives of the whole comparison if nothing differs",
        f"{TABLES:,} tables of 3 models x 4 measures, a family of 12 tests; error of the last column .007.",
    )
    rows = []
    for name, draw in NOISE.items():
        for seeds in TESTED_SEEDS:
            shared = 0.0 if name in UNSHARED else 1.0
            rates = false_positives(draw, np.random.default_rng(seeds), tables=TABLES, seeds=seeds, shared=shared)
            rows.append([name, seeds, f"{rates.tests:,}", f"{rates.alone:.3f}", f"{rates.any_in_family:.3f}"])
    print_table(["noise", "seeds", "tests", "p <= .05", "family with any after the correction"], rows)


def families() -> None:
    print_title(
        f"Families of {MEASURES} correlated measures; the last model differs in {DIFFERENT} of them or in none",
        f"{FAMILIES} tables a row, exploratory; error of a false claim .013. Last two columns: Holm over all tests.",
    )
    rows = []
    for models, seeds in itertools.product((2, 3, 5), (6, 8, 10, 12, 16)):
        for (name, draw), effect in itertools.product(FAMILY_NOISE.items(), (0.0, 1.5)):
            shares = [f"{share:.3f}" if share >= 0 else "" for share in _claims(draw, models, seeds, effect)]
            rows.append([models, seeds, name, f"{effect:g}", *shares])
    print_table(["models", "seeds", "noise", "sd", "false", "found", "false, Holm over all", "found"], rows)


def _claims(draw: Draw, models: int, seeds: int, effect: float) -> list[float]:
    """Return two shares, then the same two with Holm alone: tables with a false claim; true differences claimed."""
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
        inside = np.concatenate([step_down_p(by_measure) for by_measure in differences])
        ours = over_pairs(inside, np.repeat(np.arange(len(pairs)), MEASURES))
        for row, p in zip(counts, (ours, holm(sign_flip_p(np.concatenate(differences)))), strict=True):
            row += (p[~is_true] <= ALPHA).any(), (p[is_true] <= ALPHA).mean() if is_true.any() else -1.0
    return (counts / FAMILIES).ravel().tolist()


def copies() -> None:
    """Play one model with many seeds, and compare its runs with each other as if they came from several models."""
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
    """Return whether any difference is claimed if runs of one model are taken for runs of several models."""
    seed = played.frame["seed"].to_numpy() - start
    own = (seed >= 0) & (seed < models * each)
    frame = played.frame[own].reset_index(drop=True)
    place = seed[own]
    frame = frame.assign(model=[f"copy {number}" for number in place // each], seed=place % each)
    present = tuple(names for names, is_own in zip(played.present, own, strict=True) if is_own)
    return bool(contrasts(SignatureTable(frame, (), played.measures, present))["significant"].any())


def equivalence() -> None:
    print_title(
        "Claims that two conditions are the same within 0.1 of a range of 1, if the true difference is 0.1 or 0",
        f"{EQUIVALENCES:,} contrasts a row; error .005 to .011. Last column: with a declared widest difference of 0.3.",
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
    print_table(["differences", "true mean", "seeds", "claimed to be the same", "with 0.3 declared"], rows)


def fingerprints() -> None:
    print_title("Energy test of whole fingerprints, 8 measures", f"{TABLES:,} pairs of models; error .007.")
    rows = []
    for shift in (0.0, 0.5):
        for seeds in TESTED_SEEDS:
            rng = np.random.default_rng(seeds)
            p = np.array([_energy_p(rng, seeds, shift) for _ in range(TABLES)])
            rows.append([f"{shift:g} sd in every measure", seeds, f"{(p <= ALPHA).mean():.3f}"])
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
                share, seeds = _at_looks(np.array([p_of(differences[:, :n]) for n in LOOKS]))
                last_share = (p_of(differences) <= ALPHA).mean()
                rows.append([name, f"{effect:g}", test, f"{share:.3f}", f"{seeds:.1f}", f"{last_share:.3f}"])
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
        corrected = np.array([[[step_down_p(table[:n].T) for table in pair] for pair in pairs] for n in LOOKS])
        p = sequential_p(LOOKS, corrected.reshape(len(LOOKS), -1)).reshape(3, TABLES, 2)
        claims = np.array(
            [over_pairs(sweep.ravel(), np.repeat(np.arange(3), 2)) <= ALPHA for sweep in p.swapaxes(0, 1)]
        )
        false = claims if shift == 0 else claims[:, :2]
        rows.append([f"{shift:g}", f"{false.any(axis=1).mean():.3f}", f"{claims.mean():.3f}"])
    print_table(["third model differs by", "any false claim", "share of tests claimed"], rows)


def undeclared_looks() -> None:
    print_title("Undeclared looks, each at .05", "20,000 comparisons a row, t; error .003.")
    drawn = np.random.default_rng(60).normal(size=(20_000, 60))
    cases = {"6 to 60, every seed": tuple(range(6, 61)), "10, 20, 30, 40": (10, 20, 30, 40), "8, 12, 18": (8, 12, 18)}
    rows = []
    for name, sizes in cases.items():
        share = np.array([student_p(drawn[:, :n]) <= ALPHA for n in sizes]).any(axis=0).mean()
        rows.append([name, f"{share:.3f}", f"{error_of(sizes, ALPHA):.3f}"])
    print_table(["looks at", "significant at any", "in the note"], rows)


def student_p(differences: np.ndarray) -> np.ndarray:
    n = differences.shape[1]
    t = differences.mean(axis=1) / differences.std(axis=1, ddof=1) * math.sqrt(n)
    return 2 * stdtr(n - 1, -np.abs(t))


def _at_looks(p: np.ndarray) -> tuple[float, float]:
    """Return the share of comparisons that any look finds, and the mean number of seeds when the looks end."""
    significant = p <= levels(LOOKS, np.array([ALPHA]))
    seeds = np.where(significant.any(axis=0), np.array(LOOKS)[significant.argmax(axis=0)], LOOKS[-1])
    return float(significant.any(axis=0).mean()), float(seeds.mean())


def probes() -> None:
    print_title(
        "False positives of a probe where nothing differs",
        f"{COPIES_IN_PROBE} copies; {MOMENTS} moments per seed, {REPEATS} repeats, {len(CHOICES)} choices; "
        f"{COPY_DATA_SETS} data sets of copies, {PROBE_TABLES} of formats and of quantities; ± is the standard error.",
    )
    rows = []
    for (name, concentration), seeds in itertools.product(POLICIES.items(), TESTED_SEEDS):
        rng = np.random.default_rng(seeds)
        rows.append([name, seeds])
        for p_of, count in ((_copies_p, COPY_DATA_SETS), (_format_p, PROBE_TABLES), (_slope_p, PROBE_TABLES)):
            rows[-1] += _rates([np.array(p_of(_policy(rng, seeds, concentration))) for _ in range(count)])
    tables, rates = ("copies or edits", "formats", "slopes"), ("p <= .05", "any (Holm)")
    heads = [f"{table}, {rate}" for table, rate in itertools.product(tables, rates)]
    print_table(["policy", "seeds", *heads], rows)


def _policy(rng: np.random.Generator, seeds: int, concentration: float) -> Ask:
    keys = [MomentKey(seed, "run", step, 0, "action", 0) for seed in range(seeds) for step in range(MOMENTS)]
    chances = rng.dirichlet(np.full(len(CHOICES), concentration), size=len(keys))

    def ask() -> Chosen:
        counts = rng.multinomial(REPEATS, chances)
        return {
            key: Counter(dict(zip(CHOICES, row, strict=True))) for key, row in zip(keys, counts.tolist(), strict=True)
        }

    return ask


def _copies_p(ask: Ask) -> list[float]:
    """Return p of the excess of each pair of copies, as in the tables `agreement` and `edits`."""
    pairs = itertools.combinations([ask() for _ in range(COPIES_IN_PROBE)], 2)
    return [float(upper_sign_flip_p(Compared.of(first, second, "").excesses()[None, :])[0]) for first, second in pairs]


def _format_p(ask: Ask) -> list[float]:
    """Return p of each row of the table `formats`."""
    return list(format_tables(_answers(ask, [Change("none", "invariance")], FORMATS))[0]["p"])


def _slope_p(ask: Ask) -> list[float]:
    """Return p of each row of the table `steepness`."""
    moves = [Change(f"x={value}", "cause", moves="x", to=value) for value in QUANTITY_VALUES]
    return list(curve_tables(_answers(ask, moves, ["none"]))[1]["p"])


def _answers(ask: Ask, edits: Sequence[Change], formats: Sequence[str]) -> Answers:
    subject = Subject("copy", "p", "")
    chosen = {ProbeCondition(subject, edit.name, layout): ask() for edit in edits for layout in formats}
    return Answers(chosen, {edit.name: edit for edit in edits}, tuple(formats), {subject: "copy"}, 0)


def _rates(families: Sequence[np.ndarray]) -> list[str]:
    """Return the share of tests with p <= .05, and of families with any such test after Holm, each with its error."""
    significant = np.concatenate(families) <= ALPHA
    by_family = np.array([(p <= ALPHA).mean() for p in families])
    any_in_family = np.array([(holm(p) <= ALPHA).any() for p in families])
    error = by_family.std(ddof=1) / math.sqrt(len(families))
    any_error = any_in_family.std() / math.sqrt(len(families))
    return [f"{significant.mean():.3f} ± {error:.3f}", f"{any_in_family.mean():.3f} ± {any_error:.3f}"]


def main() -> None:
    parser = argparse.ArgumentParser(description=__doc__.partition("\n")[0])
    parser.add_argument("--probes", action="store_true", help="measure the tables of a probe instead of sweeps")
    watch = Stopwatch()
    for measure in (probes,) if parser.parse_args().probes else SWEEPS:
        measure()
    print(f"{watch.cost().wall_s:.0f} s in all", file=sys.stderr)


SWEEPS = (
    looks,
    families_at_looks,
    undeclared_looks,
    intervals,
    paired_intervals,
    tests,
    families,
    copies,
    equivalence,
    fingerprints,
)

if __name__ == "__main__":
    main()
