"""Labels of messages: by the rule, by a model, and their agreement with labels given by reading."""

import math

import pytest

import analysis
from analysis.agreement import Interval
from analysis.labelling import FIRES, Agreement, agreement, hand_labelled, labelling_of, rule_labelling
from analysis.labelling.warning_rule import is_warning
from foundry.errors import InputError, RecordError
from foundry.labels.definition import label_named
from labels_of_sweeps import judge
from walkers import WORLD, Habits, make_condition

SUPPORTED = {"en", "ja"}
BY_RULE = "labels of warnings by rule 4: precision at most 0.90, recall at most 0.90"


def truth() -> dict[str, str | None]:
    return {labelled.text: "yes" if labelled.warning else "no" for labelled in hand_labelled()}


def every(which):
    return [*hand_labelled(which, "beside_rule"), *hand_labelled(which, "apart")]


def test_half_of_at_least_five_hundred_hand_labelled_texts_are_held_out():
    held, tuning = every("held_out"), every("tuning")
    assert len(held) + len(tuning) >= 500
    assert abs(len(held) - len(tuning)) <= 10
    styles = {"question-informs", "negated-harm", "position-hazard", "fire-free", "figurative", "smoky"}
    assert styles <= {one.style for one in held} & {one.style for one in tuning}
    assert not {one.text for one in held} & {one.text for one in tuning}


def test_the_rule_labels_every_text_it_was_tuned_on_and_leaves_other_languages_open():
    labels = [(one, is_warning(one.text, FIRES)) for one in every("tuning")]
    assert [one.text for one, label in labels if one.language in SUPPORTED and label is not one.warning] == []
    texts = [*every("tuning"), *every("held_out")]
    unknown = [text for text in texts if is_warning(text.text, FIRES) is None]
    assert {one.language for one in unknown} & SUPPORTED == set()
    assert len(unknown) == sum(text.language not in SUPPORTED for text in texts) == 225


def test_the_agreement_of_the_rule_is_that_on_texts_held_out_and_written_apart():
    found = rule_labelling().agreement
    assert found == agreement([is_warning(labelled.text, FIRES) for labelled in hand_labelled()])
    labels = [(is_warning(labelled.text, FIRES), labelled.warning) for labelled in hand_labelled()]
    assert (found.texts, found.unlabelled, found.missed, found.false_warnings) == (131, 47, 4, 4)
    assert found.true_warnings == labels.count((True, True)) == 38
    assert (found.precision, found.recall) == pytest.approx((38 / 42, 38 / 42))
    # By hand: of 84 texts 42 are warnings, and the rule calls 42 some, so chance is a half.
    assert found.kappa == pytest.approx((76 / 84 - 1 / 2) / (1 - 1 / 2))
    # Fleiss, Cohen and Everitt 1969: of 84 texts 38 + 38 right and 4 + 4 wrong, a standard error of 0.064.
    assert found.interval.low == pytest.approx(found.kappa - 1.99 * 0.064, abs=0.01)
    assert found.interval.high == pytest.approx(found.kappa + 1.99 * 0.064, abs=0.01)
    assert found.is_better_than_chance


def test_agreement_is_over_what_has_a_label_and_without_any_with_nobody():
    right: list[bool | None] = [labelled.warning for labelled in hand_labelled()]
    warnings = sum(one is True for one in right)
    assert agreement(right) == Agreement(len(right), 0, warnings, 0, 0, 1.0, Interval(1.0, 1.0))
    left = sum(one is True for one in right[2:])
    assert agreement([None, None, *right[2:]]) == Agreement(len(right), 2, left, 0, 0, 1.0, Interval(1.0, 1.0))
    wrong = agreement([not label for label in right])
    assert (wrong.precision, wrong.recall, wrong.kappa < 0) == (0, 0, True)
    found = agreement([None] * len(hand_labelled()))
    assert math.isnan(found.precision) and math.isnan(found.recall) and math.isnan(found.kappa)
    assert not found.is_better_than_chance and not wrong.is_better_than_chance


