"""How the minimal naming game grows with its population."""

from __future__ import annotations

import pytest

from foundry.validating.naming_growth import _exponent, consensus, consensus_exponent, peak, peak_exponent


def test_two_know_most_names_after_their_second_meeting_and_agree_once_both_know_a_name():
    peaks = {peak(2, seed) for seed in range(20)}
    assert peaks == {1}, "the first speaker invents, the other learns it: two in all, and never more"
    assert {consensus(2, seed) for seed in range(20)} == {2}, "the first meeting fails, every other succeeds"


def test_more_agents_need_more_interactions_each_to_know_most_names():
    small, large = ([peak(agents, seed) for seed in range(3)] for agents in (20, 80))
    assert 4 < sum(large) / sum(small) < 16, "4^1.5 is 8"


@pytest.mark.slow
def test_more_agents_need_more_interactions_each_to_agree():
    small, large = ([consensus(agents, seed) for seed in range(6)] for agents in (20, 80))
    assert 4 < sum(large) / sum(small) < 16, "4^1.3 is 6.1"


def test_the_exponent_of_a_power_is_found_and_its_error_is_none_where_all_lie_on_it():
    assert _exponent([(n, n**2) for n in (10, 20, 40)]) == pytest.approx((2, 0), abs=1e-9)


@pytest.mark.exhaustive
def test_the_peak_grows_like_the_population_to_the_power_of_three_halves_and_consensus_slower():
    (peaks, of_peaks), (agreed, of_agreed) = peak_exponent(), consensus_exponent()
    assert of_peaks < 0.02 and abs(peaks - 1.5) < 0.1
    assert of_agreed < 0.03 and abs(agreed - 1.3) < 0.02 + 3 * of_agreed
