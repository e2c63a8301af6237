"""What every 2D prompt variant must hold, and the paper's own to the letter."""

import os
import re
from collections.abc import Mapping
from functools import cache
from typing import Any

import pytest
import yaml

from foundry.paths import conf_dir
from foundry.running.build import build
from foundry.worlds.base import Question

PLACES = [
    {"name": "cafe", "type": "cafe", "x": -15, "y": 0,
     "x_min": -20, "x_max": -10, "y_min": -5, "y_max": 5, "capacity": 12},
    {"name": "library", "type": "library", "x": 15, "y": 0,
     "x_min": 10, "x_max": 20, "y_min": -5, "y_max": 5, "capacity": 10},
]  # fmt: skip
LIBRARY = {"name": "library", "type": "library"}
EXAMPLE = {
    "agent": 3,
    "step": 7,
    "persona": {"gender": "female"},
    "x": 14,
    "y": 2,
    "half_size": 25,
    "place_types": ["cafe", "library"],
    "place": {**LIBRARY, "agents": 3, "capacity": 10, "occupancy_rate": 0.3},
    "fires": [{"name": "fire1", "x": 15, "y": 10, "intensity": 0.8, "radius": 15, "distance": 65**0.5}],
    "places": PLACES,
    "neighbours": [{"id": 1, "x": 16, "y": 1, "persona": {"gender": "male"}, "place": LIBRARY}],
    "memory": ["I entered the library to inspect its occupancy."],
    "received": [{"sender": 1, "text": "I can also see fire1 from inside the library."}],
    "message": "I can detect fire1 near the library; please stay alert.",
}
ALONE = EXAMPLE | {"place": None, "fires": [], "neighbours": [], "memory": [], "received": [], "message": None}
TWO_OF_EACH = EXAMPLE | {
    "fires": [EXAMPLE["fires"][0], {"name": "fire2", "x": -15, "y": -10, "intensity": 0.5, "radius": 8, "distance": 7}],
    "neighbours": [EXAMPLE["neighbours"][0], {"id": 4, "x": 9, "y": 0, "persona": {"gender": "female"}, "place": None}],
    "memory": ["one", "two"],
    "received": [{"sender": 1, "text": "a"}, {"sender": 4, "text": "b"}],
}

EXAMPLE_ACTION = """\
You are Agent 3 (female) in a 2D world with multiple places (cafe, library).

=== YOUR CURRENT STATE ===
Gender: female
Position: (14, 2)
In place: Yes
Current place: library

You are currently in the library (library).
  Number of agents here: 3
  Capacity: 10
  Occupancy rate: 0.30

=== FIRE EVENT ===
Fire "fire1":
  Position: (15, 10)
  Intensity: 0.8 (scale: 0.0 to 1.0)
  Radius: 15
  Your distance: 8.06

=== PLACE LOCATIONS ===
cafe (cafe): center at (-15, 0), covers X from -20 to -10, Y from -5 to 5
library (library): center at (15, 0), covers X from 10 to 20, Y from -5 to 5

=== NEARBY AGENTS ===
Agent 1 (male) is at (16, 1) and is in library (library)

=== PREVIOUS MEMORY ===
- I entered the library to inspect its occupancy.

=== MESSAGES FROM OTHERS ===
from Agent 1: I can also see fire1 from inside the library.

=== MESSAGE YOU DECIDED TO SEND ===
I can detect fire1 near the library; please stay alert.
=== AVAILABLE ACTIONS ===
- "stay": remain at current position
- "move" with direction: "up" (Y+1), "down" (Y-1), "left" (X-1), "right" (X+1)

Field boundaries: X and Y from -25 to +25

=== RESPOND IN JSON ===
{
    "action": "move" or "stay",
    "direction": "up", "down", "left", or "right" (only if action is "move"),
    "memory": "what you want to remember for the next step (your thoughts, observations, intentions)",
    "reasoning": "brief explanation of your decision"
}

Step: 7"""

TWO_OF_EACH_MESSAGE = """\
You are Agent 3 (female) in a 2D world with multiple places (cafe, library).

=== YOUR CURRENT STATE ===
Gender: female
In place: Yes
Current place: library

You are currently in the library (library).
  Number of agents here: 3
  Capacity: 10
  Occupancy rate: 0.30

=== FIRE EVENT ===
Fire "fire1":
  Position: (15, 10)
  Intensity: 0.8 (scale: 0.0 to 1.0)
  Radius: 15
  Your distance: 8.06
Fire "fire2":
  Position: (-15, -10)
  Intensity: 0.5 (scale: 0.0 to 1.0)
  Radius: 8
  Your distance: 7.00

=== NEARBY AGENTS (you can communicate with these agents) ===
Agent 1 (male) is in library (library)
Agent 4 (female) is outside the places

=== PREVIOUS MEMORY ===
- one
- two

=== MESSAGES FROM OTHERS ===
from Agent 1: a
from Agent 4: b

=== YOUR TASK ===
Decide what message you want to send to nearby agents. \
You can share your observations, experiences, or thoughts about the places and situation.

=== RESPOND IN JSON ===
{
    "message": "message to nearby agents (max 200 words, optional if you don't want to send a message)",
    "reasoning": "brief explanation of why you want to send this message"
}

Step: 7"""

