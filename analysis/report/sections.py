"""The parts of the page that show results: tables, pictures, and a section for every signature."""

import base64
from collections.abc import Mapping, Sequence
from dataclasses import dataclass, replace
from pathlib import Path

import numpy as np
import pandas as pd
from markupsafe import Markup

from analysis.figures import pictures
from analysis.plots import Drawn, Picture, draw, write
from analysis.report.definitions import Definition, definitions
from analysis.report.grids import Cell, Grid, grid, grid_of
from analysis.report.material import Material
from analysis.report.provenance import address, link
from analysis.signatures import READABLE_SUFFIX, Signature, discover, is_readable_only
from analysis.tables.texts import COMPARED, alike, contrast_tables, mean_cells, p_value, shown_measures, told_rows

MOST_COLUMNS = 4
"""Maximum number of measures in the short table of a signature."""

MOST_FIGURES, MOST_OF_WORLDS = 9, 6
"""Maximum number of pictures on a page, and of those among them that forms draw."""

DENSE = 120_000
"""Number of characters of SVG from which a picture is shown as PNG, if PNG is smaller."""
_ROUNDING = 1e-9
"""Difference below which values count as equal."""


@dataclass(frozen=True)
class Shape:
    """A picture on the page: `svg`, or `source` of a PNG if it is dense; `says` is the text alternative.

    `links` lead to its files; `name` is the name of the files.
    """

    name: str
    title: str
    caption: str
    says: str
    svg: Markup
    source: str
    links: tuple[Cell, ...] = ()


@dataclass(frozen=True)
class Section:
    """The section of one signature.

    Attributes:
        name: name of the signature.
        declared: whether one of its measures is declared.
        definitions: definitions of its measures.
        headline: mean and interval of its headline measures; None without any.
        shapes: the picture of its means, if any.
        means: mean and interval of every measure and group.
    """

    name: str
    declared: bool
    definitions: tuple[Definition, ...]
    headline: Grid | None
    shapes: tuple[Shape, ...]
    means: Grid


@dataclass(frozen=True)
class Gallery:
    """Draws pictures, and writes them into a folder; a page in `base` links to the files."""

    folder: Path
    base: Path

    def shapes(self, wanted: Sequence[Picture | None]) -> tuple[Shape, ...]:
        """Return existing pictures for the page."""
        return tuple(self._shape(picture) for picture in wanted if picture is not None)

    def _shape(self, picture: Picture) -> Shape:
        drawn = draw(picture, "svg")
        if len(drawn.svg) > DENSE:
            drawn = draw(picture, "svg", "png")
        texts = {".svg": "SVG", ".csv": "data"}
        files = [file for file in write(drawn, self.folder) if file.suffix in texts]
        return replace(shape(drawn), links=tuple(Cell(texts[file.suffix], address(file, self.base)) for file in files))


def shape(drawn: Drawn) -> Shape:
    """Return a picture for the page."""
    source = f"data:image/png;base64,{base64.b64encode(drawn.png).decode()}"
    dense = bool(drawn.png) and len(drawn.svg) > max(DENSE, len(source))
    picture = drawn.picture
    # The text of the SVG is already escaped.
    svg = Markup("" if dense else drawn.svg)
    return Shape(picture.name, picture.title, picture.caption, _said(picture), svg, source if dense else "")


def _said(picture: Picture) -> str:
    return " ".join(filter(None, (f"{picture.title}.", picture.caption, picture.says)))


@dataclass(frozen=True)
class Pictures:
    """The pictures of a page, at most MOST_FIGURES: of whole groups, of worlds, and by signature."""

    fingerprint: tuple[Shape, ...]
    world: tuple[Shape, ...]
    means: Mapping[str, Shape]


def drawn(found: Material, gallery: Gallery) -> Pictures:
    """Draw the pictures of a page; pictures of signatures with the largest gaps fill the remaining room."""
    fingerprint = gallery.shapes([pictures.fingerprint_picture(found.analysis.fingerprint)])
    world = gallery.shapes(found.examples.pictures[:MOST_OF_WORLDS])
    headline = found.analysis.compared.headlines
    ranked = [finding.measure.partition(".")[0] for finding in found.analysis.findings]
    room = MOST_FIGURES - len(fingerprint) - len(world)
    names = [name for name in dict.fromkeys(ranked) if name in headline][:room]
    means = [
        pictures.means_picture(found.analysis.compared, found.shown, name, found.analysis.validation) for name in names
    ]
    return Pictures(fingerprint, world, dict(zip(names, gallery.shapes(means), strict=False)))


def signature_sections(found: Material, means: Mapping[str, Shape]) -> list[Section]:
    """Return a section for every signature of any run, declared signatures first.

    Args:
        found: content of the page.
        means: picture of the means by signature, if drawn.
    """
    columns = [(signature, _columns(found.analysis.runs, signature.name)) for signature in discover()]
    every = [_section(found, means, signature, kept) for signature, kept in columns if kept]
    return sorted(every, key=lambda section: not section.declared)


def _columns(runs: pd.DataFrame, signature: str) -> list[str]:
    """Return the measures of a signature; measures over readable decisions are included only if they differ."""
    every = [str(name) for name in runs.columns if str(name).startswith(f"{signature}.")]
    return [name for name in every if not is_readable_only(name) or _differs(runs, name)]


