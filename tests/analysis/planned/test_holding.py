"""A plan held against the runs that are there."""

from collections.abc import Callable, Sequence

import msgspec
import numpy as np
import pandas as pd
import pytest

from analysis.planned.holding import PlanCheck, answered, open_rows, plan_check, plans_of
from analysis.stats.contrasts import contrasts
from analysis.tables.signature_table import SignatureTable
from foundry import __version__
from foundry.errors import InputError, RecordError
from foundry.expansion import Sweep
from foundry.storing.preregistration import plan_sha256, preregistration_of, write_preregistration
from foundry.storing.store import SweepFolder
from planning import LOOKS, MEASURES, plan
from signature_tables import table

VALUES = np.random.default_rng(0).normal(size=(3, 14, 2)) + np.array([0, 3, 0])[:, None, None]

FURTHER = {"family": (*MEASURES, "movement.variety"), "margins": {"movement.variety": 0.1}}
"""Declares a measure that no run has."""


def runs_of(models: str = "ab", seeds: Sequence[int] = range(12), **changes: object) -> SignatureTable:
    rows = [
        {"run": f"{model}{seed}", "model": model, "seed": seed, **dict(zip(MEASURES, VALUES[at, seed], strict=True))}
        for at, model in enumerate(models)
        for seed in seeds
    ]
    return table([{**row, **changes} for row in rows])


@pytest.fixture
def hold(tmp_path) -> Callable[..., PlanCheck]:
    def found(made: SignatureTable, models: Sequence[dict[str, object]] = (), weights=(), **changes) -> PlanCheck:
        write_preregistration(tmp_path, plan(**{"foundry": __version__, "models": list(weights), **changes}))
        sweep = SweepFolder(tmp_path, Sweep((), (), ()), {}, models)
        result = plan_check(sweep, made, made.frame[["model"]])
        assert result is not None
        return result

    return found


@pytest.mark.parametrize(("seeds", "reached"), [(5, 0), (6, 1), (8, 1), (12, 3)])
def test_a_look_is_reached_when_all_its_seeds_have_ended(hold, seeds, reached):
    found = hold(runs_of(seeds=range(seeds)))
    assert found.plan.reached == reached and bool(found.differs) == (seeds not in LOOKS)


def test_a_seed_that_is_open_holds_up_the_looks_behind_it_and_a_failed_one_does_not(hold):
    made = runs_of()
    for status, reached in (("unfinished", 1), ("failed", 3)):
        made.frame.loc[made.frame["seed"] == 7, "status"] = status
        found = hold(made)
        assert found.plan.reached == reached and bool(found.differs) == (status == "unfinished")


def test_a_plan_that_holds_says_so_with_its_margins_and_widest_differences(hold):
    notes = hold(runs_of()).notes()
    assert len(notes) == 1
    assert "look 3 of 3, at 12 seeds, level 0.026 of a single test; nothing differs" in notes[0]
    margins, widest = {MEASURES[1]: 0.1}, {MEASURES[1]: 0.3}
    plan = hold(runs_of(), margins=margins, widest=widest).plan
    assert (plan.margins, plan.widest) == (margins, widest)
    assert hold(runs_of(), margins=margins).plan.widest == {}


@pytest.mark.parametrize(
    ("made", "changes", "said"),
    [
        (runs_of("a"), {}, "1 of the 2 planned conditions are missing"),
        (runs_of("abc"), {}, "c was added later and is exploratory"),
        (runs_of(seeds=range(14)), {}, "2 seeds were run, but are not in the plan, so they are not tested"),
        (
            runs_of(seeds=range(8)),
            {},
            "there are 8 seeds, but looks are planned at 6, 9, 12: the tests were made at 6 seeds",
        ),
        (runs_of(seeds=range(5)), {}, "there are 5 seeds, but looks are planned at 6, 9, 12: nothing is tested yet"),
        (runs_of(), {"foundry": "0.0.1"}, f"the plan was made with foundry 0.0.1; this is foundry {__version__}"),
        (runs_of(), FURTHER, "no run has movement.variety"),
    ],
)
def test_what_differs_from_the_plan_is_said(hold, made, changes, said):
    found = hold(made, **changes)
    assert found.differs == (said,) and not found.plan.margins


def test_before_a_run_is_complete_no_measure_is_missed_and_baselines_differ_in_nothing(hold):
    assert hold(runs_of(status="unfinished"), **FURTHER).differs == ()
    beside = runs_of("abc")
    beside.frame["baseline"] = beside.frame["model"] == "c"
    assert hold(beside).differs == ()


def test_other_weights_are_said(hold):
    then, now = ([{"name": "a", "digest": digest}] for digest in ("1", "2"))
    for known in (then, [{"name": "a", "digest": None}], []):
        assert hold(runs_of(), known, weights=then).differs == ()
    assert hold(runs_of(), now, weights=then).differs == ("a has other weights",)


def test_a_measure_whose_code_changed_explores_and_stays_in_the_family(tmp_path):
    made = plan(foundry=__version__)
    other = msgspec.structs.replace(made.measures[0], code_sha256={"grid": "0"})
    write_preregistration(tmp_path, msgspec.structs.replace(made, measures=[other, *made.measures[1:]]))
    runs = runs_of()
    found = plan_check(SweepFolder(tmp_path, Sweep((), (), ()), {}, []), runs, runs.frame[["model"]])
    assert found.differs == (f"the code of {MEASURES[0]} has changed since the plan, so these results are exploratory",)
    rows = contrasts(runs, plan=found.plan).set_index("measure")
    assert rows["claim"].to_dict() == {MEASURES[0]: "exploratory", MEASURES[1]: "declared"}
    assert rows["family"].tolist() == [2, 2]


def test_a_question_is_answered_when_every_declared_row_stands():
    rows = {"claim": ["declared", "declared", "exploratory"], "significant": [True, False, False]}
    frame = pd.DataFrame({**rows, "equivalent": [False, True, False]})
    assert answered(frame)
    assert not answered(frame.assign(equivalent=False))
    assert not answered(frame[2:])
    named = frame.assign(measure="idle", level="a", reference="b", equivalent=False)
    assert open_rows(named) == ["idle (a against b)"]


def test_of_several_sweeps_the_first_plan_alone_declares_families_and_further_ones_are_named(tmp_path):
    made = runs_of()
    names = ("none", "first", "second")
    for name in names[1:]:
        (tmp_path / name).mkdir()
        write_preregistration(tmp_path / name, plan(foundry=__version__))
    sweeps = [SweepFolder(tmp_path / name, Sweep((), (), ()), {}, (), plan_sha256(tmp_path / name)) for name in names]
    with pytest.raises(InputError, match="leave --family and --margin out"):
        plan_check(sweeps[1], made, made.frame[["model"]], asked=True)
    found, others = plans_of(sweeps, made, made.frame[["model"]])
    assert found.plan.reached == 3
    assert others == [
        f"{tmp_path / 'second' / 'preregistration.yaml'} is not used for several sweeps: "
        "to use it, analyse its sweep alone"
    ]
    assert plans_of(sweeps[:1], made, made.frame[["model"]]) == (None, [])


def test_a_plan_comes_back_as_it_was_written_and_a_damaged_one_is_refused(tmp_path):
    made = plan()
    sha256 = write_preregistration(tmp_path, made)
    assert preregistration_of(tmp_path) == (msgspec.convert(msgspec.to_builtins(made), type(made)), sha256)
    (tmp_path / "preregistration.yaml").write_text("looks: 3\n")
    with pytest.raises(RecordError, match=r"preregistration\.yaml cannot be read"):
        preregistration_of(tmp_path)
