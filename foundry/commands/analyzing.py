"""The commands that declare a study, and that analyse runs."""

from __future__ import annotations

import itertools
import tempfile
from collections.abc import Mapping, Sequence, Set
from dataclasses import replace
from pathlib import Path
from typing import TYPE_CHECKING, Annotated, Any

import typer

from foundry.commands.application import EXIT_OK, LOOK, OVERRIDES, TRUST, app
from foundry.commands.options import (
    AsJson,
    Family,
    Folders,
    Labeller,
    Margins,
    Mine,
    Only,
    Overrides,
    Trusted,
    TrustedServers,
    WhoLabels,
    Without,
    check_belongs,
    given,
)
from foundry.commands.printing import only_json
from foundry.commands.probing import composed_probe, folders_first
from foundry.commands.showing import analyze_and_print, analyze_and_show, probe_in
from foundry.commands.sweeps import composed_here, existing_answers, known_models, run_baselines, sweep_reach
from foundry.composing.settings import UNTIL
from foundry.errors import InputError
from foundry.expansion import Sweep, expand
from foundry.storing.preregistration import (
    PREREGISTRATION_FILE,
    Preregistration,
    check_before_runs,
    conditions_of,
    holders_of,
    write_preregistration,
)
from foundry.storing.store import fresh_folder
from foundry.texts import counted
from foundry.version import __version__

if TYPE_CHECKING:
    from foundry.composing.compose import Composed
    from foundry.models.base import ModelInfo
    from foundry.probing.composing import Probe


@app.command(rich_help_panel=LOOK)
def analyze(
    folders: Folders,
    baselines: Annotated[
        bool, typer.Option("--baselines", help="First play scripted baselines in the same worlds, with the same seeds.")
    ] = False,
    labeller: WhoLabels = Labeller.RULE,
    family: Family = None,
    margin: Margins = None,
    only: Only = None,
    without: Without = None,
    plots: Annotated[
        bool, typer.Option("--plots", help="Also write each figure as SVG, PDF, PNG and data into analysis/plots.")
    ] = False,
    columns: Annotated[
        int, typer.Option(min=1, max=2, help="With --plots: width of the figures, in columns of a paper.")
    ] = 1,
    json: AsJson = False,
    trust_targets: Trusted = None,
    config_dir: Mine = None,
) -> None:
    """Measure every run, and compare models, prompts and settings.

    Declare the measures that your claims need (--family). Without a declaration, all findings are exploratory.

    The tables are in analysis in the folder. The tables of A and B together are in A/analysis_with_B.
    """
    margins = margins_of(margin or [])
    if baselines:
        _check_before_baselines(folders, family, margins)
    with only_json(json):
        codes = [run_baselines(folder, trust_targets or ()) for folder in folders] if baselines else []
    by_model, show = labeller is Labeller.MODEL, analyze_and_print if json else analyze_and_show
    show(
        folders,
        labelled_by_model=by_model,
        family=family,
        margins=margins,
        **({"plots": True, "columns": columns} if plots else {}),
        only=only or (),
        without=without or (),
    )
    raise typer.Exit(max(codes, default=EXIT_OK))


def _check_before_baselines(
    folders: Sequence[Path], family: Sequence[str] | None, margins: Mapping[str, float]
) -> None:
    """Reject unknown measures before the baselines are played, because playing takes time."""
    from analysis.pipeline import check_declared, opened

    if probe_in(folders, {}) is None:
        check_declared(opened(folders), family, margins)


