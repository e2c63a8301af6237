"""The whole analysis of one or several sweeps, for `foundry analyze`."""

from collections import Counter
from collections.abc import Callable, Mapping, Sequence
from dataclasses import dataclass, field, replace
from functools import cached_property
from pathlib import Path

import pandas as pd

from analysis import signatures
from analysis.figures.members import Member, members, shown_groups
from analysis.figures.shown import ShownGroup
from analysis.filtering import Filter
from analysis.findings.finding_records import FindingRecord, write_findings
from analysis.findings.furthest import FarRun, furthest, write_overview
from analysis.findings.partings import first_partings
from analysis.findings.ranking import findings
from analysis.findings.recording import Runs, records_of
from analysis.findings.study_matrix import Matrix, matrix
from analysis.form import FormAnalysis, form_of, forms_of
from analysis.labelling import Labelling, Reading
from analysis.labelling.people import write_labellers
from analysis.load import Folders, folders_of, runs_by_id
from analysis.measuring.events import EventsFile
from analysis.measuring.memory import open_memory
from analysis.measuring.runs import RunResult, Source, measure_runs, schemas_of, sources_of
from analysis.measuring.steps_file import open_steps_file
from analysis.measuring.twins import beyond_twins
from analysis.paper.ending import EndingContent, ending, means_of
from analysis.paper.methods import Basis, bibtex, methods
from analysis.paper.sentence import Sides
from analysis.paper.study import on_new_seeds, study
from analysis.paper.summary import summary
from analysis.planned.declaring import check_measures
from analysis.planned.holding import PlanCheck, plans_of
from analysis.planned.looking import counted, settings_by_side
from analysis.retest import retest
from analysis.stats.contrasts import ALPHA, contrasts
from analysis.stats.factors import MODEL
from analysis.stats.family import primary_measures
from analysis.stats.fingerprint import Fingerprint, fingerprint
from analysis.stats.values import Group
from analysis.stats.variance import variance_split
from analysis.tables.comparison import Comparison, compare
from analysis.tables.equal_chances import equal_chances
from analysis.tables.groups import group_columns, group_keys
from analysis.tables.latex import split_by
from analysis.tables.notes import doubtful_weights, notes_of, out_of_reach, unlike_published
from analysis.tables.signature_table import SignatureTable, build_table
from analysis.tables.texts import (
    NUMBERS,
    escaped,
    remove_table,
    write_numbers,
    write_summary,
    write_table,
    write_tables,
)
from analysis.tables.thresholds import sentences, thresholds
from analysis.validation.known_values import validation_frame, validation_table
from foundry.errors import InputError
from foundry.storing.determinism import inexact, repeats_of
from foundry.storing.store import SweepFolder, ensure_writable


