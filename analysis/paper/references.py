"""BibTeX of what an analysis used: foundry, the models, the sources of worlds, the tests that were made."""

from __future__ import annotations

import re
from collections.abc import Iterator, Mapping
from functools import cache
from pathlib import Path

import msgspec
import yaml

from analysis.paper.basis import Basis
from analysis.stats.plan import DECLARED
from foundry.storing.store import is_served

_ESCAPED = str.maketrans({letter: f"\\{letter}" for letter in "&%$#_{}"} | {"\\": "", "~": "", "^": ""})


class Source(msgspec.Struct, frozen=True, forbid_unknown_fields=True):
    """A work, and what it is the source of.

    Attributes:
        key: of its entry.
        of: the parts of an analysis of which any makes it one to cite: `world NAME`, or what `_used` yields.
        kind: of its entry.
        fields: of its entry.
    """

    key: str
    of: tuple[str, ...]
    kind: str
    fields: Mapping[str, str]


def bibtex(found: Basis) -> str:
    """Return the entries, foundry first."""
    used = set(_used(found))
    works = [_entry(one.kind, one.key, one.fields) for one in _known() if used & set(one.of)]
    return "\n".join([*_software(found), *_models(found), *works])


@cache
def _known() -> tuple[Source, ...]:
    """Return every work that may be cited, read once."""
    file = Path(__file__).with_name("references.yaml")
    return msgspec.convert(yaml.safe_load(file.read_text("utf-8")), tuple[Source, ...])


def _used(found: Basis) -> Iterator[str]:
    """Yield the parts of the analysis that have sources."""
    for member in found.members:
        config = member.folder.config()
        yield f"world {config['world']['name']}"
        yield f"prompt {config['prompt']['name']}"
    rows = found.contrasts[found.contrasts["headline"].astype(bool)]
    yield from rows["test"].astype(str)
    yield from found.comparison["interval"].astype(str)
    yield from rows["interval"].astype(str)
    if rows["p_adjusted"].notna().any():
        yield "max-t"
        yield "holm"
    if (rows["claim"] == DECLARED).any() and rows["look"].max() > 0:
        yield "looks"
    if found.contrasts["p_equivalence"].notna().any():
        yield "equivalence"
    energy = found.fingerprint.energy
    if len(energy) and energy["p"].notna().any():
        yield "energy"


def _software(found: Basis) -> Iterator[str]:
    made = dict.fromkeys(one.summary.foundry_version for one in found.members if one.summary is not None)
    for place, version in enumerate(made):
        fields = {"title": "foundry", "author": "{The foundry developers}", "version": version}
        yield _entry("software", "foundry" if not place else f"foundry-{_slug(version)}", fields)


def _models(found: Basis) -> Iterator[str]:
    """Yield an entry for each served model, with the digests of its weights."""
    digests: dict[str, dict[str, None]] = {}
    for member in found.members:
        config = member.folder.config()["model"]
        if is_served(config):
            mine = digests.setdefault(str(config["name"]), {})
            if member.summary is not None and member.summary.model_digest:
                mine[member.summary.model_digest] = None
    for name, mine in digests.items():
        note = f"Weights {', '.join(mine)}" if mine else "Weights not known by a digest"
        yield _entry("misc", f"model-{_slug(name)}", {"title": f"{{{name.translate(_ESCAPED)}}}", "note": note})


def _entry(kind: str, key: str, fields: Mapping[str, str]) -> str:
    lines = [f"  {name} = {{{value}}}," for name, value in fields.items()]
    return "\n".join([f"@{kind}{{{key},", *lines, "}", ""])


def _slug(text: str) -> str:
    return re.sub(r"[^A-Za-z0-9.]+", "-", text).strip("-")
