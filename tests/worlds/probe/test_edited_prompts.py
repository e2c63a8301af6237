"""After an edit the prompt tells one story: what was changed is changed wherever it is told."""

import json
import re
from collections.abc import Sequence
from functools import cache
from typing import Any, NamedTuple

import pytest

from foundry import seeding
from foundry.composing.compose import compose
from foundry.composing.preflight import prompt_of, scenario_of
from foundry.conformance.playing import play
from foundry.worlds.base import Answer, Question, Scenario
from foundry.worlds.probe.editing import edits_of, find_edit

PLACES = (
    "[{name: Zum Anker, type: cafe, center: [-3, 0], extent: [2, 2], capacity: 2},"
    " {name: Lesesaal, type: library, center: [3, 0], extent: [2, 2], capacity: 2}]"
)
FIRE = "world.fires=[{name: Inferno, start: 1, position: [0, 0], intensity: 1, radius: 99}]"
SIGNS = "++world.personas={sign: {libra: 1, virgo: 1}}"
PLAYED = {
    "cafe_library": (
        "world.agents=4", "layout@world.layout=explicit", "world.layout.positions=[[-3,0],[3,0],[3,0],[0,0]]",
        "world.half_size=5", f"world.places={PLACES}", FIRE, SIGNS,
    ),
    "survival": ("world.agents=6", "world.half_size=3"),
    "evacuation": ("world.agents=6", f"{FIRE[:-2]}, spread: 1}}]"),
    "fishery": ("world.talk=6", "world.stock=10000", SIGNS),
    "bar": ("world.fun=7001", "world.crowded=-3001", "world.home=2001"),
    "naming": ("world.equal=9901", "world.different=-1001"),
    "public_goods_punishment": (),
    "cliff_walking": (),
}  # fmt: skip
"""Small worlds in which names and numbers are told that stand nowhere else in a prompt."""


class EditedPrompt(NamedTuple):
    """A question whose text an edit changed, before and after."""

    question: Question
    changed: Question
    before: str
    after: str


def talking(questions: Sequence[Question]) -> list[Answer]:
    """Answer with any option, something to hear and something to keep."""
    answers = []
    for question in questions:
        options = question.options or ("{}",)
        chosen = json.loads(options[int(seeding.stream(1, str(question.asked)).integers(len(options)))])
        said = (
            {"message": f"Hear {question.agent}!"} if "action" not in chosen else {"memory": f"Keep {question.agent}!"}
        )
        answers.append(Answer(json.dumps(chosen | said)))
    return answers


@cache
def asked_in(world: str, *overrides: str) -> tuple[Scenario, Any, list[Question]]:
    """Return a world, its prompt and the questions of an episode in which everybody talks and remembers."""
    composed = compose([f"world={world}", "world.steps=2", *PLAYED[world], *overrides])
    config = composed.conditions[0].config
    scenario = scenario_of(config)
    return scenario, prompt_of(config), list(play(scenario.start(3), talking, most=1000).questions)


def edited(edit: str, world: str, *overrides: str) -> list[EditedPrompt]:
    scenario, prompt, asked = asked_in(world, *overrides)
    changing = find_edit(edit, scenario)

    def text(question: Question) -> str:
        return "\n".join(message.content for message in prompt.render(question))

    changed = [
        (question, changing.applied(question, [other for other in asked if other is not question]))
        for question in asked
    ]
    prompts = [
        EditedPrompt(question, other, text(question), text(other)) for question, other in changed if other is not None
    ]
    assert prompts, f"{edit} changes nothing in {world}"
    return prompts


@pytest.mark.parametrize("world", PLAYED)
def test_what_is_taken_away_was_told_and_is_told_no_more(world: str):
    """An edit that takes nothing out of the prompt would be reported as a cause that has no effect."""
    scenario, _, asked = asked_in(world)
    for edit in edits_of(scenario.form):
        if edit.leaves == "cause" and any(edit.applied(question, asked) is not None for question in asked):
            assert all(edited_prompt.before != edited_prompt.after for edited_prompt in edited(edit.name, world)), (
                edit.name
            )


