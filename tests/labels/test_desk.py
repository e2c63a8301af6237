"""Texts handed out to people and the journals of their labels: order, undo, crashes, several people at once."""

from pathlib import Path

import pytest

from foundry.errors import InputError, RecordError
from foundry.labels.definition import Label
from foundry.labels.desk import LabelDesk
from foundry.labels.folder import Entry, LabelFolder
from foundry.labels.sampling import Sample, SampledText, Stratum

LABEL = Label(name="polite", question="Is it polite?", choices=("yes", "no"), unit="message")


def sample(texts: int = 24, strata: int = 3, same: int = 0) -> Sample:
    """Make a sample; the last `same` texts are equal."""
    drawn = tuple(
        SampledText(
            item=f"r/{number}", stratum=number % strata, text="equal" if number >= texts - same else f"text {number}",
            context={}, run="r", seed=0, step=number + 1, agent=0, kind="message",
        )
        for number in range(texts)
    )  # fmt: skip
    known = tuple(Stratum(draw=0, model="m", says=str(one), size=100, probability=0.1) for one in range(strata))
    return Sample(label="polite", question_sha256=LABEL.question_sha256, seed=0, strata=known, drawn=drawn)


@pytest.fixture
def folder(tmp_path: Path) -> LabelFolder:
    return LabelFolder(tmp_path / "labels" / "polite", "polite")


def next_item(desk: LabelDesk, person: str) -> str:
    shown = desk.place(person).shown
    return shown.item


def test_each_person_has_an_order_of_their_own_that_takes_one_text_of_every_stratum_in_turn(folder: LabelFolder):
    desk = LabelDesk(folder, LABEL, sample())
    ana, ben = desk.order("ana"), desk.order("ben")
    assert sorted(ana) == sorted(ben) and ana != ben
    strata = {picture.item: picture.stratum for picture in sample().drawn}
    for start in range(0, 24, 3):
        assert {strata[item] for item in ana[start : start + 3]} == {0, 1, 2}


def test_two_people_at_once_label_different_texts_first(folder: LabelFolder):
    desk = LabelDesk(folder, LABEL, sample())
    seen: list[str] = []
    for _ in range(12):
        for person in ("ana", "ben"):
            seen.append(next_item(desk, person))
        for person in ("ana", "ben"):
            desk.label(person, next_item(desk, person), "yes")
    assert len(set(seen)) == 24, "nobody labels what the other has, while there is something else"
    assert desk.place("ana").shown is not None, "after that each goes on with the texts of the other"


def test_a_label_is_on_the_disk_before_anybody_is_told_and_another_process_goes_on_from_there(folder: LabelFolder):
    desk = LabelDesk(folder, LABEL, sample(), clock=iter(range(100)).__next__)
    first = next_item(desk, "ana")
    place = desk.label("ana", first, "no")
    assert folder.labels_by("ana") == {first: "no"}
    assert (place.done, place.total, place.can_undo) == (1, 24, True)
    assert b'"seconds":1' in (folder.path / "people" / "ana.jsonl").read_bytes()
    again = LabelDesk(LabelFolder(folder.path, "polite"), LABEL, sample()).place("ana")
    assert again.done == 1 and again.shown is not None and again.shown.item != first


def test_undo_withdraws_the_last_label_shows_its_text_again_and_the_file_tells_both(folder: LabelFolder):
    desk = LabelDesk(folder, LABEL, sample())
    first = next_item(desk, "ana")
    desk.label("ana", first, "yes")
    second = next_item(desk, "ana")
    desk.label("ana", second, "unclear")
    place = desk.undo("ana")
    assert place.shown is not None and (place.shown.item, place.done) == (second, 1)
    assert folder.labels_by("ana") == {first: "yes"}
    desk.label("ana", second, "no")
    assert folder.labels_by("ana") == {first: "yes", second: "no"}
    assert len((folder.path / "people" / "ana.jsonl").read_bytes().splitlines()) == 4
    desk.undo("ana")
    assert desk.undo("ana").can_undo is False
    with pytest.raises(InputError, match="no label to undo"):
        desk.undo("ana")


def test_a_text_that_was_drawn_several_times_is_asked_about_once(folder: LabelFolder):
    desk = LabelDesk(folder, LABEL, sample(6, same=3))
    asked = 0
    while (shown := desk.place("ana").shown) is not None:
        desk.label("ana", shown.item, "yes" if shown.text == "equal" else "no")
        asked += 1
    assert asked == 4 and list(folder.labels_by("ana").values()).count("yes") == 3
    desk.undo("ana")


def test_a_label_of_a_text_that_is_not_shown_or_that_is_no_choice_is_refused(folder: LabelFolder):
    desk = LabelDesk(folder, LABEL, sample())
    with pytest.raises(InputError, match="no longer shown"):
        desk.label("ana", "r/0", "yes")
    item = next_item(desk, "ana")
    with pytest.raises(InputError, match="'maybe' is not an answer to this question: choose yes, no, unclear"):
        desk.label("ana", item, "maybe")
    with pytest.raises(InputError, match="'../x' is not a valid name"):
        desk.place("../x")
    assert not (folder.path / "people").exists()


def test_a_line_that_a_crash_cut_is_left_out_and_the_next_label_begins_a_line_of_its_own(folder: LabelFolder):
    folder.add("ana", Entry(item="r/1", label="yes"))
    file = folder.path / "people" / "ana.jsonl"
    for cut in (1, 9, 20):
        file.write_bytes(file.read_bytes() + b'{"item":"r/2","label":"no"}'[:cut])
        assert folder.labels_by("ana") == {"r/1": "yes"}
        folder.add("ana", Entry(item="r/1", label="yes"))
    folder.add("ana", Entry(item="r/3", label="no"))
    assert folder.labels_by("ana") == {"r/1": "yes", "r/3": "no"}
    file.write_bytes(file.read_bytes() + b"torn by hand\n")
    with pytest.raises(RecordError, match=r"Line \d+ of .*ana.jsonl cannot be read"):
        folder.labels_by("ana")
