"""A paragraph on methods that a paper can use, and the limits of what was done, both from what was really done."""

from __future__ import annotations

from collections.abc import Sequence

import pandas as pd

from analysis.figures.members import Member
from analysis.form import forms_of
from analysis.plots.ledger import percent
from analysis.prose import joined
from analysis.report.material import Material
from analysis.stats.contrasts import ALPHA, MCNEMAR, SIGN_FLIP
from analysis.stats.intervals import BOOTSTRAP_T, FEWEST_FOR_CLAIMS, STUDENT, WILSON
from foundry import __version__
from foundry.storing.determinism import told_of
from foundry.storing.store import is_served
from foundry.storing.unread import unread

_ENOUGH = 20
"""Seeds from which claims are made."""

_OF_ITSELF = (
    " Its server answers the same call in different ways: differences as small as that makes may be the server's own; "
    "the records stand as they are."
)

_INTERVALS = {
    STUDENT: "Student's t",
    BOOTSTRAP_T: "the bootstrap-t where the values are skewed",
    WILSON: "Wilson's for outcomes",
}
_TESTS = {
    SIGN_FLIP: "sign-flip permutation tests of the mean difference",
    MCNEMAR: "exact McNemar tests for outcomes",
}


def methods(found: Material) -> list[str]:
    """Return the paragraphs on methods."""
    return [_design(found), _measuring(found), _statistics(found), _software(found)]


def _design(found: Material) -> str:
    seeds = sorted({member.seed for member in found.members if not member.shown.baseline})
    worlds = _names(found, "world")
    prompts = _names(found, "prompt")
    complete = sum(member.complete for member in found.members)
    baselines = [one.label for one in found.shown if one.baseline]
    text = (
        f"We ran {joined(_model_names(found))} in the {_counted(worlds, 'world')} with the "
        f"{_counted(prompts, 'prompt')} and {seeds_text(seeds)}; a run is one episode of one condition and seed, and "
        f"{complete} of {len(found.members)} runs are complete."
    )
    if baselines:
        text += f" The baselines {joined(baselines)} were run on the same worlds and seeds."
    return text


def _model_names(found: Material) -> list[str]:
    own = [member for member in found.members if not member.shown.baseline]
    digests = {str(member.folder.config()["model"]["name"]): "" for member in own}
    for member in own:
        if member.summary is not None and member.summary.model_digest:
            digests[member.summary.model] = member.summary.model_digest[:12]
    return [f"{name} (digest {digest})" if digest else name for name, digest in digests.items()]


def _names(found: Material, part: str) -> list[str]:
    return list(dict.fromkeys(str(member.folder.config()[part]["name"]) for member in found.members))


def _counted(names: Sequence[str], what: str) -> str:
    return f"{what} {names[0]}" if len(names) == 1 else f"{what}s {joined(names)}"


def seeds_text(seeds: Sequence[int]) -> str:
    """Return how many seeds there were, and which."""
    if len(seeds) == 1:
        return f"the one seed {seeds[0]}"
    whole = list(seeds) == list(range(seeds[0], seeds[-1] + 1))
    named = f"{seeds[0]} to {seeds[-1]}" if whole else joined(map(str, seeds))
    return f"{len(seeds)} seeds ({named})"


def _measuring(found: Material) -> str:
    parts = [
        "The behaviour in each run was described by the signatures of this report, over all decisions and, apart, over "
        "those alone that could be read.",
    ]
    parts += [text for form in found.forms for text in form.words.methods(found.labelled_by)]
    parts.append("The value of a group and seed is the mean over its runs, so that the seed is the independent unit.")
    return " ".join(parts)


def _statistics(found: Material) -> str:
    rows = found.analysis.contrasts[found.analysis.contrasts["headline"].astype(bool)]
    kinds = set(found.analysis.comparison["interval"]) | set(rows["interval"])
    intervals = [text for kind, text in _INTERVALS.items() if kind in kinds]
    text = "Means are given with 95 % intervals"
    text += f" ({joined(intervals)})." if intervals else " where there are enough values."
    tests = [text for kind, text in _TESTS.items() if kind in set(rows["test"])]
    if tests:
        sizes = [f"{size} for {factor}" for factor, size in rows.groupby("factor", sort=False)["family"].max().items()]
        text += (
            f" Differences were paired by seed and tested by {joined(tests)}, two-sided, with Holm's correction over "
            f"all pairs of levels and {rows['measure'].nunique()} measures ({joined(rows['measure'].unique())}; "
            f"tests in the family: {joined(sizes)}; alpha {ALPHA:g})."
        )
    else:
        text += " No difference was tested."
    margins = found.analysis.contrasts.loc[found.analysis.contrasts["margin"].notna(), "measure"].nunique()
    text += (
        f" Sameness was tested by two one-sided tests within margins declared for {margins} measures."
        if margins
        else " No margin of equivalence was declared, so nothing is said to be the same."
    )
    return text + _fingerprinting(found)


