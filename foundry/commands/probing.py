"""The commands probe (models answer in recorded moments) and play (people answer, in recorded moments or runs)."""

from __future__ import annotations

import itertools
import tempfile
from collections.abc import Sequence
from dataclasses import dataclass
from functools import partial
from pathlib import Path
from typing import TYPE_CHECKING, Annotated, Any

import typer

from foundry.commands.application import EXIT_OK, OVERRIDES, RUN, app
from foundry.commands.labelling import label_by_people
from foundry.commands.options import (
    Browser,
    Host,
    Mine,
    Overrides,
    Port,
    Trusted,
    TrustedServers,
    check_belongs,
    folder_argument,
    given,
)
from foundry.commands.printing import console, say
from foundry.commands.sweeps import Run, composed_here, go_on, reached_now, run_checked, run_folder, say_defaults
from foundry.commands.view import AskingPage, check_view, terms_for
from foundry.errors import InputError
from foundry.expansion import Sweep, overridden
from foundry.own_code import CONFIG_DIR, config_dirs
from foundry.storing.store import SweepFolder

if TYPE_CHECKING:
    from foundry.models.base import ModelInfo
    from foundry.probing.composing import Probe
    from foundry.running.local import Runner

SITTING = {"moments": "40", "repeats": "1"}
"""The default settings of a probe for people: it takes about ten minutes and asks no question twice."""


@app.command(context_settings=OVERRIDES, rich_help_panel=RUN)
def probe(
    sweep: Annotated[Path, folder_argument("A sweep's folder; further ones may follow.")],
    overrides: Overrides = None,
    plan: Annotated[bool, typer.Option("--plan", help="Count moments, conditions and calls, and ask nothing.")] = False,
    trust_targets: Trusted = None,
    trust_servers: TrustedServers = False,
    config_dir: Mine = None,
) -> None:
    """Ask every model the same recorded questions, and find out what changes its choices.

    foundry probe outputs/pilot -m model=qwen3:4b,llama3.2 edit=none,no_fire,mirror

    Takes the overrides of a sweep, and these:

    moments=300: number of recorded questions (moments), or the moments.json of an earlier probe;
    moments_seed=0: seed by which the moments are drawn;
    window=5: at most one moment of an agent in so many steps; 0 sets no limit;
    repeats=10: number of times that each question is asked, each with another sampling seed; with model.logprobs once,
    if the probabilities of the reply can replace the repeats;
    edit=none: changes of the observation, such as no_fire,mirror, or your own from mine/edits/;
    sweep_over=fires.0.distance=1..20: a number in the observation that takes each of these values.

    -m format=none,0-9 asks with randomly drawn formats of the prompt.
    """
    further, arguments = folders_first(given(overrides, config_dir))
    folders, trusted = [sweep, *further], trust_targets or ()
    code = _plan_probe(folders, arguments, trusted) if plan else _run_probe(folders, arguments, trusted, trust_servers)
    raise typer.Exit(code)


@app.command(context_settings=OVERRIDES, rich_help_panel=RUN)
def play(
    overrides: Overrides = None,
    label: Annotated[
        str | None, typer.Option(help="Let people label texts of a sweep with warning, refusal or another label.")
    ] = None,
    per_model: Annotated[
        int | None, typer.Option(min=1, help="With --label: number of texts per model; default 200.")
    ] = None,
    host: Host = "127.0.0.1",
    port: Port = None,
    browser: Browser = True,
    trust_targets: Trusted = None,
    trust_servers: TrustedServers = False,
    config_dir: Mine = None,
) -> None:
    """Let people answer the questions of models on a web page.

    foundry play outputs/pilot model=human/ana        40 recorded moments of a sweep, as in foundry probe

    foundry play model=mix/human/ana@0+qwen3:4b@1-9   a run together with models

    foundry play outputs/<sweep>                      the questions that people have not answered yet

    foundry play outputs/<sweep> --label warning      people say which of 200 texts per model are warnings; foundry
    analyze then corrects its measures of warnings by their labels
    """
    page = AskingPage(host, port, browser)
    folders, arguments = folders_first(given(overrides, config_dir))
    if label is not None:
        if len(folders) != 1 or _overrides_alone(arguments):
            raise InputError(
                "--label takes one sweep and nothing else, as in foundry play outputs/<sweep> --label warning. People "
                "enter their names on the page."
            )
        label_by_people(folders[0], label, per_model, page)
        return
    check_belongs("--label", {"per-model": per_model})
    sitting, trusted = _Sitting(page), trust_targets or ()
    if not folders:
        raise typer.Exit(_play_run(arguments, sitting))
    if not any("=" in argument for argument in arguments):
        raise typer.Exit(_go_on_playing(folders, trusted, trust_servers, sitting))
    keys = overridden(arguments)
    usual = [f"{key}={value}" for key, value in SITTING.items() if key not in keys]
    raise typer.Exit(_run_probe(folders, [*usual, *arguments], trusted, trust_servers, sitting))


def _overrides_alone(arguments: Sequence[str]) -> list[str]:
    folders = list(config_dirs(arguments))
    return [argument for argument in arguments if argument not in (*CONFIG_DIR, *map(str, folders))]


