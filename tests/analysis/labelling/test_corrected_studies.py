"""Whole studies whose labels people correct: played, labelled, analysed, grown, bundled and verified."""

import hashlib
import json
from typing import Any

import numpy as np
import pandas as pd
import pytest

import analysis
from analysis.grid.signatures import warning
from analysis.load import measurable
from analysis.paper.card import card
from analysis.stats.intervals import estimate
from commands import foundry, succeeds
from foundry.labels.definition import label_named
from foundry.labels.folder import Entry, LabelFolder
from foundry.labels.items import items_of
from foundry.labels.sampling import Sample, extended
from foundry.storing.store import SweepFolder
from labels_of_sweeps import draw, judge, label_all
from ollama_server import OllamaServer
from walkers import WORLD, Habits, make_condition

SHARE = "warning.warning_share"
WARNING = label_named("warning")


def reply(body: dict[str, Any]) -> str:
    """Warn as often as the other model does; `llama3.2` often in words that the rule does not know."""
    prompt = body["messages"][-1]["content"]
    number = int(hashlib.sha256(f"{body['options']['seed']}{prompt}".encode()).hexdigest()[:8], 16)
    if '"direction"' in prompt:
        return json.dumps({"action": "stay", "memory": "", "reasoning": ""})
    if number % 10 >= 4:
        text = f"Shall we meet at table {number}?"
    elif body["model"] == "qwen3:4b" or number % 10 == 0:
        text = f"Fire at table {number}, run!"
    else:
        text = f"It glows orange at table {number}, better keep off."
    return json.dumps({"message": text, "reasoning": ""})


def truth(text: str) -> str:
    return "yes" if "Fire" in text or "glows" in text else "no"


@pytest.fixture(scope="module")
def study(tmp_path_factory: pytest.TempPathFactory) -> SweepFolder:
    folder = tmp_path_factory.mktemp("study")
    served = ("-m", "model=qwen3:4b,llama3.2", "seed=0-9", "world.agents=5", "world.steps=6")
    with OllamaServer(reply) as server:
        done = foundry(*served, "analyze=false", "output.dir=out", cwd=folder, OLLAMA_HOST=server.url)
    assert done.returncode == 0, done.stderr
    return SweepFolder.open(folder / "out")


def compared(sweep: SweepFolder) -> tuple[dict[str, Any], str, pd.DataFrame]:
    """Return the row and the sentence of the share, and the table of runs."""
    found = analysis.analyze([sweep.path], family=[SHARE])
    rows = found.contrasts
    [row] = rows[rows["measure"] == SHARE].to_dict("records")
    [sentence] = [one for one in found.summary if SHARE in one]
    return row, sentence, found.runs


@pytest.mark.slow
def test_two_models_that_warn_in_different_words_differ_to_the_rule_and_not_to_people(study: SweepFolder, tmp_path):
    by_rule, sentence, _ = compared(study)
    assert by_rule["significant"] and abs(by_rule["difference"]) > 0.2
    assert "than qwen3:4b, as labelled by rule 4: " in sentence
    texts = label_all(study, WARNING, "ana", lambda one: truth(one.text), 120)
    corrected, sentence, runs = compared(study)
    assert not corrected["significant"] and corrected["low"] < 0 < corrected["high"]
    assert f"corrected with {texts} labels of 1 person" in sentence
    assert runs[f"{SHARE}_uncorrected"].nunique() > 2, "the share by the rule stands beside it"
    assert runs.groupby("model")[SHARE].mean().to_numpy() == pytest.approx(0.4, abs=0.1)
    notes = (study.analysis_dir / "summary.md").read_text(encoding="utf-8")
    said = "labels of warnings by rule 4, without this correction: precision"
    assert f"warnings are corrected with {texts} labels of 1 person; {said}" in notes
    label_all(study, WARNING, "ben", lambda one: truth(one.text), 120)
    _, sentence, again = compared(study)
    assert "labels of 2 people" in sentence
    planned = succeeds("plan", "--pilot", str(study.path), "--labels", "warning", cwd=tmp_path)
    assert "errors of the rule from people's labels" in planned.stdout
    succeeds("bundle", str(study.path), str(tmp_path / "study.foundry"), cwd=tmp_path)
    succeeds("unbundle", "study.foundry", "copy", cwd=tmp_path)
    copy = analysis.analyze([tmp_path / "copy"]).runs
    assert copy[SHARE].tolist() == again[SHARE].tolist()
    succeeds("verify", "copy", cwd=tmp_path)


