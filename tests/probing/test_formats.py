"""Formats of the prompt as an axis of a probe: what is known in closed form of who reads them comes out."""

from collections import Counter
from pathlib import Path

import numpy as np
import pandas as pd
import pytest

from analysis.probes.choices import Answers, Change, Chosen, MomentKey, ProbeCondition, Subject
from analysis.probes.formats import ChoicesByFormat, _dealt, _variance_by_chance, format_tables
from foundry.prompts.formats import Format
from foundry.seeding import stream
from probing.conftest import done, lines, runs, write_models

SEEDS, MOMENTS, REPEATS, FORMATS = 12, 10, 4, ("none", "spread/0", "spread/1", "spread/2", "spread/3")


def answers(chances: dict[str, list[float]], name: str = "answers") -> Answers:
    """Return what models choose that say `yes` with a chance of each format."""
    rng = stream(0, name)
    chosen: dict[ProbeCondition, Chosen] = {}
    for model, of_format in chances.items():
        for written, chance in zip(FORMATS, of_format, strict=True):
            said = {
                MomentKey(seed, "run", step, 0, "action", 0): int(rng.binomial(REPEATS, chance))
                for seed in range(SEEDS)
                for step in range(MOMENTS)
            }
            counts = {key: Counter({"yes": yes, "no": REPEATS - yes}) for key, yes in said.items()}
            chosen[ProbeCondition(Subject(model, "p", ""), "none", written)] = counts
    names = {asked.subject: asked.subject.model for asked in chosen}
    return Answers(chosen, {"none": Change("none", "invariance")}, FORMATS, names, 0)


def row(frame: pd.DataFrame, **wanted: str) -> pd.Series:
    for column, value in wanted.items():
        frame = frame[frame[column] == value]
    (found,) = frame.to_dict("records")
    return pd.Series(found)


def test_a_model_blind_to_formats_spreads_as_far_as_chance_does():
    found = [row(format_tables(answers({"a": [0.4] * 5}, f"{number}"))[0], choice="yes") for number in range(8)]
    excess = np.array([column["excess"] for column in found])
    assert min(column["floor"] for column in found) > 0.1
    assert (
        abs(excess.mean()) < 3 * excess.std(ddof=1) / np.sqrt(8) and sum(column["p"] <= 0.05 for column in found) <= 2
    )


def test_the_spread_and_its_deviation_are_those_of_the_chances():
    chances = [0.2, 0.35, 0.5, 0.65, 0.8]
    column = row(format_tables(answers({"a": chances}))[0], choice="yes")
    assert (column["least_format"], column["greatest_format"]) == ("none", "spread/3")
    assert column["greatest"] - column["least"] == pytest.approx(0.6, abs=0.08)
    assert (
        column["sd"] == pytest.approx(np.std(chances, ddof=1), abs=0.04) and column["sd_low"] < 0.24 < column["sd_high"]
    )
    assert column["p_holm"] < 0.01 and column["seeds"] == SEEDS


def test_the_variance_by_chance_is_that_of_answers_dealt_out_anew():
    rng = stream(0, "dealt")
    counts = rng.integers(0, REPEATS + 1, size=(6, 5))
    formatted = ChoicesByFormat(
        np.stack([counts, REPEATS - counts], axis=-1), ("yes", "no"), np.array([0, 0, 0, 0, 1, 1])
    )
    dealt = np.concatenate([_dealt(counts, REPEATS, rng) for _ in range(100)]) / REPEATS
    by_seed = np.stack([dealt[:, :4].mean(axis=1), dealt[:, 4:].mean(axis=1)])
    assert _variance_by_chance(formatted, counts) == pytest.approx(by_seed.var(axis=2, ddof=1).mean(axis=1), rel=0.02)


def test_the_order_of_two_models_turns_round_where_their_chances_do_and_else_never():
    _, orders = format_tables(answers({"a": [0.9, 0.9, 0.1, 0.1, 0.1], "b": [0.5] * 5, "c": [0.5] * 5}))
    column = row(orders, first="a", second="b", choice="yes")
    assert (column["first_more"], column["second_more"]) == (2, 3)
    assert column["turned"] == column["turned_clearly"] == 0.6
    alike = row(orders, first="b", second="c", choice="yes")
    assert alike["turned_clearly"] == 0 and 0.3 < alike["floor"] < 0.65
    _, orders = format_tables(answers({"a": [0.9] * 5, "b": [0.2] * 5}))
    column = row(orders, choice="yes")
    assert column["turned"] == 0 and column["first_more"] == 5 and column["difference"] == pytest.approx(0.7, abs=0.06)
    assert column["floor"] == 0


@pytest.mark.slow
def test_a_probe_asks_in_formats_and_finds_who_reads_them(pilot: Path, tmp_path: Path):
    write_models(tmp_path, bracketed="policies.Bracketed")
    asked = ("-m", "model=bracketed,scripted/random", "format=0-2", "moments=12", "repeats=2", "runner.workers=1")
    told = done("probe", str(pilot), "--config-dir", "mine", *asked, "output.dir=out", cwd=tmp_path)
    assert "12 moments of 6 runs, 8 conditions, 2 repeats" in told
    ways: dict[str, set[str]] = {}
    for run in runs(tmp_path / "out"):
        space = run.config()["prompt"].get("format")
        if run.config()["model"]["name"] == "bracketed":
            ways.setdefault(run.factors["format"], set()).update(
                line["action"] for line in lines(run) if line["kind"] == "action"
            )
            drawn = None if space is None else Format.of(space).chosen
            text = next(run.calls()).messages[0]["content"]
            assert ("\n[" in text) == (drawn is not None and drawn["heading"] == "[{}]")
    assert ways["none"] == {"stay"} and ways["spread/0"] == {"left"}
    frame = pd.read_csv(tmp_path / "out" / "analysis" / "formats.csv", keep_default_na=False, na_values=[""])
    assert row(frame, model="bracketed", choice="left")["greatest_format"] == "spread/0"
    assert set(frame[frame["model"] == "scripted/random"]["sd"]) == {0}
