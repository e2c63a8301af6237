"""Paragraphs on methods that a paper can use, made from what was really done."""

from __future__ import annotations

from collections.abc import Sequence

from analysis.figures.members import Member
from analysis.paper.basis import Basis
from analysis.prose import joined
from analysis.stats.contrasts import ALPHA
from analysis.stats.intervals import BOOTSTRAP_T, SIGN_FLIP, STUDENT, WILSON
from foundry.storing.store import is_served, leaves
from foundry.version import __version__

_SAMPLING = frozenset(
    ("temperature", "top_p", "top_k", "min_p", "seed", "num_predict", "max_tokens", "num_ctx", "think", "format")
)
"""Settings of a model that say how its replies are drawn, by the last part of their paths."""
_UNSET = ("null", "None", "none", "")
_INTERVALS = {
    STUDENT: "Student's t",
    BOOTSTRAP_T: "the bootstrap-t where the values are skewed",
    WILSON: "Wilson's for outcomes",
    SIGN_FLIP: "the shifts that the sign-flip test does not reject for paired differences",
}


def methods(found: Basis) -> list[str]:
    """Return the paragraphs on methods."""
    return [_design(found), _measuring(found), _statistics(found), _software(found)]


def _design(found: Basis) -> str:
    seeds = sorted({member.seed for member in found.members if not member.shown.baseline})
    complete = sum(member.complete for member in found.members)
    baselines = dict.fromkeys(one.shown.label for one in found.members if one.shown.baseline)
    text = (
        f"We ran {joined(_model_names(found))} in the {counted_names(found.members, 'world')} with the "
        f"{counted_names(found.members, 'prompt')} and {seeds_text(seeds)}; a run is one episode of one condition and "
        f"seed, and {complete} of {len(found.members)} runs are complete."
    )
    if baselines:
        text += f" The baselines {joined(baselines)} were run on the same worlds and seeds."
    return text + _sampling(found) + _excluded(found)


def _sampling(found: Basis) -> str:
    """Say with which settings served models were asked."""
    configs = [member.folder.config()["model"] for member in found.members if not member.shown.baseline]
    asked: dict[str, list[str]] = {}
    for config in configs:
        settings = [(path.rpartition(".")[2], value) for path, value in leaves(config) if is_served(config)]
        kept = [f"{name} {value}" for name, value in settings if name in _SAMPLING and value not in _UNSET]
        names = asked.setdefault(", ".join(kept), [])
        if config["name"] not in names:
            names.append(str(config["name"]))
    said = [
        f" {joined(names)} {'was' if len(names) == 1 else 'were'} asked with {kept}."
        for kept, names in asked.items()
        if kept
    ]
    return "".join(said)


def _excluded(found: Basis) -> str:
    """Say which runs are in no number."""
    lacking = sum(not member.complete for member in found.members)
    text = f" Failed and missing runs ({lacking}) are in no mean." if lacking else ""
    return text + (f" Of all runs a part alone was taken: {found.filtered}." if found.filtered else "")


def _model_names(found: Basis) -> list[str]:
    own = [member for member in found.members if not member.shown.baseline]
    digests = {str(member.folder.config()["model"]["name"]): "" for member in own}
    for member in own:
        if member.summary is not None and member.summary.model_digest:
            digests[member.summary.model] = member.summary.model_digest[:12]
    return [f"{name} (digest {digest})" if digest else name for name, digest in digests.items()]


def counted_names(members: Sequence[Member], part: str) -> str:
    """Return what the worlds (prompts, ...) of these runs are called, with the word for it."""
    names = list(dict.fromkeys(str(member.folder.config()[part]["name"]) for member in members))
    return f"{part} {names[0]}" if len(names) == 1 else f"{part}s {joined(names)}"


def seeds_text(seeds: Sequence[int]) -> str:
    """Return how many seeds there were, and which."""
    if len(seeds) == 1:
        return f"the one seed {seeds[0]}"
    whole = list(seeds) == list(range(seeds[0], seeds[-1] + 1))
    named = f"{seeds[0]} to {seeds[-1]}" if whole else joined(map(str, seeds))
    return f"{len(seeds)} seeds ({named})"


def _measuring(found: Basis) -> str:
    parts = [
        "The behaviour in each run was described by the signatures of foundry, over all decisions and, apart, over "
        "those alone that could be read.",
    ]
    parts += [text for form in found.forms for text in form.words.methods(found.labelled_by)]
    parts.append("The value of a group and seed is the mean over its runs, so that the seed is the independent unit.")
    return " ".join(parts)


def _statistics(found: Basis) -> str:
    rows = found.contrasts[found.contrasts["headline"].astype(bool)]
    kinds = set(found.comparison["interval"]) | set(rows["interval"])
    intervals = [text for kind, text in _INTERVALS.items() if kind in kinds]
    text = "Means are given with 95 % intervals"
    text += f" ({joined(intervals)})." if intervals else " where there are enough values."
    if (rows["test"] == SIGN_FLIP).any():
        sizes = [f"{size} for {factor}" for factor, size in rows.groupby("factor", sort=False)["family"].max().items()]
        text += (
            " Differences were paired by seed and tested by sign-flip permutation tests of the mean difference, "
            f"two-sided. They were corrected by step-down max-T over {rows['measure'].nunique()} measures inside each "
            f"pair of levels, and by Holm's method over the pairs ({joined(rows['measure'].unique())}; "
            f"tests in the family: {joined(sizes)}; alpha {ALPHA:g})."
        )
    else:
        text += " No difference was tested."
    text += _declared(found)
    margins = found.contrasts.loc[found.contrasts["margin"].notna(), "measure"].nunique()
    text += (
        f" Sameness was tested by Gaffke's bounds of the mean within margins declared for {margins} measures."
        if margins
        else " No margin of equivalence was declared, so nothing is said to be the same."
    )
    return text + _fingerprinting(found)


def _declared(found: Basis) -> str:
    held = found.planned
    if held is None:
        return " Nothing was declared before the runs."
    looks = joined(f"{one.seeds} (level {one.alpha:.2g})" for one in held.declared.looks)
    differs = f", from which differs: {'; '.join(held.differs)}" if held.differs else ""
    known = f" Of its runs was {held.plan.known}." if held.plan.known else ""
    return (
        f" Measures, tests and looks at {looks} seeds were declared before the runs (preregistration.yaml, SHA-256 "
        f"{held.sha256}){differs}; this is {held.look}.{known}"
    )


def _fingerprinting(found: Basis) -> str:
    tested = found.fingerprint.energy
    if not len(tested) or not tested["p"].notna().any():
        return ""
    return (
        f" Groups as a whole were compared by the energy distance of their {len(found.fingerprint.measures)} "
        "standardised headline measures, labels swapped within seeds, with Holm's correction over the pairs."
    )


def _software(found: Basis) -> str:
    made: dict[str, None] = {}
    for member in found.members:
        if member.summary is not None:
            one = member.summary
            packages = ", ".join(f"{name} {version}" for name, version in one.packages.items())
            made[f"foundry {one.foundry_version} (Python {one.python_version}; {packages})"] = None
    versions = joined(made) if made else "no run that has ended"
    return f"Runs were made with {versions}, and analysed with foundry {__version__}."
