"""Builds the parts of the page that show results: tables, pictures, and a section for every signature."""

import base64
from collections.abc import Iterable, Sequence
from dataclasses import dataclass, replace
from pathlib import Path

import numpy as np
import pandas as pd
from markupsafe import Markup

from analysis.plots import DrawnPicture, Picture, draw, write
from analysis.report.definitions import Definition, definitions
from analysis.report.grids import Cell, Grid, grid, grid_of
from analysis.report.material import Material
from analysis.report.provenance import address, link
from analysis.signatures import READABLE_SUFFIX, Signature, discover, is_readable_only
from analysis.tables.texts import COMPARED, alike, contrast_tables, mean_cells, p_value, shown_measures, text_rows

MOST_COLUMNS = 4
"""Maximum number of measures in the short table of a signature."""
MOST_OF_WORLDS = 6
"""Maximum number of pictures that show the world, such as maps."""
DENSE = 120_000
"""Number of characters above which an SVG is replaced by a PNG, if the PNG is smaller."""
_ROUNDING = 1e-9
"""Difference below which values count as equal."""


@dataclass(frozen=True)
class Shape:
    """A picture on the page.

    Attributes:
        name: name of its files, without a suffix.
        says: description of the picture for readers who cannot see it.
        source: the PNG as a data URL, or "".
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
        declared: whether one of its measures is declared.
        headline: mean and interval of its headline measures; None if it has none.
    """

    name: str
    declared: bool
    definitions: tuple[Definition, ...]
    headline: Grid | None
    means: Grid


def shapes(pictures: Iterable[Picture], folder: Path, base: Path) -> tuple[Shape, ...]:
    """Draw pictures, write them into a folder, and return them for a page in the folder `base`."""
    return tuple(_shape(picture, folder, base) for picture in pictures)


def _shape(picture: Picture, folder: Path, base: Path) -> Shape:
    drawn = draw(picture, "svg", dense=DENSE)
    texts = {".svg": "SVG", ".csv": "data"}
    files = [file for file in write(drawn, folder) if file.suffix in texts]
    return replace(shape(drawn), links=tuple(Cell(texts[file.suffix], address(file, base)) for file in files))


def shape(drawn: DrawnPicture) -> Shape:
    """Return a drawn picture for the page, without links."""
    source = f"data:image/png;base64,{base64.b64encode(drawn.png).decode()}"
    dense = bool(drawn.png) and len(drawn.svg) > max(DENSE, len(source))
    picture = drawn.picture
    says = " ".join(filter(None, (f"{picture.title}.", picture.caption, picture.says)))
    svg = Markup("" if dense else drawn.svg)  # its texts are already escaped
    return Shape(picture.name, picture.title, picture.caption, says, svg, source if dense else "")


def signature_sections(material: Material) -> list[Section]:
    """Return a section for every signature that any run has, declared signatures first."""
    columns = [(signature, _columns(material.analysis.runs, signature.name)) for signature in discover()]
    every = [_section(material, signature, measures) for signature, measures in columns if measures]
    return sorted(every, key=lambda section: not section.declared)


def _columns(runs: pd.DataFrame, signature: str) -> list[str]:
    """Return the measures of a signature; those over readable decisions only if they differ from all decisions."""
    every = [str(name) for name in runs.columns if str(name).startswith(f"{signature}.")]
    return [name for name in every if not is_readable_only(name) or _differs(runs, name)]


def _differs(runs: pd.DataFrame, name: str) -> bool:
    whole = name.removesuffix(READABLE_SUFFIX)
    if whole not in runs:
        return True
    readable, other = (runs[column].to_numpy(dtype=np.float64) for column in (name, whole))
    return not np.allclose(readable, other, rtol=0, atol=_ROUNDING, equal_nan=True)


def _section(material: Material, signature: Signature, columns: Sequence[str]) -> Section:
    compared, name = material.analysis.compared, signature.name
    headline = compared.headlines.get(name, [])
    return Section(
        name=name,
        declared=any(measure.startswith(f"{name}.") for measure in material.analysis.declared),
        definitions=tuple(definitions(signature, material.forms)),
        headline=_headline(material, headline, name) if headline else None,
        means=_means(material, columns, name),
    )


def _headline(material: Material, measures: Sequence[str], name: str) -> Grid:
    shown = measures[:MOST_COLUMNS]
    more = f" The table below has {len(measures) - len(shown)} further measures." if len(shown) < len(measures) else ""
    caption = f"{name}: mean over seeds with its 95 % interval.{more}"
    return _by_group(material, shown, [measure.partition(".")[2] for measure in shown], caption)


