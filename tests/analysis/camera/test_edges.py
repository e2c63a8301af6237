"""What is undefined is missing, and what could not be read is as if it had not been decided."""

import dataclasses
import math

import numpy as np
import pytest

from analysis import signatures
from analysis.camera.camera_run import CameraRun
from analysis.camera.sight_rule import is_readable
from analysis.camera.signatures import recognition
from analysis.form import form_of
from analysis.labelling import Labelling, agreement, hand_labelled, rule_labelling
from analysis.labelling.correcting import Correction, WeighedText
from foundry.labels.definition import label_named


def undefined(found: dict[str, float], signature: str) -> set[str]:
    mine = {key.partition(".")[2]: value for key, value in found.items() if key.startswith(f"{signature}.")}
    return {name for name, value in mine.items() if math.isnan(value)}


def defined(found: dict[str, float], signature: str) -> set[str]:
    return {key.partition(".")[2] for key in found if key.startswith(f"{signature}.")} - undefined(found, signature)


def test_without_a_target_nothing_about_one_is_defined(camera):
    measures = signatures.measure(camera(1, target="", radius=0.0, shortest_path=[], shortest_m=None).run)
    things = {"chair_i", "chair_s", "mentions", "n_mentions", "n_things"}
    views = {"view_change", "same_view_change", "view_effect"}
    for signature in ("path_efficiency", "recognition", "recovery", "viewpoint"):
        rest = {name.removesuffix("_readable") for name in defined(measures, signature)} - things - views
        assert all(name.startswith(("n_", "object_")) for name in rest)
    assert (
        measures["path_efficiency.n_episodes"] == measures["recognition.n_claims"] == measures["recovery.n_steps"] == 0
    )
    assert measures["collision.rate"] > 0


def test_where_nothing_is_labelled_nothing_about_things_is_defined(camera):
    run = camera(1).run
    bare = dataclasses.replace(run, visible_px=({},) * run.decisions)
    measures = recognition.measure(bare)
    about_things = {"chair_i", "chair_s", "mentions", "object_precision", "object_recall", "object_f1"}
    assert all(math.isnan(measures[name]) for name in about_things)
    assert measures["n_mentions"] == measures["n_things"] == 0
    assert not math.isnan(measures["precision"])


def test_without_a_way_or_with_one_of_no_length_there_is_no_path_efficiency(camera):
    measures = signatures.measure(camera(2, shortest_path=[], shortest_m=None, stop=True).run)
    assert undefined(measures, "path_efficiency") >= {"spl", "soft_spl", "ndtw", "shortest"}
    assert measures["path_efficiency.success"] == 1
    assert "detour_cost" in undefined(measures, "recovery")
    measures = signatures.measure(camera(2, shortest_path=[(0.0, 0.0, 0.0)], shortest_m=0.0, stop=True).run)
    assert undefined(measures, "path_efficiency") >= {"spl", "soft_spl"}
    assert measures["path_efficiency.ndtw"] >= 0


def test_reaching_the_goal_without_staying_is_no_success(camera):
    recorded = camera(3, stop=True)
    steps = (recorded.folder.path / "steps.jsonl").read_text("utf-8")
    assert signatures.measure(recorded.run)["path_efficiency.success"] == 1
    head, tail = steps.rstrip("\n").rsplit("\n", 1)
    (recorded.folder.path / "run.json").unlink()
    changed = tail.replace('"stay":true', '"stay":false')
    (recorded.folder.path / "steps.jsonl").write_text(f"{head}\n{changed}\n", encoding="utf-8")
    measures = signatures.measure(recorded.run)
    assert (measures["path_efficiency.success"], measures["path_efficiency.reached"]) == (0, 1)
    assert measures["path_efficiency.spl"] == 0


@pytest.mark.parametrize(
    "signature",
    ["collision", "gaze", "path_efficiency", "recognition", "recovery", "stability", "turning", "viewpoint"],
)
def test_without_decisions_everything_but_counts_is_missing(camera, signature):
    measures = signatures.measure(camera(0, 0).run)
    facts = {"path_length", "shortest", "ndtw", "distance_to_goal", "n_episodes"}
    known = {name.removesuffix("_readable") for name in defined(measures, signature)} - facts
    assert all(measures[f"{signature}.{name}"] == 0 for name in known)
    assert all(name.startswith("n_") for name in known)


def test_one_decision_has_no_pairs_and_silence_nothing_to_label(camera):
    measures = signatures.measure(camera(4, 1).run)
    assert {"persistence", "kappa", "conditional_entropy", "reversal_rate"} <= undefined(measures, "stability")
    run = camera(0).run
    judge = Labelling("judge", "1", agreement([None] * len(hand_labelled())), {})
    assert form_of("camera").labelled(run, judge) is run


@pytest.mark.parametrize("measure", ["clustering", "communication", "warning", "place_choice", "movement"])
def test_what_a_world_does_not_have_has_no_column(camera, measure):
    assert not any(name.startswith(measure) for name in signatures.measure(camera(0).run))
    assert not any("message" in name for name in signatures.measure(camera(0).run))


