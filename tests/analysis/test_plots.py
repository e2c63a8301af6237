"""The plots: each by itself, and what holds of every figure of an analysis."""

import dataclasses
import math
import re
import struct
from collections.abc import Iterator
from types import SimpleNamespace
from xml.etree import ElementTree

import numpy as np
import pandas as pd
import pytest
from matplotlib.axes import Axes
from matplotlib.figure import Figure
from msgspec.structs import replace

from analysis import analyze, signatures
from analysis.figures import pictures
from analysis.figures.measures import dendrogram, scale_of
from analysis.figures.members import shown_groups
from analysis.figures.pictures import in_words, means_picture
from analysis.figures.shown import ShownGroup
from analysis.grid.grid_crop import crop
from analysis.grid.grid_figures import GridGroup, cascade_tree, not_warned, occupancy
from analysis.grid.grid_run import GridRun, GridSettings
from analysis.grid.plots import grid_plots
from analysis.grid.plots.grid_plots import SurvivalCurve, draw_cascade, draw_survival
from analysis.grid.plots.occupancy import OccupancyMap, draw_occupancy
from analysis.measuring.runs import Source, measure_run
from analysis.plots import FORMATS, Picture, draw, style
from analysis.plots.fingerprints import FingerprintMap, Merge, draw_dendrogram, draw_fingerprint
from analysis.plots.forest import Pair, draw_forest
from analysis.plots.panel import GroupValues, Scale, draw_panel
from analysis.plots.saving import styled
from analysis.prose import percent
from analysis.stats.contrasts import contrasts
from analysis.tables.comparison import Comparison, compare
from analysis.tables.signature_table import build_table
from foundry.palette import BASELINE, COLOURS
from walkers import WORLD, Habits, make_condition, write_sweep

NAN = float("nan")
DRAWN = ("hazard", "idle_rate")
"""The signatures of which every picture is drawn: all of them take long."""


@pytest.fixture(scope="module")
def plots(tmp_path_factory):
    world = {**WORLD, "steps": 12}
    path = tmp_path_factory.mktemp("plots") / "sweep"
    sweep = write_sweep(path, [make_condition("scripted/random", [0, 1], world=world)])
    with pytest.MonkeyPatch.context() as patch:
        every = Comparison.headlines.func
        patch.setattr(Comparison, "headlines", property(lambda one: {name: every(one)[name] for name in DRAWN}))
        return analyze([sweep.path], plots=True, columns=2).path / "plots"


def axes():
    return Figure().add_subplot()


def texts(ax) -> list[str]:
    return [text.get_text() for text in ax.texts]


def ticks(ax) -> list[str]:
    return [label.get_text() for label in ax.get_yticklabels()]


@pytest.mark.slow
def test_every_figure_is_there_in_all_formats_with_its_data_two_columns_wide_and_without_version(plots):
    expected = {*DRAWN, "occupancy", "survival", "course", "cascade", "paths"}
    for suffix in (".png", ".svg", ".pdf", ".csv"):
        assert {path.stem for path in plots.iterdir() if path.suffix == suffix} == expected
    means = pd.read_csv(plots / "idle_rate.csv")
    assert set(means) >= {"panel", "label", "mean", "low", "high", "seeds", "values"} and set(means["seeds"]) == {0, 1}
    assert set(pd.read_csv(plots / "occupancy.csv")) == {"group", "row", "column", "share"}
    for path in plots.glob("*.png"):
        content = path.read_bytes()
        assert content.startswith(b"\x89PNG")
        assert struct.unpack(">I", content[16:20])[0] == 2100
        assert b"Software" not in content
        assert b"Date" not in content
    for path in plots.glob("*.svg"):
        content = path.read_text(encoding="utf-8")
        assert ElementTree.fromstring(content).tag.endswith("svg")
        assert set(re.findall(r"https?://[^\"]*", content)) <= {
            "http://www.w3.org/2000/svg",
            "http://www.w3.org/1999/xlink",
        }
        assert "scripted/random" in content
        ids = re.findall(r' id="([^"]*)"', content)
        assert len(ids) == len(set(ids))
        assert set(re.findall(r'(?:url\(|href=")#([^)"]*)', content)) == set(ids)
    sizes = {
        float(size) for path in plots.glob("*.svg") for size in re.findall(r"font-size: ?([\d.]+)px", path.read_text())
    }
    assert sizes and min(sizes) >= 7


