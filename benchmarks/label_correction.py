"""How far labels of people mend measures of warnings: bias of a difference, and how often its interval holds the truth.

    python benchmarks/label_correction.py [REPETITIONS [CASE ...]]

A rule reads the messages of two models differently. A pool of runs is played by a scripted policy. The texts of its
messages are then made up: each is a warning with a probability that depends on whether its agent has seen a fire, was
told of one, or knows of none. The rule is wrong with a probability that depends on the case. Each repetition takes ten
seeds of each model from the pool. It draws texts, has people label them, corrects, and compares the models as `foundry
analyze` does. In all cases but the last the models behave alike.
"""

import sys
import tempfile
from collections.abc import Callable, Mapping, Sequence
from dataclasses import dataclass, field, replace
from pathlib import Path

import joblib
import numpy as np
import pandas as pd
from numpy.random import Generator, default_rng

from analysis.grid.grid_run import GridRun
from analysis.grid.signatures import warning
from analysis.labelling.correcting import COPIES, Correction, corrected_by
from analysis.load import measurable
from analysis.stats.contrasts import contrasts
from analysis.tables.signature_table import SignatureTable
from foundry.cli import run as foundry
from foundry.labels.definition import UNCLEAR, Label
from foundry.labels.desk import LabelDesk
from foundry.labels.folder import LabelFolder, Labels
from foundry.labels.items import MESSAGE, Item
from foundry.labels.sampling import Sample, extended
from foundry.storing.store import SweepFolder

POOL, SEEDS, STEPS = 60, 10, 25
LABEL = Label(
    name="warning", question="?", choices=("yes", "no"), unit="message", rule="rule_yes", rule_is_pattern=True,
    near="rule_near", near_is_pattern=True,
)  # fmt: skip
SHARE, REACH, RELAY = "warning.warning_share", "warning.social_reach", "warning.relay_probability"
SEES, KNOWS_NOTHING = 0.5, 0.05
"""Probability with which a message warns: of an agent that has seen a fire, and of one that knows of none."""
FALSE = 0.03
"""Probability with which the rule takes another message for a warning."""

Recall = Callable[[str, int, int, int], float]
"""Probability with which the rule finds a warning: of a model, by seed, agent and step."""
Answer = Callable[[Generator, bool, bool], str | None]
"""The answer of a person to a text: whether it is a warning and whether it is near the border; None for no answer."""


@dataclass(frozen=True)
class Case:
    """How the rule errs, and how people label.

    Attributes:
        name: what it is called in the table.
        recall: of the rule.
        answer: of the people.
        part: part of the drawn texts that are labelled before the people stop.
        near: probability with which a text that the rule does not find counts as near, of warnings and of others.
        relays: probability with which a message warns if its agent was told of a fire and has seen none, by model.
    """

    name: str
    recall: Recall
    answer: Answer = lambda rng, truth, near: "yes" if truth else "no"
    part: float = 1.0
    near: tuple[float, float] = (0.6, 0.1)
    relays: Mapping[str, float] = field(default_factory=lambda: {"a": SEES, "b": SEES})


def by_model(model: str, seed: int, agent: int, step: int) -> float:
    return {"a": 0.9, "b": 0.6}[model]


def sometimes_unclear(rng: Generator, truth: bool, near: bool) -> str:
    return UNCLEAR if rng.random() < (0.25 if near else 0.05) else ("yes" if truth else "no")


def sometimes_withdrawn(rng: Generator, truth: bool, near: bool) -> str | None:
    return None if rng.random() < 0.15 else ("yes" if truth else "no")


CASES = (
    Case("by model", by_model),
    Case("by seed", lambda model, seed, agent, step: 0.9 if model == "a" else (0.3, 0.5, 0.7, 0.9)[seed % 4]),
    Case("by agent", lambda model, seed, agent, step: 0.9 if model == "a" or agent % 2 else 0.3),
    Case("over time", lambda model, seed, agent, step: 0.9 if model == "a" else 0.95 - 0.7 * step / STEPS),
    Case("two judges disagree", by_model, near=(0.8, 0.3)),
    Case("unclear labels", by_model, sometimes_unclear),
    Case("stopped half-way", by_model, part=0.5),
    Case("labels withdrawn", by_model, sometimes_withdrawn),
    Case("b relays less", by_model, relays={"a": SEES, "b": 0.15}),
)


