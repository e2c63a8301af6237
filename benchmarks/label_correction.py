"""Measures how well labels of people correct measures of warnings: bias and coverage of differences.

    python benchmarks/label_correction.py [REPETITIONS [CASE ...]] [--share]

A rule labels the messages of two models with different error rates. A scripted policy plays a pool of runs, and the
texts of its messages are then made up. Each text is a warning with a probability that depends on whether the agent has
seen a fire, was told of a fire, or knows of no fire. The error rate of the rule depends on the case. Each repetition
takes ten seeds of each model from the pool, draws texts, lets people label them, corrects the measures, and compares
the models as `foundry analyze` does. In all cases except the last, the models behave alike. If people disagree, the
true value is the mean of their labels. With --share, only the share of warnings is measured, four times as fast.
"""

import argparse
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
"""Probability that a message warns, for an agent that has seen a fire, and for an agent that knows of no fire."""
FALSE = 0.03
"""Probability that the rule labels a message as a warning if it is none."""

Recall = Callable[[str, int, int, int], float]
"""Function that returns the probability that the rule finds a warning of a model, by seed, agent and step."""
Reading = Callable[[Generator, bool, bool], bool]
"""Function that returns whether a person reads a text as a warning; arguments: is it one, is it a near miss."""
Answer = Callable[[Generator, bool, bool], str | None]
"""Function that returns the answer of a person, from the reading and whether it is a near miss; None for no answer."""


def by_model(model: str, seed: int, agent: int, step: int) -> float:
    return {"a": 0.9, "b": 0.6}[model]


def as_meant(rng: Generator, warns: bool, near: bool) -> bool:
    return warns


def otherwise(rng: Generator, warns: bool, near: bool) -> bool:
    """Read half of the near texts without a warning as warnings, and a fifth of all warnings as no warnings."""
    return rng.random() < (0.8 if warns else 0.5 if near else 0.0)


def sometimes_unclear(rng: Generator, reading: bool, near: bool) -> str:
    return UNCLEAR if rng.random() < (0.25 if near else 0.05) else ("yes" if reading else "no")


def sometimes_withdrawn(rng: Generator, reading: bool, near: bool) -> str | None:
    return None if rng.random() < 0.15 else ("yes" if reading else "no")


@dataclass(frozen=True)
class Case:
    """A case: the errors of the rule, and the way in which people label.

    Attributes:
        name: name in the table.
        recall: recall of the rule.
        readings: how each person reads a text; each person labels the texts in a different order.
        answer: how people answer for a reading.
        part: share of the drawn texts that each person labels.
        near: probability that a text that the rule does not find counts as near, for warnings and for other texts.
        relays: probability that a message warns if its agent was told of a fire and has seen none, by model.
    """

    name: str
    recall: Recall
    readings: tuple[Reading, ...] = (as_meant,)
    answer: Answer = lambda rng, reading, near: "yes" if reading else "no"
    part: float = 1.0
    near: tuple[float, float] = (0.6, 0.1)
    relays: Mapping[str, float] = field(default_factory=lambda: {"a": SEES, "b": SEES})


CASES = (
    Case("by model", by_model),
    Case("by seed", lambda model, seed, agent, step: 0.9 if model == "a" else (0.3, 0.5, 0.7, 0.9)[seed % 4]),
    Case("by agent", lambda model, seed, agent, step: 0.9 if model == "a" or agent % 2 else 0.3),
    Case("over time", lambda model, seed, agent, step: 0.9 if model == "a" else 0.95 - 0.7 * step / STEPS),
    Case("two people disagree", by_model, (as_meant, otherwise)),
    Case("they stop half-way", by_model, (as_meant, otherwise), part=0.5),
    Case("unclear labels", by_model, answer=sometimes_unclear),
    Case("stopped half-way", by_model, part=0.5),
    Case("labels withdrawn", by_model, answer=sometimes_withdrawn),
    Case("b relays less", by_model, relays={"a": SEES, "b": 0.15}),
)


def pool(folder: Path) -> list[GridRun]:
    """Play the runs that later get made-up texts."""
    command = ["-m", "-q", "model=scripted/herd", f"seed=0-{POOL - 1}", f"world.steps={STEPS}", f"output.dir={folder}"]
    assert foundry(command) == 0
    runs = (measurable(run, run.summary()) for run in SweepFolder.open(folder).runs())
    return [whole.run for whole in runs if whole is not None]