TO_NOBODY = {
    r"In place: Yes\n.*\n\n=== FIRE EVENT ===\n.*?\n\n": "In place: No\n\n",
    r"(?<====\n)Agent 1 .*?\n\n": "No nearby agents.\n\n",
    r"(?<=MEMORY ===\n).*?\n\n": "No previous experiences.\n\n",
    r"(?<=OTHERS ===\n).*?\n\n": "No messages received.\n\n",
    r"=== MESSAGE YOU DECIDED TO SEND ===\n.*?\n(?====)": "",
}
"""What is said instead to an agent outside all places that perceives nothing, by patterns of what is said to others."""


def to_nobody(text: str) -> str:
    for pattern, instead in TO_NOBODY.items():
        text = re.sub(pattern, instead, text, flags=re.DOTALL)
    return text


@cache
def load(name: str):
    return build(yaml.safe_load((conf_dir() / "prompt" / f"{name}.yaml").read_text("utf-8")))


FURTHER = "window"
"""What prompts for worlds with further parts show, and the worlds of the paper do not have."""
VARIANTS = sorted(
    path.stem
    for path in (conf_dir() / "prompt").glob("*.yaml")
    if "\n  message:" in (text := path.read_text("utf-8")) and "\n  action:" in text and FURTHER not in text
)


def render(name: str, kind: str, observation: Mapping[str, Any]) -> str:
    seen = {key: value for key, value in observation.items() if kind == "action" or key != "message"}
    messages = load(name).render(Question(seen["step"], seen["agent"], kind, seen))
    return "\n".join(message.content for message in messages)


def test_the_prompts_of_the_paper_are_reproduced_to_the_letter():
    assert render("paper", "action", EXAMPLE) == EXAMPLE_ACTION
    assert render("paper", "message", TWO_OF_EACH) == TWO_OF_EACH_MESSAGE
    assert render("paper", "message", ALONE) == to_nobody(TWO_OF_EACH_MESSAGE)
    assert render("paper", "action", ALONE) == to_nobody(EXAMPLE_ACTION)


def test_a_persona_may_have_any_attributes():
    rich = render("paper", "message", EXAMPLE | {"persona": {"gender": "female", "age": "40"}})
    assert rich.startswith("You are Agent 3 (female, 40) in a 2D world")
    assert "Gender: female\nAge: 40\nIn place" in rich
    assert render("paper", "message", EXAMPLE | {"persona": {}}).startswith("You are Agent 3 in a 2D world")


DISTINCT = {
    "agent": 301,
    "step": 302,
    "persona": {"gender": "Q1", "mood": "Q2"},
    "x": 303,
    "y": 304,
    "half_size": 305,
    "place_types": ["T1", "T2"],
    "place": {"name": "P1", "type": "T1", "agents": 306, "capacity": 307, "occupancy_rate": 308.25},
    "fires": [
        {"name": "F1", "x": 310, "y": 311, "intensity": 0.312, "radius": 313, "distance": 314.154},
        {"name": "F2", "x": 315, "y": 316, "intensity": 0.317, "radius": 318.5, "distance": 319},
    ],
    "places": [
        {"name": "P1", "type": "T1", "x": 320, "y": 321,
         "x_min": 322, "x_max": 323, "y_min": 324, "y_max": 325, "capacity": 307},
        {"name": "P2", "type": "T2", "x": 326, "y": 327,
         "x_min": 328, "x_max": 329, "y_min": 330, "y_max": 331, "capacity": 398},
    ],
    "neighbours": [
        {"id": 332, "x": 333, "y": 334, "persona": {"gender": "Q3", "mood": "Q4"},
         "place": {"name": "P1", "type": "T1"}},
        {"id": 335, "x": 336, "y": 337, "persona": {"gender": "Q5", "mood": "Q6"},
         "place": {"name": "P2", "type": "T2"}},
    ],
    "memory": ["M1", "M2"],
    "received": [{"sender": 338, "text": "R1"}, {"sender": 339, "text": "R2"}],
    "message": "S1",
}  # fmt: skip
PERSONAS = {f"Q{number}" for number in range(1, 7)}


