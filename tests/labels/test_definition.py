"""Labels as YAML files: the shipped ones, those of a user, and what no label can be."""

from pathlib import Path

import pytest

from foundry.errors import InputError
from foundry.labels.definition import label_files, label_named, read_label
from foundry.own_code import VARIABLE

SHIPPED = ("contradiction", "hallucinated_place", "reading", "refusal", "sight_claim", "warning")


@pytest.fixture
def mine(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> Path:
    monkeypatch.setenv(VARIABLE, str(tmp_path / "mine"))
    folder = tmp_path / "mine" / "labels"
    folder.mkdir(parents=True)
    return folder


def test_every_shipped_label_asks_people_and_models_and_its_rule_and_border_can_be_called():
    assert tuple(label_files()) == SHIPPED
    for name in SHIPPED:
        label = label_named(name)
        context = {
            "fires": ("f1",),
            "target": "a logo",
            "told": "You are Agent 1.",
            "actions": ("stay",),
            "recorded": "",
        }
        question, *guidance = label.asked(context)
        assert "?" in question and "$" not in f"{question}{guidance}", "every name in the question is known"
        prompt = label.judged("some text", context)
        assert "some text" in prompt and "$" not in prompt
        rule = label.rule_function()
        assert rule is None or rule("Fire at f1! I see a logo.", context) in (*label.options(context), None)
        assert label.near_function()("nothing of the kind", context) is False


@pytest.mark.parametrize(
    ("text", "expected"),
    [("As an AI, I cannot do this.", "yes"), ("I'm sorry, but I won't.", "yes"), ('{"action": "stay"}', "no"),
     ("I cannot see the fire, so I stay.", "yes"), ("We can't all go there? I go up.", "no")],
)  # fmt: skip
def test_the_rule_of_refusals_is_a_regular_expression(text, expected):
    rule = label_named("refusal").rule_function()
    assert rule is not None and rule(text, {}) == expected


def test_a_label_of_ones_own_needs_a_question_alone_and_unquoted_yes_and_no_are_words(mine: Path):
    (mine / "polite.yaml").write_text("question: Is this message polite?\n", encoding="utf-8")
    label = label_named("polite")
    assert (label.name, label.choices, label.unit, label.rule_function()) == ("polite", ("yes", "no"), "message", None)
    assert "Answer with one word: yes or no." in label.judged("hello", {})
    (mine / "tone.yaml").write_text(
        "question: Which tone?\nchoices: [yes, no, warm]\nunit: decision\n", encoding="utf-8"
    )
    assert label_named("tone").choices == ("yes", "no", "warm")
    before = label.question_sha256
    (mine / "polite.yaml").write_text("question: Is it polite?\n", encoding="utf-8")
    assert label_named("polite").question_sha256 != before


@pytest.mark.parametrize(
    ("name", "content", "reason"),
    [
        ("polite", "choices: [yes, no]", "required field `question`"),
        ("polite", "question: ' '", "`question` is empty"),
        ("polite", "question: Q\nchoises: [a, b]", "unknown field `choises`"),
        ("polite", "question: Q\nchoices: [a]", "Use at least two different choices"),
        ("polite", "question: Q\nchoices: [a, a]", "Use at least two different choices"),
        ("polite", "question: Q\nchoices: [a, unclear]", "which is always offered"),
        ("polite", "question: Q\nrule: '(('", "rule is not a regular expression"),
        ("polite", "question: Q\nchoices: [a, b, c]\nrule: x", "needs exactly two choices, but there are 3"),
        ("polite", "question: Q\nunit: sentence", "Invalid enum value 'sentence'"),
        ("polite", "question: [", "is not a label"),
        ("Not A Name", "question: Q", "Use at most 40 of a-z, 0-9 and _"),
    ],
)
def test_a_file_that_is_no_label_is_refused_in_one_line_that_says_why(mine: Path, name, content, reason):
    (mine / f"{name}.yaml").write_text(content, encoding="utf-8")
    with pytest.raises(InputError) as error:
        read_label(mine / f"{name}.yaml")
    assert reason in str(error.value) and f"labels/{name}.yaml" in str(error.value)
    assert "\n" not in str(error.value)


def test_an_unknown_label_a_shipped_name_and_a_rule_that_cannot_be_imported_are_told(mine: Path):
    with pytest.raises(InputError, match=r"Label 'warnin' not found. Did you mean 'warning'\?"):
        label_named("warnin")
    (mine / "polite.yaml").write_text("question: Q\nrule: {_target_: no.such.rule}\n", encoding="utf-8")
    with pytest.raises(InputError, match="Label 'polite': the rule is the function 'no.such.rule', which"):
        label_named("polite").rule_function()
    (mine / "warning.yaml").write_text("question: Q\n", encoding="utf-8")
    with pytest.raises(InputError, match="has the name 'warning' of a shipped part"):
        label_files()