@dataclass(frozen=True)
class Analysis:
    """The results of an analysis, and the written files.

    Attributes:
        path: the folder of tables and plots.
        notes: warnings about the results, one line each.
        contrasts: one row per measure and pair of groups, as in `contrasts.csv`; see `analysis.stats.contrasts`.
        variance: shares of the variation, as in `variance.csv`.
        fingerprint: comparison of whole groups; its energy tests are in `fingerprint.csv`.
        retest: test-retest consistency, as in `retest.csv`; no rows if nothing was sampled again.
        equal_chances: comparison of mutually exclusive outcomes with equal chances, as in `equal_chances.csv`; no rows
            without such outcomes.
        thresholds: values of settings from which outcomes prevail, as in `thresholds.csv`; no rows without a numeric
            setting with three values.
        sources: module and origin of each signature, as in `sources.csv`; see `analysis.signatures.sources`.
        validation: known values of the worlds next to the results, as in `validation.csv`; no rows without any.
        declared: measures of the declared family.
        shown: groups of tables and plots, baselines last.
        members: the runs with their groups, in the order of `table`.
        planned: the preregistration compared with the runs; None without one.
        filtered: the filter of the runs; "" for all runs.
        doubts: by signature, the reason why none of its measures can be trusted.
        readings: who labelled the texts behind a measure, by the name of the measure.
    """

    path: Path
    compared: Comparison
    notes: tuple[str, ...]
    table: SignatureTable
    groups: pd.DataFrame
    contrasts: pd.DataFrame
    variance: pd.DataFrame
    fingerprint: Fingerprint
    retest: pd.DataFrame
    equal_chances: pd.DataFrame
    thresholds: pd.DataFrame
    sources: pd.DataFrame
    validation: pd.DataFrame
    declared: tuple[str, ...]
    shown: tuple[ShownGroup, ...]
    members: tuple[Member, ...]
    planned: PlanCheck | None = None
    filtered: str = ""
    doubts: Mapping[str, str] = field(default_factory=dict)
    forms: Mapping[Group, FormAnalysis] = field(default_factory=dict)
    readings: Mapping[str, Reading] = field(default_factory=dict)
    written: list[Path] = field(default_factory=list)

    @property
    def runs(self) -> pd.DataFrame:
        """One row per run, as in `signatures.csv`."""
        return self.table.frame

    @property
    def comparison(self) -> pd.DataFrame:
        """One row per measure and group, as in `comparison.csv`."""
        return self.compared.frame

    @cached_property
    def findings(self) -> tuple[FindingRecord, ...]:
        """The differences of the declared rows by size, with example moments, as in `findings.json`."""
        rows = self.contrasts[self.contrasts["headline"].astype(bool)].to_dict("records")
        return tuple(records_of(findings(rows), self.sides, Runs(self.compared, self.members, self.runs), self.doubts))

    @cached_property
    def sides(self) -> Sides:
        """Facts about the groups, for the sentences about them."""
        return Sides.of(self.contrasts, self.compared, self.forms, self.readings)

    @cached_property
    def summary(self) -> tuple[str, ...]:
        """Sentences about the thresholds, then sentences about the findings."""
        planned = self.planned is not None
        lines = summary(
            self.contrasts, self.compared, planned=planned, filtered=self.filtered, doubts=self.doubts, sides=self.sides
        )
        return (*sentences(self.thresholds), *lines)

    @cached_property
    def matrix(self) -> Matrix:
        """A table with a row per group and a column per world; for one world, a column per measure with a large gap."""
        measures = list(dict.fromkeys(finding.measure for finding in self.findings)) or self.declared
        return matrix(self.compared, self.shown, self.members, self.validation, measures)

    @property
    def furthest(self) -> tuple[FarRun, ...]:
        """The runs whose declared measures are furthest from their group; measures with doubts do not count."""
        measures = [name for name in self.declared if name.partition(".")[0] not in self.doubts]
        return furthest(self.compared, self.members, self.runs, measures)

    def on_new_seeds(self, folders: Sequence[Path], measures: Sequence[str], pairs: int) -> str:
        """Return the command that declares measures and runs the first sweep again, with new seeds.

        There are enough seeds for tests that are corrected for the given number of pairs.
        """
        sweep = SweepFolder.open(folders[0]).sweep
        asked = [entry.overrides for entry in sweep.history] or [sweep.asked]
        return on_new_seeds(asked, {run.seed for run in sweep.runs}, measures, pairs, ALPHA)

    def ending(self, folders: Sequence[Path], width: int, printed: int = 0) -> list[str]:
        """Return the last lines of an analysis on a terminal: at most twenty, less the `printed` lines."""
        sweeps = [SweepFolder.open(folder).sweep for folder in folders]
        means = means_of(self.compared, self.declared)
        worlds = [condition.config["world"] for sweep in sweeps for condition in sweep.conditions]
        results = EndingContent(
            contrasts=self.contrasts,
            sides=self.sides,
            notes=self.notes,
            study=study(self.compared, worlds, self.contrasts["claim"].tolist()),
            folders=" ".join(map(str, folders)),
            tables=str(self.path),
            again=lambda measures, pairs: self.on_new_seeds(folders, measures, pairs),
            thresholds=sentences(self.thresholds),
            alone="Nothing is compared." if means else "No measure is defined in these runs.",
            means=means,
            matrix=self.matrix,
        )
        return ending(results, width, printed)


