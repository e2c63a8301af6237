"""The cards of the first screen: each has a finding as a sentence, a small plot of values, and an example moment."""

import difflib
import math
import re
from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from pathlib import Path

from markupsafe import Markup

from analysis.figures.shown import ShownGroup
from analysis.findings.finding_records import FindingRecord
from analysis.findings.moments import Moment
from analysis.load import measurable
from analysis.paper.gaps import short_names
from analysis.paper.sentence import equals_p
from analysis.report.grids import Cell
from analysis.report.material import Material
from analysis.report.provenance import link
from analysis.stats.factors import MODEL, find_factors, sides_of
from analysis.tables.texts import rounded
from foundry.palette import look
from foundry.texts import counted, one_line

MOST_CARDS = 3
"""Maximum number of findings on the first screen."""
MOST_ROWS = 10
"""Maximum number of groups in the small plot of a card."""
WIDTH, MARGIN = 160.0, 5.0
"""Width of the small plot of a card, and of the empty space at its left and right end, in units of the drawing."""
LONGEST = 230
"""Maximum number of characters of a reply on a card, which are three lines."""
_BEFORE = 60
"""Number of characters that a card shows before the first difference between two long replies."""
_TOKEN = re.compile(r"\s+|\w+|[^\w\s]")


@dataclass(frozen=True)
class Mark:
    """The name of a group, its marker as an SVG path, and its CSS colour."""

    name: str
    path: str
    paint: str


@dataclass(frozen=True)
class StripRow:
    """The values of one group in the small plot of a card, with positions in units of the drawing."""

    mark: Mark
    dots: tuple[float, ...]
    mean: float | None
    low: float | None
    high: float | None
    text: str


@dataclass(frozen=True)
class Reply:
    """A reply in an example moment: the model's name, a link to its run, and the text, cut into pieces.

    A piece is marked as True if it differs from the reply of the other model.
    """

    name: str
    run: Cell
    parts: tuple[tuple[str, bool], ...]


@dataclass(frozen=True)
class Card:
    """A finding on the first screen.

    Attributes:
        where: place of the example moment, or the reason why there is none.
        crop: picture of the agent's surroundings; "" if the form draws none.
        compared: address of the comparison of both runs in the viewer; "" if the viewer does not show both runs.
    """

    finding: FindingRecord
    test: str
    rows: tuple[StripRow, ...]
    more: int
    where: str
    replies: tuple[Reply, ...]
    crop: Markup = Markup("")
    compared: str = ""


def cards(material: Material, base: Path) -> list[Card]:
    """Return the cards of the first findings, if possible of different signatures and worlds."""
    chosen: list[FindingRecord] = []
    for is_new in (_of_another_context, _of_another_signature):
        for finding in material.analysis.findings:
            if len(chosen) < MOST_CARDS and is_new(finding, chosen):
                chosen.append(finding)
    chosen.sort(key=material.analysis.findings.index)
    return [_card(material, finding, base) for finding in chosen]


def _of_another_signature(finding: FindingRecord, chosen: Sequence[FindingRecord]) -> bool:
    signature = finding.measure.partition(".")[0]
    return all(signature != other.measure.partition(".")[0] for other in chosen)


def _of_another_context(finding: FindingRecord, chosen: Sequence[FindingRecord]) -> bool:
    others = (other.context for other in chosen)
    return _of_another_signature(finding, chosen) and (not finding.context or finding.context not in others)


def mark(shown: ShownGroup, name: str) -> Mark:
    """Return the name, the marker and the colour of a group."""
    group = look(shown.index, baseline=shown.baseline)
    marker = group.marker
    corners = "M" + "L".join(f"{x} {-y}" for x, y in marker) + "z" if marker else "M-1 0a1 1 0 1 0 2 0a1 1 0 1 0-2 0z"
    return Mark(name, corners, group.paint)


def _card(material: Material, finding: FindingRecord, base: Path) -> Card:
    rows = _strip(material, finding)
    moment = finding.moments[0] if finding.moments else None
    return Card(
        finding=finding,
        test=tested(finding),
        rows=tuple(rows[:MOST_ROWS]),
        more=max(0, len(rows) - MOST_ROWS),
        where=f"No example moment: {finding.no_moments}."
        if moment is None
        else f"seed {moment.seed}, step {moment.step}, agent {moment.agent}, both runs had {moment.asked}",
        replies=() if moment is None else _replies(material, finding, moment, base),
        crop=Markup("") if moment is None else _crop(material, moment),
        compared="" if moment is None else _compared(material, moment, base),
    )


def _compared(material: Material, moment: Moment, base: Path) -> str:
    runs = (moment.level_run, moment.reference_run)
    inside = {
        member.folder.id
        for member in material.members
        if member.folder.path.parent.resolve() == (base / "runs").resolve()
    }
    return f"{'/'.join(runs)}?step={moment.step}&agent={moment.agent}" if inside.issuperset(runs) else ""


