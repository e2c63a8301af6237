"""How sure a model was of a decision, and how often it would decide each way, by tokens with known probabilities."""

import math

import numpy as np
import pytest

from foundry.canary import TokenLogprobs
from foundry.certainty import GREATEST_ERROR, Sampling, certainty_of, foreseen
from told_runs import OPENLY, place

LABELS = ("go", "stay")


def token(text: str, **top: float) -> TokenLogprobs:
    return TokenLogprobs(text, -0.1, {name: math.log(share) for name, share in top.items()})


def test_the_shares_of_the_labels_are_those_of_the_tokens_that_begin_them():
    tokens = [token('{"action": "'), token("go", go=0.6, stay=0.2, Go=0.1), token('"}')]
    found = certainty_of('{"action": "go"}', tokens, "go", LABELS)
    assert (found.probability, found.covered) == (pytest.approx(0.75), pytest.approx(0.8))
    assert found.entropy == pytest.approx(-0.75 * math.log2(0.75) - 0.25 * math.log2(0.25))


def test_a_token_may_hold_the_mark_before_or_after_a_label():
    top = {' "go"': math.log(0.9), ' "st': math.log(0.1)}
    found = certainty_of(
        '{"action": "go"}', [token('{"action":'), TokenLogprobs(' "go"', -0.1, top), token("}")], "go", LABELS
    )
    assert found.probability == pytest.approx(0.9)


@pytest.mark.parametrize(
    ("text", "decided", "labels"),
    [
        ("I go, they go", "go", LABELS),  # which of them decides?
        ("go", "go", ("go", "goal")),  # labels that begin alike
        ("goes", "stay", LABELS),  # a decision that is not in the text
    ],
)
def test_where_no_one_token_decides_nothing_is_said(text: str, decided: str, labels: tuple[str, ...]):
    assert certainty_of(text, [TokenLogprobs(text, 0.0, {text: 0.0, "go": -1.0})], decided, labels) is None


def test_a_reply_whose_tokens_are_not_its_text_says_nothing():
    assert certainty_of("go", [token("stay", stay=1.0)], "go", LABELS) is None


def expected(chances: dict[str, float], **options: float | None) -> tuple[dict[str, float], float]:
    """Return the shares of `go` and `stay`, and how wrong they may be, where the likelier one was decided."""
    sampling = Sampling.of({"temperature": 1.0, **OPENLY, **options})
    found = certainty_of("go", [place("go", **chances)], "go", LABELS, sampling)
    return found.expected, found.error


@pytest.mark.parametrize(
    ("options", "go"),
    [
        ({}, 0.8),
        ({"temperature": 0.5}, 0.64 / 0.68),
        ({"temperature": 0.0}, 1.0),
        ({"top_k": 1}, 1.0),
        ({"top_p": 0.75}, 1.0),
        ({"top_p": 0.85}, 0.8),
        ({"min_p": 0.3}, 1.0),
        ({"min_p": 0.2}, 0.8),
    ],
)
def test_probabilities_are_converted_by_temperature_and_filters(options: dict[str, float], go: float):
    shares, error = expected({"go": 0.8, "stay": 0.2}, **options)
    assert shares == pytest.approx({"go": go, "stay": 1 - go}) and error == pytest.approx(0.0, abs=1e-9)


def test_a_filter_that_the_request_leaves_to_the_server_is_an_error_where_it_would_change_the_shares():
    unsaid = {"top_k": None, "min_p": None}
    assert expected({"go": 0.97, "stay": 0.03}, **unsaid)[1] == pytest.approx(0.03)
    assert expected({"go": 0.9, "stay": 0.1}, **unsaid)[1] == pytest.approx(0.0, abs=1e-9)
    assert expected({"go": 0.9, "stay": 0.1}, top_p=None)[1] == pytest.approx(0.1)


def test_filters_before_and_after_the_temperature_are_an_error_where_they_differ():
    shares, error = expected({"go": 0.6, "stay": 0.4}, temperature=0.5, top_p=0.65)
    assert shares["go"] == 1 and error == pytest.approx(1 - 0.36 / 0.52)


def test_expected_shares_are_those_of_samples_within_the_error_that_is_told():
    rng = np.random.default_rng(0)
    for _ in range(200):
        chances = rng.dirichlet([2.0, 1.0, 0.05, 0.02])
        temperature = float(rng.uniform(0.1, 1.0))
        powers = chances ** (1 / temperature)
        true = powers[:2] / powers[:2].sum()
        named = dict(zip(("go", "stay", "Go"), chances.tolist(), strict=False))
        shares, error = expected(named, temperature=temperature)
        assert 0.5 * (abs(shares["go"] - true[0]) + abs(shares["stay"] - true[1])) <= error + 1e-9


@pytest.mark.parametrize(
    "options", [{"temperature": None}, {"temperature": 1.5}, {"presence_penalty": 0.5}, {"repeat_penalty": 1.1}]
)
def test_a_sampling_that_cannot_be_converted_tells_nothing_of_shares(options: dict[str, float | None]):
    assert Sampling.of({"temperature": 1.0, **options}) is None
    found = certainty_of("go", [place("go", go=0.8, stay=0.2)], "go", LABELS, None)
    assert found.error == 1 and found.probability == pytest.approx(0.8)


def test_options_are_found_where_ollama_has_them():
    assert Sampling.of({"options": {"temperature": 0.3, **OPENLY}}) == Sampling(0.3, (OPENLY,))


OPEN = Sampling(1.0, (OPENLY,))
BEGIN, DECIDED = TokenLogprobs('{"action": "', 0.0, {}), place("go", go=0.8, stay=0.2)


def test_one_reply_stands_for_all_where_only_its_decision_is_drawn():
    found = foreseen('{"action": "go', [BEGIN, DECIDED], "go", LABELS, OPEN)
    assert found.expected == pytest.approx({"go": 0.8, "stay": 0.2})


@pytest.mark.parametrize("before", ["Fire is near: ", "I think so. "])
def test_after_drawn_words_it_stands_for_itself_alone(before: str):
    reason = TokenLogprobs(before, math.log(0.9), {before: math.log(0.9), "Well ": math.log(0.1)})
    assert foreseen(f"{before}go", [reason, DECIDED], "go", LABELS, OPEN) is None
    greedy = foreseen(f"{before}go", [reason, DECIDED], "go", LABELS, Sampling(0.0, (OPENLY,)))
    assert greedy.expected == {"go": 1.0, "stay": 0.0}


def test_where_labels_are_badly_covered_it_stands_for_itself_alone():
    assert pytest.approx(0.05) == GREATEST_ERROR
    for uncovered, is_foreseen in ((0.04, True), (0.06, False)):
        token = place("go", go=0.8 - uncovered, stay=0.2, Go=uncovered)
        assert (foreseen("go", [token], "go", LABELS, OPEN) is not None) == is_foreseen


def test_the_error_of_a_foreseen_decision_has_its_uncovered_part_and_its_uncertain_beginning():
    likely = place("So ", **{"So ": 0.98, "Well ": 0.02})
    error = foreseen("So go", [likely, place("go", go=0.78, stay=0.2, Go=0.02)], "go", LABELS, OPEN)
    assert error.error == pytest.approx(1 - 0.98 * 0.98)
