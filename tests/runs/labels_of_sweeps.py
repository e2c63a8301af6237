"""Labels of a sweep as a model and people would have given them, written without asking anybody."""

from collections.abc import Callable, Mapping

from analysis.labelling import FIRES
from foundry.labels.definition import Label, label_named
from foundry.labels.folder import Entry, Judge, Judgement, LabelFolder
from foundry.labels.items import complete_runs, items_of
from foundry.labels.sampling import Sample, SampledText, extended
from foundry.storing.store import SweepFolder


def judge(
    sweep: SweepFolder, texts: Mapping[str, str | None], fires: tuple[str, ...], by_hand: Mapping[str, str | None],
    name: str = "judge:1b",
) -> None:  # fmt: skip
    """Write what a model says of messages by text, and of the texts that were labelled by hand."""
    label = label_named("warning")

    def said(labels: Mapping[str, str | None], names: tuple[str, ...]) -> tuple[Judgement, ...]:
        return tuple(
            Judgement(text=text, context={"fires": names}, label=one, reply="") for text, one in labels.items()
        )

    LabelFolder.of(sweep, "warning").keep_judge(
        Judge(
            labeller=name, digest="ab" * 32, question_sha256=label.question_sha256, parameters={},
            judgements=said(texts, fires), by_hand=said(by_hand, FIRES),
        )
    )  # fmt: skip


def draw(sweep: SweepFolder, label: Label, per_model: int = 200) -> Sample:
    empty = Sample(label=label.name, question_sha256=label.question_sha256, seed=0)
    runs = [run.id for run in complete_runs(sweep)]
    sample = extended(empty, label, items_of(sweep, label), runs, per_model)
    LabelFolder.of(sweep, label.name).keep_sample(sample)
    return sample


def label_all(
    sweep: SweepFolder, label: Label, person: str, answer: Callable[[SampledText], str], per_model: int = 200
) -> int:
    """Draw texts and have a person label all of them; returns how many."""
    sample, folder = draw(sweep, label, per_model), LabelFolder.of(sweep, label.name)
    for picture in sample.drawn:
        folder.add(person, Entry(item=picture.item, label=answer(picture)))
    return len(sample.drawn)
