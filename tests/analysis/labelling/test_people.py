"""People, models and rules that label the same texts: how far they agree, and which commands are refused."""

import math

import numpy as np
import pytest

import analysis
from analysis.agreement import krippendorff_alpha
from analysis.labelling.people import clustered_kappa, labellers
from commands import refusal, succeeds
from foundry.labels.definition import label_named
from foundry.labels.folder import Entry, LabelFolder
from foundry.storing.store import SweepFolder
from labels_of_sweeps import draw, judge, label_all
from walkers import WORLD, Habits, make_condition

WARNING = label_named("warning")
TEXTS = tuple(f"there is smoke {number}" if number % 2 else f"hello {number}" for number in range(20))


@pytest.fixture
def talk(make_sweep) -> SweepFolder:
    """A sweep of six seeds in which twenty texts are said, half of them warnings."""
    return make_sweep([make_condition("a", range(6))], {"a": Habits(texts=TEXTS)})


def warns(text: str) -> str:
    return "yes" if "smoke" in text else "no"


def test_people_a_model_and_the_rule_are_held_against_each_other_on_the_texts_that_both_labelled(talk):
    fires = tuple(fire["name"] for fire in WORLD["fires"])
    judge(talk, {text: "yes" for text in TEXTS}, fires, {})
    texts = label_all(talk, WARNING, "ana", lambda one: warns(one.text))
    folder, sample = LabelFolder.of(talk, "warning"), draw(talk, WARNING)
    some = [one for one in sample.drawn if int(one.text.split()[-1]) < 10]
    for number, one in enumerate(some):
        unlike = {"yes": "no", "no": "yes"}[warns(one.text)]
        folder.add("ben", Entry(item=one.item, label="unclear" if number == 0 else unlike))
    frame = labellers(talk).set_index(["first", "second"])
    assert list(frame.index) == [
        ("ana", "ben"), ("ana", "judge:1b"), ("ana", "the rule"), ("ben", "judge:1b"), ("ben", "the rule"),
        ("all 3 people and models", ""),
    ]  # fmt: skip
    rule = frame.loc[("ana", "the rule")]
    assert (rule["label"], rule["texts"], rule["seeds"], rule["same"], rule["kappa"]) == ("warning", texts, 6, 1.0, 1.0)
    assert math.isnan(rule["low"]), "where all agree without any seed, nothing is known of the spread"
    against = frame.loc[("ana", "ben")]
    assert (against["texts"], against["same"], against["kappa"]) == (len(some) - 1, 0.0, pytest.approx(-1, abs=0.1))
    assert frame.loc[("ana", "judge:1b"), "kappa"] == 0, "who always says yes is no better than chance"
    assert frame.loc[("all 3 people and models", ""), "texts"] == texts


@pytest.mark.slow
def test_an_analysis_writes_the_table_of_labellers_and_removes_it_when_nobody_labelled(talk):
    label_all(talk, WARNING, "ana", lambda one: warns(one.text))
    assert talk.analysis_dir / "labellers.csv" in analysis.analyze([talk.path], plots=False).written
    assert "ana" in (talk.analysis_dir / "labellers.md").read_text(encoding="utf-8")
    (talk.path / "labels" / "warning" / "people" / "ana.jsonl").unlink()
    analysis.analyze([talk.path], plots=False)
    assert not (talk.analysis_dir / "labellers.md").exists()


@pytest.mark.slow
def test_the_recorded_decision_is_the_rule_of_the_label_reading_and_unread_replies_are_a_stratum(tmp_path):
    flaky = ("model=scripted/flaky", "world.agents=8", "world.steps=6", "analyze=false", "output.dir=flaky")
    succeeds("-m", *flaky, "seed=0-3", cwd=tmp_path)
    sweep, reading = SweepFolder.open(tmp_path / "flaky"), label_named("reading")
    texts = label_all(sweep, reading, "ana", lambda one: "none", 60)
    sample = LabelFolder.of(sweep, "reading").sample()
    strata = {one.says for one in sample.strata}
    assert strata == {"near", "stay", "up", "down", "left", "right"}, "near are those that could not be read"
    assert all(set(one.context["actions"]) == strata - {"near"} for one in sample.drawn)
    [row] = labellers(sweep).to_dict("records")
    assert (row["second"], row["same"]) == ("the rule", 0.0) and 0 < row["texts"] < texts
    assert "reading" not in {name.partition(".")[0] for name in analysis.analyze([sweep.path]).table.measures}