def folders_first(arguments: Sequence[str]) -> tuple[list[Path], list[str]]:
    """Split a command line into the folders at its beginning, and the other arguments."""
    folders = list(
        itertools.takewhile(lambda argument: "=" not in argument and not argument.startswith("-"), arguments)
    )
    return [Path(folder) for folder in folders], list(arguments[len(folders) :])


def _plan_probe(folders: Sequence[Path], arguments: Sequence[str], trusted: Sequence[str]) -> int:

    from foundry.composing.defaults import read_defaults
    from foundry.display import frame_table
    from foundry.probing.composing import compose_probe, planned

    composed = compose_probe(_opened(folders, trusted), arguments, read_defaults())
    if composed is None:
        return EXIT_OK
    with tempfile.TemporaryDirectory() as scratch:
        rows = planned(composed, Path(scratch))
    texts = [(row.edit, str(row.moments), str(row.conditions), f"{row.calls:,}") for row in rows]
    console().print(frame_table(texts, ("edit", "moments", "conditions", "calls")))
    say(f"{composed.asked}; with these edits, calls: {sum(row.calls for row in rows):,}")
    return EXIT_OK


def _opened(folders: Sequence[Path], trusted: Sequence[str]) -> list[SweepFolder]:
    from foundry.trust.unknown import check_sweep_targets

    sweeps = [SweepFolder.open(path) for path in folders]
    for sweep in sweeps:
        check_sweep_targets(sweep.sweep, sweep.settings, trusted)
        sweep.sweep = reached_now(sweep.sweep)
    return sweeps


def composed_probe(
    folders: Sequence[Path], arguments: Sequence[str], trusted: Sequence[str], trust_servers: bool
) -> Probe | None:
    """Return a probe, after checking that its servers may be called; None if Hydra answered the command line itself."""
    from foundry.composing.defaults import read_defaults
    from foundry.probing.composing import compose_probe
    from foundry.trust.unknown import check_models

    sweeps = _opened(folders, trusted)
    probe = compose_probe(sweeps, arguments, read_defaults())
    if probe is not None and not trust_servers:
        models = [condition.config["model"] for condition in probe.composed.conditions]
        recorded = [condition.config["model"] for sweep in sweeps for condition in sweep.sweep.conditions]
        check_models(models, typed=arguments, recorded=recorded)
    return probe


def _run_probe(
    folders: Sequence[Path],
    arguments: Sequence[str],
    trusted: Sequence[str],
    trust_servers: bool,
    sitting: _Sitting | None = None,
) -> int:
    from foundry.composing.preparing import checked

    composed = composed_probe(folders, arguments, trusted, trust_servers)
    if composed is None:
        return EXIT_OK
    run = sitting.checked_for(composed.composed.sweep) if sitting else run_folder
    say_defaults(composed.composed)
    check_view(composed.composed.settings["view"])
    with tempfile.TemporaryDirectory() as scratch:
        ready = checked(composed.composed, partial(composed.placed, Path(scratch)))
    say(composed.asked)
    return run_checked(ready, composed.keep, run)


def _play_run(arguments: Sequence[str], sitting: _Sitting) -> int:
    from foundry.composing.preparing import checked

    composed = composed_here(arguments)
    if composed is None:
        return EXIT_OK
    run = sitting.checked_for(composed.sweep)
    check_view(composed.settings["view"])
    return run_checked(checked(composed), run=run)


def _go_on_playing(folders: Sequence[Path], trusted: Sequence[str], trust_servers: bool, sitting: _Sitting) -> int:
    from foundry.trust.unknown import check_sweep_targets

    if len(folders) > 1:
        raise InputError("Only one sweep can be continued at a time. Name one, or add model=human/<name> to probe all.")
    opened = SweepFolder.open(folders[0])
    check_sweep_targets(opened.sweep, opened.settings, trusted)
    run = sitting.checked_for(opened.sweep)
    return go_on(folders[0], trusted, trust_servers, run)


@dataclass(frozen=True)
class _Sitting:
    """Runs a sweep while it serves a page on which people answer."""

    page: AskingPage

    def checked_for(self, sweep: Sweep) -> Run:
        """Return a function that plays the runs of a sweep while the page is served."""
        from foundry.probing.sitting import people_to_ask

        return partial(self._run, people_to_ask(sweep))

    def _run(
        self, people: Sequence[str], folder: SweepFolder, settings: Any, infos: dict[str, ModelInfo], runner: Runner
    ) -> int:
        """Play the unfinished runs in this process. The viewer is off: people could see replies of models there."""
        from foundry.models.human.desk import Desk
        from foundry.probing.sitting import SittingRunner, how_far

        blind = folder.moments_file.exists()
        desk = Desk(blind=blind)
        alone = SittingRunner(desk, together=blind)
        stop_file = folder.stop_file(alone.session)
        folder.start_progress(alone.session)

        def look() -> None:
            if stop_file.exists():
                desk.leave()

        leave = partial(folder.ask_to_stop, alone.session)
        far = (lambda: None) if blind else how_far(folder)
        with self.page.shown(desk, terms_for(people, folder.path.name), leave=leave, look=look, far=far):
            return run_folder(folder, {**settings, "view": None}, infos, alone)
