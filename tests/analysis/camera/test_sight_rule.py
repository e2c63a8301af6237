"""Which replies claim to see the target, what else they say is seen, and what labels are."""

import dataclasses

import pytest
from hypothesis import given
from hypothesis import strategies as st

import analysis
from analysis.camera.sight_rule import claims_to_see, thing_of, things_claimed
from analysis.camera.sight_words import AMBIGUOUS, THINGS
from analysis.camera.signatures import recognition

CLAIMS = {
    "JAXA logo": [
        "I see the JAXA logo.", "The JAXA logo is visible on the left.", "I see a hatch, racks and the JAXA logo.",
        "There is a JAXA emblem in front of me.", "I don't see any obstacles and the JAXA logo is straight ahead.",
        "I have found the logo of JAXA.", "I spotted the JAXA logo! Move forward 1 m.", "That's the JAXA logo.",
        "I am now very close to the JAXA logo. Stay.", "I've reached the target. Stay.", "The logo is visible.",
        "I move toward the JAXA logo, which is visible on the right wall.",
        "JAXA logo visible at center. move forward 2 m", "I can't move further, but I see the JAXA logo on my right.",
        "Keep the JAXA logo in view. Turn left 5 degrees.", "正面にJAXAのロゴが見えます。前に2m進む。",
        "JAXAロゴを発見しました。", "壁にJAXAのロゴがあります。", "ハッチは見えないが、JAXAのロゴは見える。",
        "JAXAのロゴ、ハッチ、ラックが見えます。", "ロゴが見えるので近づきます。",
        "I am facing a wall with the JAXA logo.", "The JAXA logo is not far, I can see it: it is the JAXA logo.",
        "**I see the JAXA logo**",
    ],
    "picture 3": [
        "I see picture 3 on the wall.",
        "Picture number 3 is to the left.",
        "I see painting #3.",
        "3番の絵が見えます。",
        "I see pictures; picture 03 is ahead.",
    ],
    "refrigerator": ["The fridge is on the right side."],
    "fire extinguisher": [
        "There's an extinguisher on the wall.",
        "消火器が見えます",
    ],
    "sofa": ["I see the couch."],
    "coffee machine": ["I see a coffee maker on the counter."],
    "globe": ["Looking at the globe now. Stay."],
    "red valve": ["I notice a red valve on the pipe."],
    "printer": ["The image shows a corridor with a printer at the end."],
    "whiteboard": ["I see and approach the whiteboard: it is right ahead."],
}  # fmt: skip

NO_CLAIMS = {
    "JAXA logo": [
        "I know where the JAXA logo is. Move forward 3 m.", "I don't see the JAXA logo.",
        "I do not see the JAXA logo yet, so I turn left.", "No logo visible.", "No JAXA logo is visible here.",
        "I am looking for the JAXA logo.", "I see racks but no JAXA logo.", "The JAXA logo might be on the left wall.",
        "Move toward the JAXA logo.", "Can I see the JAXA logo?", "I will turn until I see the JAXA logo.",
        "Turn left to see the JAXA logo.", "The JAXA logo is nowhere to be seen.", "I see a wall. Stay.", "",
        "The NASA logo is visible? no", "<think>I see the JAXA logo</think> Turn left.",
        "I have not yet clearly seen or spotted the JAXA logo.", "JAXAのロゴは見えません。右に45度回転します。",
        "JAXAのロゴを探します。", "壁とハッチが見えますが、JAXAのロゴはまだ見えません。",
        "JAXAのロゴを見つけるために右を向きます。", "JAXAのロゴに近づきます。", "JAXAのロゴがあるかもしれません。",
        "I look around. Turn left 45.00 degrees.", "If the JAXA logo is visible I will stop.",
    ],
    "picture 3": [
        "I see picture 13 on the wall.",
        "I see a picture 3 m away.",
        "I see a picture.",
    ],
    "coffee machine": ["I see a vending machine."],
    "water cooler": ["I see a water pipe."],
    "safe": ["It is safely stored: I see a globe."],
    "printer": ["I see a sign pointing to the printer."],
}  # fmt: skip

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


@given(
    st.one_of(st.text(), st.text(alphabet="JAXA logo see not 見える。, ")),
    st.sampled_from(["JAXA logo", "picture 3", ""]),
)
def test_any_reply_and_target_can_be_read(text: str, target: str):
    assert claims_to_see(text, target) in (True, False, None)


