"""People who label: what they are shown, what is kept, and how their agreement with others comes out."""

from __future__ import annotations

import json
import math
import re

import numpy as np
import pytest

import analysis
from analysis.labelling.people import clustered_kappa, labellers
from commands import foundry
from foundry.labels import NONE, REPLIES, WARNINGS, Judged, JudgedBy, Labelled, Labels, People
from foundry.probing.sitting import replies_of
from foundry.storing.store import SweepFolder
from sittings import played

TEXTS = tuple(f"there is smoke {number}" if number % 2 else f"hello {number}" for number in range(20))
ACTIONS = ["stay", "up", "down", "left", "right"]


@pytest.fixture
def talk(make_sweep, make_condition, make_habits):
    """A sweep of six seeds in which twenty texts are said, half of them warnings."""
    return make_sweep([make_condition("a", range(6))], {"a": make_habits(texts=TEXTS)})


def yes_to_smoke(question) -> str:
    return "yes" if "smoke" in question["messages"][0]["content"].split("-----")[1] else "no"


def test_a_person_who_says_what_the_rule_says_agrees_with_it_and_what_is_no_label_is_left_out(
    talk, tmp_path, monkeypatch
):
    done, person = played(
        monkeypatch, tmp_path, str(talk.path), "--label", "model=human/ana", reply=yes_to_smoke, begins_at=20
    )
    assert done.returncode == 0, done.stderr
    assert "20 of 20 texts labelled by human/ana" in done.stdout
    assert {tuple(question["schema"]["enum"]) for question in person.seen} == {("yes", "no")}
    [row] = labellers(talk).to_dict("records")
    assert (row["what"], row["first"], row["second"], row["texts"]) == (WARNINGS, "human/ana", "rule 4", 20)
    assert (row["same"], row["kappa"]) == (1.0, 1.0)
    assert math.isnan(row["low"]), "where all agree without any seed, nothing is known of the spread"
    maybe = lambda question: yes_to_smoke(question).replace("no", "maybe")  # noqa: E731
    command = (str(talk.path), "--label", "model=human/ben", "--texts", "4")
    played(monkeypatch, tmp_path, *command, begins_at=4, reply=maybe)
    ben = talk.people().people[-1]
    assert {one.label for one in ben.labels} == {"yes"} and 0 < len(ben.labels) < 4, "what is no label is left out"


def test_a_sitting_that_ends_early_keeps_what_was_said_and_goes_on_another_day(talk, tmp_path, monkeypatch):
    command = (str(talk.path), "--label", "model=human/ana", "--texts", "12")
    done, first = played(monkeypatch, tmp_path, *command, reply=yes_to_smoke, begins_at=12, most=5)
    assert "5 of 12 texts labelled" in done.stdout
    done, then = played(monkeypatch, tmp_path, *command, reply=yes_to_smoke, begins_at=7)
    assert "12 of 12 texts labelled" in done.stdout
    more = (*command[:-1], "15")
    done, last = played(monkeypatch, tmp_path, *more, reply=yes_to_smoke, begins_at=3)
    shown = [question["messages"][0]["content"] for one in (first, then, last) for question in one.seen]
    assert [len(one.seen) for one in (first, then, last)] == [5, 7, 3]
    assert len(set(shown)) == 15
    [kept] = talk.people().people
    assert (kept.labeller, kept.asked, len(kept.labels)) == ("human/ana", 15, 15)


def test_people_and_a_model_are_held_against_each_other_on_what_both_labelled(talk):
    def said(name: str, yes: int, texts: int) -> JudgedBy:
        labels = tuple(
            Judged(text=text, seed=at % 6, label="yes" if at < yes else "no", fires=("f",))
            for at, text in enumerate(TEXTS[:texts])
        )
        return JudgedBy(labeller=name, what=WARNINGS, question_sha256="", asked=texts, labels=labels)

    by_model = tuple(Labelled(text=one, fires=("f",), warning=at < 8, reply="") for at, one in enumerate(TEXTS[:16]))
    talk.write_labels(
        Labels(labeller="m", digest=None, question_sha256="", parameters={}, labels=by_model, hand_labelled=())
    )
    talk.write_people(People(people=(said("human/ana", 8, 20), said("human/ben", 10, 16))))
    frame = labellers(talk).set_index(["first", "second"])
    assert list(frame.index) == [
        ("human/ana", "human/ben"), ("human/ana", "m"), ("human/ana", "rule 4"), ("human/ben", "m"),
        ("human/ben", "rule 4"),
    ]  # fmt: skip
    assert frame.loc[("human/ana", "m"), "kappa"] == 1.0
    pair = frame.loc[("human/ana", "human/ben")]
    assert (pair["texts"], pair["same"], pair["kappa"]) == (16, 14 / 16, 0.75)  # chance is a half
    assert pair["low"] < 0.75 < pair["high"]
    assert frame.loc[("human/ana", "rule 4"), "kappa"] == pytest.approx(0.0), (
        "who goes by the order is no better than chance"
    )


