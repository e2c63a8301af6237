"""Formats change how a prompt is written, and neither what is said in it nor the shape of the reply."""

import re
import unicodedata
from collections.abc import Callable
from pathlib import Path
from typing import Any

import pytest
import yaml
from hypothesis import example, given
from hypothesis import strategies as st

from foundry.composing.compose import compose
from foundry.composing.recorded import compose_recorded
from foundry.errors import InputError
from foundry.paths import conf_dir
from foundry.prompts.formats import Format
from foundry.prompts.prompt import Prompt
from foundry.worlds.base import Question

SPREAD: dict[str, Any] = yaml.safe_load((conf_dir() / "format" / "spread.yaml").read_text("utf-8"))
PROMPTS = sorted((conf_dir() / "prompt").glob("*.yaml"))
TEMPLATE = """You are Agent 1.

=== WHERE YOU ARE ===
{% if place %}
Current place: {{ place }}
{% endif %}
Step: {{ step }}

=== WHAT YOU HEARD ===
{% for text in heard %}
- {{ text }}{% if loop.last %} (the last){% endif %}

{% endfor %}

=== WHAT YOU CAN DO ===
- "stay": stand still

=== YOUR ANSWER ===
Answer with one JSON object:
{
    "action": "stay"
}

Round: {{ step }}
"""
SAID = ["=== RUN ===", "Name: fire\n- nöw"]


def written(space: dict[str, Any] | None = None, template: str = TEMPLATE, **observed: Any) -> str:
    """Return a question by a template in a format, or in none."""
    observation = observed or {"place": "Bär", "step": 3, "heard": SAID}
    asked = Question(agent=1, step=3, kind="action", observation=observation)
    return Prompt("p", {"action": template}, format=space).render(asked)[0].content


def one_format(**features: Any) -> dict[str, Any]:
    """Return a space with the one format that has these features."""
    return {"name": "own", "options": {key: [value] for key, value in features.items()}, "draw": 0}


def test_the_format_in_which_a_prompt_is_written_changes_nothing():
    assert written(one_format(heading="=== {} ===")) == written()


@pytest.mark.parametrize(
    ("feature", "option", "changed"),
    [
        ("heading", "## {}", {"=== WHERE": "## WHERE", "HEARD ===": "HEARD", "ARE ===": "ARE", "=== WHAT": "## WHAT",
                              "DO ===": "DO", "=== YOUR ANSWER ===": "## YOUR ANSWER"}),
        ("separator", " = ", {"place: ": "place = ", "Step: ": "Step = ", "Round: ": "Round = "}),
        ("item", "* ", {"- === R": "* === R", "- Name": "* Name", '- "stay"': '* "stay"'}),
        ("case", "upper", {"Current place": "CURRENT PLACE", "Step": "STEP", "Round": "ROUND"}),
        ("wording", {"Answer": "Reply", "stay": "halt", "place": "spot", "if": "or", "last": "end"},
         {"Answer": "Reply", '- "stay"': '- "halt"', "Current place": "Current spot", "the last": "the end"}),
        ("structure", "json", {"Current place: Bär\nStep: 3": '{"Current place": "Bär", "Step": "3"}',
                               "- === RUN ===\n- Name: fire\n- nöw (the last)":
                               '["=== RUN ===", "Name: fire\\n- nöw (the last)"]', "Round: 3": '{"Round": "3"}'}),
    ],
)  # fmt: skip
def test_a_feature_changes_the_words_of_the_template_and_no_others(feature: str, option: Any, changed: dict[str, str]):
    expected = written()
    for before, after in changed.items():
        assert before in expected
        expected = expected.replace(before, after)
    assert written(one_format(**{feature: option})) == expected


def test_items_are_numbered_from_one_in_each_list():
    text = written(one_format(item="{n}) "))
    assert "1) === RUN ===\n2) Name: fire\n- nöw" in text and '1) "stay"' in text


@pytest.mark.parametrize(("case", "cased"), [("upper", str.upper), ("lower", str.lower), ("title", str.title)])
@pytest.mark.parametrize("structure", ["lines", "json"])
def test_a_case_is_that_of_headings_and_labels_alone(case: str, cased: Callable[[str], str], structure: str):
    template = "=== Where you ARE ===\nNow at: {{ place }}\n- Go oN\n"
    text = written(one_format(case=case, structure=structure), template, place="mY bar")
    label = f"{cased('Now at')}: mY bar" if structure == "lines" else f'{{"{cased("Now at")}": "mY bar"}}'
    assert text == f"=== {cased('Where you ARE')} ===\n{label}\n- Go oN"


