"""The command that has a model say which messages are warnings."""

from __future__ import annotations

from pathlib import Path
from typing import TYPE_CHECKING, Annotated, Any

import typer

from foundry.commands.application import OVERRIDES, Folder, TrustedServers, app
from foundry.errors import FoundryError, InputError, ModelChangedError

if TYPE_CHECKING:
    from foundry.composing.compose import Composed
    from foundry.labelling import Text
    from foundry.labels import Labels
    from foundry.storing.store import SweepFolder


@app.command(context_settings=OVERRIDES)
def label(
    context: typer.Context,
    folder: Folder,
    model: Annotated[str, typer.Option(help="The model that labels, as in model=...", show_default=False)],
    trust_servers: TrustedServers = False,
) -> None:
    """Have a model say which messages of a sweep are warnings.

    Takes a sweep's folder: foundry label outputs/<sweep> --model qwen3:4b; overrides of model.* may follow. Each
    distinct text is asked about once, and answers are cached. `foundry analyze --labeller model` then takes these
    labels instead of the rule.
    """
    import asyncio

    from analysis.labelling import model_labelling
    from foundry.composing.compose import compose
    from foundry.labelling import texts_of
    from foundry.storing.store import SweepFolder
    from foundry.trust import reaching

    opened = SweepFolder.open(folder)
    if not trust_servers:
        reaching.check_settings({"cache": opened.settings.get("cache", {})})
    texts = texts_of(opened)
    if not texts:
        raise InputError(f"No message was said in the runs of '{folder}': there is nothing to label.")
    composed = compose([f"model={model}", *context.args])
    if composed is None:
        return
    labels = asyncio.run(_ask(composed, _cache_of(opened, composed), texts))
    opened.write_labels(labels)
    unreadable = sum(one.warning is None for one in labels.labels)
    print(f"{len(texts)} distinct texts labelled, {unreadable} of them with no readable answer")
    print(model_labelling(opened).note())
    print(f"labels in {opened.labels_file}")


def _cache_of(sweep: SweepFolder, composed: Composed) -> str:
    """Return the sweep's cache of answers, or the usual one where the sweep was moved away from its own."""
    from foundry.models.answers.addresses import is_database

    own: str | None = sweep.settings.get("cache", {}).get("path")
    is_there = own is not None and (is_database(own) or Path(own).exists())
    return str(own if is_there else composed.settings["cache"]["path"])


async def _ask(composed: Composed, cache: str, texts: list[Text]) -> Labels:
    from analysis.labelling import FIRES, hand_labelled, question
    from foundry.labelling import Text, label, steady
    from foundry.models.answers.base import Answers
    from foundry.models.answers.opening import open_answers
    from foundry.running.build import build, model_stack

    opened: list[Answers] = []

    def answers() -> Answers:
        opened.append(open_answers(cache))
        return opened[-1]

    config: dict[str, Any] = steady(composed.conditions[0].config["model"])
    built = build(config)
    try:
        model = model_stack(built, answers, await built.inspect())
        labels = await label(model, question(), texts, [Text(one.text, FIRES) for one in hand_labelled()])
        await model.confirm()
        return labels
    except ModelChangedError as error:
        raise FoundryError(
            f"Model '{built.name}' changed while it labelled ({error.how}). Its answers since it was confirmed last "
            "have left the cache, and no label was written: put the first one back and say it again."
        ) from error
    finally:
        await built.close()
        for one in opened:
            one.close()
