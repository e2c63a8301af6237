"""How the minimal naming game grows with its population."""

from __future__ import annotations

import pytest

from foundry.validating.naming_growth import peak, peak_exponent


def test_two_know_most_names_after_their_second_meeting_at_the_latest():
    peaks = {peak(2, seed) for seed in range(20)}
    assert peaks == {1}, "the first speaker invents, the other learns it: two in all, and never more"


def test_more_agents_need_more_interactions_each_to_know_most_names():
    small, large = ([peak(agents, seed) for seed in range(3)] for agents in (20, 80))
    assert 4 < sum(large) / sum(small) < 16, "4^1.5 is 8"


@pytest.mark.slow
@pytest.mark.timeout(300)
def test_the_peak_grows_like_the_population_to_the_power_of_three_halves():
    slope, error = peak_exponent()
    assert error < 0.05 and abs(slope - 1.5) < 0.1 + 4 * error
