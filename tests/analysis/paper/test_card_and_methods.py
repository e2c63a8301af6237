"""The card of a model, beside null, best policy and the other models; methods and references that say what was done."""

import re
from pathlib import Path
from types import SimpleNamespace

import msgspec
import pytest

from analysis.paper.card import PROBES, card
from analysis.paper.methods import Basis, bibtex, methods
from analysis.report.material import gather
from commands import foundry, succeeds
from foundry.errors import InputError
from foundry.records import Counts
from foundry.storing.determinism import write_repeats
from foundry.storing.run_writer import write_run_summary
from foundry.storing.store import SweepFolder
from foundry.trust.bundling import write_bundle
from repeated import repeats
from walkers import WORLD, Habits, make_condition, rewrite_run, write_sweep


@pytest.fixture(scope="module")
def sweeps(tmp_path_factory) -> tuple[SweepFolder, ...]:
    """Two sweeps of one model, one with another model and baselines."""
    path = tmp_path_factory.mktemp("cards")
    first = write_sweep(path / "first", [make_condition(name, range(2)) for name in ("mine", "<b>other</b>")])
    write_sweep(first.baselines_dir, [make_condition("scripted/random", range(2))])
    return first, write_sweep(path / "second", [make_condition("mine", range(2, 4))])


def test_a_card_has_a_table_of_every_sweep_of_its_model_beside_null_policy_and_other_models_without_markup(sweeps):
    made = card("mine", [sweep.path for sweep in sweeps])
    assert [setting.title.rpartition(", ")[2] for setting in made.settings] == ["first", "second"]
    assert [row[0] for row in made.facts.rows] == ["first", "second"] and PROBES not in made.facts.caption
    assert [row[4:] for row in made.facts.rows] == [("2", "2", "-"), ("2", "2", "-")]
    first, second = (setting.table for setting in made.settings)
    assert first.columns[1:] == ("mine", "null", "best", "<b>other</b>", "scripted/random (baseline)")
    assert second.columns[1:] == ("mine", "null", "best")
    rows = {row[0].partition(":")[0]: row for row in first.rows}
    assert rows["hazard.away_beyond_blind"][2] == "0"
    assert len(rows) > 20
    assert "<b>other" not in made.html() and "&lt;b&gt;other" in made.html() and "\\<b\\>other" in made.markdown()
    of_other = card("<b>other</b>", [sweep.path for sweep in sweeps])
    assert [row[0] for row in of_other.facts.rows] == ["first"]
    (idle,) = (row for row in of_other.settings[0].table.rows if row[0].startswith("idle_rate.chosen:"))
    assert (rows["idle_rate.chosen"][1], rows["idle_rate.chosen"][4]) == (idle[4], idle[1])
    assert [file.name for file in sweeps[1].analysis_dir.iterdir()] == ["measured.sqlite"], "it writes no table"
    with pytest.raises(InputError, match="Did you mean '<b>other</b>'"):
        card("<b>othr</b>", [sweep.path for sweep in reversed(sweeps)])


def test_a_card_says_what_became_of_the_runs_of_its_model_those_that_failed_or_have_not_ended_too(make_sweep):
    sweep = make_sweep([make_condition("mine", range(4)), make_condition("other", range(2))])
    rewrite_run(sweep.runs()[0], "failed")
    rewrite_run(sweep.runs()[1], "unfinished")
    counts = Counts(outcomes={"chosen": 9, "unreadable": 3})
    for run in sweep.runs()[2:]:
        write_run_summary(run, msgspec.structs.replace(run.summary(), model_digest="f00d" * 16, counts=counts))
    write_repeats(sweep, [repeats("mine", alone=10, loaded=8), repeats("other", alone=10, loaded=10)])
    (facts,) = card("mine", [sweep.path]).facts.rows
    assert facts == ("sweep", "f00df00df00d", "0", "8 of 10 calls exactly", "4", "2", "25 %")


