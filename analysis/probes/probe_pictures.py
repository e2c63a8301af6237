"""Plots of a probe: distances between models, effects of edits and formats, and curves over a quantity."""

from collections.abc import Iterator, Mapping, Sequence

import pandas as pd

from analysis.plots import Picture
from analysis.plots.panel import Scale
from analysis.plots.rounds import Curve
from analysis.probes.differences import EDIT, FORMAT
from analysis.stats.factors import MODEL

MOST_PANELS = 12
"""Maximum number of panels of a plot; it shows the choices or edits with the largest effects."""
_FORESTS = {
    MODEL: ("agreement", "Distances between models"),
    EDIT: ("edits", "Effects of the edits"),
    FORMAT: ("formats", "Effects of the prompt's format"),
}
_FOREST = (
    "Distance between the choices in the same moments, minus its floor, with 90 % intervals over seeds. A filled "
    "mark with a star is significant after Holm's correction. n is the number of seeds."
)


def pictures_of(frames: Mapping[str, pd.DataFrame], contrasts: pd.DataFrame) -> Iterator[Picture]:
    """Yield a plot for each table that has rows."""
    for factor, (name, title) in _FORESTS.items():
        rows = contrasts[contrasts["factor"] == factor]
        by_measure = {"distance": rows} if factor == MODEL else {str(of): own for of, own in rows.groupby("measure")}
        widest = sorted(by_measure, key=lambda of: -by_measure[of]["difference"].fillna(0).max())
        if len(rows):
            yield _forest(name, title, {of: by_measure[of] for of in widest[:MOST_PANELS]})
    for quantity, rows in frames["curves"].groupby("quantity", sort=False):
        yield _curves(str(quantity), rows, list(dict.fromkeys(frames["moments"]["model"])))


def _forest(name: str, title: str, panels: Mapping[str, pd.DataFrame]) -> Picture:
    from analysis.figures.measures import pairs_of
    from analysis.plots.figures import forest_figure

    contents = [(of, pairs_of(rows.assign(measure=of), of, {})) for of, rows in panels.items()]
    return Picture(name, title, _FOREST, lambda: forest_figure(contents, {}), data=contents)


def _curves(quantity: str, rows: pd.DataFrame, models: Sequence[str]) -> Picture:
    from analysis.plots.rounds import curves_figure

    index = {model: place for place, model in enumerate(models)}
    by_choice = {of: mine for of, mine in rows.groupby(["kind", "choice"], sort=False)}
    varied = sorted(by_choice, key=lambda of: -by_choice[of].groupby("model")["share"].agg("std").fillna(0).max())
    shown = set(varied[:MOST_PANELS])
    panels = [
        (
            f"{kind}: {choice}",
            [_curve(str(model), points, index[str(model)]) for model, points in mine.groupby("model", sort=False)],
        )
        for (kind, choice), mine in by_choice.items()
        if (kind, choice) in shown
    ]
    caption = f"Share of each choice if only {quantity} changes, with 95 % intervals over seeds (n of them)."
    name = "curves_" + quantity.replace(".", "_").replace("-", "last")
    title, scale = f"Choices by {quantity}", Scale(0.0, 1.0)
    return Picture(name, title, caption, lambda: curves_figure(panels, scale, quantity), data=panels)


def _curve(model: str, rows: pd.DataFrame, index: int) -> Curve:
    ordered = rows.sort_values("value")
    mean, low, high, at = (ordered[name].to_numpy(dtype=float) for name in ("share", "low", "high", "value"))
    return Curve(model, mean, low, high, int(ordered["seeds"].max()), index, at=at)
