"""Plots of a probe: how far models are apart, what edits change, how choices follow a quantity."""

from __future__ import annotations

from collections.abc import Callable, Iterator, Mapping, Sequence

import pandas as pd

from analysis.plots import Picture
from analysis.plots.forest import Pair
from analysis.plots.panel import Scale
from analysis.plots.rounds import Curve
from analysis.probes.comparing import ALL
from analysis.stats.contrasts import ALPHA

MOST_PANELS = 12
"""Choices whose curves are drawn: those that vary most."""


def pictures_of(frames: Mapping[str, pd.DataFrame]) -> Iterator[Picture]:
    """Yield the plots of what there is."""
    if len(frames["agreement"]):
        yield _matrix(frames["agreement_matrix"], frames["agreement"])
    agreement, edits = (frames[name][frames[name]["kind"] == ALL] for name in ("agreement", "edits"))
    if len(agreement):
        yield _forest("agreement", "How far models are apart", {"total variation above chance": agreement}, _two)
    if len(edits):
        panels = {f"{edit} ({rows['leaves'].iloc[0]})": rows for edit, rows in edits.groupby("edit", sort=False)}
        yield _forest("edits", "What each edit changes", panels, _one)
    if len(frames["formats"]):
        yield _spreads(frames["formats"])
    for quantity, rows in frames["curves"].groupby("quantity", sort=False):
        yield _curves(str(quantity), rows, list(dict.fromkeys(frames["moments"]["model"])))


def _matrix(matrix: pd.DataFrame, agreement: pd.DataFrame) -> Picture:
    from analysis.plots.figures import matrix_figure
    from analysis.plots.matrix import Estimated

    names = list(dict.fromkeys([*matrix["first"], *matrix["second"]]))
    place = {name: number for number, name in enumerate(names)}
    cells = {
        (place[row["first"]], place[row["second"]]): Estimated(row["kappa"], row["low"], row["high"])
        for _, row in matrix.iterrows()
    }
    cells |= {
        (place[row["second"]], place[row["first"]]): Estimated(row["excess"], row["excess_low"], row["excess_high"])
        for _, row in agreement[agreement["kind"] == ALL].iterrows()
    }
    caption = (
        "Above the diagonal (blue) the agreement of two models beyond chance, kappa; on it that of each with itself "
        "over its repeats, with 95 % intervals over seeds; below it (orange) their total variation less its floor, "
        "with 90 % intervals."
    )
    return Picture("agreement_matrix", "Who agrees with whom", caption, lambda: matrix_figure(names, cells))


def _spreads(formats: pd.DataFrame) -> Picture:
    by_choice = {of: rows for of, rows in formats.groupby(["kind", "choice"], sort=False)}
    widest = sorted(by_choice, key=lambda of: -by_choice[of]["excess"].fillna(0).max())[:MOST_PANELS]
    panels = {f"{kind}: {choice}": by_choice[kind, choice] for kind, choice in widest}
    caption = (
        "How far the share of a choice spreads over formats of the prompt, less what dealing the answers out anew "
        "would give; 90 % intervals over seeds; filled with a star where it stands after Holm's correction; n seeds."
    )
    return _forest("formats", "What the format of the prompt changes", panels, _one, caption)


def _two(row: pd.Series) -> str:
    return f"{row['first']} - {row['second']}"


def _one(row: pd.Series) -> str:
    return str(row["model"])


_APART = (
    "Total variation of choices in the same moments less its floor, with 90 % intervals over seeds; filled with a star "
    "where it stands after Holm's correction; n is the number of seeds."
)


def _forest(
    name: str,
    title: str,
    panels: Mapping[str, pd.DataFrame],
    label: Callable[[pd.Series], str],
    caption: str = _APART,
) -> Picture:
    from analysis.plots.figures import forest_figure

    contents = [(of, [_pair(row, label) for _, row in rows.iterrows()]) for of, rows in panels.items()]
    return Picture(name, title, caption, lambda: forest_figure(contents, {}))


def _pair(row: pd.Series, label: Callable[[pd.Series], str]) -> Pair:
    return Pair(
        label=label(row),
        difference=row["excess"],
        low=row["excess_low"],
        high=row["excess_high"],
        pairs=int(row["seeds"]),
        significant=bool(row["p_holm"] <= ALPHA),
        equivalent=False,
        tested=True,
    )


def _curves(quantity: str, rows: pd.DataFrame, models: Sequence[str]) -> Picture:
    from analysis.plots.rounds import curves_figure

    index = {model: place for place, model in enumerate(models)}
    by_choice = {of: mine for of, mine in rows.groupby(["kind", "choice"], sort=False)}
    varied = sorted(by_choice, key=lambda of: -by_choice[of].groupby("model")["share"].agg("std").fillna(0).max())
    shown = set(varied[:MOST_PANELS])
    panels = [
        (
            f"{kind}: {choice}",
            [_curve(str(model), one, index[str(model)]) for model, one in mine.groupby("model", sort=False)],
        )
        for (kind, choice), mine in by_choice.items()
        if (kind, choice) in shown
    ]
    caption = f"Share of each choice where {quantity} alone is moved, with 95 % intervals over seeds (n of them)."
    name = "curves_" + quantity.replace(".", "_").replace("-", "last")
    return Picture(name, f"Choices by {quantity}", caption, lambda: curves_figure(panels, Scale(0.0, 1.0), quantity))


def _curve(model: str, rows: pd.DataFrame, index: int) -> Curve:
    ordered = rows.sort_values("value")
    mean, low, high, at = (ordered[name].to_numpy(dtype=float) for name in ("share", "low", "high", "value"))
    return Curve(model, mean, low, high, int(ordered["seeds"].max()), index, at=at)
