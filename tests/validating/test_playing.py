"""Scripted policies are played and held against their numbers; the exit code says where one does not hold."""

import math
from dataclasses import replace
from pathlib import Path

import pytest

from commands import foundry, succeeds
from foundry.validating.playing import KnownResult, page

SMALL = "overrides: [world.agents=2, world.steps=2]"
FACTS = f"""
world: cafe_library
score: idle_rate.chosen
closed_forms:
  - {{name: idlers, policy: scripted/stay, column: idle_rate.chosen, value: 1, seeds: 2, why: they stay, {SMALL}}}
  - {{name: count, policy: scripted/random, column: outcome.n_decisions, value: 5, seeds: 2, why: 2 x 2, {SMALL}}}
"""
HELD = KnownResult(
    world="w", name="n", command="c", column="a.b", n=4, result=10.0, error=0.5, value=11.9, tolerance=0.0, why="so"
)


@pytest.mark.slow
def test_what_holds_and_what_does_not_is_written_as_a_page_with_the_commands_that_play_it_again(tmp_path: Path):
    (tmp_path / "mine" / "validation").mkdir(parents=True)
    (tmp_path / "mine" / "validation" / "cafe_library.yaml").write_text(FACTS)
    done = foundry("check", "--known", "cafe_library", "--config-dir", "mine", "--write", "page.md", cwd=tmp_path)
    assert done.returncode == 3 and "1 of 2 results agree with their known values" in done.stdout
    written = (tmp_path / "page.md").read_text()
    assert "| idlers | idle_rate.chosen | 2 | 1 | 1 | yes |" in written
    assert "| count | outcome.n_decisions | 2 | 4 | 5 | NO |" in written
    played = "world=cafe_library model=scripted/random seed=0-1 world.agents=2 world.steps=2 --config-dir mine"
    assert f"- *count*: 2 x 2. `foundry -m {played}`" in written


@pytest.mark.parametrize(
    ("changes", "holds"),
    [
        ({}, True),
        ({"value": 12.1}, False),
        ({"value": 12.1, "tolerance": 0.2}, True),
        ({"value": 7.9}, False),
        ({"error": 0.0, "value": 10.0}, True),
        ({"error": 0.0, "value": 10.00001}, False),
        ({"result": math.nan}, False),
    ],
)
def test_a_number_holds_within_four_standard_errors_and_its_own_rounding(changes: dict[str, float], holds: bool):
    assert replace(HELD, **changes).holds is holds


def test_the_rounding_of_sums_is_shown_as_nothing():
    assert "| 0 ± 0.5 |" in page([replace(HELD, result=2e-14)])


@pytest.mark.exhaustive
@pytest.mark.timeout(900)
def test_every_known_closed_form_is_met(tmp_path: Path):
    succeeds("check", "--known", "--write", "page.md", cwd=tmp_path)