@pytest.mark.slow
def test_tables_and_pictures_are_the_same_byte_for_byte_when_repeated(plots, recorded):
    before = {path: path.read_bytes() for path in plots.parent.iterdir() if path.is_file() and path.suffix != ".sqlite"}
    assert set(analyze([plots.parents[1]]).written) == set(before)
    assert {path.suffix for path in before} == {".bib", ".csv", ".json", ".md", ".parquet", ".tex"}
    assert before == {path: path.read_bytes() for path in before}
    world = recorded().run.world
    shares = {"日本語 $x": np.eye(11) / 11, "b": np.eye(11) / 22}
    maps = [OccupancyMap(ShownGroup((name,), 0, False), world, share) for name, share in shares.items()]
    picture = Picture("name", "t", "c", lambda: grid_plots.occupancy_figure(maps))
    assert draw(picture, *FORMATS) == draw(picture, *FORMATS)


SIGNATURES = ("hazard", "idle_rate", "movement", "place_choice", "stability", "warning")
"""Few of all signatures, with and without nulls and bounds: drawing all takes long."""


@pytest.fixture(scope="module")
def compared(tmp_path_factory) -> tuple[Comparison, pd.DataFrame]:
    """The groups of two models, whose runs cost nothing, and a baseline, and their differences."""
    path = tmp_path_factory.mktemp("figures")
    models, stay = ([make_condition(name, range(3)) for name in names] for names in (("a", "b"), ("scripted/stay",)))
    sweeps = ((write_sweep(path / "s", models), False), (write_sweep(path / "b", stay), True))
    results = [measure_run(run, Source(sweep, "s", which)) for sweep, which in sweeps for run in sweep.runs()]
    table = build_table(results)
    return compare(table), contrasts(table)


def panels(compared: Comparison) -> Iterator[tuple[str, Scale, Axes]]:
    """Yield the panels of means, with their measure and what its values are seen against."""
    shown = shown_groups(compared)
    for signature in SIGNATURES:
        axes_of_all = drawn(means_picture(compared, shown, signature))
        for measure, ax in zip(compared.headlines[signature], axes_of_all, strict=True):
            yield measure, scale_of(compared, measure), ax


def drawn(picture: Picture) -> list[Axes]:
    with styled():
        return list(picture.draw().axes)


def upright(ax: Axes) -> set[float]:
    """Return where lines go from the bottom to the top of a panel."""
    lines = [np.asarray(line.get_xdata(), dtype=float) for line in ax.lines]
    return {float(line[0]) for line in lines if len(line) == 2 and line[0] == line[1]}


def within(limits: tuple[float, float], ticks: np.ndarray, scale: Scale) -> bool:
    """Return whether a scale stays where values can be, but for the room that marks at its ends take."""
    (low, high), room = limits, 0.08 * (limits[1] - limits[0])
    return (
        low >= scale.low - room and high <= scale.high + room and all(scale.low <= tick <= scale.high for tick in ticks)
    )


@pytest.mark.slow
def test_in_every_panel_chance_is_a_line_and_no_scale_begins_or_has_a_tick_where_no_value_can_be(compared):
    of_form = {
        signature.name for signature in signatures.discover() if signature.part(GridRun) and not signature.is_label
    }
    without = {"persona_effect", "utility", "evacuation", "survival", "certainty"}  # these runs have nothing of them
    assert set(compared[0].headlines) == of_form - without
    every = list(panels(compared[0]))
    with_null = [(measure, scale.null, ax) for measure, scale, ax in every if not math.isnan(scale.null)]
    assert {signatures.describe(measure).null is not None for measure, _, _ in with_null} == {True}
    assert len({measure for measure, _, _ in with_null}) > 5
    assert {measure for measure, null, ax in with_null if null not in upright(ax)} == set()
    unseen = {measure for measure, null, ax in with_null if not ax.get_xlim()[0] < null < ax.get_xlim()[1]}
    assert unseen == set()
    wrong = {measure for measure, scale, ax in every if not within(ax.get_xlim(), ax.get_xticks(), scale)}
    assert wrong == set()
    shown = shown_groups(compared[0])
    forests = [pictures.forest_picture(compared[1], compared[0], shown, signature) for signature in SIGNATURES]
    tested = [ax for picture in forests for ax in drawn(picture) if len(ax.get_xticks())]
    assert len(tested) > 10
    assert all(0.0 in upright(ax) for ax in tested)


def test_a_panel_shows_groups_with_their_seeds_baselines_in_grey_and_that_there_is_no_value():
    values = np.array([0.1, 0.2, NAN])
    groups = GroupValues("first", values, 0.15, 0.1, 0.2), GroupValues("second", values, 0.15, NAN, NAN)
    ax = draw_panel(axes(), groups, "What is measured")
    assert ticks(ax) == ["first", "second"]
    assert ax.get_yticks().tolist() == [0, -1]
    assert texts(ax) == ["n=2", "n=2"]
    low, high = ax.get_xlim()
    assert low < 0.1 < 0.2 < high
    ax = draw_panel(axes(), [GroupValues("a", np.array([NAN]), NAN, NAN, NAN)], "t")
    assert texts(ax) == ["undefined", "n=0"]
    assert ax.get_xticks().tolist() == []
    group = GroupValues("a", np.array([1.0]), 1.0, NAN, NAN, index=2, baseline=True)
    ax = draw_panel(axes(), [group], "t")
    assert ax.get_yticklabels()[0].get_color() == BASELINE
    assert (ax.lines[0].get_color(), ax.lines[0].get_marker()) == (BASELINE, "o")


