"""Which texts are warnings."""

import pytest
from hypothesis import given
from hypothesis import strategies as st

from analysis.warning_rule import is_warning


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
