"""Compares groups by all headline measures together: which groups are similar, and which pairs differ."""

from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from itertools import combinations

import numpy as np
import pandas as pd

from analysis.arrays import BoolArray, FloatArray
from analysis.prose import group_label
from analysis.stats.family import headline_measures
from analysis.stats.intervals import FEWEST_FOR_CLAIMS, NO_VARIATION, varies
from analysis.stats.pairing import comparable_measures
from analysis.stats.sign_flip import assignments, share_as_extreme, sign_blocks
from analysis.stats.testing import holm
from analysis.stats.values import seed_values, select
from analysis.tables.signature_table import SignatureTable
from foundry.seeding import stream

RESAMPLES = 999
UNDEFINED = "undefined in a run"
OTHER_QUESTIONS = "not comparable: the worlds ask different questions"
_TIES = 1e-10
_AT_ONCE = 512
"""Number of points whose distances to all others are in memory at once."""
_DRAWS_AT_ONCE = 128


@dataclass(frozen=True)
class Fingerprint:
    """A comparison of L groups that uses K measures at the same time.

    Attributes:
        seeds: the seeds for which every group has a complete run; other seeds are not used.
        z: mean of the standardised measures, levels x measures; 0 is the mean of all groups, 1 the standard deviation
            over all their runs.
        linkage: the merges of levels by average distance (L - 1, 4): the indices of both clusters, their distance, and
            their number of levels; merge k makes cluster L + k. None with fewer than two levels.
        support: for each merge, the share of resamples (of seeds) in which it occurs again (L - 1,).
        energy: one row per pair of levels: `level`, `reference`, `n_seeds`, `statistic`, `p`, `p_holm`, `note`.
        dropped: measures that are left out, with the reason.
    """

    levels: tuple[str, ...]
    measures: tuple[str, ...]
    seeds: tuple[int, ...]
    z: pd.DataFrame
    linkage: FloatArray | None
    support: FloatArray
    energy: pd.DataFrame
    dropped: Mapping[str, str]


def fingerprint(
    table: SignatureTable, groups: pd.DataFrame | None = None, *, measures: Sequence[str] | None = None
) -> Fingerprint:
    """Return the fingerprint of the groups that are not baselines, by default over the headline measures."""
    values = seed_values(table, groups)
    chosen = headline_measures(values.measures) if measures is None else tuple(measures)
    own = np.flatnonzero(~values.baseline)
    levels = tuple(group_label(values.groups[index]) for index in own)
    complete = np.asarray(values.complete[own].all(axis=0))
    cells = values.values[own][:, complete][:, :, select(values.measures, chosen)]
    names = [name for name in values.measures if name in chosen]
    usable, dropped = _usable(
        cells, names, comparable_measures(values, ~values.baseline)[select(values.measures, chosen)]
    )
    scaled = _standardised(cells[:, :, usable])
    merges = _merges(scaled.mean(axis=1)[None]) if len(scaled) > 1 and scaled.size else None
    return Fingerprint(
        levels=levels,
        measures=tuple(np.array(names, dtype=object)[usable]),
        seeds=tuple(np.array(values.seeds)[complete].tolist()),
        z=_means(scaled, levels, [names[index] for index in usable]),
        linkage=None if merges is None else merges.linkage[0],
        support=np.zeros(0) if merges is None else _support(scaled, merges.joined[0]),
        energy=_energy(scaled, levels),
        dropped=dropped,
    )


def energy_distance(first: FloatArray, second: FloatArray) -> float:
    """Return 2 E|X - Y| - E|X - X'| - E|Y - Y'| of points (n, K) and (m, K), all pairs counted (Szekely 2002)."""
    between, within, other = (_mean_distance(*two) for two in ((first, second), (first, first), (second, second)))
    return 2 * between - within - other


def _mean_distance(first: FloatArray, second: FloatArray) -> float:
    blocks = (first[start : start + _AT_ONCE] for start in range(0, len(first), _AT_ONCE))
    return sum(float(_distances(block, second).sum()) for block in blocks) / (len(first) * len(second))


def _usable(cells: FloatArray, names: Sequence[str], comparable: BoolArray) -> tuple[list[int], dict[str, str]]:
    """Return the indices of the measures to use, and for each other measure the reason why it is left out."""
    flat = cells.reshape(cells.shape[0] * cells.shape[1], len(names))
    dropped = {name: UNDEFINED for name, column in zip(names, flat.T, strict=True) if np.isnan(column).any()}
    dropped |= {name: OTHER_QUESTIONS for name, is_same in zip(names, comparable, strict=True) if not is_same}
    for name, column in zip(names, flat.T, strict=True):
        if name not in dropped and (not len(column) or not varies(column[None, :])[0]):
            dropped[name] = NO_VARIATION
    return [index for index, name in enumerate(names) if name not in dropped], dropped


def _standardised(cells: FloatArray) -> FloatArray:
    if not cells.size:
        return cells
    return np.asarray((cells - cells.mean(axis=(0, 1))) / cells.std(axis=(0, 1)))


def _means(scaled: FloatArray, levels: Sequence[str], names: Sequence[str]) -> pd.DataFrame:
    means = scaled.mean(axis=1) if scaled.size else np.zeros((len(levels), len(names)))
    return pd.DataFrame(means, index=pd.Index(levels, name="level"), columns=list(names))


@dataclass(frozen=True)
class _Merges:
    """The trees that join L levels, one tree for each of D random draws of the seeds.

    Attributes:
        linkage: as in `Fingerprint`, for each draw (D, L - 1, 4).
        joined: the levels that each merge joins (D, L - 1, L).
    """

    linkage: FloatArray
    joined: BoolArray