@dataclass(frozen=True)
class Text:
    """A made-up text.

    Attributes:
        warns: whether it is a warning.
        by_rule: whether the rule labels it as a warning.
        near: whether it is a near miss.
        readings: whether each person reads it as a warning.
    """

    warns: bool
    by_rule: bool
    near: bool
    readings: tuple[bool, ...]


def with_texts(run: GridRun, model: str, case: Case, rng: Generator) -> tuple[GridRun, dict[str, Text]]:
    """Return a run with made-up texts, and the properties of each text."""
    seed = int(run.id.split("-s")[1].split("-")[0])
    said, texts = np.full(run.said.shape, None, dtype=object), dict[str, Text]()
    seen, heard_of = np.zeros((2, run.agents), dtype=np.bool_)
    for step in range(run.steps):
        seen |= run.perceived[step]
        likely = np.where(seen, SEES, np.where(heard_of, case.relays[model], KNOWS_NOTHING))
        for agent in np.flatnonzero(run.spoke[step]).tolist():
            warns = bool(rng.random() < likely[agent])
            by_rule = bool(rng.random() < (case.recall(model, seed, agent, step) if warns else FALSE))
            near = bool(not by_rule and rng.random() < case.near[0 if warns else 1])
            text = f"{run.id}/{step + 1}/{agent} {'rule_yes' if by_rule else 'rule_near' if near else 'rule_no'}"
            readings = tuple(reading(rng, warns, near) for reading in case.readings)
            said[step, agent], texts[text] = text, Text(warns, by_rule, near, readings)
        heard = run.deliveries[run.deliveries[:, 0] == step + 1]
        warned = [texts[said[step, sender]].warns for sender in heard[:, 1].tolist()]
        heard_of[heard[np.array(warned, dtype=np.bool_), 2]] = True
    return replace(run, said=said), texts


def items_of(run: GridRun, model: str) -> list[Item]:
    aware, seed = warning.knows_of_a_fire(run, LABEL), int(run.id.split("-s")[1].split("-")[0])
    return [
        Item(run.id, model, seed, step + 1, agent, MESSAGE, text, {"fires": ()}, bool(aware[step, agent]))
        for step, agent in np.argwhere(run.spoke).tolist()
        for text in (run.said[step, agent],)
    ]


