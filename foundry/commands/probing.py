"""The commands that put models and people before recorded moments and messages, and people into runs."""

from __future__ import annotations

import itertools
import tempfile
from collections.abc import AsyncIterator, Mapping, Sequence
from contextlib import asynccontextmanager
from dataclasses import dataclass
from functools import partial
from pathlib import Path
from typing import TYPE_CHECKING, Annotated, Any

import typer

from foundry.commands.application import (
    EXIT_OK,
    LOOK,
    OVERRIDES,
    RUN,
    Folder,
    Mine,
    Overrides,
    Trusted,
    TrustedServers,
    app,
    check_belongs,
    console,
    folder_argument,
    given,
    say,
)
from foundry.commands.sweeps import Run, composed_here, go_on, reached_now, run_checked, run_folder, say_defaults
from foundry.commands.view import AskingPage, Browser, Host, Port, check_view, told_to
from foundry.errors import FoundryError, InputError, ModelChangedError
from foundry.expansion import overridden

if TYPE_CHECKING:
    from foundry.composing.compose import Composed
    from foundry.expansion import Sweep
    from foundry.labelling import Text
    from foundry.labels import JudgedBy, Labels
    from foundry.models.base import Model, ModelInfo
    from foundry.probing.composing import Probe
    from foundry.running.local import Runner
    from foundry.storing.store import SweepFolder

SITTING = {"moments": "40", "repeats": "1"}
"""What a person is asked of a probe where nothing else is said: ten minutes, and nothing twice."""


@app.command(context_settings=OVERRIDES, rich_help_panel=LOOK)
def label(
    folder: Folder,
    model: Annotated[str, typer.Option(help="The model that labels, as in model=...", show_default=False)],
    overrides: Overrides = None,
    trust_servers: TrustedServers = False,
    config_dir: Mine = None,
) -> None:
    """Have a model say which messages of a sweep are warnings; foundry play DIR --label asks people.

    Takes a sweep's folder: foundry label outputs/<sweep> --model qwen3:4b; overrides of model.* may follow. Each
    distinct text is asked about once, and answers are cached. `foundry analyze --labeller model` then takes these
    labels instead of the rule.
    """
    _label_by_model(_opened_to_label(folder, trust_servers), [f"model={model}", *given(overrides, config_dir)])


def _opened_to_label(folder: Path, trust_servers: bool) -> SweepFolder:
    """Open a sweep whose cache of answers may be used."""
    from foundry.storing.store import SweepFolder
    from foundry.trust.unknown import check_settings

    opened = SweepFolder.open(folder)
    if not trust_servers:
        check_settings({"cache": opened.settings.get("cache", {})})
    return opened


def _label_by_model(opened: SweepFolder, overrides: Sequence[str]) -> None:
    import asyncio

    from analysis.labelling import model_labelling
    from foundry.labelling import texts_of

    texts = list(texts_of(opened))
    if not texts:
        raise InputError(f"No message was said in the runs of '{opened.path}': there is nothing to label.")
    composed = composed_here(overrides)
    if composed is None:
        return
    labels = asyncio.run(_ask(composed, _cache_of(opened, composed), texts))
    opened.write_labels(labels)
    unreadable = sum(one.warning is None for one in labels.labels)
    print(f"{len(texts)} distinct texts labelled, {unreadable} of them with no readable answer")
    print(model_labelling(opened).note())
    print(f"labels in {opened.labels_file}")


def label_by_person(
    folder: Path, overrides: Sequence[str], page: AskingPage, *, replies: bool, most: int, trust_servers: bool
) -> None:
    """Ask a person on a page which messages of a sweep are warnings, or what its replies decide."""
    import asyncio

    from analysis.labelling import question, reading_question
    from analysis.labelling.people import labellers, labellers_table, write_labellers
    from foundry.display import frame_table
    from foundry.models.human.desk import Desk, seated
    from foundry.probing.sitting import drawn, judge, messages_of, people_to_ask, replies_of, schemas_of

    composed = composed_here(overrides)
    if composed is None:
        return
    people = people_to_ask(composed.sweep)
    if len(composed.conditions) > 1 or people != [composed.conditions[0].config["model"]["name"]]:
        raise InputError(f"One person labels at a time, not {', '.join(people)}: give one model=human/NAME.")
    opened = _opened_to_label(folder, trust_servers)
    items = replies_of(opened, most) if replies else drawn(messages_of(opened), most)
    if not items:
        what = "reply that could not be read" if replies else "message"
        raise InputError(f"There is no {what} in the runs of '{opened.path}': there is nothing to label.")
    config = {**composed.conditions[0].config["model"], "schemas": schemas_of(opened)}
    asked, desk = reading_question() if replies else question(), Desk(blind=True)

    async def ask() -> JudgedBy:
        async with _stacked(config, _cache_of(opened, composed)) as stacked:
            return await judge(stacked, asked, items)

    introduction = told_to(people, opened.path.name)
    with page.shown(desk, introduction, leave=desk.leave), seated(desk):
        judged = asyncio.run(ask())
    opened.write_people(opened.people().joined(judged))
    write_labellers(opened)
    print(f"{len(judged.labels)} of {judged.asked} texts labelled by {judged.labeller}, kept in {opened.people_file}")
    table = labellers_table(labellers(opened))
    console().print(frame_table(table.rows, table.columns))
    print(table.caption)