@pytest.mark.parametrize("language", ["", "_japanese"])
@pytest.mark.parametrize("world", ["bar", "naming"])
def test_all_points_in_a_prompt_are_ten_times_as_many(world: str, language: str):
    for edited_prompt in edited("scale_payoffs", world, f"prompt={world}{language}"):
        assert edited_prompt.after == re.sub(r"\d{4,}", lambda found: f"{found[0]}0", edited_prompt.before)


@pytest.mark.parametrize("prompt", ["paper", "japanese"])
def test_places_have_their_new_names_wherever_they_are_told(prompt: str):
    prompts = edited("rename_places", "cafe_library", f"prompt={prompt}")
    for edited_prompt in prompts:
        assert edited_prompt.after == edited_prompt.before.replace("Zum Anker", "Place 1").replace(
            "Lesesaal", "Place 2"
        )
    assert max(edited_prompt.before.count("Lesesaal") for edited_prompt in prompts) > 3, (
        "where it is, who is in it, what there is"
    )


@pytest.mark.parametrize("world", ["cafe_library", "survival", "evacuation"])
def test_agents_of_a_grid_have_their_new_numbers_wherever_they_are_told(world: str):
    for edited_prompt in edited("rename_agents", world):
        assert edited_prompt.after == re.sub(
            r"Agent (\d+)", lambda found: f"Agent {int(found[1]) + 100}", edited_prompt.before
        )


def facts(text: str, agents: int | None = None) -> list[str]:
    """Return what is told of each agent; where `agents` is given, under the numbers counted from the end."""
    if agents is not None:
        text = re.sub(r"(?<=gent )\d+", lambda found: str(agents - 1 - int(found[0])), text)
    return sorted(re.findall(r"(?:[Aa]gent \d+|You)[^,.\n]*", text.partition('"action"')[0]))


@pytest.mark.parametrize("world", ["fishery", "public_goods_punishment"])
def test_the_same_is_told_of_the_same_agents_of_a_game_under_their_new_numbers(world: str):
    agents = asked_in(world)[0].agents
    for edited_prompt in edited("rename_agents", world):
        assert facts(edited_prompt.after, agents) == facts(edited_prompt.before)


@pytest.mark.parametrize(
    ("edit", "world", "gone"),
    [
        ("no_messages", "cafe_library", "Hear (?!{agent}!)"),
        ("no_messages", "survival", "Hear (?!{agent}!)"),
        ("no_messages", "fishery", "Hear (?!{agent}!)"),
        ("no_history", "evacuation", "Hear (?!{agent}!)|Keep"),
        ("no_history", "fishery", "Hear|Month 1:"),
        ("no_persona", "cafe_library", "(?i)libra(?!r)|virgo|sign:"),
        ("no_persona", "fishery", "libra|virgo|sign:"),
        ("no_fire", "cafe_library", "Inferno"),
        ("no_fire", "evacuation", r"(?m)Inferno|^[^ ]*\*|'burning': \[\["),
    ],
)
def test_nothing_is_left_of_what_is_taken_away(edit: str, world: str, gone: str):
    """Neither in what the shipped prompt tells nor in what one's own could."""
    for edited_prompt in edited(edit, world):
        pattern = gone.replace("{agent}", str(edited_prompt.question.agent))
        assert re.search(pattern, f"{edited_prompt.before}\n{edited_prompt.question.observation}")
        assert not re.search(pattern, f"{edited_prompt.after}\n{edited_prompt.changed.observation}")


@pytest.mark.parametrize("world", ["bar", "naming", "public_goods_punishment", "fishery", "cliff_walking"])
def test_whoever_knows_of_nothing_before_knows_what_it_knew_at_first(world: str):
    scenario, _, asked = asked_in(world)
    forgetting, passing = find_edit("no_history", scenario), {"step", "names", "stock", "tokens", "given", "state"}
    for edited_prompt in edited("no_history", world):
        first = next(question for question in asked if question.asked[1:] == edited_prompt.question.asked[1:])
        known, known_first = edited_prompt.changed.observation, (forgetting.applied(first) or first).observation
        assert {key for key in known if known[key] != known_first[key]} <= passing