def test_null_and_best_are_the_policies_of_the_same_world_and_others_have_the_same_prompt(make_sweep):
    world, small = {**WORLD, "name": "cafe_library"}, {**WORLD, "places": WORLD["places"][:1]}
    asked = [("mine", "paper", world), ("other", "paper", world), ("far", "japanese", world), ("mine", "paper", small)]
    conditions = [
        make_condition(model, range(seeds), ("model", "x"), prompt=prompt, world=one, values={"x": seeds})
        for model, prompt, one in asked
        for seeds in [2 if one is world else 1]
    ]
    sweep = make_sweep(conditions)
    policies = {f"scripted/{name}": Habits(move=move) for name, move in (("random", 0.5), ("avoid", 1))}
    write_sweep(sweep.baselines_dir, [make_condition(name, range(2), world=world) for name in policies], policies)
    (first, second), (policy,) = (card(model, [sweep.path]).settings for model in ("mine", "scripted/random"))
    assert [(setting.title, setting.table.caption) for setting in (first, second)] == [
        ("world cafe_library, prompt paper, x 2", "2 seeds."),
        ("world small, prompt paper, x 1", "1 seed."),
    ]
    own = ("mine", "null", "best (scripted/avoid)", "other")
    assert first.table.columns[1:] == (*own, "scripted/random (baseline)", "scripted/avoid (baseline)")
    assert second.table.columns[1:] == ("mine", "null", "best")
    rows, fewer, alone = (
        {row[0].partition(":")[0]: row[2:] for row in setting.table.rows} for setting in (first, second, policy)
    )
    null, best, _, random, avoid = rows["idle_rate.chosen"]
    assert null == f"{random.partition(' ')[0]} (scripted/random)" and best == avoid.partition(" ")[0]
    assert alone["idle_rate.chosen"][0] == "-" and rows["hazard.away_beyond_blind"][0] == "0"
    assert {cells[0] for measure, cells in rows.items() if measure.startswith("cost.")} == {"-"}
    assert rows.keys() - fewer.keys() == {"place_choice.share_library"}


def test_the_command_writes_page_and_text_from_folders_and_bundles_under_names_that_any_system_takes(sweeps, tmp_path):
    bundle, page = tmp_path / "second.tar.zst", tmp_path / "out" / "card.html"
    write_bundle(sweeps[1].path, bundle)
    command = ("report", "--model")
    succeeds(*command, "mine", str(sweeps[0].path), str(bundle), "--out", str(page), cwd=tmp_path)
    assert page.read_text(encoding="utf-8").startswith("<!doctype html>")
    assert ", second" in page.with_suffix(".md").read_text(encoding="utf-8")
    succeeds(*command, "<b>other</b>", str(sweeps[0].path), cwd=tmp_path)
    assert {one.name for one in tmp_path.glob("card*")} == {"card-_b_other_b_.html", "card-_b_other_b_.md"}


@pytest.mark.parametrize(
    ("more", "told"),
    [
        (("{second}",), "is given more than once"),
        (("second.tar.zst",), "is given more than once"),
        (("--out", "card.md"), "give the page another name"),
        (("--out", "file/card.html"), "cannot be written"),
    ],
)
def test_the_command_refuses_a_sweep_that_is_given_twice_and_a_page_that_cannot_be(more, told, sweeps, tmp_path):
    (tmp_path / "file").touch()
    write_bundle(sweeps[1].path, tmp_path / "second.tar.zst")
    second = str(sweeps[1].path)
    more = [one.format(second=second) for one in more]
    finished = foundry("report", "--model", "mine", second, *more, cwd=tmp_path)
    assert (finished.returncode, finished.stderr.count("\n")) == (2, 1) and told in finished.stderr


SERVED = {"server": {"hosts": "http://a"}, "options": {"temperature": 0.2, "top_k": 40, "stop": None}, "think": False}


def test_methods_and_references_are_those_of_what_was_used_and_are_written_by_an_analysis(make_sweep):
    world = {**WORLD, "agents": 3, "steps": 6}
    conditions = [make_condition(name, range(6), world=world) for name in ("scripted/stay", "qwen3:4b")]
    conditions[1].config["model"].update(SERVED)
    idle = SimpleNamespace(speak=0.4, move=0.3, unreadable=0.1, texts=("hello", "fire"))
    served = make_sweep(conditions, {"scripted/stay": idle})

    def keys(basis: Basis) -> set[str]:
        return set(re.findall(r"^@\w+\{(.*),$", bibtex(basis), re.MULTILINE))

    material = gather([served.path])
    both, written = material.basis, material.analysis.written
    assert {"summary.md", "methods.md", "references.bib"} <= {file.name for file in written}
    told = (material.analysis.path / "methods.md").read_text(encoding="utf-8").replace("\\", "")
    assert "We asked qwen3:4b with" in told
    assert all(isinstance(file, Path) and file.exists() for file in written)
    design = methods(both)[0]
    assert " We asked qwen3:4b with temperature 0.2, top_k 40, think false." in design
    assert design.count("We asked ") == 1
    assert bibtex(both).count("{") == bibtex(both).count("}")
    assert {"foundry", "model-qwen3-4b", "fisher1935", "holm1979"} <= keys(both)
    assert not {"lan1983", "gaffke2005", "ashery2025"} & keys(both)
    margins = {"idle_rate.chosen": 0.5}
    assert "gaffke2005" in keys(gather([served.path], family=list(margins), margins=margins).basis)
    alone = gather([served.path], without=["model=scripted/stay"]).basis
    part = "The analysis covers only a part of the runs: without model=scripted/stay: 6 of 12 runs."
    assert part in methods(alone)[0]
    assert not {"fisher1935", "holm1979"} & keys(alone)