@pytest.fixture
def talk(make_sweep) -> SweepFolder:
    """Two models of four seeds that say unlike texts, some in other languages; all actions of the first can be read."""
    texts = {"a": ("Feuer!", "hello", "there is smoke"), "b": ("hello", "bonjour", "no fire here")}
    conditions = [make_condition(model, range(4)) for model in texts]
    habits = {model: Habits(texts=said, unreadable=0.1 * (model == "b")) for model, said in texts.items()}
    return make_sweep(conditions, habits)


@pytest.mark.slow
def test_with_every_text_labelled_the_share_is_that_of_the_people_and_chains_are_those_of_their_labels(talk):
    label_all(talk, WARNING, "ana", lambda one: "no", 10_000)
    analysed = analysis.analyze([talk.path])
    frame = analysed.runs
    assert frame[SHARE].to_numpy() == pytest.approx(0, abs=1e-12)
    assert frame["warning.social_reach"].dropna().eq(0).all() and frame["warning.social_reach"].notna().any()
    assert frame["warning.social_reach_uncorrected"].max() > 0 or frame["warning.social_reach_uncorrected"].isna().any()
    assert "warning.relay_probability_uncorrected" not in frame, "relays have no correction"
    relay = "warning.relay_probability"
    assert analysed.readings[relay].text == "as labelled by rule 4 (not corrected by people's labels)"
    assert analysed.readings[f"{SHARE}_uncorrected"].text == "as labelled by rule 4"
    [sentence] = [one for one in analysis.analyze([talk.path], family=[relay]).summary if relay in one]
    assert "as labelled by rule 4 (not corrected by people's labels)" in sentence
    assert "warning.oracle_reach" not in analysed.readings
    rows = {row[0].partition(":")[0]: row for row in card("a", [talk.path]).settings[0].table.rows}
    assert "corrected with" in rows["warning.social_reach"][0] and "(uncorrected " in rows["warning.social_reach"][1]
    assert rows[relay][0].endswith(", as labelled by rule 4 (not corrected by people's labels)")


@pytest.mark.slow
def test_too_few_labels_and_runs_that_came_later_correct_nothing_and_the_notes_say_what_to_do(talk, tmp_path):
    draw(talk, WARNING)
    before = analysis.analyze([talk.path])
    assert f"{SHARE}_uncorrected" not in before.runs
    assert "as labelled by rule 4" in {reading.text for reading in before.readings.values()}
    label_all(talk, WARNING, "ana", lambda one: "yes" if one.seed < 0 else "unclear")
    note = next(note for note in analysis.analyze([talk.path]).notes if "not corrected" in note)
    assert "have a label by a person, but" in note and f"continue with foundry play {talk.path} --label warning" in note
    old = [item for item in items_of(talk, WARNING) if item.seed < 2]
    empty = Sample(label="warning", question_sha256=WARNING.question_sha256, seed=0)
    sample = extended(empty, WARNING, old, dict.fromkeys(item.run for item in old), 10_000)
    folder = LabelFolder.of(talk, "warning")
    folder.keep_sample(sample)
    for one in sample.drawn:
        folder.add("ana", Entry(item=one.item, label="yes"))
    grown = analysis.analyze([talk.path])
    assert "no texts to label were drawn from 4 newer runs" in next(
        note for note in grown.notes if "not corrected" in note
    )
    assert f"{SHARE}_uncorrected" not in grown.runs


@pytest.mark.slow
def test_a_label_of_ones_own_is_a_signature_by_its_rule_by_a_model_and_corrected(talk, tmp_path, monkeypatch):
    mine = tmp_path / "mine" / "labels"
    mine.mkdir(parents=True)
    (mine / "polite.yaml").write_text('question: Is it polite?\nrule: "hello"\n', encoding="utf-8")
    (mine / "tongue.yaml").write_text("question: Which language?\nchoices: [english, other]\n", encoding="utf-8")
    monkeypatch.setenv("FOUNDRY_MINE", str(tmp_path / "mine"))
    polite, tongue = label_named("polite"), label_named("tongue")
    draw(talk, polite)
    steps = analysis.load(talk.path).steps
    said = steps[steps["message"].notna()]
    hello = said.assign(is_hello=said["message"] == "hello").groupby("run")["is_hello"].mean()
    by_rule = analysis.analyze([talk.path])
    assert by_rule.runs.set_index("run")["polite.share"].to_dict() == pytest.approx(hello.to_dict())
    read = said[said["message_outcome"] == "chosen"].groupby("run").size()
    assert by_rule.runs.set_index("run")["polite.n_texts_readable"].to_dict() == read.to_dict(), "messages, not actions"
    assert "polite.share" in by_rule.declared and by_rule.readings["polite.share"].text == "as labelled by the rule"
    assert "polite" in set(by_rule.sources["signature"]) and "refusal" not in set(by_rule.sources["signature"])
    label_all(talk, polite, "ana", lambda one: "no" if one.text == "hello" else "yes", 10_000)
    label_all(talk, tongue, "ana", lambda one: "english" if one.text == "hello" else "other", 10_000)
    runs = analysis.analyze([talk.path]).runs.set_index("run")
    assert runs["polite.share"].to_numpy() == pytest.approx(1 - hello[runs.index].to_numpy())
    assert runs["polite.share_uncorrected"].to_dict() == pytest.approx(hello.to_dict())
    assert runs["tongue.share_english"].to_dict() == pytest.approx(hello.to_dict())
    assert (runs["tongue.share_english"] + runs["tongue.share_other"]).to_numpy() == pytest.approx(1)
    assert (runs["tongue.n_texts"] == runs["warning.n_messages"]).all()
    assert (runs["tongue.n_labelled"] == runs["tongue.n_texts"]).all()


