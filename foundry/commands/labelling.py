"""The commands by which models and people label the texts of a sweep."""

from __future__ import annotations

from collections.abc import AsyncIterator, Mapping, Sequence
from contextlib import asynccontextmanager
from pathlib import Path
from typing import TYPE_CHECKING, Annotated, Any

import typer

from foundry.commands.application import LOOK, OVERRIDES, app
from foundry.commands.options import Folder, Mine, TrustedServers, given
from foundry.commands.printing import console
from foundry.commands.sweeps import composed_here
from foundry.commands.view import AskingPage
from foundry.errors import FoundryError, InputError, ModelChangedError
from foundry.storing.store import SweepFolder

if TYPE_CHECKING:
    from foundry.composing.compose import Composed
    from foundry.labels.definition import Label
    from foundry.labels.folder import Judge, LabelFolder
    from foundry.labels.items import Item
    from foundry.labels.judging import Texts
    from foundry.labels.sampling import Sample
    from foundry.models.base import Model

_TEXTS = {
    "message": "messages",
    "decision": "replies",
    "reply": "replies in 3D",
    "moment": "replies in a probe",
}


@app.command(context_settings=OVERRIDES, rich_help_panel=LOOK)
def label(
    folder: Folder,
    model: Annotated[str, typer.Option(help="The model that labels, as in model=...")],
    overrides: Annotated[
        list[str] | None,
        typer.Argument(metavar="[LABEL] OVERRIDES", help="The label, by default warning; then overrides of model."),
    ] = None,
    trust_servers: TrustedServers = False,
    config_dir: Mine = None,
) -> None:
    """Have a model label the texts of a sweep; foundry play DIR --label NAME asks people.

    foundry label outputs/<sweep> refusal --model qwen3:4b

    Asks about each distinct text once, and caches the answers. `foundry analyze --labeller model` then uses these
    labels instead of a rule.
    """
    import asyncio  # it takes a seventh of the time of foundry --help

    from foundry.labels.definition import label_named
    from foundry.labels.folder import LabelFolder

    arguments = list(overrides or ())
    name = arguments.pop(0) if arguments and "=" not in arguments[0] and not arguments[0].startswith("-") else "warning"
    opened, asked = _opened(folder, trust_servers), label_named(name)
    texts = _texts_of(opened, asked)
    composed = composed_here([f"model={model}", *given(arguments, config_dir)])
    if composed is None:
        return
    judge = asyncio.run(_ask(composed, _cache_of(opened, composed), asked, texts))
    file = LabelFolder.of(opened, name).keep_judge(judge)
    unreadable = sum(judgement.label is None for judgement in judge.judgements)
    print(f"{len(texts)} distinct texts labelled; for {unreadable} of them the answer was unreadable")
    if judge.by_hand:
        from analysis.labelling import labelling_of

        print(labelling_of(opened, by_model=True).note())
    print(f"labels in {file}")


def _texts_of(sweep: SweepFolder, label: Label) -> Texts:

    sweeps = [sweep, *([SweepFolder.open(sweep.baselines_dir)] if sweep.baselines_dir.exists() else [])]
    return list({item.content: (item.text, item.context) for item in _items_of(sweeps, label)}.values())


def _items_of(sweeps: Sequence[SweepFolder], label: Label) -> list[Item]:
    """Return the texts of sweeps to which a label applies.

    Raises:
        InputError: there is no such text.
    """
    from foundry.labels.items import items_of

    items = [item for sweep in sweeps for item in items_of(sweep, label)]
    if not items:
        raise InputError(
            f"The complete runs of '{sweeps[0].path}' have no {_TEXTS[label.unit]}, so label '{label.name}' "
            "has nothing to label."
        )
    return items


def _opened(folder: Path, trust_servers: bool) -> SweepFolder:

    from foundry.trust.unknown import check_settings

    opened = SweepFolder.open(folder)
    if not trust_servers:
        check_settings({"cache": opened.settings.get("cache", {})})
    return opened


def label_by_people(folder: Path, name: str, per_model: int | None, page: AskingPage) -> None:
    """Serve a page on which people label texts of a sweep, until all people have ended or Ctrl-C is pressed."""
    from analysis.labelling.people import labellers, labellers_table, write_labellers
    from foundry.display import frame_table
    from foundry.labels.definition import label_named
    from foundry.labels.desk import LabelDesk
    from foundry.labels.folder import LabelFolder

    opened, asked = SweepFolder.open(folder), label_named(name)
    label_folder = LabelFolder.of(opened, name)
    sample = _sample(opened, asked, label_folder, per_model)
    desk = LabelDesk(label_folder, asked, sample)
    texts = sum(stratum.size for stratum in sample.strata)
    print(f"{len(sample.drawn)} texts were drawn from {texts}, in {label_folder.path}")
    with page.labelling(desk, f"label: {name.replace('_', ' ')}") as ended:
        try:
            ended.wait()
        except KeyboardInterrupt:
            print("ended")
    for person, done in desk.done().items():
        print(f"{person}: {done} of {len(sample.drawn)} texts labelled")
    table = labellers_table(labellers(opened))
    if write_labellers(opened):
        console().print(frame_table(table.rows, table.columns))
        print(table.caption)
    print(f"next: foundry analyze {folder}")


def _sample(sweep: SweepFolder, label: Label, label_folder: LabelFolder, per_model: int | None) -> Sample:
    """Return the sample of texts to label, extended if more texts are requested; it is stored before anyone labels."""
    from foundry.labels.items import complete_runs
    from foundry.labels.sampling import Sample, extended

    before = label_folder.sample()
    if before is not None and before.question_sha256 != label.question_sha256:
        raise InputError(
            f"The texts in {label_folder.path} were drawn for an earlier wording of the question '{label.name}'. "
            "Restore this wording, or write the new wording into a label file with another name."
        )
    empty = Sample(label=label.name, question_sha256=label.question_sha256, seed=0)
    runs = [run.id for run in complete_runs(sweep)]
    sample = extended(before or empty, label, _items_of([sweep], label), runs, per_model)
    if sample != before:
        label_folder.keep_sample(sample)
    return sample


def _cache_of(sweep: SweepFolder, composed: Composed) -> str:
    """Return the address of the sweep's answer cache; if it is missing, perhaps since a move, of the usual one."""
    from foundry.models.answers.answers import is_database

    own: str | None = sweep.settings.get("cache", {}).get("path")
    is_there = own is not None and (is_database(own) or Path(own).exists())
    return str(own if is_there else composed.settings["cache"]["path"])


@asynccontextmanager
async def _stacked(config: Mapping[str, Any], cache: str) -> AsyncIterator[Model]:

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
        for store in opened:
            store.close()


async def _ask(composed: Composed, cache: str, label: Label, texts: Texts) -> Judge:
    from analysis.labelling import FIRES, WARNING, hand_labelled
    from foundry.labels.judging import judge, steady

    by_hand: Texts = [(message.text, {"fires": FIRES}) for message in hand_labelled()] if label.name == WARNING else []
    async with _stacked(steady(composed.conditions[0].config["model"]), cache) as model:
        try:
            judged = await judge(model, label, texts, by_hand)
            await model.confirm()
            return judged
        except ModelChangedError as error:
            raise FoundryError(
                f"Model '{model.name}' changed while it labelled ({error.how}), so no label was written. Answers "
                "after the last weights check were removed from the cache. Restore the first weights and run the "
                "command again."
            ) from error
