"""Commands that run sweeps or show their progress."""

from __future__ import annotations

import os
import sys
from collections.abc import Callable, Sequence
from pathlib import Path
from typing import TYPE_CHECKING, Annotated, Any, TypeAlias

import typer

from foundry.commands.application import EXIT_FAILED, EXIT_INTERRUPTED, EXIT_OK, OVERRIDES, RUN, app
from foundry.commands.options import AsJson, Folder, Mine, Overrides, Trusted, TrustedServers, folder_text, given
from foundry.commands.printing import bars, console, fail, is_quiet, is_verbose, only_json, print_json, say
from foundry.commands.showing import analyze_and_show
from foundry.commands.view import check_view, watched
from foundry.composing.settings import BASELINES, UNTIL, checked_settings
from foundry.errors import InputError
from foundry.expansion import Sweep, with_hosts
from foundry.records import RunSummary
from foundry.storing.determinism import model_repeats
from foundry.storing.growing import check_declared, check_digests
from foundry.storing.preregistration import conditions_of
from foundry.storing.store import SweepFolder
from foundry.texts import counted, first_of

if TYPE_CHECKING:
    from analysis.planned.reach import Reach
    from foundry.composing.compose import Composed
    from foundry.composing.preparing import CheckedSweep
    from foundry.models.answers.answers import Answers
    from foundry.models.base import ModelInfo
    from foundry.running.local import Runner


MOST_NAMES = 4
"""Maximum number of comparisons that a message names. Of further ones, the message only gives the number."""


def run_overrides(argv: Sequence[str]) -> int:
    """Play the runs that a command line of `foundry` or `foundry -m` asks for; return the exit code."""
    composed = composed_here(argv)
    if composed is None:
        return EXIT_OK
    return run_composed(composed) if composed.settings.get(UNTIL) is None else _run_until_answered(composed)


def _run_until_answered(composed: Composed) -> int:
    """Run a preregistered sweep up to the first interim look that answers its question."""
    from analysis import analyze
    from analysis.planned.holding import answered, open_rows
    from foundry.composing.preparing import checked, stages
    from foundry.storing.standing import failures

    check_view(composed.settings["view"])
    path = Path(composed.settings["output"]["dir"] or "")
    for stage in stages(composed):
        code = run_checked(checked(stage), run=_run_unanalyzed)
        ends = _ends(path, stage.sweep)
        if code == EXIT_INTERRUPTED or None in ends:
            return code
        analysis = analyze(path, plots=False)
        stands = answered(analysis.contrasts)
        if analysis.planned is not None:
            failed = len(failures(ends))
            missing = f"; as planned, {counted(failed, 'failed run')} left out" if failed else ""
            tests = "all declared tests" if stands else "not all declared tests"
            say(f"{tests} are answered at {analysis.planned.look}{missing}")
            if not stands:
                say(f"still open: {first_of(open_rows(analysis.contrasts), MOST_NAMES)}")
        if stands:
            break
    return _analyze_at_end(path, stage.sweep, composed.settings["analyze"], code, 0)


def _ends(path: Path, sweep: Sweep) -> list[RunSummary | None]:
    own = {run.id for run in sweep.runs}
    return [run.summary() for run in SweepFolder.open(path).runs() if run.id in own]


def _run_unanalyzed(folder: SweepFolder, settings: Any, infos: dict[str, ModelInfo], runner: Runner) -> int:
    return run_folder(folder, {**settings, "analyze": False}, infos, runner)


def composed_here(argv: Sequence[str]) -> Composed | None:
    """Compose a command line and the user's defaults; print which defaults apply and which worlds are left out.

    Returns:
        The composed sweep, or None if Hydra answered the command line itself, as with --help.
    """
    from foundry.composing.compose import compose
    from foundry.composing.defaults import read_defaults

    composed = compose(argv, read_defaults())
    if composed is not None:
        say_defaults(composed)
        if composed.left_out:
            print(composed.left_out, file=sys.stderr)
    return composed


def say_defaults(composed: Composed) -> None:
    """Print, on standard error, which of the user's defaults apply to the composed runs."""
    from foundry import paths

    if composed.chosen and not is_quiet():
        print(f"{' '.join(composed.chosen)} (from {paths.user_config_file()})", file=sys.stderr)


def run_composed(composed: Composed, prepare: Callable[[SweepFolder], None] = lambda folder: None) -> int:
    """Check a composed sweep, prepare its folder, play its runs, and return the exit code."""
    from foundry.composing.preparing import checked

    check_view(composed.settings["view"])
    return run_checked(checked(composed), prepare)


