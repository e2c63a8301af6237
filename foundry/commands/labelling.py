"""Has a model or a person say which messages are warnings, and a person what replies decide."""

from __future__ import annotations

from collections.abc import AsyncIterator, Mapping, Sequence
from contextlib import asynccontextmanager
from pathlib import Path
from typing import TYPE_CHECKING, Annotated, Any

import typer

from foundry.commands.application import LOOK, OVERRIDES, Folder, Mine, Overrides, TrustedServers, app, console, given
from foundry.commands.sweeps import composed_here
from foundry.commands.view import AskingPage, told_to
from foundry.errors import FoundryError, InputError, ModelChangedError

if TYPE_CHECKING:
    from foundry.composing.compose import Composed
    from foundry.labelling import Text
    from foundry.labels import JudgedBy, Labels
    from foundry.models.base import Model
    from foundry.storing.store import SweepFolder


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
    _label_by_model(_opened(folder, trust_servers), [f"model={model}", *given(overrides, config_dir)])


def _opened(folder: Path, trust_servers: bool) -> SweepFolder:
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
    """Ask a person on a page which messages of a sweep are warnings, or what its replies decide.

    Args:
        folder: the sweep's folder.
        overrides: what names the person: model=human/NAME.
        page: where the person is asked.
        replies: whether replies are labelled in place of messages.
        most: texts at most.
        trust_servers: whether the server of the recorded cache may be reached.
    """
    import asyncio

    from analysis.labelling import question, reading_question
    from analysis.labelling.people import labellers, labellers_table, write_labellers
    from foundry.display import frame_table
    from foundry.models.human.desk import Desk, seated
    from foundry.probing.judging import drawn, judge, messages_of, replies_of, schemas_of
    from foundry.probing.sitting import people_to_ask

    composed = composed_here(overrides)
    if composed is None:
        return
    people = people_to_ask(composed.sweep)
    if len(composed.conditions) > 1 or people != [composed.conditions[0].config["model"]["name"]]:
        raise InputError(f"One person labels at a time, not {', '.join(people)}: give one model=human/NAME.")
    opened = _opened(folder, trust_servers)
    items = replies_of(opened, most) if replies else drawn(messages_of(opened), most)
    if not items:
        what = "reply that could not be read" if replies else "message"
        raise InputError(f"There is no {what} in the runs of '{opened.path}': there is nothing to label.")
    config = {**composed.conditions[0].config["model"], "schemas": schemas_of(opened)}
    asked, desk = reading_question() if replies else question(), Desk(blind=True)

    async def ask() -> JudgedBy:
        async with _stacked(config, _cache_of(opened, composed)) as stacked:
            return await judge(stacked, asked, items)

    told = told_to(people, opened.path.name)
    with page.shown(desk, told, leave=desk.leave), seated(desk):
        found = asyncio.run(ask())
    opened.write_people(opened.people().joined(found))
    write_labellers(opened)
    print(f"{len(found.labels)} of {found.asked} texts labelled by {found.labeller}, kept in {opened.people_file}")
    table = labellers_table(labellers(opened))
    console().print(frame_table(table.rows, table.columns))
    print(table.caption)


def _cache_of(sweep: SweepFolder, composed: Composed) -> str:
    """Return the sweep's cache of answers, or the usual one where the sweep was moved away from its own."""
    from foundry.models.answers.addresses import is_database

    own: str | None = sweep.settings.get("cache", {}).get("path")
    is_there = own is not None and (is_database(own) or Path(own).exists())
    return str(own if is_there else composed.settings["cache"]["path"])


@asynccontextmanager
async def _stacked(config: Mapping[str, Any], cache: str) -> AsyncIterator[Model]:
    """Yield a model whose answers are kept in a cache; both are closed at the end."""
    from foundry.models.answers.base import Answers
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
