"""Splits the variation between runs into components: model, prompt, other swept settings, seed, residual."""

from collections.abc import Iterator, Sequence
from dataclasses import dataclass
from typing import TypeAlias

import numpy as np
import numpy.typing as npt
import pandas as pd

from analysis.arrays import FloatArray
from analysis.stats.factors import swept
from analysis.stats.intervals import NO_VALUE, NO_VARIATION, varies
from analysis.stats.pairing import comparable_measures
from analysis.stats.values import SeedValues, seed_values
from analysis.tables.signature_table import SignatureTable

SEED, RESIDUAL = "seed", "residual"
CONFOUNDED = "cannot be separated from the other components"
NEGATIVE = "estimate below 0, shown as 0"
_RANK = 1e-9
"""An eigenvalue counts as 0 if it is smaller than _RANK times the largest eigenvalue."""
_AT_ONCE = 64
"""Number of measures whose variance is split into components at once; a small number saves memory."""
_DIGITS = 9
"""Number of digits of the variance that are written, so that every machine writes the same."""

Levels: TypeAlias = npt.NDArray[np.intp]


@dataclass(frozen=True)
class _Cells:
    """The K measures that are defined in the same N cells; a cell is one group with one seed.

    Attributes:
        measures: indices of the measures (K,).
        levels: for each component, the index of its level in each cell (N,), from 0 without gaps.
        values: centred values (N, K).
    """

    measures: npt.NDArray[np.intp]
    levels: dict[str, Levels]
    values: FloatArray


def variance_split(table: SignatureTable, groups: pd.DataFrame | None = None) -> pd.DataFrame:
    """Return the variance components of each measure, with one row per measure and component.

    Every swept setting and the seed have additive random effects. The residual contains chance and all interactions. A
    component is estimated from its sum of squares after all other components, set equal to its expectation (Henderson
    1953, method 3). If no cell is missing, this is the usual analysis of variance. Baselines are left out, and also
    measures that are not comparable between the worlds that have them.

    - variance: the component; NaN if it is unknown. note: the reason.
    - share: its part of the sum of all components; NaN if one of them is unknown.
    """
    values = seed_values(table, groups)
    values = values.of_measures(comparable_measures(values, ~values.baseline))
    names = [*(factor.name for factor in swept(values)), SEED, RESIDUAL]
    variance = np.full((len(values.measures), len(names)), np.nan)
    note = np.full(variance.shape, NO_VALUE, dtype=object)
    for cells in _by_pattern(values, names[:-1]):
        variance[cells.measures], note[cells.measures] = _components(cells)
    total = variance.sum(axis=1, keepdims=True)
    share = np.divide(variance, total, out=np.full(variance.shape, np.nan), where=total > 0)
    return pd.DataFrame(
        {
            "measure": np.repeat(np.array(values.measures, dtype=object), len(names)),
            "component": names * len(values.measures),
            "variance": variance.ravel(),
            "share": share.ravel().round(_DIGITS),
            "note": note.ravel(),
        }
    )


def _settled(variance: FloatArray) -> FloatArray:
    """Round the components (K, components), so that every machine writes the same table; -0.0 becomes 0.0."""
    total = np.nansum(np.abs(variance), axis=1, keepdims=True)
    places = _DIGITS - np.floor(np.log10(total, out=np.zeros_like(total), where=total > 0))
    scale = 10.0 ** np.abs(places)
    return np.asarray(
        np.where(places >= 0, np.round(variance * scale) / scale, np.round(variance / scale) * scale) + 0.0
    )


def _by_pattern(values: SeedValues, components: Sequence[str]) -> Iterator[_Cells]:
    own = ~values.baseline
    mine = values.values[own].reshape(-1, len(values.measures))
    groups = [group for group, mine in zip(values.groups, own, strict=True) for _ in values.seeds if mine]
    labels = {name: np.array([group[index] for group in groups]) for index, name in enumerate(values.columns)}
    labels[SEED] = np.tile(np.array(values.seeds), int(own.sum()))
    patterns, which = np.unique(~np.isnan(mine), axis=1, return_inverse=True)
    for index, pattern in enumerate(patterns.T):
        if pattern.any():
            levels = {name: np.unique(labels[name][pattern], return_inverse=True)[1] for name in components}
            alike = np.flatnonzero(which == index)
            for start in range(0, len(alike), _AT_ONCE):
                measures = alike[start : start + _AT_ONCE]
                rows_present = mine[:, measures][pattern]
                yield _Cells(measures, levels, rows_present - rows_present.mean(axis=0))