def pool(folder: Path) -> list[GridRun]:
    """Play the runs whose texts are made up."""
    command = ["-m", "-q", "model=scripted/herd", f"seed=0-{POOL - 1}", f"world.steps={STEPS}", f"output.dir={folder}"]
    assert foundry(command) == 0
    runs = (measurable(run, run.summary()) for run in SweepFolder.open(folder).runs())
    return [whole.run for whole in runs if whole is not None]


def told(run: GridRun, model: str, case: Case, rng: Generator) -> tuple[GridRun, dict[str, bool]]:
    """Return a run with made-up texts, and whether each text is a warning."""
    seed = int(run.id.split("-s")[1].split("-")[0])
    said, truth = np.full(run.said.shape, None, dtype=object), dict[str, bool]()
    seen, heard_of = np.zeros((2, run.agents), dtype=np.bool_)
    for step in range(run.steps):
        seen |= run.perceived[step]
        likely = np.where(seen, SEES, np.where(heard_of, case.relays[model], KNOWS_NOTHING))
        for agent in np.flatnonzero(run.spoke[step]).tolist():
            warns = bool(rng.random() < likely[agent])
            found = rng.random() < (case.recall(model, seed, agent, step) if warns else FALSE)
            near = not found and rng.random() < case.near[0 if warns else 1]
            text = f"{run.id}/{step + 1}/{agent} {'rule_yes' if found else 'rule_near' if near else 'rule_no'}"
            said[step, agent], truth[text] = text, warns
        heard = run.deliveries[run.deliveries[:, 0] == step + 1]
        warned = [truth[said[step, sender]] for sender in heard[:, 1].tolist()]
        heard_of[heard[np.array(warned, dtype=np.bool_), 2]] = True
    return replace(run, said=said), truth


def items_of(run: GridRun, model: str) -> list[Item]:
    places = zip(*(one.tolist() for one in np.nonzero(run.spoke)), strict=True)
    aware, seed = warning.knows_of_a_fire(run, LABEL), int(run.id.split("-s")[1].split("-")[0])
    return [
        Item(
            run.id,
            model,
            seed,
            step + 1,
            agent,
            MESSAGE,
            run.said[step, agent],
            {"fires": ()},
            bool(aware[step, agent]),
        )
        for step, agent in places
    ]


