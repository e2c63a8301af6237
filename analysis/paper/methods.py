"""Writes the methods section and the BibTeX references of a paper about an analysis."""

import re
from collections.abc import Iterator, Mapping, Sequence
from dataclasses import dataclass
from functools import cache
from pathlib import Path

import msgspec
import pandas as pd

from analysis.figures.members import Member
from analysis.form import FormAnalysis
from analysis.labelling import Labelling
from analysis.planned.holding import PlanCheck
from analysis.prose import joined
from analysis.report.templating import rendered
from analysis.stats.contrasts import ALPHA
from analysis.stats.fingerprint import Fingerprint
from analysis.stats.intervals import BOOTSTRAP_T, SIGN_FLIP, STUDENT, WILSON
from analysis.stats.plan import DECLARED
from foundry.storing.store import is_served, leaves
from foundry.texts import one_line
from foundry.version import __version__

_SAMPLING = frozenset(
    ("temperature", "top_p", "top_k", "min_p", "seed", "num_predict", "max_tokens", "num_ctx", "think", "format")
)
"""Settings of a model that count as sampling settings; each is the last part of a setting's path."""
_UNSET = ("null", "None", "none", "")
_INTERVALS = {
    STUDENT: "Student's t",
    BOOTSTRAP_T: "the bootstrap-t for skewed values",
    WILSON: "Wilson's for outcomes",
    SIGN_FLIP: "the shifts that the sign-flip test does not reject for paired differences",
}
_ESCAPED = str.maketrans({letter: f"\\{letter}" for letter in "&%$#_{}"} | {"\\": "", "~": "", "^": ""})


@dataclass(frozen=True)
class Basis:
    """The results of an analysis that the texts of methods and references are written from."""

    members: Sequence[Member]
    forms: Sequence[FormAnalysis]
    labelled_by: Sequence[Labelling]
    comparison: pd.DataFrame
    contrasts: pd.DataFrame
    fingerprint: Fingerprint
    planned: PlanCheck | None = None
    filtered: str = ""


def methods(basis: Basis) -> list[str]:
    """Return four paragraphs: design, measures, statistics, software."""
    own = [member for member in basis.members if not member.shown.baseline]
    rows = basis.contrasts[basis.contrasts["headline"].astype(bool)]
    tested = rows if (rows["test"] == SIGN_FLIP).any() else rows[:0]
    kinds = {*basis.comparison["interval"].unique(), *rows["interval"].unique()}
    digests = _digests(own)
    summaries = [member.summary for member in basis.members if member.summary is not None]
    content = {
        "basis": basis,
        "used": set(_used(basis)),
        "models": [f"{name} (digest {digest[-1][:12]})" if digest else name for name, digest in digests.items()],
        "worlds": counted_names(basis.members, "world"),
        "prompts": counted_names(basis.members, "prompt"),
        "seeds": seeds_text(sorted({member.seed for member in own})),
        "baselines": list(dict.fromkeys(member.shown.label for member in basis.members if member.shown.baseline)),
        "lacking": sum(not member.complete for member in basis.members),
        "asked": _names_by_sampling(own),
        "intervals": [text for kind, text in _INTERVALS.items() if kind in kinds],
        "measures": list(tested["measure"].unique()),
        "sizes": [
            f"{size} for {factor}" for factor, size in tested.groupby("factor", sort=False)["family"].max().items()
        ],
        "alpha": f"{ALPHA:g}",
        "looks": [f"{look.seeds} (level {look.alpha:.2g})" for look in basis.planned.declared.looks]
        if basis.planned
        else [],
        "margins": basis.contrasts.loc[basis.contrasts["margin"].notna(), "measure"].nunique(),
        "made": list(
            dict.fromkeys(
                f"foundry {summary.foundry_version} (Python {summary.python_version}; "
                f"{', '.join(f'{name} {version}' for name, version in summary.packages.items())})"
                for summary in summaries
            )
        ),
        "version": __version__,
    }
    return [one_line(paragraph) for paragraph in rendered("methods.txt", content).split("\n¶\n")]


def _digests(members: Sequence[Member]) -> dict[str, list[str]]:
    digests: dict[str, list[str]] = {}
    for member in members:
        known = digests.setdefault(str(member.folder.config()["model"]["name"]), [])
        if member.summary is not None and member.summary.model_digest and member.summary.model_digest not in known:
            known.append(member.summary.model_digest)
    return digests


