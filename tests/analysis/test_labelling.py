"""Labels of messages: by the rule, by a model, and their agreement with people."""

from __future__ import annotations

import pytest

import analysis
from analysis.labelling import FIRES, Agreement, agreement, hand_labelled, model_labelling, question, rule_labelling
from analysis.warning_rule import is_warning
from foundry.errors import InputError, RecordError
from foundry.records import Labelled, Labels


def labels(texts: dict[str, bool | None], fires: tuple[str, ...], hand: dict[str, bool | None]) -> Labels:
    def lines(said: dict[str, bool | None], names: tuple[str, ...]) -> tuple[Labelled, ...]:
        return tuple(Labelled(text=text, fires=names, warning=label, reply="") for text, label in said.items())

    return Labels(
        labeller="judge:1b",
        digest="ab" * 32,
        question_sha256="cd" * 32,
        parameters={},
        labels=lines(texts, fires),
        hand_labelled=lines(hand, FIRES),
    )


def truth() -> dict[str, bool | None]:
    return {one.text: one.warning for one in hand_labelled()}


@pytest.mark.parametrize("which", ["tuning", "held_out"])
def test_the_hand_labelled_texts_are_of_many_languages_and_both_kinds(which):
    texts = hand_labelled(which)
    assert len(texts) == len({one.text for one in texts}) >= 120
    assert len({one.language for one in texts}) >= 8
    assert 0.3 < sum(one.warning for one in texts) / len(texts) < 0.7


@pytest.mark.parametrize("text", ["The cafe is warm.", "No fire here.", "Is there a fire?"])
def test_hard_texts_that_warn_of_nothing_are_among_those_for_tuning(text):
    assert {one.text: one.warning for one in hand_labelled("tuning")}[text] is False


def test_no_text_is_both_for_tuning_and_held_out():
    assert not {one.text for one in hand_labelled("tuning")} & set(truth())


def test_the_rule_labels_every_text_it_was_tuned_on_as_people_do():
    assert [one.text for one in hand_labelled("tuning") if is_warning(one.text, FIRES) != one.warning] == []


def test_the_agreement_of_the_rule_is_that_on_held_out_texts():
    found = rule_labelling().agreement
    missed = sum(one.warning and not is_warning(one.text, FIRES) for one in hand_labelled())
    false = sum(not one.warning and is_warning(one.text, FIRES) for one in hand_labelled())
    assert (found.texts, found.unlabelled, missed, false) == (121, 0, 2, 3)
    assert found.accuracy == pytest.approx(116 / 121)
    # By hand: 61 warnings by people, 62 by the rule; chance agreement is (61 * 62 + 60 * 59) / 121**2.
    chance = (61 * 62 + 60 * 59) / 121**2
    assert found.kappa == pytest.approx((116 / 121 - chance) / (1 - chance))


def test_agreement_is_over_what_has_a_label():
    right: list[bool | None] = list(truth().values())
    assert agreement(right) == Agreement(len(right), 0, 1.0, 1.0)
    assert agreement([None, None, *right[2:]]) == Agreement(len(right), 2, 1.0, 1.0)
    wrong = agreement([not label for label in right])
    assert (wrong.accuracy, wrong.kappa < 0) == (0, True)


def test_the_question_holds_the_message_and_the_fires():
    assert question().count("$message") == question().count("$fires") == 1


def test_without_labels_by_a_model_the_way_to_get_them_is_named(make_sweep, make_condition):
    sweep = make_sweep([make_condition("a", [0])])
    with pytest.raises(InputError, match="foundry label"):
        analysis.analyze([sweep.path], plots=False, labelled_by_model=True)


def test_a_damaged_file_of_labels_is_named(make_sweep, make_condition):
    sweep = make_sweep([make_condition("a", [0])])
    sweep.write_labels(labels({}, (), {}))
    sweep.labels_file.write_bytes(b"{")
    with pytest.raises(RecordError, match=r"labels\.json"):
        model_labelling(sweep)


def test_an_analysis_takes_the_labels_of_the_model_and_says_whose_they_are(make_sweep, make_condition, small_world):
    sweep = make_sweep([make_condition("a", range(2))])
    fires = tuple(fire["name"] for fire in small_world["fires"])
    said = ("hello", "fire1 near me", "火事だ、逃げて", "shall we meet in the cafe?", "there is smoke")
    by_rule = analysis.analyze([sweep.path], plots=False)
    sweep.write_labels(labels({text: text == "hello" for text in said}, fires, truth()))
    found = analysis.analyze([sweep.path], plots=False, labelled_by_model=True)
    assert found.runs["warning.n_warnings"].tolist() != by_rule.runs["warning.n_warnings"].tolist()
    assert found.runs["idle_rate.chosen"].tolist() == by_rule.runs["idle_rate.chosen"].tolist()
    expected = "warnings by judge:1b (abababababab), question cdcdcdcd: accuracy 1.00, Cohen's kappa 1.00"
    assert any(note.startswith(expected) for note in found.notes)
    assert any(
        note.startswith("warnings by rule 2: accuracy 0.96, Cohen's kappa 0.92 on 121 held-out")
        for note in by_rule.notes
    )


def test_messages_without_a_label_are_counted_and_named(make_sweep, make_condition, small_world):
    sweep = make_sweep([make_condition("a", [0])])
    fires = tuple(fire["name"] for fire in small_world["fires"])
    sweep.write_labels(labels({"hello": False, "there is smoke": None}, fires, {}))
    found = analysis.analyze([sweep.path], plots=False, labelled_by_model=True)
    missing = int(found.runs["warning.n_unlabelled"][0])
    assert missing > 0
    assert f"{missing} messages have no label; what depends on them is missing" in found.notes


def test_labels_for_other_names_of_fires_do_not_count(make_sweep, make_condition):
    sweep = make_sweep([make_condition("a", [0])])
    sweep.write_labels(labels({"hello": False}, ("another",), {}))
    found = analysis.analyze([sweep.path], plots=False, labelled_by_model=True)
    assert found.runs["warning.n_unlabelled"][0] == found.runs["warning.n_messages"][0]


def test_a_labelling_has_a_version_that_changes_with_any_label(make_sweep, make_condition):
    sweep = make_sweep([make_condition("a", [0])])
    versions = set()
    for label in (True, False, None):
        sweep.write_labels(labels({"hello": label}, ("fire1",), {}))
        versions.add(model_labelling(sweep).version)
    assert len(versions | {rule_labelling().version}) == 4
