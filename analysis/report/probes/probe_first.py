"""The first screen of a probe's page: facts, cards, the matrix of models and edits, possible claims."""

from collections.abc import Mapping, Sequence
from typing import Any

import pandas as pd

from analysis.figures.shown import ShownGroup
from analysis.findings.finding_records import FindingRecord
from analysis.findings.ranking import findings, measures_to_test
from analysis.findings.study_matrix import MatrixCell, MatrixColumn
from analysis.paper.gaps import short_names
from analysis.paper.sentence import Row
from analysis.probes import ProbeAnalysis
from analysis.probes.choices import NONE, MomentKey
from analysis.probes.differences import FORMAT, unread_of
from analysis.prose import percent
from analysis.report.cards import MOST_CARDS, MOST_ROWS, WIDTH, Card, Mark, Reply, mark, marked, strip_rows, tested
from analysis.report.grids import Cell
from analysis.report.overview import UNREADABLE, Claims, Matrix, claimed
from analysis.report.probes.probe_moments import MomentSource
from analysis.stats.factors import MODEL
from analysis.tables.texts import with_intervals
from foundry.storing.store import SweepFolder

_MOMENT = list(MomentKey._fields)
_CAPTION = (
    "Distance between the choices of two models, or of one model with and without an edit: from 0 to 1, minus the "
    "distance that chance alone gives. Mean over seeds [90 % interval]. Bold: significant after correction."
)


def first_screen(folder: SweepFolder, analysis: ProbeAnalysis, looked: MomentSource) -> dict[str, Any]:
    """Return the content of the first screen, by name in the template."""
    rows = analysis.contrasts.to_dict("records")
    marks = _marks(analysis.frames["moments"])
    claim = sorted(set(analysis.contrasts["claim"]))
    return {
        "facts": [*analysis.study.split(": "), f"{len(folder.runs())} runs", *claim[:1]],
        "warnings": _warnings(analysis),
        "cards": [_card(analysis, finding, marks, looked) for finding in analysis.findings[:MOST_CARDS]],
        "width": WIDTH,
        "overview": _matrix(analysis, rows, marks),
        "claims": _claims(folder, analysis, rows),
    }


def _marks(moments: pd.DataFrame) -> dict[str, Mark]:
    names = short_names(dict.fromkeys(moments["model"]))
    return {
        model: mark(ShownGroup((model,), place, baseline=False), name)
        for place, (model, name) in enumerate(names.items())
    }


def _warnings(analysis: ProbeAnalysis) -> list[str]:
    sums = unread_of(analysis.frames["moments"]).groupby(level="model", sort=False).sum()
    shares = (sums["unread"] / sums["answers"]).to_dict()
    part = [f"Only a part of the answers is analysed: {analysis.filtered}"] if analysis.filtered else []
    return part + [
        f"Unreadable decisions of {model}: {percent(share)}" for model, share in shares.items() if share >= UNREADABLE
    ]


def _matrix(analysis: ProbeAnalysis, rows: Sequence[Row], marks: Mapping[str, Mark]) -> Matrix:
    """Return a row per model, with a column per edit and, if several models were asked, a column per model."""
    compared = [row for row in rows if row["factor"] != FORMAT]
    texts = with_intervals([(row["difference"], row["low"], row["high"]) for row in compared])
    cells: dict[tuple[str, str], MatrixCell] = {}
    for row, text in zip(compared, texts, strict=True):
        cell = MatrixCell(text, end="greatest" if row["significant"] else "")
        if row["factor"] == MODEL:
            cells |= {(row["level"], row["reference"]): cell, (row["reference"], row["level"]): cell}
        else:
            cells[row["context"].removeprefix(f"{MODEL}="), row["level"]] = cell
    edits = list(dict.fromkeys(analysis.frames["edits"]["edit"]))
    columns = [*edits, *(marks if len(marks) > 1 else ())]
    heads = [MatrixColumn(f"from {marks[column].name}" if column in marks else column) for column in columns]
    sums = unread_of(analysis.frames["moments"]).groupby(level="model", sort=False).sum()
    return Matrix(
        caption=_CAPTION,
        columns=(*heads, MatrixColumn("readable"), MatrixColumn("answers")),
        rows=tuple(
            (
                looks,
                tuple(
                    cells.get((model, column), MatrixCell("itself" if column == model else "not declared"))
                    for column in columns
                ),
                (percent(1 - sums["unread"][model] / sums["answers"][model]), f"{sums['answers'][model]:,}"),
            )
            for model, looks in marks.items()
        ),
        more=0,
    )


