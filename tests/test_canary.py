"""How far two canaries are apart, and what that says of their weights."""

import pytest

from foundry.canary import Distance, Sign, TokenLogprobs, Verdict

TOP = {"a": -0.5, "b": -1.5, "c": -2.5, "d": -3.0, "e": -3.5}


def sign(text: str = "a b", *, moved: float = 0.0, top: dict[str, float] = TOP, token: str = "a") -> Sign:
    place = TokenLogprobs(token, -0.5, {name: logprob + moved for name, logprob in top.items()})
    return Sign.of(text, [place])


def verdict(first: Sign, second: Sign) -> Verdict:
    return Distance.between([first], [second]).verdict


@pytest.mark.parametrize(
    ("moved", "says"),
    [
        (0.0, Verdict.SAME),
        (0.029, Verdict.SAME),
        (0.1, Verdict.UNDECIDED),
        (0.49, Verdict.UNDECIDED),
        (0.6, Verdict.OTHER),
    ],
)
def test_log_probabilities_decide_even_where_the_texts_say_otherwise(moved: float, says: Verdict):
    assert verdict(sign("a b"), sign("x y", moved=moved)) is says


def test_weights_whose_likeliest_tokens_are_others_are_other_weights():
    assert verdict(sign(), sign(top={name: -1.0 for name in "vwxyz"})) is Verdict.OTHER
    assert verdict(sign(), sign(top={name: TOP.get(name, -3.0) for name in "abcyz"})) is Verdict.UNDECIDED


def test_tokens_after_another_token_are_not_compared_since_their_context_is_another():
    place, apart = TokenLogprobs("a", -0.5, TOP), TokenLogprobs("z", -0.5, {"z": -0.5})
    first = Sign(text="", tokens=(place, place))
    assert Distance.between([first], [Sign(text="", tokens=(TokenLogprobs("b", -1.5, TOP), apart))]).gap == 0
    assert Distance.between([first], [Sign(text="", tokens=(place, apart))]).verdict is not Verdict.SAME


@pytest.mark.parametrize(
    ("text", "says"),
    [("over the sea", Verdict.SAME), ("over it all", Verdict.UNDECIDED), ("under it all", Verdict.OTHER)],
)
def test_texts_decide_where_a_server_tells_no_log_probabilities(text: str, says: Verdict):
    then = Sign(text="over the sea")
    assert verdict(then, Sign(text=text)) is says
    assert verdict(Sign(text="over the sea", tokens=sign().tokens), Sign(text=text)) is says


def test_canaries_that_say_nothing_decide_nothing():
    assert verdict(Sign(text=""), Sign(text="")) is Verdict.UNDECIDED
