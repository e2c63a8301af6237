"""Which texts are warnings."""

import re

import pytest
from hypothesis import given
from hypothesis import strategies as st

from analysis.labelling.warning_rule import _labelled, is_warning
from analysis.words import alternatives, indexed

FIRES = ("fire1",)


LABELLED = {
    True: {
        "a text about fire": [
            "FIRE!",
            "Ｆｉｒｅ at the library",
            "図書館の近くで火災です。避難してください",
            "煙が出ている",
            "fire1を感知しました",
        ],
        "denied of going there or asked beside it": [
            "Fire reported. Do not enter the cafe.",
            "We can't put out the fire!",
            "I see fire1 at (3,4), shall we go north?",
            "Stay away until fire1 is out.",
            "fire1 is right over there, move!",
            "まだ火は消えていないので注意して",
            "火災現場には近づかないでください",
        ],
        "a question that takes a fire for granted": [
            "Did you notice that the bar burns?",
            "Why is everyone still sitting in the cafe while it is burning?",
            "カフェが燃えているのを知っていますか?",
        ],
        "a denial of harm, or the end of another fire": [
            "Nobody was hurt by the fire at the bar.",
            "I don't think fire1 has stopped burning.",
            "fire1 is out but fire2 is getting bigger",
            "fire2 is getting bigger, fire1 is out though",
            "It smells smoky over here.",
            "訓練ではありません。図書館が火事です。",
        ],
        "a danger at a position, or to flee from": [
            "Unsafe at x=12 y=7.",
            "Avoid (5, 5) and what is near it.",
            "I took damage at 7, 8",
            "Everyone must leave the library immediately.",
            "It's not safe in there, RUN!!",
            "(3, 4)は危険です。",
            "🔥 at the cafe",
        ],
    },
    False: {
        "a text about other things": [
            "Hello there",
            "The firefly sat by the fireplace, behind the firewall",
            "火曜日に会いましょう",
            "肺炎に気をつけて",
            "It is danger-free, umbrella",
        ],
        "denied, over, supposed or asked for": [
            "No fire, smoke, or flames here.", "The fire was bad, but it is out now.",
            "Yesterday, there was a fire at the cafe.", "If you notice smoke, flames or fire, tell everyone.",
            "Is there a fire or smoke near you, Agent 4?", "Agent 2 asked whether fire1 is out.", "火事はどこですか",
            "火事はもう収まりました。", "煙は見えません。", "fire1 is no longer active.",
        ],
        "another sense of the words": [
            "The whole park is fire-free and smoke free.",
            "The barista is on fire today!",
            "I have a burning question.",
            "No danger at (3, 4).",
            "I am at (1, 1) to look for potential hazards.",
            "My task is to warn others about fires.",
            "Stay away from the karaoke night.",
            "煙だと思ったら、ただの湯気でした。",
        ],
        "nothing to tell a language by": ["", "OK", "brb", "(3, 4)", "🙂", "move_up"],
    },
    None: {
        "another language": [
            "Anna Nowak, Mehmet, Ivo",
            "Hier brennt es!",
            "Le café est en feu.",
            "No hay humo ni fuego.",
            "Здесь пожар",
            "화재 발생, 대피하세요",
            "着火了,快撤离",
            "后退1米。",
            "أنا بخير",
            "fire1: Kuna moto karibu na mkahawa",
        ],
    },
}  # fmt: skip
"""Texts by their label and by what stands for it; `hand_labelled` has hundreds more."""


@pytest.mark.parametrize(
    ("label", "kind", "text"),
    [(label, kind, text) for label, kinds in LABELLED.items() for kind, texts in kinds.items() for text in texts],
)
def test_a_text_has_the_label_that_a_person_gives_it(label: bool | None, kind: str, text: str):
    assert is_warning(text, FIRES) is label, kind


def test_a_warning_is_read_among_other_sentences_until_its_end_and_whatever_its_letters():
    assert all(is_warning(text, FIRES) for text in ("fire1!", "FIRE", "omg fire fire fire", "fire2 @ 7,7 gtfo"))
    assert is_warning("Is it quiet? No smoke here. fire1 is at (3, 4). See you at the cafe!", FIRES)
    assert not is_warning("There is a fire at the cafe. It has been put out.")
    assert is_warning("There is a fire at the cafe. I am leaving. The meeting has been cleared.")
    assert not is_warning("a " * 10_000 + "fire!")
    assert not is_warning("\ue000")
    assert not is_warning("He has burnout") and not is_warning("campfires2")


@pytest.mark.parametrize("part", ["no fire ", "fire is not ", "まだ火", "(1", "if "])
def test_a_huge_text_is_labelled(part: str):
    assert is_warning("fire! " + part * (10_000_000 // len(part)))


@pytest.mark.parametrize("part", ["any ", "a", "(1,2) ", "🔥", "did you ", "烟"])
def test_half_a_million_characters_are_labelled_which_quadratic_time_would_not_allow(part: str):
    assert _labelled((part * 500_000)[:500_000], FIRES) in (True, False, None)


def test_a_fire_is_known_by_its_configured_name_taken_literally():
    assert not is_warning("Stay away from Zone-A.")
    assert is_warning("Stay away from ZONE-A.", ["zone-a"])
    assert is_warning("zone-aに近づくな", ["zone-a"])
    assert not is_warning("zone-alpha is nice", ["zone-a"])
    assert not is_warning("zone-a2 is nice", ["zone-a"])
    assert is_warning("at f.1(x)", ["f.1(x)"])
    assert not is_warning("at fx1(x)", ["f.1(x)"])


@given(st.text(), st.lists(st.text(min_size=1), max_size=3))
def test_any_text_is_labelled(text: str, fires: list[str]):
    assert is_warning(text, fires) in (True, False, None)


@given(st.text(alphabet="あいうえお 。"), st.text(alphabet="あいうえお 。"))
def test_a_word_is_found_inside_unspaced_text(before: str, after: str):
    assert is_warning(f"{before}fire{after}")


WORDS = st.lists(st.sampled_from(["ab", "a?c", "b[|)]d", "(?:a|b)c", "c", r"a\\|d"]), min_size=1).map("|".join)


@given(WORDS, st.text(alphabet="abcd|)"))
def test_alternatives_by_their_first_letter_match_the_same_texts(pattern: str, text: str):
    assert "|".join(alternatives(pattern)) == pattern
    assert (re.fullmatch(indexed(pattern), text) is None) == (re.fullmatch(pattern, text) is None)
