"""Makes independent random streams, each with a name, from the one seed of a run.

Every random stream is a child of `numpy.random.SeedSequence(seed)`, with a spawn key made of the stream's name. Because
of these keys, a new stream, or another draw from a stream, never changes the numbers of other streams.
"""

import zlib
from functools import lru_cache

from numpy.random import Generator, SeedSequence, default_rng

SEED_MASK = 0x7FFF_FFFF
"""Limits sampling seeds to 0..2^31-1: servers read larger or negative seeds as other seeds, or as random."""

_WORD = 0xFFFF_FFFF
_MULTIPLIER = 0x931E8875
_POOL = 4
"""Number of 32-bit words in the pool of a `SeedSequence` (algorithm and constants: O'Neill's `seed_seq_fe128`)."""


@lru_cache(maxsize=256)
def _name_key(name: str) -> int:
    return zlib.crc32(name.encode())


def stream(seed: int, name: str) -> Generator:
    """Return the random generator of the stream with this name, in a run with this seed."""
    return default_rng(SeedSequence(seed, spawn_key=(_name_key(name),)))


def sampling_seed(seed: int, *, step: int, agent: int, kind: str, again: int = 0) -> int:
    """Return the seed, 0..2^31-1, with which a backend samples the reply of one call.

    It is the first word of `SeedSequence(seed, spawn_key=(kind, step, agent))`; if `again` is not 0, it is the last
    part of the key. The state before the agent is cached, since the calls of a step differ only in the agent.

    Args:
        seed: seed of the run's calls.
        step: 1-based step.
        agent: id of the asked agent.
        kind: kind of question.
        again: number of earlier questions of this kind to this agent in this step.
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
    """Return the state of a `SeedSequence` before the agent's id is mixed in.

    The state is the first word of the sequence's pool, and the multiplier for the next hash.

    Each word of the pool is hashed once alone, once for every other word, and once for each word beyond the fourth.
    """
    sequence = SeedSequence(seed, spawn_key=(_name_key("call:" + kind), step))
    words = max(_POOL, -(-seed.bit_length() // 32)) + len(sequence.spawn_key)
    return int(sequence.pool[0]), 0x43B0D7E5 * pow(_MULTIPLIER, _POOL * words, _WORD + 1) & _WORD


def _hashed(value: int, multiplier: int, factor: int) -> int:
    value = (value ^ multiplier) * (multiplier * factor & _WORD) & _WORD
    return value ^ value >> 16
