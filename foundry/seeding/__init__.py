"""Independent, named random streams derived from a run's one seed.

Every stream is a child of `numpy.random.SeedSequence(seed)` whose spawn key is made of the stream's
name, so adding a stream or a draw to one never shifts another.
"""

import zlib
from functools import lru_cache

from numpy.random import Generator, SeedSequence, default_rng

SEED_MASK = 0x7FFF_FFFF
"""Sampling seeds lie in 0..2^31-1: servers read larger or negative ones as another seed, or as random."""

_WORD = 0xFFFF_FFFF
_MULTIPLIER = 0x931E8875
_POOL = 4
"""Words of a `SeedSequence`'s pool, 32 bits each; its algorithm and constants are M. O'Neill's `seed_seq_fe128`."""


@lru_cache(maxsize=256)
def _name_key(name: str) -> int:
    return zlib.crc32(name.encode())


def stream(seed: int, name: str) -> Generator:
    """Return the generator of the stream `name` of a run with this seed."""
    return default_rng(SeedSequence(seed, spawn_key=(_name_key(name),)))


def sampling_seed(seed: int, *, step: int, agent: int, kind: str, again: int = 0) -> int:
    """Return the seed, 0..2^31-1, that a backend samples one call's reply with.

    It is the first word of `SeedSequence(seed, spawn_key=(kind, step, agent))`, to which a call adds its agent alone;
    the key ends with `again` where that is not 0.

    Args:
        seed: of the run's calls.
        step: 1-based step.
        agent: who is asked.
        kind: what is asked.
        again: how often it was asked this before in the step.
    """
    if again:
        sequence = SeedSequence(seed, spawn_key=(_name_key("call:" + kind), step, agent, again))
        return int(sequence.generate_state(1)[0]) & SEED_MASK
    pool, multiplier = _mixed(seed, step, kind)
    mixed = _hashed(agent, multiplier, _MULTIPLIER)
    pool = (0xCA01F9DD * pool - 0x4973F715 * mixed) & _WORD
    return _hashed(pool ^ pool >> 16, 0x8B51F9DD, 0x58F38DED) & SEED_MASK


@lru_cache(maxsize=256)
def _mixed(seed: int, step: int, kind: str) -> tuple[int, int]:
    """Return the first word of the sequence's pool before the agent is mixed in, and the multiplier that is due then.

    Each word of the pool is hashed once by itself, once for every other one, and once for each word beyond the fourth.
    """
    sequence = SeedSequence(seed, spawn_key=(_name_key("call:" + kind), step))
    words = max(_POOL, -(-seed.bit_length() // 32)) + len(sequence.spawn_key)
    return int(sequence.pool[0]), 0x43B0D7E5 * pow(_MULTIPLIER, _POOL * words, _WORD + 1) & _WORD


def _hashed(value: int, multiplier: int, factor: int) -> int:
    value = (value ^ multiplier) * (multiplier * factor & _WORD) & _WORD
    return value ^ value >> 16
