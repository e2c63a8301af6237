import numpy as np
from hypothesis import given
from hypothesis import strategies as st
from numpy.random import SeedSequence

from foundry import seeding


def test_a_seed_and_a_name_give_the_same_stream_and_another_name_another():
    drawn = [seeding.stream(3, name).integers(0, 1000, 8).tolist() for name in ("layout", "layout", "personas")]
    assert drawn[0] == drawn[1] != drawn[2]


@given(st.integers(0, 2**200), st.integers(0, 2**32 - 1), st.integers(0, 2**32 - 1), st.sampled_from(("action", "é")))
def test_a_sampling_seed_is_what_numpy_derives_from_the_run_s_seed(seed: int, step: int, agent: int, kind: str):
    sequence = SeedSequence(seed, spawn_key=(seeding._name_key("call:" + kind), step, agent))
    derived = int(sequence.generate_state(1, np.uint32)[0]) & seeding.SEED_MASK
    assert seeding.sampling_seed(seed, step=step, agent=agent, kind=kind) == derived
    assert 0 <= derived < 2**31, "which every server takes"


def test_every_call_of_a_run_has_a_sampling_seed_of_its_own():
    seeds = {
        seeding.sampling_seed(1, step=step, agent=agent, kind=kind, again=again)
        for step in range(1, 51)
        for agent in range(20)
        for kind in ("message", "action")
        for again in range(3)
    }
    assert len(seeds) == 6000


def test_sampling_seeds_stay_what_they_are_from_version_to_version():
    assert seeding.sampling_seed(0, step=1, agent=0, kind="action") == 2046618883
