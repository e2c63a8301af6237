"""The matrix of agreement, the signed changes of an edit and the declared family, on answers that are known."""

from collections import Counter
from collections.abc import Callable, Mapping
from dataclasses import replace

import numpy as np
import pandas as pd
import pytest

from analysis.paper.summary import summary_of
from analysis.probes.changed import changes_of
from analysis.probes.choices import Answers, Change, Chosen, MomentKey, ProbeCondition, Subject
from analysis.probes.comparing import Compared, compared_edits, compared_pairs, framed
from analysis.probes.differences import contrasts_of, sides_of
from analysis.probes.formats import format_tables
from analysis.probes.layouts import LAYOUTS
from analysis.probes.probe_declaring import Family
from foundry.errors import InputError
from foundry.seeding import stream

SEEDS, STEPS, REPEATS = 8, 12, 6
MIRROR = Change("mirror", "equivariance", {"left": "right", "right": "left"})
Policy = Callable[[MomentKey, np.random.Generator], Mapping[str, int]]


def chosen(policy: Policy, name: str) -> Chosen:
    rng = stream(0, name)
    keys = [MomentKey(seed, "run", step, 0, "action", 0) for seed in range(SEEDS) for step in range(STEPS)]
    return {key: Counter(dict(policy(key, rng))) for key in keys}


def coin(key: MomentKey, rng: np.random.Generator) -> dict[str, int]:
    left = int(rng.binomial(REPEATS, 0.5))
    return {"left": left, "right": REPEATS - left}


def by_step(key: MomentKey, rng: np.random.Generator) -> dict[str, int]:
    return {"left" if key.step % 2 else "right": REPEATS}


def other_way(key: MomentKey, rng: np.random.Generator) -> dict[str, int]:
    return {"right" if key.step % 2 else "left": REPEATS}


def always(key: MomentKey, rng: np.random.Generator) -> dict[str, int]:
    return {"left": REPEATS}


def answers(policies: Mapping[tuple[str, str], Policy]) -> Answers:
    found = {
        ProbeCondition(Subject(model, "p", ""), edit, "none"): chosen(policy, f"{model} {edit}")
        for (model, edit), policy in policies.items()
    }
    changes = {"none": Change("none", "invariance"), "mirror": MIRROR, "no_fire": Change("no_fire", "cause")}
    asked = {edit: changes[edit] for _, edit in policies}
    return Answers(found, asked, ("none",), {asked.subject: asked.subject.model for asked in found}, 0)


def test_a_change_has_a_sign_and_that_of_an_equivariance_is_from_what_should_be():
    frame = changes_of(answers({("a", "none"): always, ("a", "no_fire"): by_step, ("a", "mirror"): always}))
    found = frame.set_index(["edit", "choice"])
    assert found.loc[("no_fire", "left"), ["before", "after", "change"]].tolist() == [1, 0.5, -0.5]
    assert found.loc[("no_fire", "right"), "change"] == 0.5
    assert found.loc[("mirror", "left"), ["before", "after", "change"]].tolist() == [0, 1, 1]
    assert (
        found.loc[("no_fire", "left"), "p"] == 2 / 2**SEEDS and found.loc[("no_fire", "left"), "p_holm"] == 8 / 2**SEEDS
    )


def test_p_of_changes_is_corrected_over_the_declared_rows_alone():
    policies = {("a", "none"): always, ("a", "no_fire"): by_step, ("a", "mirror"): always, ("b", "none"): always}
    probe = answers(policies | {("b", "no_fire"): by_step})
    asked = changes_of(probe, Family(frozenset("a"), frozenset({"no_fire"}))).set_index(["model", "edit"])["p_holm"]
    assert asked["a", "no_fire"].tolist() == pytest.approx([2 * 2 / 2**SEEDS] * 2)
    assert asked["a", "mirror"].isna().all() and asked["b", "no_fire"].isna().all()


def test_changes_of_no_seed_or_of_few_have_no_test():
    frame = changes_of(answers({("a", "none"): always, ("a", "no_fire"): always}))
    assert frame["change"].tolist() == [0] and frame["p"].isna().all()
    probe = answers({("a", "none"): always, ("a", "no_fire"): by_step})
    asked = ProbeCondition(Subject("a", "p", ""), "no_fire", "none")
    few = {key: counts for key, counts in probe.chosen[asked].items() if key.seed < 3}
    frame = changes_of(replace(probe, chosen={**probe.chosen, asked: few}))
    assert frame["p"].isna().all()
    assert [row[3] for row in LAYOUTS["edit_choices"].table("edit_choices", frame).rows] == ["left", "right"]


