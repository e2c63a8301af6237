"""The plots."""

from __future__ import annotations

import struct

import matplotlib
import numpy as np
import pytest
from matplotlib.figure import Figure

from analysis import analyze, signatures
from analysis.plots import style
from analysis.plots.panel import GroupValues, draw_panel, jitter, panel_height, wrapped
from analysis.run import GridRun

NAN = float("nan")


@pytest.fixture(scope="module")
def plots(tmp_path_factory, write_sweep, make_condition):
    models = ["scripted/random", "hf.co/bartowski/Some-Very-Long-Model-Name-Instruct-2507-GGUF:q4_K_M"]
    path = tmp_path_factory.mktemp("plots") / "sweep"
    return analyze([write_sweep(path, [make_condition(model, [0, 1]) for model in models]).path]).path / "plots"


def test_there_is_a_plot_for_every_signature(plots):
    assert {path.stem for path in plots.iterdir()} == {
        one.name for one in signatures.discover() if GridRun in one.functions
    }


def test_an_analysis_is_the_same_byte_for_byte_when_repeated(plots):
    before = {path: path.read_bytes() for path in plots.parent.rglob("*.*")}
    assert set(analyze([plots.parents[1]]).written) == set(before)
    assert {path.suffix for path in before} == {".csv", ".parquet", ".png"}
    assert before == {path: path.read_bytes() for path in before}


def test_plots_are_one_column_wide_and_carry_no_version(plots):
    for path in plots.iterdir():
        content = path.read_bytes()
        assert content.startswith(b"\x89PNG")
        assert struct.unpack(">I", content[16:20])[0] == 700
        assert b"Software" not in content
        assert b"Date" not in content


def panel(*groups: GroupValues):
    return draw_panel(Figure().add_subplot(), groups, "What is measured")


def test_a_panel_shows_its_groups_from_top_to_bottom():
    values = np.array([0.1, 0.2, NAN])
    ax = panel(GroupValues("first", values, 0.15, 0.1, 0.2), GroupValues("second", values, 0.15, NAN, NAN))
    assert [label.get_text() for label in ax.get_yticklabels()] == ["first", "second"]
    assert ax.get_yticks().tolist() == [0, -1]
    low, high = ax.get_xlim()
    assert low < 0.1 < 0.2 < high


def test_a_panel_without_any_value_says_so():
    ax = panel(GroupValues("a", np.array([NAN]), NAN, NAN, NAN))
    assert [text.get_text() for text in ax.texts] == ["undefined"]


def test_equal_values_are_spread_and_have_room():
    ax = panel(GroupValues("a", np.zeros(5), 0.0, NAN, NAN))
    assert ax.get_xlim() == (-0.05, 0.05)
    assert len(set(jitter(5).tolist())) == 5
    assert np.abs(jitter(50)).max() < 0.5


@pytest.mark.parametrize(
    ("label", "expected"),
    [
        ("short", "short"),
        ("qwen3:4b-instruct-2507-q4_K_M", "qwen3:4b-instruct-\n2507-q4_K_M"),
        ("a" * 25, "a" * 20 + "\n" + "a" * 5),
        ("a / prompt with blanks", "a / prompt with\nblanks"),
        ("", ""),
    ],
)
def test_long_labels_are_wrapped(label: str, expected: str):
    assert wrapped(label) == expected


def test_rows_are_high_enough_for_their_labels():
    assert panel_height(["a", "b" * 70]) > panel_height(["a", "b"])


@pytest.mark.parametrize("label", ["a", "MMMMMMMMMMMMMMMMMMMMMMMM / b"])
def test_the_titles_of_all_measures_fit_above_their_panels(label: str):
    groups = [GroupValues(label, np.array([0.1, 0.2]), 0.15, 0.1, 0.2)]
    titles = [one.of("library").label for signature in signatures.discover() for one in signature.measures.values()]
    with matplotlib.rc_context(style.settings()):
        for title in sorted(titles, key=len)[-12:]:
            size = (style.WIDTH_IN, panel_height([label], title))
            figure = Figure(figsize=size, dpi=style.DPI, layout="constrained")
            shown = draw_panel(figure.add_subplot(), groups, title).title
            figure.draw_without_rendering()
            assert shown.get_window_extent().x1 <= figure.bbox.x1
            assert shown.get_window_extent().y1 <= figure.bbox.y1


def test_names_in_any_script_can_be_drawn(make_sweep, make_condition, small_world):
    places = [{**small_world["places"][0], "name": "図書館 $x_1"}]
    found = analyze([make_sweep([make_condition("a", [0], world={**small_world, "places": places})]).path])
    assert "place_choice.share_図書館 $x_1" in found.runs.columns
    assert found.path / "plots" / "place_choice.png" in found.written
