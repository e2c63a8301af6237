"""Measures how often the corrected interval covers the true difference, in whole studies with labels of people.

    python benchmarks/labelled_studies.py [STUDIES]

Each study has its own sweep folder. Two scripted models, which warn with known probabilities, talk for ten seeds. The
rule knows the words of most warnings of one model, and of few warnings of the other. The command draws texts. Two
simulated people label them, as on the page, and the command writes their journals. `analyze` reads the folder.
"""

from __future__ import annotations

import io
import sys
import tempfile
import threading
from collections.abc import Iterator, Mapping
from contextlib import contextmanager, redirect_stdout
from dataclasses import dataclass
from pathlib import Path
from typing import Any

import numpy as np
import pandas as pd
from numpy.random import Generator, default_rng

import analysis
from foundry import own_code
from foundry.cli import run as foundry
from foundry.commands.labelling import label_by_people
from foundry.commands.view import AskingPage
from foundry.labels.definition import UNCLEAR
from foundry.labels.desk import LabelDesk
from foundry.models.base import ScriptedModel
from foundry.worlds.grid.grid_policies import STAY, act, say

SEEDS, LABELS, SECOND = 10, 200, 25
FALSE = 0.05
"""Probability that the rule labels a message as a warning if it is none."""
MEASURES = {"rule": "warning.warning_share_uncorrected", "corrected": "warning.warning_share"}
KNOWN, UNKNOWN, MISREAD = (
    "Fire at table {}, run!",
    "It glows orange at table {}, keep off.",
    "Table {} burns with gossip!",
)
NEAR, OTHER = "Is there a fire at table {}?", "Shall we meet at table {}?"
RECALL = {"a": 0.9, "b": 0.5}
"""Probability that a warning uses words that the rule knows, by model."""
TRUTHS: tuple[Mapping[str, float], ...] = ({"a": 0.4, "b": 0.4}, {"a": 0.4, "b": 0.25})
"""Probability that a message warns, by model."""


class Speaker(ScriptedModel):
    """Policy that stays and speaks; some of its messages are warnings."""

    def __init__(self, name: str, warns: float, recall: float) -> None:
        """Set the probabilities that a message warns, and that the rule knows the words of a warning."""
        super().__init__(name)
        self.warns, self.recall = warns, recall

    def message(self, observation: Mapping[str, Any], rng: Generator) -> str:
        """Say one of five sentences about a table."""
        if rng.random() < self.warns:
            text = KNOWN if rng.random() < self.recall else UNKNOWN
        else:
            text = MISREAD if rng.random() < FALSE else NEAR if rng.random() < 0.2 else OTHER
        return say(text.format(int(rng.integers(1_000_000))), reasoning="")

    def action(self, observation: Mapping[str, Any], rng: Generator) -> str:
        """Stay."""
        return act(STAY, reasoning="")

    def parameters(self) -> dict[str, Any]:
        """Return the class of the policy and its probabilities, as a configuration."""
        return super().parameters() | {"warns": self.warns, "recall": self.recall}


@dataclass(frozen=True)
class People(AskingPage):
    """Two simulated people: one labels all texts; the other labels some of them, and calls some unclear."""

    rng: Generator

    @contextmanager
    def labelling(self, desk: LabelDesk, title: str) -> Iterator[threading.Event]:
        """Let the people label."""
        for person, unclear, most in (("ana", 0.0, sys.maxsize), ("ben", 0.2, SECOND)):
            place = desk.place(person)
            while place.shown is not None and place.done < most:
                warns = "Fire" in place.shown.text or "glows" in place.shown.text
                answer = UNCLEAR if self.rng.random() < unclear else "yes" if warns else "no"
                place = desk.label(person, place.shown.item, answer)
        ended = threading.Event()
        ended.set()
        yield ended


Interval = tuple[float, float, float]
"""The difference of model b from model a, with the ends of its interval."""


def played(folder: Path, number: int, warns: Mapping[str, float]) -> Path:
    """Play the sweep of a study; returns its folder."""
    models = folder / "mine" / "model" / "speaker"
    models.mkdir(parents=True)
    for name, recall in RECALL.items():
        settings = f"name: {name}\nwarns: {warns[name]}\nrecall: {recall}\n"
        (models / f"{name}.yaml").write_text(f"_target_: labelled_studies.Speaker\n{settings}", encoding="utf-8")
    own_code.use([Path(__file__).parent])
    seeds = f"seed={number * SEEDS}-{number * SEEDS + SEEDS - 1}"
    world = (
        "world.agents=5",
        "world.steps=6",
        f"output.dir={folder / 'study'}",
        f"cache.path={folder / 'cache.sqlite'}",
    )
    chosen = ("-m", "-q", "model=speaker/a,speaker/b", seeds, "analyze=false", *world)
    assert foundry([*chosen, "--config-dir", str(folder / "mine")]) == 0
    return folder / "study"


def study(folder: Path, number: int, warns: Mapping[str, float], per_model: int) -> dict[str, Interval]:
    """Play, label and analyse a study in its own folder; return the differences by the rule and corrected."""
    with redirect_stdout(io.StringIO()):
        sweep = played(folder, number, warns)
        people = People(host="", port=None, browser=False, rng=default_rng([number, per_model]))
        label_by_people(sweep, "warning", per_model, people)
        rows = analysis.analyze([sweep], family=[MEASURES["corrected"]], plots=False).contrasts.set_index("measure")
    return {how: _difference(rows.loc[measure]) for how, measure in MEASURES.items()}


def _difference(row: pd.Series[Any]) -> Interval:
    difference, low, high = (float(row[name]) for name in ("difference", "low", "high"))
    return (difference, low, high) if row["level"] == "b" else (-difference, -high, -low)


def main(studies: int) -> None:
    print(f"{studies} studies of each row, {SEEDS} seeds, 2 models, {LABELS} labels in all")
    held = []
    for warns in TRUTHS:
        results, true = [], warns["b"] - warns["a"]
        for number in range(studies):
            with tempfile.TemporaryDirectory() as scratch:
                results.append(study(Path(scratch), number, warns, LABELS // 2))
        for how in MEASURES:
            rows = np.array([study[how] for study in results])
            covers = (rows[:, 1] <= true) & (true <= rows[:, 2])
            width = (rows[:, 2] - rows[:, 1]).mean() / 2
            line = f"bias {rows[:, 0].mean() - true:+.3f} coverage {covers.mean():.2f} half-width {width:.3f}"
            print(f"true difference {true:+.2f}, {how:9}: {line}", flush=True)
        held += covers.tolist()
    print(f"the corrected interval covers the true value in {sum(held)} of {len(held)} studies")


if __name__ == "__main__":
    main(int(sys.argv[1]) if len(sys.argv) > 1 else 25)