def _crop(material: Material, moment: Moment) -> Markup:
    """Return a picture of the agent's surroundings in an example moment, in which both runs had the same prompt."""
    member = next(member for member in material.members if member.folder.id == moment.level_run)
    whole = measurable(member.folder, member.summary)
    if whole is None or whole.form.crop is None:
        return Markup("")
    return Markup(whole.form.crop(whole.run, moment.step, moment.agent))  # its texts are already escaped


def tested(finding: FindingRecord) -> str:
    """Return the test of a finding in words, such as `p = .02, corrected for 6 tests, declared`."""
    if finding.p is None:
        return f"{counted(finding.seeds, 'seed')}, not tested"
    return f"p{equals_p(finding.p)}, corrected for {counted(finding.family, 'test')}, {finding.claim}"


def _strip(material: Material, finding: FindingRecord) -> list[StripRow]:
    compared = material.analysis.compared
    factors = find_factors(compared.group_columns, [shown.group for shown in material.own])
    levels = [
        (shown, level)
        for shown in material.own
        for factor, level, context in sides_of(compared.group_columns, shown.group, factors)
        if (factor, context) == (finding.factor, finding.context)
        and (finding.measure, shown.group) in compared.estimates
    ]
    names = short_names(level for _, level in levels)
    return strip_rows(
        [mark(shown, _name(finding, level, names)) for shown, level in levels],
        [compared.values[shown.group][finding.measure].dropna().tolist() for shown, _ in levels],
        [
            (estimate.mean, estimate.low, estimate.high)
            for estimate in (compared.estimates[finding.measure, shown.group] for shown, _ in levels)
        ],
    )


def strip_rows(
    marks: Sequence[Mark], values: Sequence[Sequence[float]], means: Sequence[tuple[float, float, float]]
) -> list[StripRow]:
    """Return the rows of the small plot of a card, one row per group.

    Args:
        marks: name, marker and colour of each group.
        values: each group's values, one per seed.
        means: each group's mean, and both ends of its interval.
    """
    every = [
        *(value for own in values for value in own),
        *(end for own in means for end in own if not math.isnan(end)),
    ]
    least, most = min(every, default=0.0), max(every, default=0.0)

    def place(value: float) -> float | None:
        if math.isnan(value):
            return None
        share = 0.5 if most == least else (value - least) / (most - least)
        return round(MARGIN + share * (WIDTH - 2 * MARGIN), 1)

    numbers = rounded([number for own in means for number in own])
    return [
        StripRow(
            mark=looks,
            dots=tuple(at for value in own if (at := place(value)) is not None),
            mean=place(mean),
            low=place(low),
            high=place(high),
            text=numbers[3 * row] if math.isnan(low) else "{} [{}, {}]".format(*numbers[3 * row : 3 * row + 3]),
        )
        for row, (looks, own, (mean, low, high)) in enumerate(zip(marks, values, means, strict=True))
    ]


def _replies(material: Material, finding: FindingRecord, moment: Moment, base: Path) -> tuple[Reply, ...]:
    runs = {member.folder.id: member for member in material.members}
    texts = marked(moment.level_reply, moment.reference_reply)
    names = short_names((finding.level, finding.reference))
    whose = ((finding.level, moment.level_run), (finding.reference, moment.reference_run))
    return tuple(
        Reply(_name(finding, level, names), link(runs[run], base), parts)
        for (level, run), parts in zip(whose, texts, strict=True)
    )


def _name(finding: FindingRecord, level: str, names: Mapping[str, str]) -> str:
    return names[level] if finding.factor == MODEL else f"{finding.factor}={names[level]}"


def marked(first: str, second: str) -> tuple[tuple[tuple[str, bool], ...], ...]:
    """Cut two texts into pieces, and return each piece with True if it differs between the texts, else False.

    Long texts are cut around the first difference.
    """
    texts = [one_line(text) for text in (first, second)]
    alike = next((at for at, (a, b) in enumerate(zip(*texts, strict=False)) if a != b), min(map(len, texts)))
    start = alike - _BEFORE if alike > LONGEST // 2 and max(map(len, texts)) > LONGEST else 0
    tokens = [_TOKEN.findall(_cut(text, start)) for text in texts]
    steps = difflib.SequenceMatcher(None, tokens[0], tokens[1], autojunk=False).get_opcodes()
    sides: list[list[tuple[str, bool]]] = [[], []]
    for kind, *places in steps:
        for side, (begin, end) in enumerate((places[:2], places[2:])):
            text = "".join(tokens[side][begin:end])
            if text:
                sides[side].append((text, kind != "equal" or text.isspace()))
    return tuple(map(tuple, sides))


def _cut(text: str, start: int) -> str:
    start_of_text = text[start : start + LONGEST]
    return ("…" if start else "") + start_of_text + ("…" if start + LONGEST < len(text) else "") if text else "(empty)"
