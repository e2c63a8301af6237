"""Which replies claim to see the target."""

import pytest
from hypothesis import given
from hypothesis import strategies as st

from analysis.camera.sight_rule import claims_to_see

CLAIMS = {
    "JAXA logo": [
        "I see the JAXA logo.",
        "I can now see the JAXA logo on the far wall. Move forward 2 m.",
        "The JAXA logo is visible on the left.",
        "The JAXA logo is on the wall ahead, so I move forward 1 m.",
        "I see a hatch, racks and the JAXA logo.",
        "I see a hatch, two racks, and the JAXA logo. Turn left 10 degrees.",
        "There is a JAXA emblem in front of me.",
        "I don't see any obstacles and the JAXA logo is straight ahead.",
        "I have found the logo of JAXA.",
        "I spotted the JAXA logo! Move forward 1 m.",
        "That's the JAXA logo.",
        "I am now very close to the JAXA logo. Stay.",
        "I've reached the target. Stay.",
        "The logo is visible.",
        "I move toward the JAXA logo, which is visible on the right wall.",
        "JAXA logo visible at center. move forward 2 m",
        "I see what appears to be the JAXA logo.",
        "I can't move further, but I see the JAXA logo on my right.",
        "Keep the JAXA logo in view. Turn left 5 degrees.",
        "正面にJAXAのロゴが見えます。前に2m進む。",
        "JAXAロゴを発見しました。",
        "壁にJAXAのロゴがあります。",
        "ハッチは見えないが、JAXAのロゴは見える。",
        "JAXAのロゴ、ハッチ、ラックが見えます。",
        "ロゴが見えるので近づきます。",
        "I am facing a wall with the JAXA logo.",
        "The JAXA logo is not far, I can see it: it is the JAXA logo.",
        "**I see the JAXA logo**",
    ],
    "picture 3": [
        "I see picture 3 on the wall.",
        "Picture number 3 is to the left.",
        "I see painting #3.",
        "3番の絵が見えます。",
        "I see pictures; picture 03 is ahead.",
    ],
    "refrigerator": [
        "The fridge is on the right side.",
    ],
    "fire extinguisher": [
        "There's an extinguisher on the wall.",
        "消火器が見えます",
    ],
    "sofa": [
        "I see the couch.",
    ],
    "coffee machine": [
        "I see a coffee maker on the counter.",
    ],
    "globe": [
        "Looking at the globe now. Stay.",
    ],
    "red valve": [
        "I notice a red valve on the pipe.",
    ],
    "printer": [
        "The image shows a corridor with a printer at the end.",
    ],
    "whiteboard": [
        "I see and approach the whiteboard: it is right ahead.",
    ],
}

NO_CLAIMS = {
    "JAXA logo": [
        "I know where the JAXA logo is. Move forward 3 m.",
        "I don't see the JAXA logo.",
        "I do not see the JAXA logo yet, so I turn left.",
        "I cannot find the JAXA logo.",
        "No logo visible.",
        "No JAXA logo is visible here.",
        "The JAXA logo is not visible.",
        "I am looking for the JAXA logo.",
        "I see a hatch and will look for the JAXA logo.",
        "I see racks but no JAXA logo.",
        "To find the JAXA logo, I turn right 30 degrees.",
        "The JAXA logo might be on the left wall.",
        "The JAXA logo is probably behind me.",
        "Move toward the JAXA logo.",
        "Can I see the JAXA logo?",
        "I will turn until I see the JAXA logo.",
        "Turn left to see the JAXA logo.",
        "I am unable to see the JAXA logo.",
        "The JAXA logo is nowhere to be seen.",
        "I see a wall. Stay.",
        "",
        "The NASA logo is visible? no",
        "I see the hatch, and the JAXA logo should be to its left.",
        "The JAXA logo is no longer visible.",
        "<think>I see the JAXA logo</think> Turn left.",
        "I have not yet clearly seen or spotted the JAXA logo.",
        "I see a corridor. Task: Find JAXA logo and get close to it.",
        "The JAXA logo is out of view.",
        "JAXAのロゴは見えません。右に45度回転します。",
        "JAXAのロゴを探します。",
        "壁とハッチが見えますが、JAXAのロゴはまだ見えません。",
        "JAXAのロゴを見つけるために右を向きます。",
        "JAXAのロゴは見当たりません。",
        "JAXAのロゴに近づきます。",
        "JAXAのロゴがあるかもしれません。",
        "JAXAロゴが見えるように右に回ります",
        "I look around. Turn left 45.00 degrees.",
        "Let me look elsewhere.",
        "If the JAXA logo is visible I will stop.",
        "I do not have the JAXA logo in view.",
        "I don't think the JAXA logo is visible.",
    ],
    "picture 3": [
        "I see picture 13 on the wall.",
        "I see a picture 3 m away.",
        "I see picture 4.",
        "I see a picture.",
    ],
    "coffee machine": [
        "I see a vending machine.",
    ],
    "water cooler": [
        "I see a water pipe.",
    ],
    "safe": [
        "It is safely stored: I see a globe.",
    ],
    "printer": [
        "I see a sign pointing to the printer.",
    ],
    "refrigerator": [
        "Searching for the refrigerator in the kitchen.",
    ],
}

OTHER_LANGUAGES = [
    "Ich sehe das JAXA-Logo an der Wand.", "Je ne vois pas le logo JAXA.", "Veo el logo de JAXA a la izquierda.",
    "Я вижу логотип JAXA.", "JAXA 로고가 보입니다.", "我看到JAXA标志在前方。向前走2米。",
    "<think>I see the logo</think> Ich drehe mich nach links.",
]  # fmt: skip


def pairs(table: dict[str, list[str]]) -> list[tuple[str, str]]:
    return [(target, text) for target, texts in table.items() for text in texts]


@pytest.mark.parametrize(("target", "text"), pairs(CLAIMS))
def test_a_reply_that_says_the_target_is_there_is_a_claim(target: str, text: str):
    assert claims_to_see(text, target)


@pytest.mark.parametrize(("target", "text"), pairs(NO_CLAIMS))
def test_a_reply_that_denies_seeks_or_guesses_is_none(target: str, text: str):
    assert not claims_to_see(text, target)


@pytest.mark.parametrize("text", OTHER_LANGUAGES)
def test_a_reply_in_another_language_has_no_label(text: str):
    assert claims_to_see(text, "JAXA logo") is None


@given(st.text(), st.text())
def test_any_reply_and_target_can_be_read(text: str, target: str):
    assert claims_to_see(text, target) in (True, False, None)


@given(st.text(alphabet="JAXA logo see not 見える。, "))
def test_letters_in_any_order_can_be_read(text: str):
    assert claims_to_see(text, "JAXA logo") in (True, False, None)


@pytest.mark.slow
@pytest.mark.parametrize("part", ["I see the JAXA logo and ", "not ", " ", "a", "jaxa ", "see a, ", "ロゴが"])
def test_half_a_million_characters_are_read_which_quadratic_time_would_not_allow(part: str):
    assert claims_to_see((part * 500_000)[:500_000], "JAXA logo") in (True, False, None)