@pytest.mark.slow
@pytest.mark.parametrize("part", ["I see the JAXA logo and ", "not ", " ", "see a, ", "ロゴが"])
def test_half_a_million_characters_are_read_which_quadratic_time_would_not_allow(part: str):
    assert claims_to_see((part * 500_000)[:500_000], "JAXA logo") in (True, False, None)


@pytest.mark.parametrize(
    ("label", "thing"),
    [
        ("exit door", "door"), ("rack JPM1A1", "rack"), ("sign to hall B", "sign"), ("desk", "table"),
        ("picture 3", "picture"), ("Whiteboard_01", "whiteboard"), ("fire extinguisher", "fire extinguisher"),
        ("JAXA logo", "logo"), ("coffee table", "table"), ("quantum flux", "flux"), ("12", "12"), ("", ""),
    ],
)  # fmt: skip
def test_a_label_names_a_kind_of_thing(label, thing):
    assert thing_of(label) == thing


@given(st.text())
def test_every_label_names_some_kind(label):
    assert isinstance(thing_of(label), str)
    assert things_claimed(label, [thing_of(label)]) <= {thing_of(label)}


@pytest.mark.parametrize(
    ("reply", "things"),
    [
        ("I see a long wall, a blue door on the left and a plant beside the sofa.", {"wall", "door", "plant", "sofa"}),
        ("There is no door here. I will look for the window.", set()),
        ("Is there a door?", set()),
        ("I see a hatch, so I go to the door.", {"hatch"}),
        ("窓とドアが見えます。", {"window", "door"}),
        ("I see a dog.", set()),
        ("", set()),
    ],
)
def test_things_are_seen_by_the_same_rule_as_the_target(reply, things):
    assert things_claimed(reply, [one for one in THINGS if one not in AMBIGUOUS]) == things


def test_each_thing_counts_once_a_reply_and_against_what_is_in_view(camera):
    run = camera(0, 3).run
    replies = run.replies.copy()
    replies[:] = ["I see a door. The door is visible.", "I see a window and a door.", ""]
    pixels = ({"exit door": 400, "plant": 19}, {"exit door": 10, "plant": 400}, {"plant": 400})
    found = recognition.measure(dataclasses.replace(run, replies=replies, visible_px=pixels))
    assert (found["n_mentions"], found["n_things"], found["mentions"]) == (3, 2, 1.5)
    assert found["chair_i"] == pytest.approx(2 / 3)
    assert (found["chair_s"], found["object_recall"], found["object_f1"]) == (0.5, 0.5, pytest.approx(2 / 5))


def test_an_ambiguous_name_counts_where_the_scene_has_such_a_thing(camera):
    run = camera(0, 1).run
    replies = run.replies.copy()
    replies[:] = ["The picture shows a wall."]
    hall = recognition.measure(dataclasses.replace(run, replies=replies, visible_px=({"wall": 50},)))
    gallery = recognition.measure(dataclasses.replace(run, replies=replies, visible_px=({"picture 3": 50},)))
    assert (hall["n_mentions"], gallery["n_mentions"]) == (1, 2)


def test_a_reply_in_another_language_counts_neither_as_a_claim_nor_as_none(camera):
    run = camera(0, 3).run
    replies = run.replies.copy()
    replies[:] = ["I see a door and the JAXA logo.", "Je vois le logo JAXA et une porte.", "Turn left."]
    pixels = ({"door": 400}, {"door": 400, "plant": 400}, {"door": 400})
    found = recognition.measure(dataclasses.replace(run, replies=replies, visible_px=pixels))
    assert (found["n_claims"], found["n_replies"], found["n_unlabelled"]) == (1, 2, 1)
    assert (found["claim_rate"], found["n_things"], found["object_recall"]) == (0.5, 2, 0.5)


def test_a_note_says_how_many_replies_have_no_label(camera_sweep):
    found = analysis.analyze([camera_sweep().path], plots=False)
    missing = int(found.runs["recognition.n_unlabelled"].sum())
    said = missing + int(found.runs["recognition.n_replies"].sum())
    assert 0 < missing < said
    expected = (
        f"{missing} of {said} replies have no label because the rule covers only English and Japanese; "
        "measures of recognition leave them out"
    )
    assert expected in found.notes