@pytest.fixture(scope="module")
def three() -> Answers:
    models = {"a": by_step, "b": other_way, "c": coin}
    return answers({(name, edit): policy for name, policy in models.items() for edit in ("none", "mirror", "no_fire")})


@pytest.fixture(scope="module")
def compared(three: Answers) -> tuple[pd.DataFrame, pd.DataFrame]:
    """The pairs of models, and the edits."""
    agreement = framed(compared_pairs(three), ("first", "second")).assign(p=0.01)
    return agreement, framed(compared_edits(three), ("model", "edit")).assign(p=0.02)


@pytest.mark.parametrize(
    ("names", "pairs", "edited"),
    [
        ((), 3, 6),
        (("a",), 2, 2),
        (("a", "b"), 1, 4),
        (("no_fire",), 0, 3),
        (("a", "no_fire"), 2, 1),
        (("a", "b", "no_fire", "mirror"), 1, 4),
    ],
)
def test_a_family_is_the_rows_of_what_is_declared(
    three: Answers, compared: tuple[pd.DataFrame, pd.DataFrame], names: tuple[str, ...], pairs: int, edited: int
):
    agreement, edits = (frame.copy() for frame in compared)
    family = Family.of(names, three)
    family.correct(agreement, edits)
    assert (agreement["p_holm"].notna().sum(), edits["p_holm"].notna().sum()) == (pairs, edited)
    assert set(edits.loc[edits["p_holm"].notna(), "kind"]) == {"all"}
    tests = edited + pairs if names else edited
    least = edits["p_holm"].min()
    assert least == pytest.approx(max(0.02 * edited, 0.01 * tests if pairs and names else 0))
    assert len(family.note(agreement, edits)) == bool(names)


def test_a_row_of_fewer_seeds_than_are_tested_is_described_and_counts_in_no_family():
    probe = answers({("a", "none"): by_step, ("a", "mirror"): by_step, ("a", "no_fire"): by_step})
    few = {key: counts for key, counts in probe.of(Subject("a", "p", ""), "no_fire").items() if key.seed < 5}
    edits = framed(
        [
            ({"model": "a", "edit": edit}, Compared.of(chosen(always, "before"), after, edit))
            for edit, after in (("mirror", probe.of(Subject("a", "p", ""), "mirror")), ("no_fire", few))
        ],
        ("model", "edit"),
    )
    family = Family(frozenset("a"), frozenset())
    family.correct(framed([], ("first", "second")), edits)
    frame = edits.set_index("edit")
    assert frame["excess"].notna().all()
    for name in ("p", "p_holm"):
        assert frame[name].tolist() == pytest.approx([1 / 2**SEEDS, np.nan], nan_ok=True)
    assert "over 1 row in the tables" in family.note(framed([], ("first", "second")), edits)[0]


def test_what_is_neither_a_model_nor_an_edit_is_refused(three: Answers):
    with pytest.raises(InputError, match="Did you mean 'no_fire'"):
        Family.of(["no_fires"], three)


def test_a_probe_is_told_in_the_sentences_of_a_sweep(three: Answers):
    frames = {
        "agreement": framed(compared_pairs(three), ("first", "second")),
        "edits": framed(compared_edits(three), ("model", "edit", "leaves", "asked")),
        "formats": format_tables(three)[0],
        "moments": pd.DataFrame({"model": "a", "edit": "no_fire", "format": "none", "by": "repeats", "count": [3, 1],
                                 "choice": ["left", "unreadable"]}),
    }  # fmt: skip
    family = Family.of(["a"], three)
    family.correct(frames["agreement"], frames["edits"])
    known = "already recorded before the plan: 8 answers"
    rows = contrasts_of(frames, family, planned=True, known=known)
    assert (len(rows), set(rows["family"]), set(rows["claim"])) == (4, {4}, {"declared"})
    told = summary_of(rows, sides_of(frames), "", [], planned=True)
    assert told[0].startswith("a decides differently than b: distance of a and b 1 against 0.2")
    assert told[0].endswith(f"after correction for 4 tests (level .05); {known}.")
    assert "With edit=mirror a misses its expected decision more often than with edit=none: change under m" in told[2]
    assert told[3].startswith("No difference was found between edit=no_fire and edit=none (model=a) in change ")
    assert told[3].endswith("; 25 % of the decisions of edit=no_fire were unreadable.")
    once = frames | {"moments": frames["moments"].head(1).assign(count=1)}
    rows = contrasts_of(once, family, planned=False, known="").tail(1)
    (told,) = summary_of(rows, sides_of(once), "", [], planned=True)[1:]
    assert (
        "in change under no_fire" in told and "could not be compared" in told and "each moment was asked once" in told
    )
