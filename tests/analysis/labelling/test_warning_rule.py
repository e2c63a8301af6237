"""Which texts are warnings."""

import re

import pytest
from hypothesis import given
from hypothesis import strategies as st

from analysis.labelling.warning_rule import _labelled, is_warning
from analysis.words import alternatives, indexed

FIRES = ("fire1",)


LABELLED = {
    True: [
        "FIRE!",
        "We can't put out the fire!",
        "I see fire1 at (3,4), shall we go north?",
        "Stay away until fire1 is out.",
        "Did you notice that the bar burns?",
        "カフェが燃えているのを知っていますか?",
        "Nobody was hurt by the fire at the bar.",
        "I don't think fire1 has stopped burning.",
        "fire1 is out but fire2 is getting bigger",
        "fire2 is getting bigger, fire1 is out though",
        "It smells smoky over here.",
        "Unsafe at x=12 y=7.",
        "Avoid (5, 5) and what is near it.",
        "I took damage at 7, 8",
        "Everyone must leave the library immediately.",
        "It's not safe in there, RUN!!",
        "(3, 4)は危険です。",
        "🔥 at the cafe",
    ],
    False: [
        "Hello there",
        "fire1 is no longer active.",
        "火事はどこですか",
        "火事はもう収まりました。",
        "I am at (1, 1) to look for potential hazards.",
        "My task is to warn others about fires.",
        "OK",
        "(3, 4)",
        "🙂",
    ],
    None: ["Hier brennt es!", "화재 발생, 대피하세요", "着火了,快撤离", "fire1: Kuna moto karibu na mkahawa"],
}
"""Texts by their label, each read by words that none of the hundreds of `hand_labelled` needs."""


@pytest.mark.parametrize(("label", "text"), [(label, text) for label, texts in LABELLED.items() for text in texts])
def test_a_text_has_the_label_that_a_person_gives_it(label: bool | None, text: str):
    assert is_warning(text, FIRES) is label


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