@pytest.mark.slow
def test_a_model_in_the_place_of_the_rule_is_corrected_too_and_named(talk):
    fires = tuple(fire["name"] for fire in WORLD["fires"])
    texts = ("Feuer!", "hello", "there is smoke", "bonjour", "no fire here")
    judge(talk, dict.fromkeys(texts, "yes"), fires, {})
    by_model = analysis.analyze([talk.path], labelled_by_model=True)
    assert (by_model.runs[SHARE] == 1).all() and by_model.readings[SHARE].text.startswith("as labelled by judge:1b")
    texts_labelled = label_all(talk, WARNING, "ana", lambda one: "yes" if one.text == "Feuer!" else "no", 10_000)
    corrected = analysis.analyze([talk.path], labelled_by_model=True)
    assert corrected.readings[SHARE].text == f"corrected with {texts_labelled} labels of 1 person"
    assert (corrected.runs[f"{SHARE}_uncorrected"] == 1).all()
    means = corrected.runs.groupby("model")[SHARE].mean()
    assert 0.1 < means["a"] < 0.6 and means["b"] == pytest.approx(0)


@pytest.mark.slow
def test_the_differences_of_copies_spread_wider_than_their_means_do(make_sweep):
    texts = tuple(f"{'there is smoke' if number % 3 else 'hello'} {number}" for number in range(900))
    habits = {model: Habits(texts=texts) for model in "ab"}
    talk = make_sweep([make_condition(model, range(6)) for model in "ab"], habits)
    label_all(talk, WARNING, "ana", lambda one: "no" if (one.seed + one.step) % 3 else "yes", 40)
    found = analysis.analyze([talk.path])
    measure = "warning.rmst"
    assert np.nanmax(np.ptp(found.table.copies[measure], axis=1)) > 0, "the copies differ"
    row = found.contrasts.set_index("measure").loc[measure]
    runs = found.runs.pivot_table(index="seed", columns="model", values=measure)
    plain = (runs[row["level"]] - runs[row["reference"]]).dropna()
    assert row["difference"] == pytest.approx(plain.mean())
    mean = found.comparison.set_index(["measure", "model"]).loc[(measure, row["level"])]
    assert mean["mean"] == pytest.approx(runs[row["level"]].mean())
    assert mean["sd"] > runs[row["level"]].std(), "so do the values behind the mean of a model"
    remembered = analysis.analyze([talk.path]).table.copies
    assert (remembered[measure] == found.table.copies[measure]).all(), "a second analysis remembers the copies"
    alone = estimate(plain.to_numpy(), beside_sign_flips=True)
    assert row["high"] - row["low"] > alone.high - alone.low, "the copies leave more open than their means do"


def test_who_knows_of_a_fire_is_the_same_to_the_texts_that_are_drawn_and_to_the_copies(talk):
    known = {(item.run, item.step, item.agent): item.aware for item in items_of(talk, WARNING)}
    arrays = [measurable(run, run.summary()) for run in talk.runs()]
    aware = {whole.run.id: warning.knows_of_a_fire(whole.run, WARNING) for whole in arrays if whole is not None}
    assert known == {place: bool(aware[place[0]][place[1] - 1, place[2]]) for place in known}
    heard = [place for place in known if known[place] and not perceived_by_then(arrays, place)]
    assert heard, "some know from others alone"


def perceived_by_then(arrays: list[Any], place: tuple[str, int, int]) -> bool:
    run = next(whole.run for whole in arrays if whole.run.id == place[0])
    return bool(run.perceived[: place[1], place[2]].any())
