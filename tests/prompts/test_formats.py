"""Formats change how a prompt is written, and neither what is said in it nor the shape of the reply."""

from __future__ import annotations

import re
from pathlib import Path
from typing import Any

import pytest
import yaml

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
SAID = ["=== RUN ===", "Name: fire\n- now"]


def written(**features: Any) -> str:
    """Return a question in the one format with these features."""
    space = {"name": "own", "options": {key: [value] for key, value in features.items()}, "draw": 0}
    observation = {"place": "Bar", "step": 3, "heard": SAID}
    prompt = Prompt("p", {"action": TEMPLATE}, format=space)
    return prompt.render(Question(agent=1, step=3, kind="action", observation=observation))[0].content


def plain() -> str:
    observation = {"place": "Bar", "step": 3, "heard": SAID}
    asked = Question(agent=1, step=3, kind="action", observation=observation)
    return Prompt("p", {"action": TEMPLATE}).render(asked)[0].content


def test_the_format_in_which_a_prompt_is_written_changes_nothing():
    assert written(heading="=== {} ===") == plain()


@pytest.mark.parametrize(
    ("feature", "option", "changed"),
    [
        ("heading", "## {}", {"=== WHERE": "## WHERE", "HEARD ===": "HEARD", "ARE ===": "ARE", "=== WHAT": "## WHAT",
                              "DO ===": "DO", "=== YOUR ANSWER ===": "## YOUR ANSWER"}),
        ("separator", " = ", {"place: ": "place = ", "Step: ": "Step = ", "Round: ": "Round = "}),
        ("item", "* ", {"- === R": "* === R", "- Name": "* Name", '- "stay"': '* "stay"'}),
        ("case", "upper", {"Current place": "CURRENT PLACE", "Step": "STEP", "Round": "ROUND"}),
        ("wording", {"Answer": "Reply", "stay": "halt"}, {"Answer": "Reply", '- "stay"': '- "halt"'}),
        ("structure", "json", {"Current place: Bar\nStep: 3": '{"Current place": "Bar", "Step": "3"}',
                               "- === RUN ===\n- Name: fire\n- now (the last)":
                               '["=== RUN ===", "Name: fire\\n- now (the last)"]', "Round: 3": '{"Round": "3"}'}),
    ],
)  # fmt: skip
def test_a_feature_changes_the_words_of_the_template_and_no_others(feature: str, option: Any, changed: dict[str, str]):
    expected = plain()
    for before, after in changed.items():
        assert before in expected
        expected = expected.replace(before, after)
    assert written(**{feature: option}) == expected


def test_items_are_numbered_from_one_in_each_list():
    text = written(item="{n}) ")
    assert "1) === RUN ===\n2) Name: fire\n- now" in text and '1) "stay"' in text


@pytest.mark.parametrize("order", ["reversed", "shuffled"])
def test_sections_change_places_and_that_of_the_reply_stays_last(order: str):
    text, sections = written(order=order), re.split(r"\n\n(?==== [WY])", plain())
    assert text.startswith(f"{sections[0]}\n\n") and text.endswith(sections[-1])
    assert all(section.strip() in text for section in sections)
    if order == "reversed":
        assert [text.index(section.strip()) for section in sections[1:-1]] == sorted(
            (text.index(section.strip()) for section in sections[1:-1]), reverse=True
        )


def test_what_an_agent_said_cannot_pose_as_a_mark_of_the_template():
    space = {"name": "own", "options": {"heading": ["# {}"]}, "draw": 0}
    mark = Format.of(space).marked("=== A ===")[0]
    prompt = Prompt("p", {"action": "=== A ===\n{{ said }}\n"}, format=space)
    asked = Question(agent=1, step=3, kind="action", observation={"said": f"{mark}B"})
    assert prompt.render(asked)[0].content == "# A\nB"


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
    assert len({(one["heading"], one["case"]) for one in drawn}) == 6
    with pytest.raises(InputError, match="own/6 is none of the 6 formats"):
        Format.of({**space, "draw": 6})


@pytest.mark.parametrize(
    ("options", "said"),
    [
        ({"headings": ["{}"]}, "Did you mean 'heading'"),
        ({"heading": "{}"}, "no list of options"),
        ({"heading": ["# "]}, "needs one {}"),
        ({"case": ["uper"]}, "Did you mean 'upper'"),
        ({"separator": [3]}, "is no text"),
        ({"wording": [["a"]]}, "no phrases"),
        ({}, "needs 'options"),
    ],
)
def test_a_space_that_says_something_else_is_refused(options: Any, said: str):
    with pytest.raises(InputError, match=said):
        Format.of({"name": "own", "options": options, "draw": 0})


def recorded(*overrides: str) -> dict[str, Any]:
    composed = compose(overrides)
    assert composed is not None
    return {**composed.conditions[0].config, "seed": 0}


@pytest.mark.parametrize(("asked", "draw"), [("format=spread/1", 1), ("format=none", None), ("record.frames=false", 3)])
def test_a_format_stands_in_place_of_the_recorded_one_and_the_format_of_replies_stays(asked: str, draw: int | None):
    config = recorded("model=qwen3:4b", "model.format=schema", "format=3")
    composed = compose_recorded(config, [asked])
    assert composed is not None
    found = composed.conditions[0].config
    assert found["model"]["format"] == config["model"]["format"] == "schema"
    assert found["prompt"].get("format", {}).get("draw") == draw
    assert found["prompt"]["templates"] == config["prompt"]["templates"]