def analyze(
    dirs: Folders,
    *,
    plots: bool = False,
    columns: int = 1,
    labelled_by_model: bool = False,
    family: Sequence[str] | None = None,
    margins: Mapping[str, float] | None = None,
    only: Sequence[str] = (),
    without: Sequence[str] = (),
    watch: Callable[[int, int], None] | None = None,
) -> Analysis:
    """Compute all signatures, compare the groups, and write all files.

    The files go to the folder `analysis` of the sweep, or, for several, to `analysis_with_<others>` of the first. For
    several sweeps all runs are combined, and the tables have a column `sweep`. Baselines of a sweep are included. Runs
    that were measured before and have not changed are not measured again.

    Args:
        dirs: folder of a sweep, or folders of several.
        plots: whether to write every figure as SVG, PDF, PNG and data; this takes longer than everything else.
        columns: width of a figure in columns of a paper, 1 or 2.
        labelled_by_model: whether warnings are labelled by a model (`foundry label`) instead of the rule.
        family: declared measures; by default one per signature.
        margins: by measure, the declared difference below which groups count as equal.
        only: runs to include, as KEY=VALUE[,VALUE...], such as `model=a,b` or `seed=0-9`; see
            `analysis.filtering.Filter`. Every table names the filter.
        without: runs to exclude, in the same form.
        watch: function that is called with the number of measured runs and of all runs.

    Raises:
        InputError: a folder is not a sweep, is given twice, or lacks labels by a model. A measure of the family or of a
            margin, or a key or value of a filter, does not exist. A filter leaves no run.
        RecordError: a recorded file is damaged.
    """
    paths = folders_of(dirs)
    sweeps = opened(paths)
    folder, memory = sweeps[0].analysis_dir_with(sweeps[1:]), sweeps[0].analysis_dir / "measured.sqlite"
    check_declared(sweeps, family, margins)
    sources = sources_of(sweeps, _sweep_names(paths), labelled_by_model)
    chosen = Filter.of(only, without)
    chosen.check([condition for source in sources for condition in source.folder.sweep.conditions])
    for used in (folder, memory.parent):
        ensure_writable(used)
    measured, events = _measure_and_write_steps(sources, folder, memory, chosen, watch)
    results = chosen.taken(measured)
    chosen.write(folder, len(results), len(measured))
    filtered = f"{chosen}: {len(results)} of {len(measured)} runs" if chosen else ""
    models = tuple(dict.fromkeys(result.keys["model"] for result in measured if not result.baseline))
    del measured  # from here on the table contains all measures
    table = build_table(results)
    results = [result.without_measures() for result in results]
    analysis = _analysis_of(
        folder, sources, table, results, models=models, family=family, margins=margins, filtered=filtered
    )
    partings = first_partings(analysis.members, analysis.compared.group_columns.index(MODEL))
    for result, parting in zip(results, partings, strict=True):
        events.add(result.sweep, result.keys["run"], parting)
    analysis.written.extend([folder / "steps.parquet", events.write(folder)])
    analysis.written.extend([*_write(analysis, sources), *write_labellers(sweeps[0])])
    if plots:
        analysis.written.extend(_plot(analysis, sources, columns))
    return analysis


def _write(analysis: Analysis, sources: Sequence[Source]) -> list[Path]:
    return [
        write_findings(analysis.path, analysis.findings),
        write_overview(analysis.path, analysis.matrix, analysis.furthest, analysis.compared),
        *_write_tables(analysis),
        write_summary(analysis.path, analysis.summary, analysis.notes),
        *_write_methods(analysis, sources),
    ]