def run_folder(folder: SweepFolder, settings: Any, infos: dict[str, ModelInfo], runner: Runner) -> int:
    """Play the runs of a folder that are not complete, print how they ended, and return the exit code."""
    from foundry.composing.preparing import job_of
    from foundry.display import ProgressDisplay
    from foundry.running.local import SweepInterrupted, SweepStopped

    job = job_of(folder, settings, infos)
    runs = folder.runs()
    say(f"{counted(len(runs), 'run')} in {folder.path}")
    if all(run.is_complete for run in runs):
        say("Nothing to run: all runs are complete.")
    try:
        with watched(folder, settings.get("view")), ProgressDisplay(folder, bars(), each_run=is_verbose()):
            runner.run(job)
    except SweepInterrupted:
        _report_end(folder)
        return _interrupted(folder)
    except KeyboardInterrupt:
        return _interrupted(folder)
    except SweepStopped as error:
        _report_end(folder)
        return fail(f"the sweep was stopped: {error}", EXIT_FAILED)
    if settings["analyze"]:
        return _analyze_at_end(folder.path, folder.sweep, settings["analyze"], *_report_runs(folder))
    return _report_end(folder)


def _interrupted(folder: SweepFolder) -> int:
    return fail(f"interrupted; go on with: {_going_on(folder)}", EXIT_INTERRUPTED)


def _analyze_at_end(path: Path, sweep: Sweep, analyze: bool | str, code: int, printed: int) -> int:
    from foundry.trust.unknown import own_packages

    if analyze == BASELINES:
        code = max(code, run_baselines(path, own_packages(sweep)))
    if analyze:
        analyze_and_show([path], printed=printed)
    return code


Run: TypeAlias = "Callable[[SweepFolder, Any, dict[str, ModelInfo], Runner], int]"
"""A function that plays the unfinished runs of a folder, and returns the exit code.

The arguments of this function are the folder, the settings, the facts about the models, and the runner.
"""


def run_checked(
    checked: CheckedSweep, prepare: Callable[[SweepFolder], None] = lambda folder: None, run: Run = run_folder
) -> int:
    """Prepare the folder of a checked sweep, play its runs, and return the exit code."""
    for line in checked.notes:
        say(line)
    folder = checked.create()
    if checked.settings["analyze"]:
        _say_seeds_lacking(folder.path)
    prepare(folder)
    return run(folder, checked.settings, checked.infos, checked.runner)


def _say_seeds_lacking(path: Path) -> None:
    sweep = SweepFolder.open(path).sweep  # with the runs of earlier commands
    reach = sweep_reach(sweep)
    if reach is not None and not reach.is_enough:
        first = max(run.seed for run in sweep.runs) + 1
        last = first + reach.fewest - reach.seeds - 1
        say(f"{reach.line()}; add seeds: foundry resume {path} seed={first}" + (f"-{last}" if last > first else ""))


def run_baselines(path: Path, trusted: Sequence[str] = ()) -> int:
    """Play the missing scripted baselines of a sweep, in its subfolder `baselines`.

    Returns:
        The exit code, which says whether a run failed or the sweep was stopped.
    """
    from analysis.validation.facts import policies_of
    from foundry.composing.baselines import baselines_of
    from foundry.composing.preflight import check
    from foundry.composing.preparing import local_runner, runner_of
    from foundry.trust.unknown import check_sweep_targets

    opened = SweepFolder.open(path)
    if opened.moments_file.exists():
        raise InputError(f"'{path}' is a probe, and probes have no baselines. Name the policies among its models.")
    check_sweep_targets(opened.sweep, {}, trusted)
    sweep = baselines_of(opened.sweep, policies_of)
    if not sweep.runs:
        say(f"{opened.path} already contains every baseline")
        return EXIT_OK
    runner = local_runner(opened.settings["runner"])
    settings = {"runner": runner, "cache": {"path": ""}, "analyze": False, "view": None, "record": {"frames": 0}}
    folder = SweepFolder.create(opened.baselines_dir, sweep, settings, [])
    code = run_folder(folder, settings, check(sweep), runner_of(settings))
    if code == EXIT_INTERRUPTED:
        raise typer.Exit(code)
    return code