@pytest.mark.parametrize(("order", "orders"), [("reversed", 1), ("shuffled", 9)])
def test_a_section_that_is_left_out_or_says_something_else_moves_no_other(order: str, orders: int):
    template = "".join(
        f"{{% if '{name}' in shown %}}\n=== {name} ===\n{name}: {{{{ step }}}}\n{{% endif %}}\n" for name in "ABCD"
    )
    space = {"name": "own", "options": {"order": [order], "separator": list("0123456789")}}

    def sections(prompt: Prompt, shown: str) -> str:
        asked = Question(agent=1, step=1, kind="action", observation={"shown": shown, "step": len(shown)})
        return "".join(re.findall("=== (.*) ===", prompt.render(asked)[0].content))

    prompts = [Prompt("p", {"action": f"{template}=== E ===\n"}, format={**space, "draw": draw}) for draw in range(10)]
    whole = [sections(prompt, "ABCD") for prompt in prompts]
    assert len(set(whole)) == orders and {"".join(sorted(one)) for one in whole} == {"ABCDE"}
    assert {one[-1] for one in whole} == {"E"} and ("DCBAE" in whole or order == "shuffled")
    for shown in ("", "A", "AD", "BC", "ABD", "BCD"):
        for prompt, one in zip(prompts, whole, strict=True):
            assert sections(prompt, shown) == "".join(name for name in one if name in f"{shown}E")


@pytest.mark.parametrize("order", ["reversed", "shuffled"])
def test_sections_change_places_and_that_of_the_reply_stays_last(order: str):
    text, sections = written(one_format(order=order)), re.split(r"\n\n(?==== [WY])", written())
    assert text.startswith(f"{sections[0]}\n\n") and text.endswith(sections[-1])
    assert all(section.strip() in text for section in sections)
    if order == "reversed":
        assert [text.index(section.strip()) for section in sections[1:-1]] == sorted(
            (text.index(section.strip()) for section in sections[1:-1]), reverse=True
        )


MARKED = Format.of(one_format(case="upper")).marked(f"{TEMPLATE}\nRules:\n")
MARKS = sorted({character for character in MARKED if unicodedata.category(character) == "Co"})


@given(st.text(st.sampled_from(["B", "\n", *MARKS]), max_size=8))
@example("".join(MARKS))
@example(f"{MARKS[0]}B{MARKS[-2]}")
def test_what_an_agent_said_cannot_pose_as_a_mark_of_the_template(said: str):
    space = one_format(heading="# {}", case="upper", item="* ")
    text = written(space, "=== A ===\n- {{ said }}\nb: {{ said }}\n", said=said)
    plain = "".join(character for character in said if character not in MARKS)
    assert text == f"# A\n* {plain}\nB: {plain}"


@pytest.mark.parametrize("path", PROMPTS, ids=lambda path: path.stem)
def test_no_format_touches_the_shape_of_a_reply(path: Path):
    templates = yaml.safe_load(path.read_text("utf-8"))["templates"]
    for draw in range(12):
        prompt = Prompt(path.stem, templates, format={**SPREAD, "draw": draw})
        assert prompt.kinds == tuple(templates)
        for source in templates.values():
            if isinstance(source, str):
                marked = Format.of({**SPREAD, "draw": draw}).marked(source)
                for shape in re.findall(r"(?ms)^\{\n.*?^\}$", source):
                    assert shape in marked


def test_draws_are_all_formats_of_the_space_each_once():
    space = {"name": "own", "options": {"heading": ["a{}", "b{}", "c{}"], "case": ["upper", "lower"]}}
    drawn = [Format.of({**space, "draw": draw}).chosen for draw in range(6)]
    # Sweeps name formats by their draw alone.
    assert [one["heading"][0] + one["case"][0] for one in drawn] == ["cl", "al", "au", "bl", "bu", "cu"]
    with pytest.raises(InputError, match="own/6 does not exist"):
        Format.of({**space, "draw": 6})


@pytest.mark.parametrize(
    ("options", "said"),
    [
        ({"headings": ["{}"]}, "Did you mean 'heading'"),
        ({"heading": "{}"}, "must be a list of options"),
        ({"heading": ["# "]}, "must contain {} once"),
        ({"case": ["uper"]}, "Did you mean 'upper'"),
        ({"heading": ["{}{}"]}, "must contain {} once"),
        ({"heading": ["{} {name}"]}, "must contain {} once"),
        ({"separator": [3]}, "must be a text"),
        ({"item": [3]}, "must be a text"),
        ({"wording": [["a"]]}, "must map phrases"),
        ({"wording": [{"": "b"}]}, "must map phrases"),
        ({"wording": [{"a": "b\nc"}]}, "must map phrases"),
        ({"wording": [{"a": 1}]}, "must map phrases"),
        ({"separator": ["-"] * 1001, "item": ["-"] * 1000}, "has 1,001,000 formats, more than 1,000,000"),
        ({}, "needs 'options"),
    ],
)
def test_a_space_that_says_something_else_is_refused(options: Any, said: str):
    with pytest.raises(InputError, match=said):
        Format.of({"name": "own", "options": options, "draw": 0})


def test_a_format_stands_in_place_of_the_recorded_one_and_the_format_of_replies_stays():
    first = compose(["model=qwen3:4b", "model.format=schema", "format=3"])
    config = {**first.conditions[0].config, "seed": 0}
    for asked, draw in (("format=spread/1", 1), ("format=none", None), ("record.frames=false", 3)):
        composed = compose_recorded(config, [asked])
        found = composed.conditions[0].config
        assert found["model"]["format"] == config["model"]["format"] == "schema"
        assert found["prompt"].get("format", {}).get("draw") == draw
        assert found["prompt"]["templates"] == config["prompt"]["templates"]