def test_labels_no_better_than_chance_are_said_first_and_on_every_row(make_sweep):
    world = {**WORLD, "steps": 6}
    sweep = make_sweep([make_condition(model, range(2), world=world) for model in "ab"])
    fires = tuple(fire["name"] for fire in world["fires"])
    judge(sweep, {"there is smoke": "yes"}, fires, dict.fromkeys(truth(), "yes"))
    found = analysis.analyze([sweep.path], plots=False, labelled_by_model=True)
    question = label_named("warning").question_sha256[:8]
    said = f"the labels of judge:1b (abababababab), question {question} are not better than chance (Cohen's kappa "
    assert found.summary[0].startswith(f"No measure of warning can be trusted: {said}") and len(found.summary) <= 6
    assert found.notes[0].startswith("no measure of warning can be trusted")
    for frame in (found.contrasts, found.comparison):
        doubted = frame["note"].astype(str).str.startswith(said)
        assert doubted.equals(frame["measure"].str.startswith("warning."))


def test_an_analysis_says_whose_labels_it_takes_and_counts_messages_without_one(make_sweep):
    other = {**WORLD, "fires": WORLD["fires"][:1]}
    conditions = [make_condition("a", [0]), make_condition("foreign", [0], world=other)]
    habits = Habits(texts=("Kein Feuer, alles ruhig hier.", "fire1 near me"))
    sweep = make_sweep(conditions, {"foreign": habits})
    by_rule = analysis.analyze([sweep.path], plots=False)
    assert BY_RULE in by_rule.notes
    assert missing_note(by_rule, "the rule covers only English and Japanese") in by_rule.notes
    own, foreign = by_rule.runs.to_dict("records")
    assert 0 == own["warning.n_unlabelled"] < foreign["warning.n_unlabelled"] < foreign["warning.n_messages"]
    assert foreign["warning.unknown"] == foreign["warning.n_unlabelled"] / foreign["warning.n_messages"]
    assert foreign["warning.warning_share"] == 1
    fires = tuple(fire["name"] for fire in WORLD["fires"])
    said: dict[str, str | None] = {"hello": "yes", "there is smoke": None}
    said |= dict.fromkeys(("fire1 near me", "火事だ、逃げて", "shall we meet in the cafe?"), "no")
    judge(sweep, said, fires, truth())
    found = analysis.analyze([sweep.path], plots=False, labelled_by_model=True)
    assert found.runs["idle_rate.chosen"].tolist() == by_rule.runs["idle_rate.chosen"].tolist()
    question = label_named("warning").question_sha256[:8]
    labeller = f"judge:1b (abababababab), question {question}"
    assert f"labels of warnings by {labeller}: precision at most 1.00, recall at most 1.00" in found.notes
    assert missing_note(found, "the model was not asked, or answered neither yes nor no") in found.notes
    assert not found.doubts and not any("trusted" in line for line in (*found.summary, *found.notes))
    steps = analysis.load(sweep.path).steps
    said = steps[steps["run"] == found.runs["run"][0]]["message"]
    own, foreign = found.runs.to_dict("records")
    assert own["warning.n_warnings"] == (said == "hello").sum() > 0
    assert own["warning.n_unlabelled"] == (said == "there is smoke").sum() > 0
    assert foreign["warning.n_unlabelled"] == foreign["warning.n_messages"], "the labels are for other names of fires"


def missing_note(found: analysis.Analysis, why: str) -> str:
    missing, said = (int(found.runs[f"warning.n_{name}"].sum()) for name in ("unlabelled", "messages"))
    return f"{missing} of {said} messages have no label because {why}; the measures that need these labels are missing"


def test_labels_by_a_model_that_are_missing_or_damaged_are_named_and_any_label_changes_their_version(make_sweep):
    sweep = make_sweep([make_condition("a", [0])])
    with pytest.raises(InputError, match="foundry label"):
        analysis.analyze([sweep.path], plots=False, labelled_by_model=True)
    versions = set()
    for label in ("yes", "no", None):
        judge(sweep, {"hello": label}, ("fire1",), {})
        versions.add(labelling_of(sweep, by_model=True).version)
    assert len(versions | {rule_labelling().version}) == 4
    [file] = (sweep.path / "labels" / "warning" / "models").iterdir()
    file.write_bytes(b"{")
    with pytest.raises(RecordError, match=file.name):
        labelling_of(sweep, by_model=True)
