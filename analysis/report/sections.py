"""The parts of the page that hold results: tables, pictures, and a section for every signature."""

from __future__ import annotations

import base64
from collections.abc import Sequence
from dataclasses import dataclass
from pathlib import Path

import numpy as np
import pandas as pd
from markupsafe import Markup

from analysis.figures import pictures
from analysis.plots import Drawn, Picture, draw, write
from analysis.report.definitions import Definition, definitions
from analysis.report.grids import Cell, Grid, grid
from analysis.report.material import Material
from analysis.report.provenance import link
from analysis.signatures import READABLE_SUFFIX, Signature, describe, discover, is_readable_only
from analysis.tables.texts import mean_cell, number, p_value

DENSE = 120_000
"""Characters of SVG from which a picture is shown as PNG, if that is smaller."""


@dataclass(frozen=True)
class Shape:
    """A picture on the page: `svg`, or `source` of a dense one."""

    title: str
    caption: str
    svg: Markup
    source: str


@dataclass(frozen=True)
class Section:
    """What is shown of one signature.

    Attributes:
        name: of the signature.
        definitions: how it is measured.
        means: mean and interval of every measure and group.
        shapes: its pictures.
        values: every measure of every run.
    """

    name: str
    definitions: tuple[Definition, ...]
    means: Grid
    shapes: tuple[Shape, ...]
    values: Grid


@dataclass(frozen=True)
class Gallery:
    """Draws pictures, and writes them into a folder."""

    folder: Path

    def shapes(self, wanted: Sequence[Picture | None]) -> tuple[Shape, ...]:
        """Return pictures for the page, those that there are."""
        return tuple(self._shape(picture) for picture in wanted if picture is not None)

    def _shape(self, picture: Picture) -> Shape:
        drawn = draw(picture)
        write(drawn, self.folder)
        return shape(drawn)


def shape(drawn: Drawn) -> Shape:
    """Return a picture for the page."""
    source = f"data:image/png;base64,{base64.b64encode(drawn.png).decode()}"
    dense = len(drawn.svg) > max(DENSE, len(source))
    # The text of the SVG was escaped when it was drawn.
    return Shape(
        drawn.picture.title, drawn.picture.caption, Markup("" if dense else drawn.svg), source if dense else ""
    )


def signature_sections(found: Material, gallery: Gallery, base: Path) -> list[Section]:
    """Return a section for every signature that any run has."""
    columns = [(signature, _columns(found.analysis.runs, signature.name)) for signature in discover()]
    return [_section(found, gallery, base, signature, kept) for signature, kept in columns if kept]


def _columns(runs: pd.DataFrame, signature: str) -> list[str]:
    """Return the measures of a signature; those over readable decisions alone only where they differ."""
    every = [str(name) for name in runs.columns if str(name).startswith(f"{signature}.")]
    return [name for name in every if not is_readable_only(name) or _differs(runs, name)]


def _differs(runs: pd.DataFrame, name: str) -> bool:
    whole = name.removesuffix(READABLE_SUFFIX)
    if whole not in runs:
        return True
    one, other = (runs[column].to_numpy(dtype=np.float64) for column in (name, whole))
    return not np.array_equal(one, other, equal_nan=True)


def _section(found: Material, gallery: Gallery, base: Path, signature: Signature, columns: Sequence[str]) -> Section:
    compared, name = found.analysis.compared, signature.name
    wanted: list[Picture | None] = []
    if name in pictures.headlines(compared):
        wanted = [
            pictures.means_picture(compared, found.shown, name),
            pictures.forest_picture(found.analysis.contrasts, compared, found.shown, name),
            pictures.slopes_picture(compared, found.shown, name),
        ]
    return Section(
        name=name,
        definitions=tuple(definitions(signature, found.forms)),
        means=_means(found, columns, name),
        shapes=gallery.shapes(wanted),
        values=_values(found, columns, name, base),
    )


def _means(found: Material, columns: Sequence[str], name: str) -> Grid:
    compared = found.analysis.compared
    seeds = {group: len(values) for group, values in compared.values.items()}
    rows = [
        (
            column.partition(".")[2],
            describe(column).label,
            *(mean_cell(compared.estimates.get((column, one.group)), seeds[one.group]) for one in found.shown),
        )
        for column in columns
    ]
    labels = [one.label + (" (baseline)" if one.baseline else "") for one in found.shown]
    caption = f"{name}: mean over seeds with its 95 % interval; n where not every seed has a value."
    return grid(caption, ("measure", "meaning", *labels), rows, labels=2)


def _values(found: Material, columns: Sequence[str], name: str, base: Path) -> Grid:
    values = found.analysis.runs[list(columns)].to_numpy(dtype=np.float64)
    rows: list[tuple[Cell | str, ...]] = [
        (link(member, base), member.shown.label, str(member.seed), *(number(value) for value in row))
        for member, row in zip(found.members, values.tolist(), strict=True)
        if member.complete
    ]
    heads = ("run", "group", "seed", *(column.partition(".")[2] for column in columns))
    return grid(f"{name}: the value of every complete run.", heads, rows, labels=2)


def variance_grid(found: Material) -> Grid | None:
    """Return how the variation of the headline measures splits up; None where there is nothing to split."""
    headline = [name for names in pictures.headlines(found.analysis.compared).values() for name in names]
    rows = found.analysis.variance[found.analysis.variance["measure"].isin(headline)]
    components = list(dict.fromkeys(rows["component"]))
    if len(components) < 3 or rows["share"].isna().all():
        return None
    shares = rows.pivot(index="measure", columns="component", values="share").reindex(headline)[components]
    cells = [
        (str(measure), *("-" if np.isnan(share) else f"{100 * share:.3g} %" for share in row))
        for measure, row in zip(shares.index, shares.to_numpy(dtype=np.float64).tolist(), strict=True)
        if not np.isnan(row).all()
    ]
    caption = "Share of the variation between runs that goes with each setting and with the seed (random effects)."
    return grid(caption, ("measure", *components), cells)


def energy_grid(found: Material) -> Grid | None:
    """Return which groups differ as a whole; None where nothing is compared."""
    rows = found.analysis.fingerprint.energy.to_dict("records")
    if not rows:
        return None
    cells = [
        (
            row["level"],
            row["reference"],
            str(row["n_seeds"]),
            number(float(row["statistic"])),
            p_value(float(row["p_holm"])) if not row["note"] else row["note"],
        )
        for row in rows
    ]
    caption = "Energy distance between groups over all standardised headline measures; p after Holm's correction."
    return grid(caption, ("first", "second", "seeds", "distance", "p (Holm)"), cells, labels=2)


def retest_grid(found: Material) -> Grid | None:
    """Return how alike models answer one prompt again; None where nothing was sampled again."""
    frame = found.analysis.retest
    if not len(frame):
        return None
    rows = [
        [number(value) if isinstance(value, float) else str(value) for value in row]
        for row in frame.itertuples(index=False, name=None)
    ]
    caption = "Test-retest consistency: equal prompts, other sampling seeds."
    return grid(caption, [str(name) for name in frame.columns], rows)


def run_grids(found: Material, base: Path) -> list[tuple[str, Grid]]:
    """Return what the forms of the runs show of single ones besides pictures, with titles; the runs are links."""
    by_run = {member.folder.id: member for member in found.members}
    return [
        (
            one.title,
            grid(
                one.caption,
                one.columns,
                [(link(by_run[run], base), *cells) for run, *cells in one.rows],
                labels=one.labels,
            ),
        )
        for one in found.examples.tables
    ]
