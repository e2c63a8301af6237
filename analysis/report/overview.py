"""The first screen without its cards: a line of facts, warnings, the matrix of groups and measures, possible claims."""

from collections.abc import Callable, Sequence
from dataclasses import dataclass

from analysis.figures.members import Member
from analysis.findings.finding_records import FindingRecord
from analysis.findings.ranking import findings, measures_to_test
from analysis.findings.study_matrix import MatrixCell, MatrixColumn, MatrixRow
from analysis.paper.ending import nothing_claimed, tests_in
from analysis.paper.sentence import DIFFERENT, Row, kind_of
from analysis.paper.study import new_seeds, telling_apart
from analysis.paper.summary import EXPLORES, HELD_NOT
from analysis.prose import joined, percent
from analysis.report.cards import Mark, mark
from analysis.report.material import Material
from analysis.stats.contrasts import ALPHA
from analysis.stats.plan import DECLARED, EXPLORATORY
from foundry.texts import counted

UNREADABLE = 0.05
"""Share of unreadable decisions above which the first screen warns about a model."""
MOST_GROUPS = 24
"""Maximum number of rows of the matrix."""


def facts(material: Material) -> list[str]:
    """Return short texts for the first screen: compared groups, runs, cost, and whether claims were declared."""
    own = [member for member in material.members if not member.shown.baseline]
    compared, groups = material.analysis.compared, [shown.group for shown in material.own]
    levels = {compared.group_columns[at]: len({group[at] for group in groups}) for at in telling_apart(groups)}
    sides = [counted(count, name) for name, count in levels.items() if count > 1 or name == "model"]
    sides.append(counted(len({member.seed for member in own}), "seed"))
    worlds = list(dict.fromkeys(_world(member) for member in own))
    cost = _cost(own)
    return [
        " x ".join(sides) + (f" in {worlds[0]}" if len(worlds) == 1 else ""),
        f"{sum(member.complete for member in own)} of {len(own)} runs",
        f"{cost.calls:,} calls, {_short(cost.tokens)} tokens, {duration(cost.seconds)} of runs",
        *_standing(material, own),
    ]


def _standing(material: Material, own: Sequence[Member]) -> list[str]:
    """Return whether the claims were declared, with the numbers of seeds if only a part of the runs was declared."""
    claims, planned = set(material.analysis.contrasts["claim"]), material.analysis.planned
    if DECLARED not in claims or planned is None:
        return [DECLARED if DECLARED in claims else EXPLORATORY] if claims else []
    declared = {member.seed for member in own if member.folder.id in planned.declared.runs}
    others = {member.seed for member in own if member.folder.id not in planned.declared.runs}
    return [f"{counted(len(declared), 'seed')} declared, {len(others)} exploratory" if others else DECLARED]


def warnings(material: Material) -> list[str]:
    """Return warnings about a filter of the runs, and about models with many unreadable decisions."""
    said = [f"Only a part of the runs is analysed: {material.analysis.filtered}"] if material.analysis.filtered else []
    own = [member for member in material.members if not member.shown.baseline]
    several = len(set(map(_world, own))) > 1
    for model, members in _grouped(own, _model).items():
        shares = {
            world: unreadable / decisions
            for world, played in _grouped(members, _world).items()
            for decisions, unreadable in [_decisions(played)]
            if decisions and unreadable / decisions >= UNREADABLE
        }
        parts = [f"{percent(share)} in {world}" if several else percent(share) for world, share in shares.items()]
        said += [f"Unreadable decisions of {model}: {joined(parts)}"] if parts else []
    return said


@dataclass(frozen=True)
class _Cost:
    calls: int
    tokens: int
    seconds: float


def _cost(members: Sequence[Member]) -> _Cost:
    ends = [member.summary for member in members if member.summary is not None]
    tokens = sum(end.counts.prompt_tokens + end.counts.output_tokens for end in ends)
    return _Cost(sum(end.counts.calls for end in ends), tokens, sum(end.duration_s for end in ends))


def _decisions(members: Sequence[Member]) -> tuple[int, int]:
    return sum(member.decisions for member in members), sum(member.unreadable for member in members)


def _world(member: Member) -> str:
    return str(member.folder.config()["world"]["name"])