def test_an_analysis_writes_the_table_of_labellers(talk):
    talk.write_people(
        People(people=(JudgedBy(
            labeller="human/ana", what=WARNINGS, question_sha256="", asked=1,
            labels=(Judged(text="there is smoke", seed=0, label="yes"),),
        ),))
    )  # fmt: skip
    written = analysis.analyze([talk.path], plots=False).written
    assert talk.analysis_dir / "labellers.csv" in written
    assert "human/ana" in (talk.analysis_dir / "labellers.md").read_text(encoding="utf-8")


@pytest.mark.slow
def test_unread_replies_come_among_read_ones_and_nobody_is_told_which(tmp_path, monkeypatch):
    flaky = ("model=scripted/flaky", "world.agents=8", "world.steps=6", "analyze=false", "output.dir=flaky")
    assert foundry("-m", *flaky, "seed=0-3", cwd=tmp_path).returncode == 0
    done, person = played(
        monkeypatch, tmp_path, "flaky", "--label", "model=human/ana", "--replies", begins_at=2,
        reply=lambda question: NONE,
    )  # fmt: skip
    assert done.returncode == 0, done.stderr
    assert [question["schema"]["enum"] for question in person.seen] == [[*ACTIONS, NONE]] * len(person.seen)
    [kept] = SweepFolder.open(tmp_path / "flaky").people().people
    recorded = [one.recorded for one in kept.labels]
    assert recorded.count(NONE) == len(recorded) / 2 > 2
    assert set(recorded) - {NONE} <= set(ACTIONS)
    [row] = labellers(SweepFolder.open(tmp_path / "flaky")).to_dict("records")
    assert (row["what"], row["second"], row["same"], row["kappa"]) == (REPLIES, "the records", 0.5, 0.0)


def decided(text: str) -> str:
    """Return what a careful person reads in a reply that ends in JSON."""
    try:
        said = json.loads(re.findall(r"\{[^{}]*\}", text)[-1])
        return said["direction"] if said["action"] == "move" else said["action"]
    except (ValueError, IndexError, KeyError):
        return NONE


@pytest.mark.slow
def test_a_reply_of_a_probe_is_held_against_what_that_very_reply_decided(tmp_path):
    small = ("world.agents=6", "world.steps=6", "analyze=false")
    assert foundry("-m", "model=scripted/random", *small, "seed=0-2", "output.dir=pilot", cwd=tmp_path).returncode == 0
    probe = ("probe", "pilot", "model=scripted/flaky", "repeats=8", "analyze=false", "output.dir=asked")
    assert foundry(*probe, cwd=tmp_path).returncode == 0
    found = [one.judged for one in replies_of(SweepFolder.open(tmp_path / "asked"), 1000)]
    read = [one for one in found if decided(one.text) != NONE and one.recorded != NONE]
    assert len(read) >= 4
    assert [one.recorded for one in read] == [decided(one.text) for one in read]
    assert {one.kind for one in found} == {"action"}, "a message is no choice among labels"


@pytest.mark.parametrize(
    ("arguments", "reason"),
    [
        (("model=scripted/stay",), "Nobody is asked here"),
        (("model=human/a@b",), "no name for a person"),
        (("-m", "model=human/ana,human/ben"), "One person labels at a time"),
        (("missing", "model=human/ana"), "Name one sweep"),
    ],
)
def test_what_cannot_be_asked_is_refused_in_one_line(talk, tmp_path, arguments, reason):
    done = foundry("play", str(talk.path), *arguments, "--label", cwd=tmp_path)
    assert done.returncode == 2
    assert reason in done.stderr
    assert len(done.stderr.splitlines()) == 1


def drawn_pair(rng: np.random.Generator, clusters: int, texts: int) -> tuple[np.ndarray, np.ndarray, np.ndarray]:
    """Two labellers of whom the second errs in a tenth, on texts whose clusters differ in how many are warnings."""
    cluster = np.repeat(np.arange(clusters), texts)
    first = (rng.random(clusters * texts) < rng.beta(1.5, 3.5, clusters)[cluster]).astype(np.int64)
    return first, np.where(rng.random(len(first)) < 0.9, first, 1 - first), cluster


def test_the_interval_of_kappa_covers_it_as_often_as_it_says_and_one_seed_has_none():
    rng = np.random.default_rng(1)
    truth = clustered_kappa(*drawn_pair(rng, 3000, 10)).kappa
    found = [clustered_kappa(*drawn_pair(rng, 12, 10)) for _ in range(200)]
    covered = np.mean([one.low <= truth <= one.high for one in found])
    assert 0.90 <= covered <= 0.98
    of_one_seed = clustered_kappa(np.array([0, 1, 1]), np.array([0, 1, 0]), np.array([4, 4, 4]))
    assert of_one_seed.note == "no interval: one seed" and math.isnan(of_one_seed.low)