def _merges(means: FloatArray) -> _Merges:
    """For each random draw, join levels to a tree by average distance, the closest first (UPGMA).

    Source: Sokal and Michener 1958.

    Args:
        means: means of the levels in each draw (D, L, K).
    """
    draws, count, _ = means.shape
    every, levels = np.arange(draws), np.arange(count)
    apart = np.sqrt(sum((axis[:, :, None] - axis[:, None]) ** 2 for axis in np.moveaxis(means, -1, 0)))
    apart[:, levels, levels] = np.inf
    holds = np.broadcast_to(np.eye(count, dtype=bool), apart.shape).copy()
    numbers = np.broadcast_to(levels, (draws, count)).copy()
    linkage, joined = np.empty((draws, count - 1, 4)), np.empty((draws, count - 1, count), dtype=bool)
    for merge in range(count - 1):
        first, second = np.divmod(apart.reshape(draws, -1).argmin(axis=1), count)
        both = np.sort([numbers[every, first], numbers[every, second]], axis=0)
        sizes = [holds[every, index].sum(axis=1, keepdims=True) for index in (first, second)]
        linkage[:, merge, :3] = np.column_stack([*both, apart[every, first, second]])
        mean = (sizes[0] * apart[every, first] + sizes[1] * apart[every, second]) / (sizes[0] + sizes[1])
        apart[every, first] = apart[every, :, first] = mean
        apart[every, second] = apart[every, :, second] = np.inf
        holds[every, first] |= holds[every, second]
        numbers[every, first] = count + merge
        joined[:, merge] = holds[every, first]
    linkage[:, :, 3] = joined.sum(axis=2)
    return _Merges(linkage, joined)


def _support(scaled: FloatArray, joined: BoolArray) -> FloatArray:
    """Return the support of each branch of the tree, (L - 1,).

    It is the share of random resamples of the seeds in which a branch with the same levels exists.
    """
    if len(joined) == 1:
        return np.ones(1)
    seeds = scaled.shape[1]
    draws = stream(seeds, "fingerprint").integers(0, seeds, size=(RESAMPLES, seeds))
    seen = np.zeros(len(joined))
    for draw in np.array_split(draws, -(-RESAMPLES // _DRAWS_AT_ONCE)):
        weights = np.array([np.bincount(drawn, minlength=seeds) for drawn in draw]) / seeds
        again = _merges(np.tensordot(weights, scaled, axes=(1, 1))).joined
        seen += (again[:, :, None] == joined).all(axis=3).any(axis=1).sum(axis=0)
    return seen / RESAMPLES


def _energy(scaled: FloatArray, levels: Sequence[str]) -> pd.DataFrame:
    columns = ["level", "reference", "n_seeds", "statistic", "p", "p_holm", "note"]
    if not scaled.size:
        return pd.DataFrame(columns=columns)
    seeds = scaled.shape[1]
    tested = seeds >= FEWEST_FOR_CLAIMS
    note = "" if tested else f"not tested: n < {FEWEST_FOR_CLAIMS}"
    rows = [
        {
            "level": levels[second],
            "reference": levels[first],
            "n_seeds": seeds,
            "statistic": energy_distance(scaled[first], scaled[second]),
            "p": swap_p(scaled[first], scaled[second]) if tested else np.nan,
            "note": note,
        }
        for first, second in combinations(range(len(levels)), 2)
    ]
    frame = pd.DataFrame(rows, columns=columns)
    frame["p_holm"] = holm(frame["p"].to_numpy(dtype=np.float64))
    return frame


def swap_p(first: FloatArray, second: FloatArray) -> float:
    """Return the p value of the energy distance between two groups of n points each, (n, K), one point per seed.

    The null distribution comes from swapping the two points of a seed. It is exact up to n = 16; for larger n, a fixed
    random sample of swaps is used.
    """
    # With labels s of all 2n points, +1 and -1, the distance is -s'Ds / n^2, and a swap changes the sign of a pair.
    size = len(first)
    null, observed, spread = np.zeros(len(assignments(size))), 0.0, 0.0
    for start in range(0, size, _AT_ONCE):
        kernel = _kernel(first[start:], second[start:], min(_AT_ONCE, size - start))
        blocks = (signs[:, start:] for signs in sign_blocks(size))
        null += np.concatenate([((signs @ kernel) * signs[:, : kernel.shape[1]]).sum(axis=1) for signs in blocks])
        observed += float(kernel.sum())
        spread += float(np.abs(kernel).sum())
    return float(share_as_extreme([null[None, :]], np.array([observed]), np.array([_TIES * spread]), size)[0])


def _kernel(first: FloatArray, second: FloatArray, count: int) -> FloatArray:
    """Return how much the distance between two pairs of points changes if one pair is swapped, (m, count).

    The m pairs are compared with the first `count` pairs.

    The whole matrix is symmetric, so each pair beyond the first `count` counts twice.
    """
    early, other = first[:count], second[:count]
    kernel = _distances(first, other) + _distances(second, early) - _distances(first, early) - _distances(second, other)
    kernel[count:] *= 2
    return kernel


def _distances(first: FloatArray, second: FloatArray) -> FloatArray:
    squares = np.zeros((len(first), len(second)))
    for own, other in zip(first.T, second.T, strict=True):
        squares += np.subtract.outer(own, other) ** 2
    return np.sqrt(squares)