def correction_of(
    items: Sequence[Item], texts: Mapping[str, Text], labels: int, case: Case, rng: Generator
) -> Correction | None:
    """Draw texts, and let each person label them in the order of their page."""
    empty = Sample(label=LABEL.name, question_sha256=LABEL.question_sha256, seed=int(rng.integers(2**31)))
    models = {item.run: item.model for item in items}
    sample = extended(empty, LABEL, items, list(models), labels // 2)
    text_of = {drawn.item: texts[drawn.text] for drawn in sample.drawn}
    by_person: dict[str, dict[str, str]] = {}
    for number, person in enumerate(("ana", "ben")[: len(case.readings)]):
        order = LabelDesk(LabelFolder(Path("nowhere"), LABEL.name), LABEL, sample).order(person)
        answers = by_person[person] = {}
        for item in order[: round(case.part * len(order))]:
            answer = case.answer(rng, text_of[item].readings[number], text_of[item].near)
            if answer is not None:
                answers[item] = answer
    return corrected_by(Labels(sample, by_person), LABEL, models).correction


def measured(run: GridRun, labels: Mapping[str, bool], measures: Sequence[str]) -> dict[str, float]:
    """Return the measures of a run for given labels of its texts."""
    if measures == (SHARE,):
        return {SHARE: float(np.mean([labels[text] for text in run.said[run.spoke]]))}
    values = warning.measure(replace(run, labels=dict(labels)))
    return {name: values[name.partition(".")[2]] for name in measures}


def difference(values: dict[tuple[str, int], dict[str, float]], copies: dict[str, list[np.ndarray]]) -> pd.DataFrame:
    """Compare the models as the analysis does."""
    rows = [{"model": model, "seed": seed, "status": "complete", **row} for (model, seed), row in values.items()]
    names = tuple(dict.fromkeys(name for row in values.values() for name in row))
    frame = pd.DataFrame(rows)
    by_copy = {name: np.array(of_runs) for name, of_runs in copies.items()}
    table = SignatureTable(frame, (), names, (frozenset(names),) * len(frame), (), by_copy)
    return contrasts(table, frame[["model"]], family=names).set_index("measure")


@dataclass(frozen=True)
class Estimate:
    """The difference of the models in a measure with its interval, the true difference, the errors of both levels."""

    difference: float
    low: float
    high: float
    true: float
    levels: dict[str, float]


def repetition(
    runs: Sequence[GridRun], case: Case, labels: int, rng: Generator, measures: Sequence[str]
) -> dict[str, Estimate]:
    """Return two estimates for each measure: from the rule, and corrected."""
    chosen = rng.permutation(len(runs))[: 2 * SEEDS]
    items: list[Item] = []
    texts: dict[str, Text] = {}
    said: dict[tuple[str, int], GridRun] = {}
    for place, number in enumerate(chosen.tolist()):
        model, seed = "ab"[place % 2], place // 2
        run = replace(runs[number], id=f"{model}-s{seed}-x")
        said[model, seed], made_up = with_texts(run, model, case, rng)
        items += items_of(said[model, seed], model)
        texts |= made_up
    correction = correction_of(items, texts, labels, case, rng)
    assert correction is not None, "every stratum has labels"
    by_rule_of = {text: known.by_rule for text, known in texts.items()}
    by_rule = {key: measured(run, by_rule_of, measures) for key, run in said.items()}
    readings = [{text: known.readings[person] for text, known in texts.items()} for person in range(len(case.readings))]
    by_reader = [levels_of({key: measured(run, read, measures) for key, run in said.items()}) for read in readings]
    true = sum(by_reader[1:], by_reader[0]) / len(by_reader)
    corrected: dict[tuple[str, int], dict[str, float]] = {}
    copies: dict[str, list[np.ndarray]] = {name: [] for name in measures if name != SHARE}
    for key, unread in said.items():
        run = replace(unread, labels=by_rule_of)
        corrected[key] = {SHARE: warning.corrected_share(run, correction)}
        if copies:
            copies[REACH].append(warning.correct(run, correction)["social_reach"])
            copies[RELAY].append(warning.relays_of(run, warning.labels_of_copies(run, correction)).shares)
            corrected[key] |= {name: float(np.nanmean(of_runs[-1])) for name, of_runs in copies.items()}
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
    true = np.mean([estimate.true for estimate in estimates])
    bias = np.mean([estimate.difference for estimate in estimates]) - true
    covers = np.mean([estimate.low <= true <= estimate.high for estimate in estimates])
    width = np.mean([estimate.high - estimate.low for estimate in estimates]) / 2
    levels = " ".join(f"{np.mean([estimate.levels[model] for estimate in estimates]):+.3f}" for model in "ab")
    return f"{bias:+.3f} {covers:.2f} {width:.3f} {levels}"


def main(repetitions: int, names: Sequence[str], measures: Sequence[str]) -> None:
    with tempfile.TemporaryDirectory() as scratch:
        runs = pool(Path(scratch) / "pool")
    print(f"{repetitions} repetitions, {SEEDS} seeds, 2 models, {COPIES} copies")
    print("of each: bias of the difference, coverage and half-width of its interval, bias of the level of a and of b")
    columns = [f"{measure} by {how}" for measure in measures for how in ("rule", "corrected")]
    print(f"{'rule errs':20} {'labels':>6}  " + "  ".join(f"{name.partition('.')[2]:>32}" for name in columns))
    for case in (case for case in CASES if case.name in names):
        for labels in (100, 200, 400) if case in (CASES[0], CASES[-1]) else (200,):
            seeds = ([labels, number, *case.name.encode()] for number in range(repetitions))
            each = (joblib.delayed(repetition)(runs, case, labels, default_rng(seed), measures) for seed in seeds)
            studies = joblib.Parallel(n_jobs=-1)(each)
            cells = (f"{cell([study[column] for study in studies]):>32}" for column in columns)
            true = " ".join(f"{np.mean([study[column].true for study in studies]):+.3f}" for column in columns[::2])
            print(f"{case.name:20} {labels:6}  {'  '.join(cells)}  true {true}", flush=True)


if __name__ == "__main__":
    arguments = argparse.ArgumentParser()
    arguments.add_argument("repetitions", nargs="?", type=int, default=200)
    arguments.add_argument("cases", nargs="*", default=[case.name for case in CASES])
    arguments.add_argument("--share", action="store_true")
    asked = arguments.parse_args()
    main(asked.repetitions, asked.cases, (SHARE,) if asked.share else (SHARE, REACH, RELAY))