@app.command(context_settings=OVERRIDES, rich_help_panel=TRUST)
def preregister(
    overrides: Overrides = None,
    family: Family = None,
    margin: Margins = None,
    widest: Annotated[
        list[str] | None,
        typer.Option(help="MEASURE=SIZE: the largest difference that a seed can have, for a measure with --margin."),
    ] = None,
    looks: Annotated[
        str,
        typer.Option(help="Test each time that so many seeds are played, such as 8,12,18; default: once, at the end."),
    ] = "",
    trust_targets: Trusted = None,
    trust_servers: TrustedServers = False,
    config_dir: Mine = None,
) -> None:
    """Declare a study before its runs: which measures you test, and after how many seeds.

    Writes preregistration.yaml into the sweep's folder and prints its hash. Takes the same overrides as foundry:

    foundry preregister -m model=a,b seed=0-33 --family idle_rate.chosen --looks 8,12,18,26,34

    Before a probe, takes the same arguments as foundry probe, and declares models or edits:

    foundry preregister outputs/pilot -m model=a,b edit=no_fire --family no_fire
    """
    from foundry.composing.preparing import OUTPUTS

    sweeps, arguments = folders_first(given(overrides, config_dir))
    if sweeps:
        if margin or widest or looks:
            raise InputError("A probe has no margins and no interim looks. Leave out --margin, --widest and --looks.")
        probe = composed_probe(sweeps, arguments, trust_targets or (), trust_servers)
        if probe is not None:
            _preregister_probe(probe, " ".join([*map(str, sweeps), *arguments]), family or [])
        return
    check_belongs("a recorded sweep", {"trust-targets": trust_targets, "trust-servers": trust_servers or None})
    composed = composed_here(arguments)
    if composed is None:
        return
    asked = composed.settings["output"]["dir"]
    if asked:
        check_before_runs(Path(asked))
    places = _places(asked)
    sizes = {"margins": margins_of(margin or []), "widest": margins_of(widest or [], "--widest")}
    plan, note = _planned(composed, places, family=family or [], looks=looks_of(looks), **sizes)
    folder = Path(asked) if asked else fresh_folder(OUTPUTS)
    _tell_plan(plan, note, folder, write_preregistration(folder, plan))
    reach = sweep_reach(composed.sweep, len(plan.measures))
    if reach is not None:
        print(reach.line())
    if plan.known:
        print(f"{plan.known}; seeds without runs and cached answers: seed={_unseen(composed, plan.seeds, places)}")
    more = "" if asked else f" output.dir={folder}"
    until = "" if composed.settings[UNTIL] else f" {UNTIL}=answered"
    print(f"Give this hash to someone else, or publish it; then: foundry {' '.join(composed.asked)}{more}{until}")


def _preregister_probe(probe: Probe, command: str, names: Sequence[str]) -> None:

    from analysis.probes.probe_declaring import declared_probe
    from foundry.composing.preparing import OUTPUTS

    asked = probe.composed.settings["output"]["dir"]
    if asked:
        check_before_runs(Path(asked))
    sweep = expand(probe.composed.asked, probe.composed.conditions)
    with tempfile.TemporaryDirectory() as scratch:
        circumstances, note = _circumstances(probe.composed, probe.placed(Path(scratch), sweep), _places(asked))
    configs = [condition.config for condition in sweep.conditions]
    plan = declared_probe(conditions_of(sweep), configs, names, **circumstances)
    folder = Path(asked) if asked else fresh_folder(OUTPUTS)
    print(f"{write_preregistration(folder, plan)}  {folder / PREREGISTRATION_FILE}")
    tests = " and ".join(f"{count} of {what}" for what, count in plan.tests.items())
    print(f"{len(plan.seeds)} seeds, tests: {tests}")
    if note:
        print(note)
    if plan.known:
        print(f"{plan.known}; to ask in other moments, set another moments_seed or name another sweep")
    more = "" if asked else f" output.dir={folder}"
    print(f"Give this hash to someone else, or publish it; then: foundry probe {command}{more}")


def _places(asked: str | None) -> set[Path]:
    """Return the folders that may be sweeps with the same runs: those in outputs/ and beside the new sweep's folder."""
    from foundry.composing.preparing import OUTPUTS

    return {path for parent in {OUTPUTS, Path(asked or OUTPUTS).parent} for path in parent.glob("*")}


