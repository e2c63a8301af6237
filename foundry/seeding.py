"""Independent, named random streams derived from a run's one seed.

Every stream is a child of `numpy.random.SeedSequence(seed)` whose spawn key is made of the stream's
name, so adding a stream or a draw to one never shifts another.
"""

from __future__ import annotations

import zlib
from functools import lru_cache

import numpy as np
from numpy.random import Generator, SeedSequence, default_rng

SEED_MASK = 0x7FFF_FFFF
"""Sampling seeds lie in 0..2^31-1: servers read larger or negative ones as another seed, or as random."""


@lru_cache(maxsize=256)
def _name_key(name: str) -> int:
    return zlib.crc32(name.encode())


def stream(seed: int, name: str) -> Generator:
    """Return the generator of the stream `name` of a run with this seed."""
    return default_rng(SeedSequence(seed, spawn_key=(_name_key(name),)))


def sampling_seed(seed: int, *, step: int, agent: int, kind: str, again: int = 0) -> int:
    """Return the seed, 0..2^31-1, that a backend samples one call's reply with.

    Args:
        seed: of the run's calls.
        step: 1-based step.
        agent: who is asked.
        kind: what is asked.
        again: how often it was asked this before in the step.
    """
    place = (_name_key("call:" + kind), step, agent)
    sequence = SeedSequence(seed, spawn_key=(*place, again) if again else place)
    return int(sequence.generate_state(1, np.uint32)[0]) & SEED_MASK
