"""The limitations of a study, which a reader should know before any number."""

import pandas as pd

from analysis.paper.methods import counted_names
from analysis.prose import joined
from analysis.report.material import Material
from analysis.stats.intervals import ENOUGH_FOR_CLAIMS, FEWEST_FOR_CLAIMS
from foundry.storing.determinism import model_repeats
from foundry.storing.standing import unread
from foundry.storing.store import is_served


def limits(material: Material) -> list[str]:
    """Return the limitations of a study, one sentence each."""
    filtered = material.analysis.filtered
    return [
        *([f"This page covers only a part of the runs: {filtered}."] if filtered else ()),
        *_of_unread(material),
        *_of_numbers(material),
        *_of_servers(material),
        *_of_baselines(material),
        *_of_tests(material),
        *_of_reach(material),
        *(note for note in material.analysis.notes if not filtered or filtered not in note),
    ]


def _of_unread(material: Material) -> list[str]:
    unreadable = unread(member.folder for member in material.members)
    return [
        "; ".join(line.strip() for line in of_model.lines()).replace(", such as;", ", such as", 1)
        for of_model in unreadable
    ]


def _of_numbers(material: Material) -> list[str]:
    seeds = {
        shown.label: len({member.seed for member in material.of(shown) if member.complete}) for shown in material.own
    }
    fewest = min(seeds.values(), default=0)
    if fewest < FEWEST_FOR_CLAIMS:
        return [
            f"At least one group has only {fewest} complete seeds, so nothing is tested: the numbers only describe "
            "these runs."
        ]
    if fewest < ENOUGH_FOR_CLAIMS:
        return [
            f"The smallest group has {fewest} complete seeds, so only large differences can be detected "
            f"({ENOUGH_FOR_CLAIMS} seeds are advised for claims)."
        ]
    return []


def _of_servers(material: Material) -> list[str]:
    return [
        f"{result.line()}." for sweep in material.sweeps for result in model_repeats(sweep) if result.repeats is None
    ]


def _of_baselines(material: Material) -> list[str]:
    if any(shown.baseline for shown in material.shown):
        return ["Baselines are scripted policies. They are shown for comparison, and are not tested."]
    return ["The sweep has no baselines, so the report does not show which values result by chance."]


def _of_tests(material: Material) -> list[str]:
    undefined = _undefined(material.analysis.contrasts[material.analysis.contrasts["headline"].astype(bool)])
    if not undefined:
        return []
    return [f"These measures could not be compared, because they are undefined in all pairs: {joined(undefined)}."]


def _undefined(rows: pd.DataFrame) -> list[str]:
    defined = rows.groupby("measure", sort=False)["n_pairs"].max()
    return [str(measure) for measure, pairs in defined.items() if pairs == 0]


def _of_reach(material: Material) -> list[str]:
    said = [text for form in material.forms for text in form.words.limits(material.labelled_by)]
    said.append(
        f"The results are valid for the {counted_names(material.members, 'world')} and the "
        f"{counted_names(material.members, 'prompt')}; other worlds and prompts may reverse them."
    )
    unknown = _without_digest(material)
    if unknown:
        said.append(f"It is unknown which weights answered for {joined(unknown)}: no digest was recorded.")
    return said


def _without_digest(material: Material) -> list[str]:
    known = {
        member.summary.model
        for member in material.members
        if member.summary is not None and member.summary.model_digest
    }
    served = [member.folder.config()["model"] for member in material.members]
    names = dict.fromkeys(str(model["name"]) for model in served if is_served(model))
    return [name for name in names if name not in known]