def _analysis_of(
    folder: Path,
    sources: Sequence[Source],
    table: SignatureTable,
    results: Sequence[RunResult],
    *,
    models: tuple[str, ...],
    family: Sequence[str] | None,
    margins: Mapping[str, float] | None,
    filtered: str,
) -> Analysis:
    groups = group_columns(results, table)
    compared = replace(compare(table, groups), models=models)
    sweeps = [source.folder for source in sources]
    shown_models = set(table.frame["model"])
    repeating = inexact(repeats for sweep in sweeps for repeats in repeats_of(sweep) if repeats.of in shown_models)
    planned, others = plans_of(sweeps, table, groups, asked=bool(family or margins))
    plan = planned.plan if planned else None
    tested = contrasts(table, groups, family=family, margins=margins, repeating=repeating, plan=plan)
    forms = [form_of(name) for name in dict.fromkeys(result.form for result in results)]
    forms_by_group = _forms_by_group(results, groups)
    labellings = [source.labelling for source in sources]
    doubts = {name: why for form in forms for name, why in form.words.doubts(labellings).items()}
    differences = _doubted(counted(tested, sweeps[0].path, settings_by_side(results, groups)), doubts)
    compared = replace(compared, frame=_doubted(compared.frame, doubts))
    shown = tuple(shown_groups(compared))
    validation = validation_frame(results, groups, compared)
    played = tuple(members(table.frame, groups, shown, runs_by_id(sweeps)))
    return Analysis(
        path=folder,
        compared=compared,
        notes=(
            *(f"no measure of {signature} can be trusted: {why}" for signature, why in doubts.items()),
            *([f"only a part of the runs, {filtered}"] if filtered else ()),
            *(planned.notes() if planned else ()),
            *others,
            *doubtful_weights(member.summary.canaries for member in played if member.summary is not None),
            *notes_of(table, compared, differences, forms_by_group, labellings),
            *(
                f"{said}; differences as small as the share of its other calls may come from the server"
                for said in repeating.values()
            ),
            *unlike_published(validation),
            *out_of_reach(differences),
        ),
        table=table,
        groups=groups,
        contrasts=differences,
        variance=variance_split(table, groups),
        fingerprint=fingerprint(table, groups),
        retest=retest([source.folder for source in sources if not source.baseline], set(table.frame["run"])),
        equal_chances=equal_chances(compared),
        thresholds=thresholds(compared),
        sources=pd.DataFrame(signatures.sources(forms, table.measures)),
        validation=validation,
        declared=plan.family if plan else tuple(family or primary_measures(table.measures, table.present)),
        shown=shown,
        members=played,
        planned=planned,
        filtered=filtered,
        doubts=doubts,
        forms=forms_by_group,
        readings=signatures.readings(labellings, table.measures),
    )


def _doubted(frame: pd.DataFrame, doubts: Mapping[str, str]) -> pd.DataFrame:
    """Add to the `note` of each measure the reason why it cannot be trusted, if there is one."""
    if not doubts:
        return frame
    whys = [doubts.get(name.partition(".")[0], "") for name in frame["measure"]]
    notes = ["; ".join(filter(None, both)) for both in zip(whys, frame["note"].astype(str), strict=True)]
    return frame.assign(note=notes)


def opened(paths: Sequence[Path]) -> list[SweepFolder]:
    """Open all sweeps, so that a wrong folder is reported before any run is processed.

    Raises:
        InputError: no folder is given, a folder is not a sweep, or a sweep is given twice, even as a copy or a bundle.
        RecordError: a recorded file is damaged.
    """
    if not paths:
        raise InputError("No sweep to analyse: give at least one sweep's folder, such as outputs/<sweep>.")
    repeated = [str(path) for path, count in Counter(path.resolve() for path in paths).items() if count > 1]
    if repeated:
        raise InputError(f"'{repeated[0]}' is given more than once: give each sweep's folder once.")
    sweeps = [SweepFolder.open(path) for path in paths]
    if len(sweeps) > 1:
        _check_runs_once(sweeps)
    return sweeps


def check_declared(
    sweeps: Sequence[SweepFolder], family: Sequence[str] | None, margins: Mapping[str, float] | None
) -> None:
    """Raise an InputError if no signature of the sweeps' worlds has a declared measure."""
    if names := [*(family or ()), *(margins or {})]:
        check_measures(names, [form.name for form in forms_of(run for sweep in sweeps for run in sweep.runs())])


def _check_runs_once(sweeps: Sequence[SweepFolder]) -> None:
    """Raise an InputError if two folders hold the same run, which its start and duration identify."""
    known: dict[tuple[str, str, float], Path] = {}
    holders = Counter(run.id for sweep in sweeps for run in sweep.runs())
    for sweep in sweeps:
        for end in filter(None, (run.summary() for run in sweep.runs() if holders[run.id] > 1)):
            other = known.setdefault((end.run, end.started, end.duration_s), sweep.path)
            if other != sweep.path:
                raise InputError(
                    f"'{sweep.path.name}' is given more than once, also as '{other.name}': both hold the run "
                    f"{end.run} of {end.started}. Give each sweep once."
                )