def _claims(folder: SweepFolder, analysis: ProbeAnalysis, rows: Sequence[Row]) -> Claims:
    sentence = claimed(rows, analysis.findings, planned=analysis.planned)
    measures = measures_to_test(findings([row for row in rows if row["difference"] > 0]))
    command = analysis.in_other_moments(folder.path, measures) if measures else ""
    if not command or any(finding.stands for finding in analysis.findings):
        return Claims(sentence, "", "")
    return Claims(sentence, command, f"about {int(analysis.frames['moments']['count'].sum()):,} answers")


def _card(analysis: ProbeAnalysis, finding: FindingRecord, marks: Mapping[str, Mark], looked: MomentSource) -> Card:
    strip = [
        row
        for row in analysis.contrasts.to_dict("records")
        if row["factor"] == finding.factor and (finding.factor == MODEL or row["measure"] == finding.measure)
    ]
    means = [(row["difference"], row["low"], row["high"]) for row in strip]
    rows = strip_rows([_mark(row, marks) for row in strip], [[] for _ in strip], means)
    where, replies = _example(analysis.frames["moments"], finding, marks, looked)
    return Card(finding, tested(finding), tuple(rows[:MOST_ROWS]), max(0, len(rows) - MOST_ROWS), where, replies)


def _mark(row: Row, marks: Mapping[str, Mark]) -> Mark:
    """Return the name and the marker of a row; a pair of models has the marker of its first model."""
    if row["factor"] != MODEL:
        return marks[row["context"].removeprefix(f"{MODEL}=")]
    first, second = marks[row["level"]], marks[row["reference"]]
    return Mark(f"{first.name} - {second.name}", first.path, first.paint)


def _example(
    moments: pd.DataFrame, finding: FindingRecord, marks: Mapping[str, Mark], looked: MomentSource
) -> tuple[str, tuple[Reply, ...]]:
    """Return in words the moment in which a finding's difference is largest, and one reply of each side."""
    if finding.factor == FORMAT:
        return "No example moment: prompt formats are compared over all moments.", ()
    if finding.factor == MODEL:
        sides = [(finding.level, NONE), (finding.reference, NONE)]
        names = [marks[model].name for model, _ in sides]
    else:
        model = finding.context.removeprefix(f"{MODEL}=")
        sides, names = [(model, NONE), (model, finding.level)], ["unedited", finding.level]
    asked = moments[moments["format"] == NONE]
    first, second = (_shares(asked[(asked["model"] == model) & (asked["edit"] == edit)]) for model, edit in sides)
    first, second = first.align(second, join="outer", axis=1, fill_value=0.0)
    apart = (first - second).abs().sum(axis=1).dropna()
    place = int(apart.to_numpy().argmax())
    key = MomentKey(*apart.index[place])
    choices = [str(shares.loc[apart.index[place]].idxmax()) for shares in (first, second)]
    replies = _replies(looked, key, sides, choices)
    where = f"seed {key.seed}, step {key.step}, agent {key.agent}, {key.kind}"
    parts = marked(*replies)
    return where, tuple(Reply(name, Cell(""), part) for name, part in zip(names, parts, strict=True))


def _shares(rows: pd.DataFrame) -> pd.DataFrame:
    return rows.pivot_table(index=_MOMENT, columns="choice", values="share", fill_value=0.0)


def _replies(
    looked: MomentSource, key: MomentKey, sides: Sequence[tuple[str, str]], choices: Sequence[str]
) -> tuple[str, str]:
    """Return one reply of each side in a moment, if possible a reply with the choice most typical of the side."""
    models, edits = list(looked.models.values()), [edit.name for edit in looked.edits]
    answers = {
        (models[answer.model], edits[answer.edit]): answer.replies
        for answer in looked.seen(looked.place(*key[1:])).answers
        if answer.format == 0
    }
    first, second = (
        next(
            (answer.text or "" for answer in sorted(answers.get(side, ()), key=lambda answer: answer.choice != choice)),
            "",
        )
        for side, choice in zip(sides, choices, strict=True)
    )
    return first, second