def test_models_look_apart_and_each_the_same_in_every_world_and_part_with_lines_broken_otherwise():
    assert len({style.marker(index) for index in range(12)} | {style.marker(0, baseline=True)}) == 13
    looks = {(style.colour(index), style.marker(index)) for index in range(20)}
    assert len(looks) == 20
    groups = [("b", "y"), ("a", "x"), ("b", "x"), ("stay", "x")]
    shown = shown_of(groups, ("model", "world"), ("b", "a"), baselines=groups[3:])
    assert [group.group for group in shown.values()] == [("b", "y"), ("b", "x"), ("a", "x"), ("stay", "x")]
    group, other, third = (style.line(shown[group].index) for group in (("b", "y"), ("b", "x"), ("a", "x")))
    assert (group["color"], group["marker"]) == (other["color"], other["marker"]) != (third["color"], third["marker"])
    assert group["linestyle"] != other["linestyle"]
    assert [group.index for group in shown_of([("b",)], ("model",), ("a", "b")).values()] == [1]
    prompts = [("a", "x"), ("a", "y")]
    assert [group.index for group in shown_of(prompts, ("model", "prompt"), ("a",)).values()] == [0, 1]


def shown_of(groups, columns, models, baselines=()) -> dict[tuple[str, ...], ShownGroup]:
    compared = SimpleNamespace(groups=groups, group_columns=columns, baselines=frozenset(baselines), models=models)
    return {shown_group.group: shown_group for shown_group in shown_groups(compared)}


def test_chance_and_the_best_are_marked_where_they_are_known_and_said_to_those_who_do_not_see_it():
    group = GroupValues("a", np.array([0.2, 0.4]), 0.3, NAN, NAN)
    ax = draw_panel(axes(), [group], "t", Scale(null=0.0, best=0.9))
    marks = {line.get_xdata()[0]: line.get_linestyle() for line in ax.lines if len(line.get_xdata()) == 2}
    assert marks == {0.0: "--", 0.9: ":"}
    low, high = ax.get_xlim()
    assert low < 0 < 0.9 < high
    groups = [GroupValues(name, np.array([0.1, 0.2]), 0.15, 0.1, 0.2) for name in ("one", "two")]
    assert in_words(groups, Scale(null=0.5)) == "one 0.15 [0.1, 0.2], two 0.15 [0.1, 0.2], chance alone 0.5."


def test_a_forest_fills_and_stars_what_stands_and_greys_what_was_not_tested():
    pairs = [
        Pair("b - a", 0.5, 0.4, 0.6, 9, significant=True, equivalent=False, tested=True),
        Pair("c - a", 0.0, -0.1, 0.1, 9, significant=False, equivalent=True, tested=True),
        Pair("c - b", 0.1, NAN, NAN, 1, significant=False, equivalent=False, tested=False),
        Pair("d - b", NAN, NAN, NAN, 0, significant=False, equivalent=False, tested=False),
    ]
    ax = draw_forest(axes(), pairs, "t")
    assert ticks(ax) == ["b - a", "c - a", "c - b", "d - b"]
    assert texts(ax) == ["n=9 *", "n=9 ~", "n=1", "n=0", "undefined"]
    dots = [line for line in ax.lines if line.get_marker() == "o"]
    assert [dot.get_markerfacecolor() for dot in dots] == [COLOURS[0], "white", "white"]
    assert dots[2].get_color() == BASELINE
    ax = draw_forest(axes(), [Pair("b - a", NAN, NAN, NAN, 0, significant=False, equivalent=False, tested=True)], "t")
    assert ax.get_xticks().tolist() == []


def test_a_fingerprint_dashes_what_is_undefined():
    fingerprint_map = FingerprintMap(("a", "b"), ("m", "n"), np.array([[1.0, -1.0], [NAN, 0.0]]), ())
    ax = axes()
    image = draw_fingerprint(ax, fingerprint_map)
    assert texts(ax) == ["–"]
    assert ticks(ax) == ["m", "n"]
    assert image.get_clim() == (-2.5, 2.5)


def test_a_dendrogram_joins_branches_where_they_end():
    linkage = np.array([[0, 2, 1.0, 2], [1, 3, 2.0, 3]])
    order, merges = dendrogram(linkage, np.array([0.9, 0.5]), 3)
    assert order == [1, 0, 2]
    assert merges == [Merge(1, 2, 0, 0, 1.0, 0.9), Merge(0, 1.5, 0, 1.0, 2.0, 0.5)]
    ax = draw_dendrogram(axes(), merges, 3)
    assert texts(ax) == ["90", "50"]
    assert dendrogram(None, np.zeros(0), 1) == ([0], [])


