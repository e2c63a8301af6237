"""Which texts are warnings."""

import re

import pytest
from hypothesis import given
from hypothesis import strategies as st

from analysis.labelling.warning_rule import _labelled, is_warning
from analysis.words import alternatives, indexed

FIRES = ("fire1",)


@pytest.mark.parametrize(
    "text",
    [
        "FIRE!",
        "There is a fire near the cafe.",
        "Something is burning",
        "smoke, lots of it",
        "We should evacuate now",
        "Ｆｉｒｅ at the library",
        "火事だ!",
        "図書館の近くで火災です。避難してください",
        "炎が見える",
        "煙が出ている",
        "fire1を感知しました",
    ],
)
def test_a_text_about_fire_is_a_warning(text: str):
    assert is_warning(text)


@pytest.mark.parametrize(
    "text",
    [
        "",
        "Hello there",
        "The firefly sat by the fireplace, behind the firewall",
        "a new brand of coffee",
        "火曜日に会いましょう",
        "肺炎に気をつけて",
        "煙草を買う",
        "It is danger-free, umbrella",
        "He has burnout",
        "campfires2",
    ],
)
def test_a_text_about_other_things_is_none(text: str):
    assert not is_warning(text)


LABELLED = {
    True: {
        "denied of going there or asked beside it": [
            "Danger! There is a fire at (3, 4), should we move away?",
            "Fire reported. Do not enter the cafe.",
            "I heard from Agent 9 that fire1 is at (2, 3), so I will not go to the cafe.",
            "We can't put out the fire!",
            "There's a fire, please don't panic.",
            "I see fire1 at (3,4), shall we go north?",
            "Stay away until fire1 is out.",
            "The fire is not under control.",
            "Watch out for fire1!",
            "fire1 is right over there, move!",
            "火が近づいています、一緒に逃げませんか？",
            "まだ火は消えていないので注意して",
            "火事なので逃げましょう。",
            "fire1の半径に入らないでください。",
            "火災現場には近づかないでください",
            "Avoid the fire in the north and do not get too close.",
            "I'm staying away from the fire.",
            "The fire is growing and nobody is helping.",
            "Fire at the library; I can't reach it.",
        ],
        "a question that takes a fire for granted": [
            "Did you notice that the bar burns?",
            "Did you see that the museum is on fire?",
            "Can you believe the cafe caught fire?",
            "Why is everyone still sitting in the cafe while it is burning?",
            "Could everyone near the museum leave? It is full of smoke.",
            "カフェが燃えているのを知っていますか?",
        ],
        "a denial of harm, or the end of another fire": [
            "Nobody was hurt by the fire at the bar.",
            "This is not a drill: fire at the library!",
            "We didn't manage to put the fire out.",
            "I don't think fire1 has stopped burning.",
            "fire1 is out but fire2 is getting bigger",
            "fire2 is getting bigger, fire1 is out though",
            "It smells smoky over here.",
            "The library has been on fire since this morning.",
            "訓練ではありません。図書館が火事です。",
        ],
        "a danger at a position, or to flee from": [
            "(12, 7) is deadly right now, go around it.",
            "Hazard at (-4, 11).",
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
        "denied, over, supposed or asked for": [
            "Nothing at all is burning.",
            "No fire, smoke, or flames here.",
            "I see no fire, no smoke and no danger.",
            "The fire was bad, but it is out now.",
            "There was a fire near the cafe. It has been put out.",
            "Yesterday, there was a fire at the cafe.",
            "If you notice smoke, flames or fire, tell everyone.",
            "I don't know if there is a fire.",
            "Is there a fire or smoke near you, Agent 4?",
            "Agent 2 asked whether fire1 is out.",
            "火事はどこですか",
            "火事はもう収まりました。",
            "煙は見えません。",
            "fire1 is no longer active.",
            "It was a false alarm, there is no fire.",
        ],
        "a question that asks for a fire": [
            "Did anyone see a fire?",
            "Do you smell smoke?",
            "Has anybody noticed something burning?",
            "誰か煙を見ましたか?",
        ],
        "another sense of the words": [
            "The whole park is fire-free and smoke free.",
            "Zero fires in the cafe.",
            "The barista is on fire today!",
            "Her speech sparked a blaze of applause.",
            "I have a burning question.",
            "That playlist is 🔥🔥🔥",
            "No danger at (3, 4).",
            "I am at (1, 1) to look for potential hazards.",
            "I will report any fire I see.",
            "My task is to warn others about fires.",
            "Stay away from the karaoke night.",
            "I have to leave the cafe now.",
            "That wasn't smoke, only steam.",
            "昔、この図書館は火事で焼けました。",
            "煙だと思ったら、ただの湯気でした。",
        ],
        "nothing to tell a language by": [
            *("", "OK", "No", "hi", "brb", "(3, 4)", "12", "🙂", "move_up"),
        ],
    },
    None: {
        "another language": [
            "Anna Nowak, Mehmet, Ivo",
            "Vuur!",
            "Hier brennt es!",
            "Bitte nicht rauchen.",
            "Le café est en feu.",
            "¡Hay humo y fuego!",
            "No hay humo ni fuego.",
            "Não há mais fogo.",
            "C'è un incendio? fiamme!",
            "Er is geen brand.",
            "Nie ma pożaru.",
            "Здесь пожар",
            "화재 발생, 대피하세요",
            "着火了,快撤离",
            "没有发现火情。",
            "有烟,快跑",
            "后退1米。",
            "Φωτιά στο μπαρ! Φύγετε τώρα!",
            "สวัสดีค่ะ",
            "أنا بخير",
            "आग!",
            "Kirjastossa on tulipalo!",
            "Merhaba komşular, ben kafeye gidiyorum.",
            "Đám cháy ở công viên",
            "Сьогодні в барі жива музика",
            "fire1: Kuna moto karibu na mkahawa",
            "Na (12, 4) hoří, okamžitě utíkejte!",
        ],
    },
}
"""Texts by their label and by what stands for it."""


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


@pytest.mark.parametrize("part", ["no fire ", "fire is not ", ", no fire", "まだ火", "(1", "if ", "the a ", "?"])
def test_a_huge_text_is_labelled(part: str):
    assert is_warning("fire! " + part * (10_000_000 // len(part)))


@pytest.mark.parametrize(
    "part",
    [
        "any ",
        "a",
        "(1,2) ",
        *(
            pytest.param(part, marks=pytest.mark.slow)
            for part in ("🔥", "avoid ", "did you ", "is really ", "1,", "烟")
        ),
    ],
)
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