def _model(member: Member) -> str:
    return str(member.folder.config()["model"]["name"])


def _grouped(members: Sequence[Member], name_of: Callable[[Member], str]) -> dict[str, list[Member]]:
    groups: dict[str, list[Member]] = {}
    for member in members:
        groups.setdefault(name_of(member), []).append(member)
    return groups


def _short(count: int) -> str:
    if count >= 1_000_000:
        return f"{count / 1_000_000:.1f} M"
    return f"{count / 1000:.0f} k" if count >= 10_000 else f"{count:,}"


def duration(seconds: float) -> str:
    """Return a duration as text, in hours, minutes or seconds."""
    if seconds >= 3600:
        return f"{seconds / 3600:.1f} h"
    return f"{seconds / 60:.0f} min" if seconds >= 90 else f"{seconds:.0f} s"


@dataclass(frozen=True)
class Matrix:
    """The matrix of groups and measures on the first screen.

    Attributes:
        rows: for each group its name and look, its measures, and its readability and cost.
    """

    caption: str
    columns: tuple[MatrixColumn, ...]
    rows: tuple[tuple[Mark, tuple[MatrixCell, ...], tuple[str, ...]], ...]
    more: int


def matrix(material: Material) -> Matrix:
    """Return the matrix of models and worlds, with the readable share and the cost of each row."""
    made = material.analysis.matrix
    known = {shown.group: shown for shown in material.own}
    heads = ("readable actions", "calls", "tokens", "time")
    return Matrix(
        caption=made.caption,
        columns=(*made.columns, *map(MatrixColumn, heads)),
        rows=tuple(
            (mark(known[row.groups[0]], row.name), row.cells, _took(material, row)) for row in made.rows[:MOST_GROUPS]
        ),
        more=max(0, len(made.rows) - MOST_GROUPS),
    )


def _took(material: Material, row: MatrixRow) -> tuple[str, ...]:
    mine = [member for member in material.members if member.shown.group in row.groups and not member.shown.baseline]
    decisions, unreadable = _decisions(mine)
    cost = _cost(mine)
    readable = percent(1 - unreadable / decisions) if decisions else "not counted"
    return readable, f"{cost.calls:,}", _short(cost.tokens), duration(cost.seconds)


@dataclass(frozen=True)
class Claims:
    """The possible claims; also a command that tests more, with its cost, or "" if there is none."""

    sentence: str
    command: str
    cost: str


def claims(material: Material) -> Claims:
    """Return the possible claims about the declared measures."""
    contrasts = material.analysis.contrasts
    rows = contrasts[contrasts["headline"].astype(bool)].to_dict("records")
    sentence = claimed(rows, material.analysis.findings, planned=material.analysis.planned is not None)
    measures = measures_to_test(findings(rows))
    if not measures or any(finding.stands for finding in material.analysis.findings):
        return Claims(sentence, "", "")
    pairs = len({(row["level"], row["reference"], row["context"]) for row in rows})
    own = [member for member in material.members if not member.shown.baseline]
    seeds = {member.seed for member in own}
    share = new_seeds(len(seeds), pairs, ALPHA) / len(seeds)
    cost = _cost(own)
    takes = f"about {round(share * cost.calls):,} calls, {duration(share * cost.seconds)} of runs"
    return Claims(
        sentence, material.analysis.on_new_seeds([sweep.path for sweep in material.sweeps], measures, pairs), takes
    )


def claimed(rows: Sequence[Row], findings: Sequence[FindingRecord], *, planned: bool) -> str:
    """Return a sentence that says which claims are possible, from the declared comparisons and their findings."""
    if not rows:
        return "No groups are compared, so nothing can be claimed."
    different = sum(kind_of(row) == DIFFERENT for row in rows)
    standing = sum(finding.stands for finding in findings)
    if standing:
        return f"You can claim {counted(standing, 'finding')}: declared before the runs, and significant."
    if not different:
        return nothing_claimed(rows)
    said = f"{different} of {counted(tests_in(rows), 'test')} show{'s' * (different == 1)} a difference."
    return f"{said} {HELD_NOT if planned else EXPLORES} To make a claim, declare these measures and run new seeds:"