def test_occupancy_counts_every_state_but_the_start_on_one_scale(recorded):
    run = recorded().run
    share = occupancy(run)
    assert math.isclose(share.sum(), 1.0)
    cell = (run.y == run.y[-1, 0]) & (run.x == run.x[-1, 0])
    assert math.isclose(share[run.y[-1, 0] + 5, run.x[-1, 0] + 5], cell[1:].sum() / run.decisions)
    world = GridSettings(name="w", half_size=1, agents=1, steps=1, communication_distance=1)
    shares = {"a": 0.1, "b": 0.3}
    maps = [
        OccupancyMap(ShownGroup((name,), 0, False), world, np.full((3, 3), share)) for name, share in shares.items()
    ]
    images = [draw_occupancy(axes(), shown_map, 0.3) for shown_map in maps]
    assert {image.get_clim() for image in images} == {(0, 0.3)}
    assert images[0].get_extent() == [-1.5, 1.5, -1.5, 1.5]


def test_survival_falls_from_one_and_its_curve_names_its_runs(recorded):
    runs = [recorded(seed).run for seed in range(3)]
    curve = not_warned(runs[0])
    assert curve[0] == 1.0
    assert len(curve) == runs[0].steps + 1
    assert (np.diff(curve) <= 0).all()
    group = GridGroup(ShownGroup(("a",), 0, False), seed=0, world=runs[0].world)
    for seed, run in enumerate(runs):
        group.add(run, seed)
    found = group.survival_curve()
    assert found.runs == 3
    np.testing.assert_allclose(found.remaining, np.mean([not_warned(run) for run in runs], axis=0))
    flat = np.ones(3)
    ax = draw_survival(axes(), [SurvivalCurve(ShownGroup(("a",), 0, False), flat, flat * NAN, flat * NAN, 1)], "Left")
    assert [text.get_text() for text in ax.get_legend().get_texts()] == ["a (n=1)"]


def test_a_cascade_shows_who_told_whom_and_who_saw_it(recorded):
    tree = cascade_tree(recorded().run, ShownGroup(("a",), 0, False))
    assert tree.edges
    for edge in tree.edges:
        assert tree.since[edge.recipient] == edge.step >= tree.since[edge.sender]
        assert tree.rows.index(edge.sender) < tree.rows.index(edge.recipient)
    ax = draw_cascade(axes(), tree)
    assert ticks(ax) == [str(agent) for agent in tree.rows]
    assert f"{tree.informed} of {tree.agents} agents" in ax.get_title(loc="left") + ax.get_title()
    run = recorded(seed=1, habits=Habits(speak=0.1, texts=("fire!",))).run
    tree = cascade_tree(run, ShownGroup(("a",), 0, False))
    assert tree.unfounded, "who warns without a ground stands apart"
    assert {edge.sender for edge in tree.edges} <= set(tree.rows)
    draw_cascade(axes(), tree)


def test_a_crop_shows_an_agent_among_those_around_it_and_escapes_names(recorded):
    run = recorded().run
    world = replace(run.world, places=tuple(replace(place, name="<b>") for place in run.world.places))
    drawn = ElementTree.fromstring(crop(dataclasses.replace(run, world=world), 1, 0))
    names = [text.text for text in drawn.iter("text")]
    assert names[-1] == "0" and "<b>" in names
    near = int(re.findall(r", (\d+) others", drawn.get("aria-label"))[0])
    assert len(names) == 1 + len(world.places) + near, "no fire burns yet"


def test_names_in_any_script_can_be_drawn_and_many_measures_by_their_first_ones_which_is_said(monkeypatch, make_sweep):
    places = [{**WORLD["places"][0], "name": "図書館 $x_1"}]
    sweep = make_sweep([make_condition("a", [0], world={**WORLD, "places": places})])
    measures = compare(build_table([measure_run(sweep.runs()[0], Source(sweep, "s"))]))
    picture = means_picture(measures, shown_groups(measures), "place_choice")
    assert "図書館 $x_1" in draw(picture, *FORMATS).svg and "comparison.md" not in picture.caption
    monkeypatch.setattr(pictures, "MOST_PANELS", 2)
    few = means_picture(measures, shown_groups(measures), "outcome")
    with styled():
        assert len(few.draw().axes) == 2
    assert re.search(r"2 of \d measures are shown; all are in comparison.md", few.caption)


def test_no_small_share_looks_like_nought():
    assert [percent(share) for share in (0.0, 1e-6, 0.0123, 1.0)] == ["0 %", "<0.1 %", "1.23 %", "100 %"]