def _going_on(folder: SweepFolder) -> str:
    """Return the command that continues a sweep: `foundry play` if people answer in it, otherwise `foundry resume`."""
    from foundry.probing.sitting import people_in

    return f"foundry {'play' if people_in(folder.sweep) else 'resume'} {folder.path}"


def _report_end(folder: SweepFolder) -> int:
    code, _ = _report_runs(folder)
    _print_judged(folder)
    return code


def _report_runs(folder: SweepFolder) -> tuple[int, int]:
    """Print how the runs of a sweep ended; return the exit code and the number of printed lines."""
    from foundry.display import failure_lines, ran_line
    from foundry.storing.standing import counts_so_far, failures

    summaries = [run.summary() for run in folder.runs()]
    failed = failure_lines(failures(summaries))
    counts = list(counts_so_far(folder, summaries, folder.progress().values()))
    lines = [ran_line(summaries, counts, folder.path), *(f"  failed {line}" for line in failed)]
    if failed:
        lines.append(f"  try the failed runs again with: {_going_on(folder)}")
    print("\n".join(lines))
    is_whole = all(summary is not None and summary.status == "complete" for summary in summaries)
    return EXIT_OK if is_whole else EXIT_FAILED, len(lines)


def _print_judged(folder: SweepFolder) -> None:
    from foundry.storing.standing import unread

    for replies in unread(folder.runs()):
        print("\n".join(replies.lines()))
    for server in model_repeats(folder):
        print(server.line())


def sweep_reach(sweep: Sweep, measures: int = 0) -> Reach | None:
    """Return how small a difference the tests of a sweep can find; None if it compares nothing or is a probe."""
    if len(sweep.conditions) < 2:
        return None
    from analysis.planned.reach import reach_of
    from foundry.composing.preflight import declare
    from foundry.worlds.probe.probe_world import ProbeScenario

    known = sweep if all(condition.declared for condition in sweep.conditions) else declare(sweep)
    forms = [condition.declared.form for condition in known.conditions if condition.declared is not None]
    return None if ProbeScenario.form in forms else reach_of(conditions_of(sweep), forms, measures)


def existing_answers(composed: Composed) -> Answers | None:
    """Return the answer cache, or None if it does not exist yet."""
    from foundry.models.answers import opening as answers

    return answers.existing_answers(composed.settings["cache"]["path"])


def known_models(sweep: Sweep) -> tuple[dict[str, ModelInfo], str]:
    """Return the facts that servers report about a sweep's models, and a note, which is usually empty.

    A plan also works without a server: then there are no facts, and the note gives the reason.
    """
    from foundry.composing.preflight import check

    try:
        return check(sweep), ""
    except InputError as error:
        return {}, f"If the sweep started now, it would fail: {error}"


@app.command(context_settings=OVERRIDES, rich_help_panel=RUN)
def resume(
    folder: Folder,
    overrides: Overrides = None,
    trust_targets: Trusted = None,
    trust_servers: TrustedServers = False,
    config_dir: Mine = None,
) -> None:
    """Continue a sweep, and add seeds, models, prompts or worlds.

    Complete runs are kept, and no question is asked twice.

    foundry resume outputs/pilot

    foundry resume outputs/pilot seed=10-19 adds seeds to every condition; model=gemma3:4b adds a model

    Settings that you do not override stay as recorded. OLLAMA_HOST and OPENAI_BASE_URL replace the recorded servers.
    """
    trusted = trust_targets or ()
    if overrides:
        raise typer.Exit(_add(folder, given(overrides, config_dir), trusted, trust_servers))
    raise typer.Exit(go_on(folder, trusted, trust_servers))


def go_on(folder: Path, trusted: Sequence[str], trust_servers: bool, run: Run = run_folder) -> int:
    """Check that the parts of a sweep have not changed, play its missing runs, and return the exit code."""
    from foundry.composing.preflight import check, check_begun, declare
    from foundry.composing.preparing import model_lines, runner_of

    opened = open_to_run(folder, trusted, trust_servers)
    settings = checked_settings(opened.settings)
    runner = runner_of(settings)
    check_begun(opened, opened.sweep)
    infos = check(opened.sweep_here())
    check_digests(opened.models, model_lines(infos))
    check_declared(opened.sweep, declare(opened.sweep_here()))
    return run(opened, settings, infos, runner)