def _cache_of(sweep: SweepFolder, composed: Composed) -> str:
    """Return the sweep's cache of answers, or the usual one where the sweep was moved away from its own."""
    from foundry.models.answers.answers import is_database

    own: str | None = sweep.settings.get("cache", {}).get("path")
    is_there = own is not None and (is_database(own) or Path(own).exists())
    return str(own if is_there else composed.settings["cache"]["path"])


@asynccontextmanager
async def _stacked(config: Mapping[str, Any], cache: str) -> AsyncIterator[Model]:
    """Yield a model whose answers are kept in a cache; both are closed at the end."""
    from foundry.models.answers.answers import Answers
    from foundry.models.answers.opening import open_answers
    from foundry.running.build import build, model_stack

    opened: list[Answers] = []

    def answers() -> Answers:
        opened.append(open_answers(cache))
        return opened[-1]

    built = build(config)
    try:
        yield model_stack(built, answers, await built.inspect())
    finally:
        await built.close()
        for one in opened:
            one.close()


async def _ask(composed: Composed, cache: str, texts: list[Text]) -> Labels:
    from analysis.labelling import FIRES, hand_labelled, question
    from foundry.labelling import Text, label, steady

    async with _stacked(steady(composed.conditions[0].config["model"]), cache) as model:
        try:
            labels = await label(model, question(), texts, [Text(one.text, FIRES) for one in hand_labelled()])
            await model.confirm()
            return labels
        except ModelChangedError as error:
            raise FoundryError(
                f"Model '{model.name}' changed while it labelled ({error.how}). Its answers since it was confirmed "
                "last have left the cache, and no label was written: put the first one back and say it again."
            ) from error


@app.command(context_settings=OVERRIDES, rich_help_panel=RUN)
def probe(
    sweep: Annotated[Path, folder_argument("A sweep's folder; further ones may follow.")],
    overrides: Overrides = None,
    plan: Annotated[bool, typer.Option("--plan", help="Count moments, conditions and calls, and ask nothing.")] = False,
    trust_targets: Trusted = None,
    trust_servers: TrustedServers = False,
    config_dir: Mine = None,
) -> None:
    """Ask every model in the same recorded moments: what does each do, and what makes it do otherwise?

    foundry probe outputs/pilot -m model=qwen3:4b,llama3.2 edit=none,no_fire,mirror

    Beside the overrides of a sweep it takes

    moments=300: how many recorded questions, or the moments.json of an earlier probe;
    moments_seed=0: what they are drawn by;
    window=5: steps of which an agent gives one moment at most; 0 for no limit;
    repeats=10: how often each is asked, each time with a sampling seed of its own;
    edit=none: what is changed in what the agents perceive, such as no_fire,mirror; also of mine/edits/;
    sweep_over=fires.0.distance=1..20: one quantity of it that is moved alone.

    -m format=none,0-9 asks in drawn formats of the prompt.
    """
    further, arguments = folders_first(given(overrides, config_dir))
    folders, trusted = [sweep, *further], trust_targets or ()
    code = _plan_probe(folders, arguments, trusted) if plan else _run_probe(folders, arguments, trusted, trust_servers)
    raise typer.Exit(code)


