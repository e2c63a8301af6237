"""The limits of a study, which a reader must know before any number."""

from __future__ import annotations

from collections.abc import Sequence

import pandas as pd

from analysis.figures.members import Member
from analysis.form import forms_of
from analysis.paper.methods import counted_names
from analysis.prose import joined, percent
from analysis.report.material import Material
from analysis.stats.intervals import ENOUGH_FOR_CLAIMS, FEWEST_FOR_CLAIMS
from foundry.storing.determinism import told_of
from foundry.storing.standing import unread
from foundry.storing.store import is_served

_OF_ITSELF = (
    " Its server answers the same call in different ways: differences as small as that makes may be the server's own; "
    "the records stand as they are."
)


def limits(found: Material) -> list[str]:
    """Return the limits that a reader must know before any number, one sentence each."""
    part = found.analysis.filtered
    return [
        *([f"These are the numbers of a part of the runs: {part}."] if part else []),
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
    elif fewest < ENOUGH_FOR_CLAIMS:
        said.append(
            f"The group with the fewest has {fewest} complete seeds: only large differences can be found, and what is "
            f"not found may be there ({ENOUGH_FOR_CLAIMS} are advised for claims)."
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
    """Name servers that do not repeat themselves, and servers that were not checked."""
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
    weak = int((rows["out_of_reach"] != "").sum())
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
        f"All of it holds for the {counted_names(found.members, 'world')} and the "
        f"{counted_names(found.members, 'prompt')}; other worlds and other words may turn it round."
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