def _add(folder: Path, overrides: Sequence[str], trusted: Sequence[str], trust_servers: bool) -> int:
    from foundry.composing.defaults import read_defaults
    from foundry.composing.preparing import checked
    from foundry.composing.recorded import compose_growth

    opened = open_to_run(folder, trusted, trust_servers)
    composed = compose_growth(opened, overrides, read_defaults())
    if composed is None:
        return EXIT_OK
    say_defaults(composed)
    check_view(composed.settings["view"])
    added = checked(composed)
    is_whole = all(run.is_complete for run in opened.runs())
    code = EXIT_OK if is_whole else go_on(folder, trusted, trust_servers, _run_unanalyzed)
    return code if code == EXIT_INTERRUPTED else max(code, run_checked(added))


def open_to_run(folder: Path, trusted: Sequence[str], trust_servers: bool) -> SweepFolder:
    """Open a recorded sweep to run it, after checking that it builds only trusted classes and calls trusted servers."""
    from foundry.trust.unknown import check_models, check_settings, check_sweep_targets

    opened = SweepFolder.open(folder)
    opened.check_runnable()
    check_sweep_targets(opened.sweep, opened.settings, trusted)
    opened.sweep = reached_now(opened.sweep)
    if not trust_servers:
        check_models(condition.config["model"] for condition in opened.sweep.conditions)
        check_settings(opened.settings)
    return opened


def reached_now(sweep: Sweep) -> Sweep:
    """Return a recorded sweep; servers named by OLLAMA_HOST and OPENAI_BASE_URL replace its recorded servers."""
    for variable, key in (("OLLAMA_HOST", "hosts"), ("OPENAI_BASE_URL", "base_url")):
        if variable in os.environ:
            sweep = with_hosts(sweep, os.environ[variable], key)
    return sweep


@app.command(rich_help_panel=RUN)
def status(
    place: Annotated[
        str,
        typer.Argument(
            help="A sweep's folder; with --fetch, the URL that was its runner.remote.",
            metavar="DIR|URL",
            parser=folder_text,
        ),
    ],
    fetch: Annotated[Path | None, typer.Option(help="First copy the ended runs from the URL into this folder.")] = None,
    json: AsJson = False,
    config_dir: Mine = None,
) -> None:
    """Show the progress of a sweep, and why runs failed.

    foundry status s3://bucket/prefix --fetch outputs/mine copies runs from a URL, to analyse or resume them here.
    """
    from foundry.display import failure_lines, status_table
    from foundry.storing.standing import failures, standings

    if fetch is None and "://" in place:
        raise InputError(f"'{place}' is a URL. Copy its runs into a folder: foundry status {place} --fetch DIR")
    with only_json(json):
        whole = fetch is None or _fetched(place, fetch)
    opened = SweepFolder.open(fetch or Path(place))
    summaries = [run.summary() for run in opened.runs()]
    shown, failed = standings(opened, summaries), failures(summaries)
    if json:
        print_json({"sweep": opened.path, "models": shown, "failed": failed, **_judged(opened)})
    else:
        console().print(status_table(shown, console().width))
        for line in failure_lines(failed, None) if is_verbose() else failure_lines(failed):
            print(f"failed {line}")
        _print_judged(opened)
    raise typer.Exit(EXIT_OK if whole else EXIT_FAILED)


def _fetched(url: str, folder: Path) -> bool:
    """Copy the ended runs of the sweep at a URL into a folder; return False if one of these runs is damaged."""
    from foundry.running.remote import fetch

    fetched = fetch(url, folder)
    runs = fetched.folder.runs()
    ended = sum(run.ended for run in runs)
    fetched_runs, all_runs = counted(len(fetched.runs), "run"), counted(len(runs), "run")
    print(f"{fetched_runs} fetched; {ended} of {all_runs} in {fetched.folder.path} have ended")
    if fetched.damaged:
        print(f"  damaged at {url}, so not fetched: {', '.join(fetched.damaged)}")
    return not fetched.damaged


def _judged(folder: SweepFolder) -> dict[str, Any]:
    """Return, for JSON, the models with many unreadable replies, and whether the servers are deterministic."""
    from foundry.storing.standing import unread

    lost = [
        {"model": of_model.model, "replies": of_model.replies, "share": of_model.share, "outcomes": of_model.outcomes,
         "examples": of_model.examples}
        for of_model in unread(folder.runs())
    ]  # fmt: skip
    repeated = [
        {"model": line.name, "why": line.why or None}
        | {name: line.repeats and getattr(line.repeats, name) for name in ("at_once", "alone", "loaded")}
        for line in model_repeats(folder)
    ]
    return {"unread": lost, "determinism": repeated}
