"""What holds of every figure of an analysis: its null is drawn, and its scale begins where values can be."""

from __future__ import annotations

import math
from collections.abc import Iterator, Sequence
from typing import Any, TypeAlias

import numpy as np
import pytest
from matplotlib.axes import Axes

from analysis import analyze
from analysis.figures import pictures
from analysis.figures.measures import scale_of
from analysis.pipeline import Analysis
from analysis.plots import Picture
from analysis.plots.panel import Scale
from analysis.plots.rounds import Curve, curves_figure
from analysis.plots.saving import styled
from analysis.signatures import describe

pytestmark = pytest.mark.slow
Panel: TypeAlias = tuple[str, Scale, Axes]


@pytest.fixture(scope="module")
def analysed(tmp_path_factory: pytest.TempPathFactory, write_sweep: Any, make_condition: Any) -> Analysis:
    path = tmp_path_factory.mktemp("figures") / "sweep"
    folder = write_sweep(path, [make_condition(model, range(3)) for model in ("first", "second")])
    write_sweep(folder.baselines_dir, [make_condition("scripted/stay", range(3))])
    return analyze([path], plots=False)


def drawn(picture: Picture | None) -> list[Axes]:
    assert picture is not None
    with styled():
        return list(picture.draw().axes)


@pytest.fixture(scope="module")
def panels(analysed: Analysis) -> list[Panel]:
    """Every panel of values of every figure, with its measure and what the values are seen against."""
    return list(values_of(analysed))


@pytest.fixture(scope="module")
def differences(analysed: Analysis) -> list[Axes]:
    """Every panel of differences of every figure."""
    return list(differences_of(analysed))


def values_of(found: Analysis) -> Iterator[tuple[str, Scale, Axes]]:
    for signature, measures in pictures.headlines(found.compared).items():
        for picture in (
            pictures.means_picture(found.compared, found.shown, signature),
            pictures.slopes_picture(found.compared, found.shown, signature),
        ):
            yield from zip(measures, (scale_of(found.compared, one) for one in measures), drawn(picture), strict=True)


def differences_of(found: Analysis) -> Iterator[Axes]:
    for signature in pictures.headlines(found.compared):
        yield from drawn(pictures.forest_picture(found.contrasts, found.compared, found.shown, signature))


def upright(ax: Axes) -> set[float]:
    """Return where lines go from the bottom to the top of a panel."""
    lines = [np.asarray(line.get_xdata(), dtype=float) for line in ax.lines]
    return {float(line[0]) for line in lines if len(line) == 2 and line[0] == line[1]}


def test_what_chance_gives_is_a_line_in_every_panel_that_has_a_null(panels: list[Panel]):
    found = [(measure, scale.null, ax) for measure, scale, ax in panels if not math.isnan(scale.null)]
    assert {describe(measure).null is not None for measure, _, _ in found} == {True}
    assert len({measure for measure, _, _ in found}) > 5
    missing = {measure for measure, null, ax in found if null not in upright(ax)}
    assert missing == set()
    unseen = {measure for measure, null, ax in found if not ax.get_xlim()[0] < null < ax.get_xlim()[1]}
    assert unseen == set()


@pytest.mark.slow
def test_no_difference_is_a_line_in_every_panel_of_differences(differences: list[Axes]):
    tested = [ax for ax in differences if len(ax.get_xticks())]
    assert len(tested) > 10
    assert all(0.0 in upright(ax) for ax in tested)


def test_no_scale_begins_or_has_a_tick_where_no_value_can_be(panels: list[Panel]):
    wrong = {measure for measure, scale, ax in panels if not within(ax.get_xlim(), ax.get_xticks(), scale)}
    assert wrong == set()


def test_equal_values_have_one_tick_and_no_invented_scale(panels: list[Panel], differences: list[Axes]):
    every = [*(ax for _, _, ax in panels), *differences]
    flat = [ax for ax in every if len(shown(ax)) == 1]
    assert len(flat) > 5
    assert {len(ax.get_xticks()) for ax in flat} == {1}


def test_lines_by_round_begin_where_values_can_be():
    nothing = np.zeros(5)
    with styled():
        none, some = curves_figure(
            [
                ("flat", [Curve("a", nothing, nothing, nothing, 3)]),
                ("not", [Curve("a", nothing + 0.5, nothing, nothing + 1, 3)]),
            ],
            Scale(0.0, 1.0),
        ).axes
    assert none.get_yticks().tolist() == [0]
    assert all(within(ax.get_ylim(), ax.get_yticks(), Scale(0.0, 1.0)) for ax in (none, some))


def within(limits: tuple[float, float], ticks: Sequence[float], scale: Scale) -> bool:
    """Return whether a scale stays where values can be, but for the room that marks at its ends take."""
    low, high = limits
    room = 0.08 * (high - low)
    return (
        low >= scale.low - room and high <= scale.high + room and all(scale.low <= tick <= scale.high for tick in ticks)
    )


def shown(ax: Axes) -> set[float]:
    """Return the values of a panel: of dots, marks and lines."""
    lines = [value for line in ax.lines for value in np.asarray(line.get_xdata(), dtype=float)]
    dots = [float(place[0]) for dots in ax.collections for place in np.asarray(dots.get_offsets(), dtype=float)]
    return {round(float(value), 9) for value in (*lines, *dots) if math.isfinite(value)}