def _fingerprinting(found: Material) -> str:
    tested = found.analysis.fingerprint.energy
    if not len(tested) or not tested["p"].notna().any():
        return ""
    return (
        f" Groups as a whole were compared by the energy distance of their {len(found.analysis.fingerprint.measures)} "
        "standardised headline measures, labels swapped within seeds, with Holm's correction over the pairs."
    )


def _software(found: Material) -> str:
    made: dict[str, None] = {}
    for member in found.members:
        if member.summary is not None:
            one = member.summary
            packages = ", ".join(f"{name} {version}" for name, version in one.packages.items())
            made[f"foundry {one.foundry_version} (Python {one.python_version}; {packages})"] = None
    versions = joined(made) if made else "no run that has ended"
    return f"Runs were made with {versions}, and analysed with foundry {__version__}."


def limits(found: Material) -> list[str]:
    """Return what a reader must know before any number, one sentence each."""
    return [
        *_of_unread(found),
        *_of_numbers(found),
        *_of_decisions(found),
        *_of_servers(found),
        *_of_baselines(found),
        *_of_tests(found),
        *_of_reach(found),
    ]


def _of_unread(found: Material) -> list[str]:
    told = unread(member.folder for member in found.members)
    return ["; ".join(line.strip() for line in one.lines()).replace(", such as;", ", such as", 1) for one in told]


def _of_numbers(found: Material) -> list[str]:
    seeds = {shown.label: len({one.seed for one in found.of(shown) if one.complete}) for shown in found.own}
    fewest = min(seeds.values(), default=0)
    said = []
    if fewest < FEWEST_FOR_CLAIMS:
        said.append(
            f"At least one group has only {fewest} complete seeds: the numbers describe these runs and prove nothing."
        )
    elif fewest < _ENOUGH:
        said.append(
            f"The group with the fewest has {fewest} complete seeds: only large differences can be found, and what is "
            f"not found may be there ({_ENOUGH} are advised for claims)."
        )
    missing = sum(not member.complete for member in found.members)
    if missing:
        said.append(f"{missing} of {len(found.members)} runs are failed or missing; they are in no mean.")
    return said


def _of_decisions(found: Material) -> list[str]:
    said = []
    for shown in found.shown:
        decisions = sum(one.decisions for one in found.of(shown))
        unreadable = sum(one.unreadable for one in found.of(shown))
        if unreadable:
            said.append(
                f"{shown.label}: {percent(unreadable / decisions)} of the action decisions could not be read "
                f"{_unread_decision(found.of(shown))}; compare the measures with those over readable decisions alone."
            )
    if said or not any(one.decisions for one in found.members):
        return said
    return ["Every action decision could be read."]


def _unread_decision(mine: Sequence[Member]) -> str:
    forms = forms_of(member.folder for member in mine)
    return " or ".join(dict.fromkeys(form.words.unread_decision for form in forms))


def _of_servers(found: Material) -> list[str]:
    """Say what is known of servers that do not repeat themselves, and of which nothing is known."""
    told = [one for sweep in found.sweeps for one in told_of(sweep)]
    return [
        f"{one.line()}." + ("" if one.repeats is None else _OF_ITSELF)
        for one in told
        if one.repeats is None or not one.repeats.exact
    ]


def _of_baselines(found: Material) -> list[str]:
    if any(one.baseline for one in found.shown):
        return ["Baselines are scripted; they are in no family of tests."]
    return ["No baselines were run beside the models: what chance alone would give is not shown."]


def _of_tests(found: Material) -> list[str]:
    rows = found.analysis.contrasts[found.analysis.contrasts["headline"].astype(bool)]
    said = []
    weak = int(rows["note"].astype(str).str.contains("no p can reach").sum())
    if weak:
        tests = int(rows["p"].notna().sum())
        said.append(f"In {weak} of {tests} tests of the family no result could have been significant: too few seeds.")
    undefined = _undefined(rows)
    if undefined:
        said.append(f"Undefined in every pair, so not compared: {joined(undefined)}.")
    return said


def _undefined(rows: pd.DataFrame) -> list[str]:
    defined = rows.groupby("measure", sort=False)["n_pairs"].max()
    return [str(measure) for measure, pairs in defined.items() if pairs == 0]


def _of_reach(found: Material) -> list[str]:
    said = [text for form in found.forms for text in form.words.limits(found.labelled_by)]
    said.append(
        f"All of it holds for the {_counted(_names(found, 'world'), 'world')} and the "
        f"{_counted(_names(found, 'prompt'), 'prompt')}; other worlds and other words may turn it round."
    )
    unknown = _without_digest(found)
    if unknown:
        said.append(f"The weights of {joined(unknown)} are not known by a digest.")
    return said


def _without_digest(found: Material) -> list[str]:
    """Return the models that a server answers for and whose weights are not known."""
    known = {one.summary.model for one in found.members if one.summary is not None and one.summary.model_digest}
    served = [member.folder.config()["model"] for member in found.members]
    names = dict.fromkeys(str(model["name"]) for model in served if is_served(model))
    return [name for name in names if name not in known]