def _differs(runs: pd.DataFrame, name: str) -> bool:
    whole = name.removesuffix(READABLE_SUFFIX)
    if whole not in runs:
        return True
    one, other = (runs[column].to_numpy(dtype=np.float64) for column in (name, whole))
    return not np.allclose(one, other, rtol=0, atol=_ROUNDING, equal_nan=True)


def _section(found: Material, means: Mapping[str, Shape], signature: Signature, columns: Sequence[str]) -> Section:
    compared, name = found.analysis.compared, signature.name
    headline = compared.headlines.get(name, [])
    return Section(
        name=name,
        declared=any(measure.startswith(f"{name}.") for measure in found.analysis.declared),
        definitions=tuple(definitions(signature, found.forms)),
        headline=_headline(found, headline, name) if headline else None,
        shapes=(means[name],) if name in means else (),
        means=_means(found, columns, name),
    )


def _headline(found: Material, measures: Sequence[str], name: str) -> Grid:
    """Return the first headline measures of the groups, with equal decimals per column."""
    shown = measures[:MOST_COLUMNS]
    more = f"; {len(measures) - len(shown)} further measures are folded below" if len(shown) < len(measures) else ""
    caption = f"{name}: mean over seeds with its 95 % interval{more}."
    return _by_group(found, shown, [measure.partition(".")[2] for measure in shown], caption)


def _by_group(found: Material, measures: Sequence[str], heads: Sequence[str], caption: str) -> Grid:
    """Return measures of the groups, one per column, with equal decimals per column."""
    compared = found.analysis.compared
    seeds = [len(compared.values[one.group]) for one in found.shown]
    columns = [mean_cells([compared.estimates.get((one, of.group)) for of in found.shown], seeds) for one in measures]
    labels = [one.label + (" (baseline)" if one.baseline else "") for one in found.shown]
    return grid(caption, ("group", *heads), list(zip(labels, *columns, strict=True)))


def comparison_grid(found: Material) -> Grid:
    """Return the headline measures of the groups."""
    measures = shown_measures(found.analysis.compared)
    return _by_group(found, measures, measures, COMPARED)


def contrast_grids(found: Material) -> list[Grid]:
    """Return the differences of the declared family, one table per measure."""
    return [grid_of(table) for table in contrast_tables(found.analysis.contrasts)]


def _means(found: Material, columns: Sequence[str], name: str) -> Grid:
    heads = [f"{column.partition('.')[2]}: {found.analysis.compared.describe(column).label}" for column in columns]
    caption = f"All measures of {name}: mean over seeds with its 95 % interval; n is given if some seeds have no value."
    return _by_group(found, columns, heads, caption)


def values_grid(found: Material, base: Path) -> Grid:
    """Return the declared measures of every complete run, with equal decimals per column."""
    columns = [name for name in found.analysis.declared if name in found.analysis.runs]
    kept = [index for index, member in enumerate(found.members) if member.complete]
    values = found.analysis.runs[columns].to_numpy(dtype=np.float64)[kept]
    members = [found.members[index] for index in kept]
    names = [[link(one, base) for one in members], [one.shown.label for one in members], [one.seed for one in members]]
    cells = [*names, *(alike(column.tolist()) for column in values.T)]
    caption = "The declared measures of every complete run; signatures.csv has all other measures."
    return grid(caption, ("run", "group", "seed", *columns), list(zip(*cells, strict=True)), labels=2)


def variance_grid(found: Material) -> Grid | None:
    """Return the components of variation of the headline measures; None if nothing varies."""
    headline = [name for names in found.analysis.compared.headlines.values() for name in names]
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
    caption = "Share of the variation between runs by setting and by seed (random effects)."
    return grid(caption, ("measure", *components), cells)


def energy_grid(found: Material) -> Grid | None:
    """Return the differences between whole groups; None if nothing is compared."""
    rows = told_rows(found.analysis.fingerprint.energy, ("statistic",))
    if not rows:
        return None
    cells = [
        (
            row["level"],
            row["reference"],
            str(row["n_seeds"]),
            row["statistic"],
            p_value(float(row["p_holm"])) if not row["note"] else row["note"],
        )
        for row in rows
    ]
    caption = "Energy distance between groups over all standardised headline measures; p after Holm's correction."
    return grid(caption, ("first", "second", "seeds", "distance", "p (Holm)"), cells, labels=2)


def retest_grid(found: Material) -> Grid | None:
    """Return the consistency of models' answers to equal prompts; None if nothing was sampled again."""
    frame = found.analysis.retest
    if not len(frame):
        return None
    columns = [alike(frame[name].tolist()) if frame[name].dtype.kind == "f" else frame[name] for name in frame.columns]
    rows = list(zip(*columns, strict=True))
    caption = "Test-retest consistency: equal prompts with different sampling seeds."
    return grid(caption, [str(name) for name in frame.columns], rows)


def run_grids(found: Material, base: Path) -> list[tuple[str, Grid]]:
    """Return the forms' tables of single runs, with titles; the runs are links."""
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