def _names_by_sampling(members: Sequence[Member]) -> dict[str, list[str]]:
    """Return for each set of sampling settings, as text, the names of the served models that have these settings."""
    asked: dict[str, list[str]] = {}
    for config in (member.folder.config()["model"] for member in members):
        settings = [(path.rpartition(".")[2], value) for path, value in leaves(config) if is_served(config)]
        text = ", ".join(f"{name} {value}" for name, value in settings if name in _SAMPLING and value not in _UNSET)
        names = asked.setdefault(text, [])
        if config["name"] not in names:
            names.append(str(config["name"]))
    return asked


def counted_names(members: Sequence[Member], part: str) -> str:
    """Return the names of the runs' worlds or prompts, such as `worlds cafe and office`."""
    names = list(dict.fromkeys(str(member.folder.config()[part]["name"]) for member in members))
    return f"{part} {names[0]}" if len(names) == 1 else f"{part}s {joined(names)}"


def seeds_text(seeds: Sequence[int]) -> str:
    """Return the seeds in words, such as `10 seeds (0 to 9)`."""
    if len(seeds) == 1:
        return f"the one seed {seeds[0]}"
    whole = list(seeds) == list(range(seeds[0], seeds[-1] + 1))
    named = f"{seeds[0]} to {seeds[-1]}" if whole else joined(map(str, seeds))
    return f"{len(seeds)} seeds ({named})"


class Source(msgspec.Struct, frozen=True, forbid_unknown_fields=True):
    """A publication that may be cited.

    Attributes:
        of: the parts of an analysis that cite it, as `_used` yields them, such as `world NAME`.
    """

    key: str
    of: tuple[str, ...]
    kind: str
    fields: Mapping[str, str]


def bibtex(basis: Basis) -> str:
    """Return the references as BibTeX: foundry, the models, then publications."""
    used = set(_used(basis))
    works = [_entry(source.kind, source.key, source.fields) for source in _known() if used & set(source.of)]
    return "\n".join([*_software(basis), *_models(basis), *works])


@cache
def _known() -> tuple[Source, ...]:
    file = Path(__file__).with_name("references.yaml")
    return msgspec.yaml.decode(file.read_bytes(), type=tuple[Source, ...])


def _used(basis: Basis) -> Iterator[str]:
    """Yield the names of worlds, prompts, tests and so on in an analysis for which a paper may cite a source."""
    for member in basis.members:
        config = member.folder.config()
        yield f"world {config['world']['name']}"
        yield f"prompt {config['prompt']['name']}"
    rows = basis.contrasts[basis.contrasts["headline"].astype(bool)]
    yield from rows["test"].astype(str).unique()
    yield from basis.comparison["interval"].astype(str).unique()
    yield from rows["interval"].astype(str).unique()
    if rows["p_adjusted"].notna().any():
        yield "max-t"
        yield "holm"
    if (rows["claim"] == DECLARED).any() and rows["look"].max() > 0:
        yield "looks"
    if basis.contrasts["p_equivalence"].notna().any():
        yield "equivalence"
    energy = basis.fingerprint.energy
    if len(energy) and energy["p"].notna().any():
        yield "energy"


def _software(basis: Basis) -> Iterator[str]:
    made = dict.fromkeys(member.summary.foundry_version for member in basis.members if member.summary is not None)
    for place, version in enumerate(made):
        fields = {"title": "foundry", "author": "{The foundry developers}", "version": version}
        yield _entry("software", "foundry" if not place else f"foundry-{_slug(version)}", fields)


def _models(basis: Basis) -> Iterator[str]:
    served = [member for member in basis.members if is_served(member.folder.config()["model"])]
    for name, digests in _digests(served).items():
        note = f"Weights {', '.join(digests)}" if digests else "Digest of the weights unknown"
        yield _entry("misc", f"model-{_slug(name)}", {"title": f"{{{name.translate(_ESCAPED)}}}", "note": note})


def _entry(kind: str, key: str, fields: Mapping[str, str]) -> str:
    lines = [f"  {name} = {{{value}}}," for name, value in fields.items()]
    return "\n".join([f"@{kind}{{{key},", *lines, "}", ""])


def _slug(text: str) -> str:
    return re.sub(r"[^A-Za-z0-9.]+", "-", text).strip("-")