def _components(cells: _Cells) -> tuple[FloatArray, npt.NDArray[np.object_]]:
    """Return the variance of each component and of the residual, and their notes (K, components + 1)."""
    names = list(cells.levels)
    full = _Fit.of(cells, names)
    freedom = len(cells.values) - full.rank
    total = (cells.values**2).sum(axis=0)
    variance = np.full((len(cells.measures), len(names) + 1), np.nan)
    note = np.full(variance.shape, "", dtype=object)
    if freedom > 0:
        residual = np.maximum(total - full.explained, 0.0) / freedom
        variance[:, -1] = residual
        for index, name in enumerate(names):
            variance[:, index] = _component(cells, full, name, residual)
    variance = _settled(variance)
    note[np.isnan(variance)] = CONFOUNDED
    note[variance < 0] = NEGATIVE
    variance = np.where(variance < 0, 0.0, variance)
    flat = ~varies(cells.values.T)
    variance[flat] = np.where(np.isnan(variance[flat]), np.nan, 0.0)
    note[flat] = NO_VARIATION
    return variance, note


def _component(cells: _Cells, full: "_Fit", name: str, residual: FloatArray) -> FloatArray:
    """Return the estimated variance of one component (K,); NaN if the other components explain all its effects."""
    rest = _Fit.of(cells, [other for other in cells.levels if other != name])
    freedom = full.rank - rest.rank
    # E[SS] = sigma2_component * trace(Z' (P_full - P_rest) Z) + sigma2_residual * freedom, and P_full Z = Z
    trace = len(cells.values) - rest.explained_of(cells.levels[name])
    if freedom < 1 or trace < _RANK * len(cells.values):
        return np.full(len(residual), np.nan)
    return np.asarray((full.explained - rest.explained - freedom * residual) / trace)


@dataclass(frozen=True)
class _Fit:
    """A least-squares fit of values as a sum of effects, such as one of the model and one of the seed.

    The component with the most levels, such as the seed, is absorbed: its effects are the means of its levels, and the
    other components explain the deviations from these means. So no matrix grows with the square of its levels.

    Attributes:
        explained: sum of squares that the fit explains (K,).
        absorbed: levels of the absorbed component (N,).
        counts: number of cells of each absorbed level (L,).
        others: indicators of the other components' levels, minus their means within the absorbed levels (N, q).
        inverse: generalised inverse of the products of `others` (q, q).
    """

    rank: int
    explained: FloatArray
    absorbed: Levels
    counts: FloatArray
    others: FloatArray
    inverse: FloatArray

    @classmethod
    def of(cls, cells: _Cells, names: Sequence[str]) -> "_Fit":
        size = len(cells.values)
        absorbed, *others = [
            *sorted((cells.levels[name] for name in names), key=lambda levels: -int(levels.max())),
            np.zeros(size, dtype=np.intp),  # the constant
        ]
        counts = np.bincount(absorbed).astype(np.float64)
        design = np.hstack([np.zeros((size, 0)), *(np.eye(int(levels.max()) + 1)[levels] for levels in others)])
        design = design - (_sums(design, absorbed, len(counts)) / counts[:, None])[absorbed]
        weights, vectors = np.linalg.eigh(design.T @ design)
        is_estimable = weights > _RANK * size
        inverse = (vectors[:, is_estimable] / weights[is_estimable]) @ vectors[:, is_estimable].T
        moments = design.T @ cells.values
        explained = (_sums(cells.values, absorbed, len(counts)) ** 2 / counts[:, None]).sum(axis=0)
        explained += ((inverse @ moments) * moments).sum(axis=0)
        return cls(len(counts) + int(is_estimable.sum()), explained, absorbed, counts, design, inverse)

    def explained_of(self, levels: Levels) -> float:
        """Return trace(Z' P Z) for one component of the variance.

        Z (cells, levels) is 1 where a cell has a level of the component, else 0. P is the projection of this fit.
        """
        count = int(levels.max()) + 1
        cells = np.bincount(self.absorbed * count + levels, minlength=len(self.counts) * count)
        within = (cells.reshape(len(self.counts), count) ** 2 / self.counts[:, None]).sum()
        moments = _sums(self.others, levels, count).T
        return float(within + ((self.inverse @ moments) * moments).sum())


def _sums(values: FloatArray, levels: Levels, count: int) -> FloatArray:
    columns = [np.bincount(levels, weights=column, minlength=count) for column in values.T]
    return np.array(columns, dtype=np.float64).reshape(values.shape[1], count).T