def _by_group(material: Material, measures: Sequence[str], heads: Sequence[str], caption: str) -> Grid:
    compared = material.analysis.compared
    seeds = [len(compared.values[shown.group]) for shown in material.shown]
    columns = [
        mean_cells([compared.estimates.get((measure, of.group)) for of in material.shown], seeds)
        for measure in measures
    ]
    labels = [shown.label + (" (baseline)" if shown.baseline else "") for shown in material.shown]
    return grid(caption, ("group", *heads), list(zip(labels, *columns, strict=True)))


def comparison_grid(material: Material) -> Grid:
    """Return the headline measures of all groups."""
    measures = shown_measures(material.analysis.compared)
    return _by_group(material, measures, measures, COMPARED)


def contrast_grids(material: Material) -> list[Grid]:
    """Return the differences in the tested measures, one table per measure."""
    return [grid_of(table) for table in contrast_tables(material.analysis.contrasts)]


def _means(material: Material, columns: Sequence[str], name: str) -> Grid:
    heads = [f"{column.partition('.')[2]}: {material.analysis.compared.describe(column).label}" for column in columns]
    caption = f"All measures of {name}: mean over seeds with its 95 % interval. n is given if some seeds have no value."
    return _by_group(material, columns, heads, caption)


def values_grid(material: Material, base: Path) -> Grid:
    """Return the tested measures of every complete run, with equal decimals in each column."""
    columns = [name for name in material.analysis.declared if name in material.analysis.runs]
    complete = [index for index, member in enumerate(material.members) if member.complete]
    values = material.analysis.runs[columns].to_numpy(dtype=np.float64)[complete]
    members = [material.members[index] for index in complete]
    names = [
        [link(member, base) for member in members],
        [member.shown.label for member in members],
        [member.seed for member in members],
    ]
    cells = [*names, *(alike(column.tolist()) for column in values.T)]
    caption = "The tested measures of every complete run; signatures.csv has all other measures."
    return grid(caption, ("run", "group", "seed", *columns), list(zip(*cells, strict=True)), labels=2)


def variance_grid(material: Material) -> Grid | None:
    """Return which share of each headline measure's variation comes from each setting and the seed, or None."""
    headline = [name for names in material.analysis.compared.headlines.values() for name in names]
    rows = material.analysis.variance[material.analysis.variance["measure"].isin(headline)]
    components = list(dict.fromkeys(rows["component"]))
    if len(components) < 3 or rows["share"].isna().all():
        return None
    shares = rows.pivot(index="measure", columns="component", values="share").reindex(headline)[components]
    cells = [
        (str(measure), *("-" if np.isnan(share) else f"{100 * share:.3g} %" for share in row))
        for measure, row in zip(shares.index, shares.to_numpy(dtype=np.float64).tolist(), strict=True)
        if not np.isnan(row).all()
    ]
    caption = "How much of the variation between runs each setting and the seed explain (shares; random effects)."
    return grid(caption, ("measure", *components), cells)


def energy_grid(material: Material) -> Grid | None:
    """Return the energy distances between groups; None if nothing is compared."""
    rows = text_rows(material.analysis.fingerprint.energy, ("statistic",))
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
    caption = (
        "Energy distance between groups, over all headline measures together (standardised). The p values are "
        "corrected by Holm's method."
    )
    return grid(caption, ("first", "second", "seeds", "distance", "p (Holm)"), cells, labels=2)


def retest_grid(material: Material) -> Grid | None:
    """Return how often models answered equal prompts equally; None if no prompt was sampled again."""
    frame = material.analysis.retest
    if not len(frame):
        return None
    columns = [alike(frame[name].tolist()) if frame[name].dtype.kind == "f" else frame[name] for name in frame.columns]
    rows = list(zip(*columns, strict=True))
    caption = "Test-retest consistency: how often a model answers the same prompt equally with another sampling seed."
    return grid(caption, [str(name) for name in frame.columns], rows)


def run_grids(material: Material, base: Path) -> list[tuple[str, Grid]]:
    """Return the titles and tables of single runs that the forms provide; the id of a run links to its folder."""
    by_run = {member.folder.id: member for member in material.members}
    return [
        (
            table.title,
            grid(
                table.caption,
                table.columns,
                [(link(by_run[run], base), *cells) for run, *cells in table.rows],
                labels=table.labels,
            ),
        )
        for table in material.examples.tables
    ]
