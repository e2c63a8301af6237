"""Computes one value per group, seed and measure from the table of runs."""

from collections.abc import Mapping, Sequence
from dataclasses import dataclass, field, replace
from typing import TypeAlias

import numpy as np
import numpy.typing as npt
import pandas as pd

from analysis.arrays import FloatArray
from analysis.lines import COMPLETE
from analysis.measuring.runs import Questions
from analysis.signatures import FAILURE_RATE
from analysis.tables.groups import group_keys, swept_columns
from analysis.tables.signature_table import SignatureTable

BASELINE = "baseline"
"""The column that marks the runs of scripted models for comparison; a table may lack it."""

BoolArray: TypeAlias = npt.NDArray[np.bool_]
Group: TypeAlias = tuple[str, ...]
"""A group of runs, given by its values in the columns that define groups, such as its model and prompt."""


@dataclass(frozen=True)
class SeedValues:
    """The values of G groups, S seeds and M measures.

    Attributes:
        groups: values of `columns` in each group, in the order of the first runs (G).
        values: mean over the runs of a group and seed, such as repeats with other sampling seeds (G, S, M); NaN where
            a run is missing or the measure is undefined.
        asked: whether the group has a run of the seed, with any status (G, S).
        complete: whether the group has a complete run of the seed (G, S).
        present: whether the runs of a group have the measure, even if it is undefined (G, M).
        baseline: which groups are baselines (G).
        runs: number of runs with any status (G).
        questions: the decisions for which the world of each group asks (G); empty if unknown.
        copies: values of the measures that are computed on copies with drawn labels, (G, S, COPIES) each, by the index
            of the measure.
    """

    columns: tuple[str, ...]
    groups: tuple[Group, ...]
    seeds: tuple[int, ...]
    measures: tuple[str, ...]
    values: FloatArray
    asked: BoolArray
    complete: BoolArray
    present: BoolArray
    baseline: BoolArray
    runs: npt.NDArray[np.int64]
    questions: tuple[Questions, ...] = ()
    copies: Mapping[int, FloatArray] = field(default_factory=dict)

    def of_measures(self, chosen: BoolArray) -> "SeedValues":
        """Return the values of only the given measures (M,)."""
        names = tuple(name for name, is_chosen in zip(self.measures, chosen, strict=True) if is_chosen)
        place = np.cumsum(chosen) - 1
        copies = {int(place[measure]): values for measure, values in self.copies.items() if chosen[measure]}
        values, present = self.values[:, :, chosen], self.present[:, chosen]
        return replace(self, measures=names, values=values, present=present, copies=copies)


def seed_values(table: SignatureTable, groups: pd.DataFrame | None = None) -> SeedValues:
    """Return one value per group, seed and measure; by default, the swept settings define groups."""
    groups = swept_columns(table) if groups is None else groups
    keys: list[Group] = group_keys(groups)
    names = {group: index for index, group in enumerate(dict.fromkeys(keys))}
    group = np.array([names[key] for key in keys], dtype=np.int64)
    seeds, seed = np.unique(table.frame["seed"].to_numpy(), return_inverse=True)
    shape, cell = (len(names), len(seeds)), group * len(seeds) + seed
    runs = np.bincount(group, minlength=len(names))
    return SeedValues(
        columns=tuple(map(str, groups.columns)),
        groups=tuple(names),
        seeds=tuple(int(seed) for seed in seeds),
        measures=table.measures,
        values=_cell_means(table.frame[list(table.measures)].to_numpy(dtype=np.float64), cell, shape),
        asked=_any(group, seed, shape, np.ones(len(keys), dtype=bool)),
        complete=_any(group, seed, shape, (table.frame["status"] == COMPLETE).to_numpy(dtype=bool)),
        present=np.array([_present(table, group == index) for index in range(len(names))]),
        baseline=np.bincount(group[is_baseline(table.frame)], minlength=len(names)) == runs,
        runs=runs,
        questions=tuple(dict(zip(keys, table.questions, strict=False)).values()),
        copies={table.measures.index(name): _cell_means(values, cell, shape) for name, values in table.copies.items()},
    )


def is_baseline(frame: pd.DataFrame) -> BoolArray:
    """Return which runs belong to a baseline (runs,)."""
    if BASELINE not in frame.columns:
        return np.zeros(len(frame), dtype=bool)
    return frame[BASELINE].to_numpy(dtype=bool)


def _any(
    group: npt.NDArray[np.int64], seed: npt.NDArray[np.int64], shape: tuple[int, int], chosen: BoolArray
) -> BoolArray:
    is_any = np.zeros(shape, dtype=bool)
    is_any[group[chosen], seed[chosen]] = True
    return is_any


def _cell_means(values: FloatArray, cell: npt.NDArray[np.int64], shape: tuple[int, int]) -> FloatArray:
    """Return the mean of the defined values (N, C) in each cell of group and seed (G, S, C)."""
    cell_means = np.full((shape[0] * shape[1], values.shape[1]), np.nan)
    if len(set(cell.tolist())) == len(cell):
        cell_means[cell] = values
    else:
        means = pd.DataFrame(values).groupby(cell).mean()
        cell_means[means.index.to_numpy()] = means.to_numpy()
    return cell_means.reshape(*shape, values.shape[1])


def _present(table: SignatureTable, chosen: BoolArray) -> BoolArray:
    """Return which measures any of the chosen runs has (M,); all of them if no chosen run is complete."""
    names_present = {name for names, mine in zip(table.present, chosen, strict=True) if mine for name in names}
    if names_present <= {FAILURE_RATE}:
        return np.ones(len(table.measures), dtype=bool)
    return np.array([name in names_present for name in table.measures], dtype=bool)


def select(names: Sequence[str], chosen: Sequence[str]) -> BoolArray:
    """Return a mask of the names: True for those that are chosen."""
    return np.isin(np.array(names, dtype=object), np.array(chosen, dtype=object))