@pytest.mark.parametrize(
    ("arguments", "reason"),
    [
        (("--label", "warnin"), "Did you mean 'warning'?"),
        (("--label", "warning", "model=human/ana"), "--label takes one sweep and nothing else"),
        (("missing", "--label", "warning"), "--label takes one sweep and nothing else"),
        (("--label", "sight_claim"), "have no replies in 3D, so label 'sight_claim'"),
        (("--per-model", "5"), "--per-model only works with --label"),
        (("--label", "polite", "--config-dir", "absent"), "folder not found"),
    ],
)
def test_a_sitting_that_cannot_be_is_refused_in_one_line(talk, tmp_path, arguments, reason):
    assert reason in refusal("play", str(talk.path), *arguments, cwd=tmp_path)


def test_labels_to_an_earlier_wording_of_a_question_are_not_mixed_with_those_to_another(talk, tmp_path, monkeypatch):
    mine = tmp_path / "mine" / "labels"
    mine.mkdir(parents=True)
    (mine / "polite.yaml").write_text("question: Is it polite?\n", encoding="utf-8")
    monkeypatch.setenv("FOUNDRY_MINE", str(tmp_path / "mine"))
    label_all(talk, label_named("polite"), "ana", lambda one: "yes")
    assert "polite" in set(labellers(talk)["label"]) or labellers(talk).empty
    (mine / "polite.yaml").write_text("question: Is it friendly?\n", encoding="utf-8")
    assert "an earlier wording of the question 'polite'" in refusal(
        "play", str(talk.path), "--label", "polite", "--config-dir", str(tmp_path / "mine"), cwd=tmp_path
    )
    assert labellers(talk).empty


def test_krippendorffs_alpha_is_that_of_his_example_with_missing_labels():
    # Krippendorff 2011, example C: four observers, twelve units, five nominal values; alpha is .743.
    ratings = [
        "1 2 3 3 2 1 4 1 2 . . .", "1 2 3 3 2 2 4 1 2 5 . 3", ". 3 3 3 2 3 4 2 2 5 1 .", "1 2 3 3 2 4 4 1 2 5 1 .",
    ]  # fmt: skip
    rows = list(zip(*(row.split() for row in ratings), strict=True))
    counts = np.array([[row.count(str(value)) for value in range(1, 6)] for row in rows])
    assert krippendorff_alpha(counts) == pytest.approx(0.743, abs=0.0005)
    assert math.isnan(krippendorff_alpha(np.array([[2, 0], [3, 0]])))


def drawn_pair(rng: np.random.Generator, clusters: int, texts: int) -> tuple[np.ndarray, np.ndarray, np.ndarray]:
    """Two labellers of whom the second errs in a tenth, on texts whose clusters differ in how many are warnings."""
    cluster = np.repeat(np.arange(clusters), texts)
    first = (rng.random(clusters * texts) < rng.beta(1.5, 3.5, clusters)[cluster]).astype(np.int64)
    return first, np.where(rng.random(len(first)) < 0.9, first, 1 - first), cluster


def test_the_interval_of_kappa_covers_it_as_often_as_it_says_and_one_seed_has_none():
    rng = np.random.default_rng(1)
    truth = clustered_kappa(*drawn_pair(rng, 3000, 10)).kappa
    kappas = [clustered_kappa(*drawn_pair(rng, 12, 10)) for _ in range(200)]
    covered = np.mean([kappa.low <= truth <= kappa.high for kappa in kappas])
    assert 0.90 <= covered <= 0.98
    of_one_seed = clustered_kappa(np.array([0, 1, 1]), np.array([0, 1, 0]), np.array([4, 4, 4]))
    assert of_one_seed.note == "no interval: one seed" and math.isnan(of_one_seed.low)