@app.command(context_settings=OVERRIDES, rich_help_panel=RUN)
def play(
    overrides: Overrides = None,
    label: Annotated[
        bool, typer.Option("--label", help="Ask which messages of a sweep are warnings, not what to do.")
    ] = False,
    replies: Annotated[
        bool | None,
        typer.Option("--replies", help="With --label: ask what replies decide, unread ones among them."),
    ] = None,
    texts: Annotated[int | None, typer.Option(min=1, help="With --label: texts at most, by default 100.")] = None,
    host: Host = "127.0.0.1",
    port: Port = None,
    browser: Browser = True,
    trust_targets: Trusted = None,
    trust_servers: TrustedServers = False,
    config_dir: Mine = None,
) -> None:
    """Ask people on a page, as models are asked.

    foundry play outputs/pilot model=human/ana        in 40 recorded moments of a sweep, as foundry probe

    foundry play model=mix/human/ana@0+qwen3:4b@1-9   in a run, among models

    foundry play outputs/<sweep>                      goes on with what people have not answered yet

    foundry play outputs/<sweep> --label model=human/ana   which messages are warnings; tells how far she agrees with
    the rule, with a model that labelled and with other people
    """
    page = AskingPage(host, port, browser)
    folders, arguments = folders_first(given(overrides, config_dir))
    if label:
        if len(folders) != 1:
            raise InputError("Name one sweep to label: foundry play outputs/<sweep> --label model=human/NAME")
        label_by_person(
            folders[0], arguments, page, replies=bool(replies), most=texts or 100, trust_servers=trust_servers
        )
        return
    check_belongs("--label", {"replies": replies, "texts": texts})
    sitting, trusted = _Sitting(page), trust_targets or ()
    if not folders:
        raise typer.Exit(_play_run(arguments, sitting))
    if not any("=" in argument for argument in arguments):
        raise typer.Exit(_go_on_playing(folders, trusted, trust_servers, sitting))
    keys = overridden(arguments)
    usual = [f"{key}={value}" for key, value in SITTING.items() if key not in keys]
    raise typer.Exit(_run_probe(folders, [*usual, *arguments], trusted, trust_servers, sitting))


def folders_first(arguments: Sequence[str]) -> tuple[list[Path], list[str]]:
    """Return the folders that a command line begins with, and the rest."""
    folders = list(itertools.takewhile(lambda one: "=" not in one and not one.startswith("-"), arguments))
    return [Path(one) for one in folders], list(arguments[len(folders) :])


def _plan_probe(folders: Sequence[Path], arguments: Sequence[str], trusted: Sequence[str]) -> int:
    """Print what a probe would ask; nothing is asked, not even a server."""
    from foundry.composing.defaults import read_defaults
    from foundry.display import frame_table
    from foundry.probing.composing import compose_probe, planned

    composed = compose_probe(_opened(folders, trusted), arguments, read_defaults())
    if composed is None:
        return EXIT_OK
    with tempfile.TemporaryDirectory() as scratch:
        rows = planned(composed, Path(scratch))
    texts = [(one.edit, str(one.moments), str(one.conditions), f"{one.calls:,}") for one in rows]
    console().print(frame_table(texts, ("edit", "moments", "conditions", "calls")))
    say(f"{composed.asked}; here {sum(one.calls for one in rows):,}")
    return EXIT_OK


def _opened(folders: Sequence[Path], trusted: Sequence[str]) -> list[SweepFolder]:
    from foundry.storing.store import SweepFolder
    from foundry.trust.unknown import check_sweep_targets

    sweeps = [SweepFolder.open(path) for path in folders]
    for one in sweeps:
        check_sweep_targets(one.sweep, one.settings, trusted)
        one.sweep = reached_now(one.sweep)
    return sweeps


def composed_probe(
    folders: Sequence[Path], arguments: Sequence[str], trusted: Sequence[str], trust_servers: bool
) -> Probe | None:
    """Return a probe whose servers may be asked; None where Hydra answered the command line itself."""
    from foundry.composing.defaults import read_defaults
    from foundry.probing.composing import compose_probe
    from foundry.trust.unknown import check_models

    sweeps = _opened(folders, trusted)
    probe = compose_probe(sweeps, arguments, read_defaults())
    if probe is not None and not trust_servers:
        models = [condition.config["model"] for condition in probe.composed.conditions]
        recorded = [condition.config["model"] for one in sweeps for condition in one.sweep.conditions]
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
    from foundry.storing.store import SweepFolder
    from foundry.trust.unknown import check_sweep_targets

    if len(folders) > 1:
        raise InputError("Several sweeps cannot be gone on with at once: name one, or add model=human/<name> to probe.")
    opened = SweepFolder.open(folders[0])
    check_sweep_targets(opened.sweep, opened.settings, trusted)
    run = sitting.checked_for(opened.sweep)
    return go_on(folders[0], trusted, trust_servers, run)


@dataclass(frozen=True)
class _Sitting:
    """Sweeps that are run beside a page on which people are asked."""

    page: AskingPage

    def checked_for(self, sweep: Sweep) -> Run:
        """Return what runs a sweep beside the page."""
        from foundry.probing.sitting import people_to_ask

        return partial(self._run, people_to_ask(sweep))

    def _run(
        self, people: Sequence[str], folder: SweepFolder, settings: Any, infos: dict[str, ModelInfo], runner: Runner
    ) -> int:
        """Run what has not ended in this process, whatever its settings say, and without a page that shows replies."""
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
        with self.page.shown(desk, told_to(people, folder.path.name), leave=leave, look=look, far=far):
            return run_folder(folder, {**settings, "view": None}, infos, alone)