BY_STATE = ("foot", "yaw", "pitch", "distance")
BY_DECISION = (
    "bearing", "asked", "turn", "gaze", "stay", "outcome", "boundary", "travelled", "visited", "target_px", "success",
    "replies",
)  # fmt: skip
MINE = ("collision", "gaze", "path_efficiency", "recognition", "recovery", "turning", "viewpoint")


def with_known_distances(run: CameraRun) -> CameraRun:
    return dataclasses.replace(run, distance=np.linalg.norm(run.foot[:, :2] - np.array([6.0, 5.0]), axis=1))


def without_unreadable(run: CameraRun) -> CameraRun:
    """Return the run without the decisions that could not be read; they move nothing."""
    states = np.concatenate(([True], run.readable))
    return dataclasses.replace(
        run,
        **{name: getattr(run, name)[states] for name in BY_STATE},
        **{name: getattr(run, name)[run.readable] for name in BY_DECISION},
        visible_px=tuple(run.visible_px[index] for index in np.flatnonzero(run.readable)),
    )


@pytest.mark.parametrize("name", MINE)
def test_what_could_not_be_read_is_as_if_it_had_not_been_decided(name, camera):
    run = with_known_distances(camera(7, 60, stop=True).run)
    assert 0 < run.readable.sum() < run.decisions
    signature = next(signature for signature in signatures.discover() if signature.name == name)
    measures = signature.measure(run.only_readable())
    assert measures == pytest.approx(signature.measure(without_unreadable(run)), nan_ok=True)


def test_of_pairs_in_a_row_both_must_be_readable(camera):
    run = camera(7, 60).run
    stability = next(signature for signature in signatures.discover() if signature.name == "stability")
    measures = stability.measure(run.only_readable())
    assert measures["n_pairs"] == (run.readable[1:] & run.readable[:-1]).sum()
    assert measures["run_length"] * measures["n_runs"] == pytest.approx(run.readable.sum())
    alternating = dataclasses.replace(run, outcome=np.where(np.arange(60) % 2, run.outcome.max(), 0))
    assert not alternating.readable.all()
    assert math.isnan(stability.measure(alternating.only_readable())["persistence"])


def test_people_correct_shares_of_replies_and_no_measure_with_claims_in_its_denominator(camera):
    run = camera(0).run
    told = {step for step, text in enumerate(run.replies.tolist(), 1) if text.strip() and is_readable(text)}
    claims = {step: bool(run.target_px[step - 1] >= recognition.VISIBLE_PX) for step in told}
    label = label_named("sight_claim")

    def by_people(steps: set[int], weight: float) -> Correction:
        weighed = tuple(WeighedText(step, 0, "move", {"yes" if claims[step] else "no": 1.0}, weight) for step in steps)
        return Correction(
            label=label, people=("ana",), texts=len(weighed), by_run={run.id: weighed}, known={}, rates={},
            strata_of_run={run.id: (0, "walker")}, version="1",
        )  # fmt: skip

    def corrected(steps: set[int], weight: float) -> dict[str, float]:
        return {name: float(values[0]) for name, values in recognition.correct(run, by_people(steps, weight)).items()}

    alone, every = recognition.measure(run), corrected(told, 1.0)
    assert set(every) == {"informedness", "claim_rate", "accuracy", "recall", "miss_rate", "false_claim_rate"}
    assert every == pytest.approx(
        {"informedness": 1, "claim_rate": np.mean(list(claims.values())), "accuracy": 1, "recall": 1, "miss_rate": 0,
         "false_claim_rate": 0}
    )  # fmt: skip
    assert alone["informedness"] < 0.9, "the walker claims what it does not see"
    assert corrected(set(), 1.0) == pytest.approx({name: alone[name] for name in every})
    halves = [corrected({step for step in told if step % 2 == half}, 2.0)["claim_rate"] for half in (0, 1)]
    assert np.mean(halves) == pytest.approx(every["claim_rate"])
    signature = next(signature for signature in signatures.discover() if signature.name == "recognition")
    assert signature.describe("recall_uncorrected").label.endswith(", without people's labels")
    corrections = {"sight_claim": by_people(told, 1.0)}
    measures = signatures.measure(run)
    names = measures | signatures.corrected(run, measures, corrections)[0]
    readings = signatures.readings([dataclasses.replace(rule_labelling(), corrections=corrections)], names)
    assert {name for name, reading in readings.items() if reading.short == "corrected"} == {
        f"recognition.{name}{end}" for name in every for end in ("", "_readable")
    }
    uncorrected = {
        name for name, reading in readings.items() if reading.text.endswith("(not corrected by people's labels)")
    }
    assert {"recognition.precision", "recognition.hallucinated", "recognition.f1", "recognition.mcc"} <= uncorrected
    assert uncorrected.isdisjoint(f"recognition.{name}_uncorrected" for name in every)
    assert "recognition.false_stop" not in readings, "it needs no text"
