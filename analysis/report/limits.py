"""The limitations of a study, which a reader should know before any number."""

import pandas as pd

from analysis.paper.methods import counted_names
from analysis.prose import joined
from analysis.report.material import Material
from analysis.stats.intervals import ENOUGH_FOR_CLAIMS, FEWEST_FOR_CLAIMS
from foundry.storing.determinism import told_of
from foundry.storing.standing import unread
from foundry.storing.store import is_served


def limits(found: Material) -> list[str]:
    """Return the limitations of a study, one sentence each."""
    filtered = found.analysis.filtered
    return [
        *([f"This page covers only a part of the runs: {filtered}."] if filtered else ()),
        *_of_unread(found),
        *_of_numbers(found),
        *_of_servers(found),
        *_of_baselines(found),
        *_of_tests(found),
        *_of_reach(found),
        *(note for note in found.analysis.notes if not filtered or filtered not in note),
    ]


def _of_unread(found: Material) -> list[str]:
    told = unread(member.folder for member in found.members)
    return ["; ".join(line.strip() for line in one.lines()).replace(", such as;", ", such as", 1) for one in told]


def _of_numbers(found: Material) -> list[str]:
    seeds = {shown.label: len({one.seed for one in found.of(shown) if one.complete}) for shown in found.own}
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


def _of_servers(found: Material) -> list[str]:
    return [f"{one.line()}." for sweep in found.sweeps for one in told_of(sweep) if one.repeats is None]


def _of_baselines(found: Material) -> list[str]:
    if any(one.baseline for one in found.shown):
        return ["Baselines are scripted policies. They are shown for comparison, and are not tested."]
    return ["The sweep has no baselines, so the report does not show which values result by chance."]


def _of_tests(found: Material) -> list[str]:
    undefined = _undefined(found.analysis.contrasts[found.analysis.contrasts["headline"].astype(bool)])
    if not undefined:
        return []
    return [f"These measures could not be compared, because they are undefined in all pairs: {joined(undefined)}."]


def _undefined(rows: pd.DataFrame) -> list[str]:
    defined = rows.groupby("measure", sort=False)["n_pairs"].max()
    return [str(measure) for measure, pairs in defined.items() if pairs == 0]


def _of_reach(found: Material) -> list[str]:
    said = [text for form in found.forms for text in form.words.limits(found.labelled_by)]
    said.append(
        f"The results are valid for the {counted_names(found.members, 'world')} and the "
        f"{counted_names(found.members, 'prompt')}; other worlds and prompts may reverse them."
    )
    unknown = _without_digest(found)
    if unknown:
        said.append(f"It is unknown which weights answered for {joined(unknown)}: no digest was recorded.")
    return said


def _without_digest(found: Material) -> list[str]:
    known = {
        member.summary.model for member in found.members if member.summary is not None and member.summary.model_digest
    }
    served = [member.folder.config()["model"] for member in found.members]
    names = dict.fromkeys(str(model["name"]) for model in served if is_served(model))
    return [name for name in names if name not in known]