def correction_of(
    items: Sequence[Item], truth: dict[str, bool], labels: int, case: Case, rng: Generator
) -> Correction | None:
    """Draw texts and have a person label them, in the order of the page."""
    empty = Sample(label=LABEL.name, question_sha256=LABEL.question_sha256, seed=int(rng.integers(2**31)))
    models = {item.run: item.model for item in items}
    sample = extended(empty, LABEL, items, list(models), labels // 2)
    order = LabelDesk(LabelFolder(Path("nowhere"), LABEL.name), LABEL, sample).order("ana")
    drawn = {one.item: one for one in sample.drawn}
    given: dict[str, str] = {}
    for item in order[: round(case.part * len(order))]:
        text = drawn[item].text
        answer = case.answer(rng, truth[text], "rule_near" in text)
        if answer is not None:
            given[item] = answer
    return corrected_by(Labels(sample, {"ana": given}), LABEL, models).correction


def measured(run: GridRun, labels: dict[str, bool]) -> dict[str, float]:
    found = warning.measure(replace(run, labels=labels))
    return {name: found[name.partition(".")[2]] for name in (SHARE, REACH, RELAY)}


def difference(values: dict[tuple[str, int], dict[str, float]], copies: dict[str, list[np.ndarray]]) -> pd.DataFrame:
    """Compare the models as the analysis does."""
    rows = [{"model": model, "seed": seed, "status": "complete", **found} for (model, seed), found in values.items()]
    names = tuple(dict.fromkeys(name for found in values.values() for name in found))
    frame = pd.DataFrame(rows)
    together = {name: np.array(found) for name, found in copies.items()}
    table = SignatureTable(frame, (), names, (frozenset(names),) * len(frame), (), together)
    return contrasts(table, frame[["model"]], family=names).set_index("measure")


@dataclass(frozen=True)
class Estimate:
    """The difference of the models in a measure with its interval, the true one, and the errors of their levels."""

    difference: float
    low: float
    high: float
    true: float
    levels: dict[str, float]


def repetition(runs: Sequence[GridRun], case: Case, labels: int, rng: Generator) -> dict[str, Estimate]:
    """Return the estimates of each measure by the rule and corrected."""
    chosen = rng.permutation(len(runs))[: 2 * SEEDS]
    items: list[Item] = []
    truth: dict[str, bool] = {}
    said: dict[tuple[str, int], GridRun] = {}
    for place, number in enumerate(chosen.tolist()):
        model, seed = "ab"[place % 2], place // 2
        said[model, seed], known = told(replace(runs[number], id=f"{model}-s{seed}-x"), model, case, rng)
        items += items_of(said[model, seed], model)
        truth |= known
    correction = correction_of(items, truth, labels, case, rng)
    assert correction is not None, "every stratum has labels"
    read = {text: "rule_yes" in text for text in truth}
    by_rule = {key: measured(run, read) for key, run in said.items()}
    true = levels_of({key: measured(run, truth) for key, run in said.items()})
    corrected: dict[tuple[str, int], dict[str, float]] = {}
    copies: dict[str, list[np.ndarray]] = {REACH: [], RELAY: []}
    for key, unread in said.items():
        run = replace(unread, labels=read)
        found = warning.correct(run, correction)
        copies[REACH].append(found["social_reach"])
        copies[RELAY].append(warning.relays_of(run, warning.labels_of_copies(run, correction)).shares)
        means = {name: float(np.nanmean(some[-1])) for name, some in copies.items()}
        corrected[key] = {SHARE: float(found["warning_share"][0]), **means}
    estimates: dict[str, Estimate] = {}
    for how, values, of_copies in (("rule", by_rule, {}), ("corrected", corrected, copies)):
        errors = levels_of(values) - true
        for measure, row in difference(values, of_copies).iterrows():
            gap = float(true.loc[row["level"], measure] - true.loc[row["reference"], measure])
            told_by = {model: float(errors.loc[model, measure]) for model in "ab"}
            estimates[f"{measure} by {how}"] = Estimate(row["difference"], row["low"], row["high"], gap, told_by)
    return estimates


def levels_of(values: Mapping[tuple[str, int], Mapping[str, float]]) -> pd.DataFrame:
    """Return the mean of each measure over the seeds, by model."""
    return pd.DataFrame.from_dict(values, orient="index").groupby(level=0).mean()


def cell(estimates: Sequence[Estimate]) -> str:
    true = np.mean([one.true for one in estimates])
    bias = np.mean([one.difference for one in estimates]) - true
    covers = np.mean([one.low <= true <= one.high for one in estimates])
    width = np.mean([one.high - one.low for one in estimates]) / 2
    levels = " ".join(f"{np.mean([one.levels[model] for one in estimates]):+.3f}" for model in "ab")
    return f"{bias:+.3f} {covers:.2f} {width:.3f} {levels}"


def main(repetitions: int, names: Sequence[str]) -> None:
    with tempfile.TemporaryDirectory() as scratch:
        runs = pool(Path(scratch) / "pool")
    print(f"{repetitions} repetitions, {SEEDS} seeds, 2 models, {COPIES} copies")
    print("of each: bias of the difference, coverage and half-width of its interval, bias of the level of a and of b")
    columns = [f"{measure} by {how}" for measure in (SHARE, REACH, RELAY) for how in ("rule", "corrected")]
    print(f"{'rule errs':20} {'labels':>6}  " + "  ".join(f"{name.partition('.')[2]:>32}" for name in columns))
    for case in (one for one in CASES if one.name in names):
        for labels in (100, 200, 400) if case in (CASES[0], CASES[-1]) else (200,):
            seeds = ([labels, number, *case.name.encode()] for number in range(repetitions))
            each = (joblib.delayed(repetition)(runs, case, labels, default_rng(seed)) for seed in seeds)
            found = joblib.Parallel(n_jobs=-1)(each)
            cells = (cell([one[column] for one in found]) for column in columns)
            true = " ".join(f"{np.mean([one[column].true for one in found]):+.3f}" for column in columns[::2])
            print(
                f"{case.name:20} {labels:6}  " + "  ".join(f"{one:>32}" for one in cells) + f"  true {true}", flush=True
            )


if __name__ == "__main__":
    main(int(sys.argv[1]) if len(sys.argv) > 1 else 200, sys.argv[2:] or [case.name for case in CASES])
