"""Which replies claim to see the target, what else they say is seen, and what labels are."""

import dataclasses
import json
from pathlib import Path

import pytest
from hypothesis import given
from hypothesis import strategies as st

import analysis
from analysis.camera.sight_rule import claims_to_see, thing_of, things_claimed
from analysis.camera.sight_words import AMBIGUOUS, THINGS
from analysis.camera.signatures import recognition


def test_a_reply_claims_to_see_the_target_or_not_or_is_in_another_language():
    """A reply that denies, seeks or guesses claims nothing."""
    for line in Path(__file__).with_name("claims.jsonl").read_text(encoding="utf-8").splitlines():
        label = json.loads(line)
        assert claims_to_see(label["text"], label["target"]) is label["claim"], line


@given(
    st.one_of(st.text(), st.text(alphabet="JAXA logo see not 見える。, ")),
    st.sampled_from(["JAXA logo", "picture 3", ""]),
)
def test_any_reply_and_target_can_be_read(text: str, target: str):
    assert claims_to_see(text, target) in (True, False, None)


@pytest.mark.slow
@pytest.mark.parametrize("part", ["I see the JAXA logo and ", "see a, ", "ロゴが"])
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
    measures = recognition.measure(dataclasses.replace(run, replies=replies, visible_px=pixels))
    assert (measures["n_mentions"], measures["n_things"], measures["mentions"]) == (3, 2, 1.5)
    assert measures["chair_i"] == pytest.approx(2 / 3)
    assert (measures["chair_s"], measures["object_recall"], measures["object_f1"]) == (0.5, 0.5, pytest.approx(2 / 5))


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
    measures = recognition.measure(dataclasses.replace(run, replies=replies, visible_px=pixels))
    assert (measures["n_claims"], measures["n_replies"], measures["n_unlabelled"]) == (1, 2, 1)
    assert (measures["claim_rate"], measures["n_things"], measures["object_recall"]) == (0.5, 2, 0.5)


def test_a_note_says_how_many_replies_have_no_label(camera_sweep):
    found = analysis.analyze([camera_sweep().path], plots=False)
    missing = int(found.runs["recognition.n_unlabelled"].sum())
    said = missing + int(found.runs["recognition.n_replies"].sum())
    assert 0 < missing < said
    expected = (
        f"{missing} of {said} replies have no label because the rule covers only English and Japanese; "
        "measures of recognition leave these replies out"
    )
    assert expected in found.notes