def _sweep_names(paths: Sequence[Path]) -> list[str]:
    """Return the names of the folders, or their whole paths if two names are equal."""
    names = [path.resolve().name for path in paths]
    return names if len(set(names)) == len(names) else [path.as_posix() for path in paths]


def _measure_and_write_steps(
    sources: Sequence[Source], folder: Path, steps_file: Path, chosen: Filter, watch: Callable[[int, int], None] | None
) -> tuple[list[RunResult], EventsFile]:
    runs = [run for source in sources for run in source.folder.runs()]
    by_sweep = len({source.name for source in sources}) > 1
    events = EventsFile()
    results: list[RunResult] = []
    with (
        open_memory(steps_file) as memory,
        open_steps_file(folder / "steps.parquet", schemas_of(runs), by_sweep=by_sweep) as file,
    ):
        for result in measure_runs(sources, memory):
            if result.steps is not None and chosen.takes(result):
                file.add(result.sweep, result.steps)
            if chosen.takes(result):
                events.add(result.sweep, result.keys["run"], result.events)
            results.append(result.without_steps())
            if watch is not None:
                watch(len(results), len(runs))
    return beyond_twins(results), events


def _write_tables(analysis: Analysis) -> list[Path]:
    frames = {
        "signatures": analysis.runs,
        "sources": analysis.sources,
        "variance": analysis.variance,
        "fingerprint": analysis.fingerprint.energy,
        "retest": analysis.retest,
        "equal_chances": analysis.equal_chances,
        "thresholds": analysis.thresholds,
    }
    written = [
        *write_tables(analysis.path, analysis.compared, analysis.contrasts, analysis.filtered),
        *_write_validation(analysis),
    ]
    for name, frame in frames.items():
        stem = analysis.path / name
        if len(frame):
            written += write_numbers(stem, frame, "" if name == "sources" else analysis.filtered)
        else:
            remove_table(stem, NUMBERS)
    return written


def basis_of(analysis: Analysis, labelled_by: Sequence[Labelling]) -> Basis:
    """Return the results of an analysis that the texts of methods and references are written from."""
    return Basis(
        members=analysis.members,
        forms=forms_of(member.folder for member in analysis.members),
        labelled_by=labelled_by,
        comparison=analysis.comparison,
        contrasts=analysis.contrasts,
        fingerprint=analysis.fingerprint,
        planned=analysis.planned,
        filtered=analysis.filtered,
    )


def _write_methods(analysis: Analysis, sources: Sequence[Source]) -> list[Path]:
    basis = basis_of(analysis, [source.labelling for source in sources])
    texts = {"methods.md": "\n\n".join(map(escaped, methods(basis))) + "\n", "references.bib": bibtex(basis)}
    for name, text in texts.items():
        (analysis.path / name).write_text(text, encoding="utf-8", newline="\n")
    return [analysis.path / name for name in texts]


def _write_validation(analysis: Analysis) -> list[Path]:
    table = validation_table(analysis.validation)
    if len(analysis.validation):
        return write_table(analysis.path, table, analysis.validation, analysis.filtered, parts=split_by(table, "world"))
    remove_table(analysis.path / table.name)
    return []


def _plot(analysis: Analysis, sources: Sequence[Source], columns: int) -> list[Path]:
    from analysis.figures.examples import examples
    from analysis.figures.pictures import every_picture
    from analysis.plots import FORMATS, draw, write

    labellings = {run.id: source.labelling for source in sources for run in source.folder.runs()}
    pictures = [
        *every_picture(analysis.compared, analysis.contrasts, analysis.validation, analysis.fingerprint),
        *examples(analysis.members, analysis.shown, labellings).pictures,
    ]
    folder = analysis.path / "plots"
    return [path for picture in pictures for path in write(draw(picture, *FORMATS, columns=columns), folder)]


def _forms_by_group(results: Sequence[RunResult], groups: pd.DataFrame) -> dict[Group, FormAnalysis]:
    return {key: form_of(result.form) for key, result in zip(group_keys(groups), results, strict=True)}
