"""Which texts are warnings."""

import pytest
from hypothesis import given
from hypothesis import strategies as st

from analysis.warning_rule import is_warning

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
        "着火了,快撤离",
        "화재 발생, 대피하세요",
        "Es brennt! Feuer!",
        "Il y a un incendie, évacuez",
        "¡Hay humo y fuego!",
        "Há um incêndio",
        "C'è un incendio? fiamme!",
        "Здесь пожар",
        "e\u0301vacuez",
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
        "He is burnout",
        "a new brand of coffee",
        "火曜日に会いましょう",
        "肺炎に気をつけて",
        "煙草を買う",
        "It is danger-free, umbrella",
        "campfires2",
    ],
)
def test_a_text_about_other_things_is_none(text: str):
    assert not is_warning(text)


@pytest.mark.parametrize(
    "text",
    [
        "Hier brennt es!",
        "O café está em chamas.",
        "El café está en llamas.",
        "Hier is brand uitgebroken!",
        "Le café est en feu.",
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
        "咖啡馆着火了，我们去图书馆好吗？",
        "불이 났어요, 같이 갈까요?",
        "Es brennt im Café, kommst du mit?",
        "Geht nicht in die Nähe des Feuers.",
        "N'allez pas près du feu.",
        "No os acerquéis al fuego.",
        "Não se aproximem do fogo.",
        "Non avvicinatevi al fuoco.",
        "Не подходите к огню.",
        "不要靠近火灾现场。",
        "火災現場には近づかないでください",
        "Avoid the fire in the north and do not get too close.",
        "I'm staying away from the fire.",
        "The fire is growing and nobody is helping.",
        "Fire at the library; I can't reach it.",
    ],
)
def test_what_is_denied_of_going_there_or_asked_beside_it_takes_no_warning_back(text: str):
    assert is_warning(text, FIRES)


@pytest.mark.parametrize(
    "text",
    [
        "Não há mais fogo.",
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
        "没有发现火情。",
        "화재는 없습니다.",
        "Es gibt kein Feuer.",
        "Feuer sehe ich hier nicht.",
        "Il n'y a plus de feu.",
        "Пожара здесь нет.",
        "No hay humo ni fuego.",
        "Nie ma pożaru.",
        "Er is geen brand.",
        "fire1 is no longer active.",
        "It was a false alarm, there is no fire.",
    ],
)
def test_a_fire_that_is_denied_over_supposed_or_asked_for_is_no_warning(text: str):
    assert not is_warning(text, FIRES)


def test_one_warning_among_other_sentences_is_enough():
    assert is_warning("Is it quiet? No smoke here. fire1 is at (3, 4). See you at the cafe!", FIRES)


def test_an_end_takes_back_what_was_said_right_before_it_only():
    assert not is_warning("There is a fire at the cafe. It has been put out.")
    assert is_warning("There is a fire at the cafe. I am leaving. The meeting has been cleared.")


@pytest.mark.parametrize("part", ["no fire ", "fire is not ", ", no fire", "まだ火", "(1", "if ", "de a", "?"])
def test_a_huge_text_is_labelled(part: str):
    assert is_warning("fire! " + part * (10_000_000 // len(part)))


def test_only_the_beginning_of_a_text_is_read():
    assert not is_warning("a " * 10_000 + "fire!")


def test_a_character_of_private_use_is_no_name_of_a_fire():
    assert not is_warning("\ue000")


def test_a_fire_is_known_by_its_configured_name():
    assert not is_warning("Stay away from Zone-A.")
    assert is_warning("Stay away from ZONE-A.", ["zone-a"])
    assert is_warning("zone-aに近づくな", ["zone-a"])
    assert not is_warning("zone-alpha is nice", ["zone-a"])
    assert not is_warning("zone-a2 is nice", ["zone-a"])


def test_a_name_is_taken_literally():
    assert is_warning("at f.1(x)", ["f.1(x)"])
    assert not is_warning("at fx1(x)", ["f.1(x)"])


@given(st.text(), st.lists(st.text(min_size=1), max_size=3))
def test_any_text_is_labelled(text: str, fires: list[str]):
    assert is_warning(text, fires) in (True, False)


@given(st.text(alphabet="あいうえお 。"), st.text(alphabet="あいうえお 。"))
def test_a_word_is_found_inside_unspaced_text(before: str, after: str):
    assert is_warning(f"{before}fire{after}")