def _planned(composed: Composed, places: Set[Path], **asked: Any) -> tuple[Preregistration, str]:
    from analysis.planned.declaring import declared
    from foundry.composing.preflight import declare

    sweep = declare(composed.sweep)
    circumstances, note = _circumstances(composed, sweep, places)
    forms = [condition.declared.form for condition in sweep.conditions if condition.declared is not None]
    return declared(conditions_of(sweep), forms, **asked, **circumstances), note


def _circumstances(composed: Composed, sweep: Sweep, places: Set[Path]) -> tuple[dict[str, Any], str]:
    """Return the facts that a plan records, and why servers did not report their weights ("" if they did)."""
    from foundry import provenance
    from foundry.composing.preparing import model_lines

    infos, note = known_models(sweep)
    answers, holders = _known(composed, sweep, infos, places)
    circumstances = {
        "foundry": __version__,
        "commit": provenance.git_commit(),
        "asked": list(sweep.asked),
        "models": model_lines(infos),
        "answers_known": answers,
        "runs_known": holders,
    }
    return circumstances, note


def _known(
    composed: Composed, sweep: Sweep, infos: dict[str, ModelInfo], places: Set[Path]
) -> tuple[int | None, list[str]]:
    """Return how many answers of the sweep are cached (None if unknown), and which analysed sweeps contain its runs."""
    from foundry.composing.planning import plan as plan_runs

    planned = plan_runs(sweep, infos, existing_answers(composed), {})
    counts = [run.cached for run in planned]
    answers = None if None in counts else sum(filter(None, counts))
    own = Path(composed.settings["output"]["dir"] or "")
    return answers, holders_of({run.id for run in sweep.runs}, own, places)


def _unseen(composed: Composed, seeds: Sequence[int], places: Set[Path]) -> str:
    """Return the first range of unused seeds, as many as `seeds`. Used seeds have cached answers or an analysis."""
    for start in itertools.count(max(seeds) + 1, len(seeds)):
        fresh = range(start, start + len(seeds))
        sweep = expand(composed.asked, [replace(condition, seeds=tuple(fresh)) for condition in composed.conditions])
        if not any(_known(composed, sweep, known_models(sweep)[0], places)):
            return f"{fresh[0]}-{fresh[-1]}"
    raise AssertionError("a cache holds finitely many answers")


def _tell_plan(plan: Preregistration, note: str, folder: Path, sha256: str) -> None:
    from analysis.planned.declaring import never_the_same, out_of_reach

    tests = " and ".join(
        f"{count} for {counted(plan.pairs[factor], 'pair')} of levels of {factor}"
        for factor, count in plan.tests.items()
    )
    looks = ", ".join(f"{look.seeds} seeds (level {look.alpha:.2g})" for look in plan.looks)
    print(f"{sha256}  {folder / PREREGISTRATION_FILE}")
    print(f"{len(plan.seeds)} seeds; tests: {tests}; looks after {looks}")
    for line in [*out_of_reach(plan), *never_the_same(plan), *filter(None, [note])]:
        print(line)


def looks_of(text: str) -> list[int]:
    """Return the number of seeds at each interim look, given as in "8,12,18"."""
    try:
        return [int(number) for number in text.split(",") if text]
    except ValueError:
        raise InputError(f"--looks must have the form N,N,..., such as 8,12,18,26,34; got {text}") from None


def margins_of(texts: Sequence[str], option: str = "--margin") -> dict[str, float]:
    """Parse texts of the form MEASURE=SIZE, the values of an option; return the size for each measure."""
    margins = {}
    for text in texts:
        measure, _, size = text.rpartition("=")
        if measure in margins:
            raise InputError(f"{option} names the measure {measure} twice. Name each measure once.")
        try:
            margins[measure] = float(size)
        except ValueError:
            raise InputError(
                f"{option} must have the form MEASURE=SIZE, such as clustering.largest_group=0.1; got {text}"
            ) from None
    return margins