def words(text: str) -> set[str]:
    return set(re.findall(r"\d+(?:\.\d+)?|[A-Z]\d(?!\d)", text))


SAID_MORE = {("paper_prefix", "message"): {"305", "1", *map(str, range(320, 332))}}
"""What a variant tells in one kind of question beside what `paper` does: places and edges, in the common preamble."""


@pytest.mark.parametrize("kind", ["message", "action"])
@pytest.mark.parametrize("name", VARIANTS)
def test_every_variant_says_all_that_the_paper_says_and_nothing_else(name, kind):
    expected = words(render("paper", kind, DISTINCT)) - (PERSONAS if name == "no_persona" else set())
    expected |= SAID_MORE.get((name, kind), set())
    assert words(render(name, kind, DISTINCT)) == expected
    assert expected >= {"301", "302", "306", "307", "308.25", "314.15", "318.5"}


@pytest.mark.parametrize("name", VARIANTS)
def test_the_message_prompt_hides_where_agents_are_and_the_action_prompt_tells_everything_observed(name):
    hidden = {"303", "304", "305", "333", "334", "336", "337", *map(str, range(320, 332))}
    hidden -= SAID_MORE.get((name, "message"), set())
    assert not words(render(name, "message", DISTINCT)) & hidden
    shown = words(render(name, "action", DISTINCT))
    numbers = {str(number) for number in range(301, 340)} - {"308", "309", "312", "314", "317", "318", "319"}
    assert shown >= numbers | {"308.25", "0.312", "314.15", "0.317", "318.5", "319.00"}
    assert shown >= {"M1", "M2", "R1", "R2", "S1", "F1", "F2", "P1", "P2", "T1", "T2"}


JUDGING = re.compile(
    r"crowd|danger|unsafe|\bsafe|comfort|busy|\bfull\b|hazard|risk|urgent|emergency|evacuat|escape|avoid|flee|careful|"
    r"混雑|危険|安全|快適|満員|緊急|避難|逃げ|注意",
    re.IGNORECASE,
)


@pytest.mark.parametrize("kind", ["message", "action"])
@pytest.mark.parametrize("name", VARIANTS)
def test_no_variant_judges_the_situation(name, kind):
    assert not JUDGING.search(render(name, kind, DISTINCT))
    assert not JUDGING.search(render(name, kind, DISTINCT | ALONE | {"fires": []}))


@pytest.mark.parametrize("name", VARIANTS)
def test_every_variant_asks_for_the_same_json_without_ragged_blank_lines(name):
    keys = {"message": ["message", "reasoning"], "action": ["action", "direction", "memory", "reasoning"]}
    for kind, asked in keys.items():
        assert re.findall(r'^ +"(\w+)":', render(name, kind, EXAMPLE), re.MULTILINE) == asked
    for value in ("move", "stay", "up", "down", "left", "right"):
        assert f'"{value}"' in render(name, "action", EXAMPLE)
    for kind in ("message", "action"):
        for observation in (EXAMPLE, ALONE, TWO_OF_EACH):
            text = render(name, kind, observation)
            assert text == text.strip()
            assert "\n\n\n" not in text


def test_the_kinds_of_question_share_a_preamble_with_paper_prefix_and_agents_all_that_is_fixed():
    other = ALONE | {"agent": 14, "step": 9, "persona": {"gender": "male"}, "x": -3, "y": 4}
    kinds = os.path.commonprefix([render("paper_prefix", kind, EXAMPLE) for kind in ("message", "action")])
    assert kinds.endswith("\n\n=== ") and "=== PLACE LOCATIONS" in kinds and "=== AVAILABLE ACTIONS" in kinds
    for kind in ("message", "action"):
        agents = os.path.commonprefix([render("paper_prefix", kind, seen) for seen in (EXAMPLE, other)])
        assert agents.startswith(kinds) and agents.endswith("}\n\nYou are Agent ")


@pytest.mark.parametrize("kind", ["message", "action"])
def test_agents_share_the_fixed_text_of_the_reordered_variant(kind):
    other = ALONE | {"agent": 14, "step": 9, "persona": {"gender": "male"}, "x": -3, "y": 4}
    texts = [render("reordered", kind, observation) for observation in (EXAMPLE, other)]
    shared = os.path.commonprefix(texts)
    fixed = {line for line in texts[0].splitlines() if line in texts[1] and not line.startswith("===")}
    in_prefix = sum(len(line) for line in fixed if line in shared)
    assert in_prefix > 0.85 * sum(map(len, fixed))
    assert len(shared) > 2 * len(os.path.commonprefix([render("paper", kind, seen) for seen in (EXAMPLE, other)]))
