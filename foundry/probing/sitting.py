"""People at a page: runs a sweep in which they are asked, and has them label texts of a sweep."""

from __future__ import annotations

import asyncio
import hashlib
from collections.abc import Callable, Iterator, Mapping, Sequence
from dataclasses import dataclass, replace
from string import Template
from typing import Any

import msgspec

from foundry.errors import InputError, Interrupted
from foundry.expansion import Sweep, settings_key
from foundry.labelling import KIND, SAMPLING_SEED, texts_of
from foundry.labels import NONE, REPLIES, WARNINGS, Judged, JudgedBy
from foundry.models.base import ChatMessage, Model, Reply, Request, RequestKeys
from foundry.models.human.desk import Desk, Schema, seated
from foundry.models.human.human_model import HumanModel
from foundry.records import Call, Outcome
from foundry.running.build import build, members_of
from foundry.running.lane import MOST_OPEN, LaneSpec
from foundry.running.local import LocalRunner, SweepJob, new_session
from foundry.running.progress import SweepProgress
from foundry.storing.matching import with_calls
from foundry.storing.store import RunFolder, SweepFolder, lines_of
from foundry.worlds.compared import Line, compared_of

YES_NO = ("yes", "no")
UNREAD = (Outcome.UNREADABLE, Outcome.TRUNCATED)
READ = (Outcome.CHOSEN, Outcome.REPAIRED)


class SittingRunner(LocalRunner):
    """Runs what a sweep still lacks while people sit at a desk.

    Attributes:
        session: what its worker's name begins with, known before the page on which a person can end it.
    """

    def __init__(self, desk: Desk, *, together: bool) -> None:
        """Set where people are asked.

        Args:
            desk: where their questions wait.
            together: whether the questions of all runs wait at once, as those of a probe may; else a run is played
                after another, and round by round.
        """
        super().__init__(workers=1, ahead=False)
        self.session = new_session()
        self._desk = desk
        self._at_once = MOST_OPEN if together else 1

    def spec(self, job: SweepJob, runs: Sequence[RunFolder], number: int) -> LaneSpec:
        """Return what the one worker is given."""
        return replace(super().spec(job, runs, number), open_runs=self._at_once)

    def run(self, job: SweepJob) -> None:
        """Run everything that has not ended; nothing is asked any more when this returns.

        Raises:
            SweepStopped: a failure that no further run could escape.
            SweepInterrupted: someone asked to stop.
        """
        with seated(self._desk):
            super().run(replace(job, session=self.session))


def people_in(sweep: Sweep) -> list[str]:
    """Return the names of the models of a sweep that are people, those in populations among them."""
    configs = {settings_key(one.config["model"]): one.config["model"] for one in sweep.conditions}
    models = (member for config in configs.values() for member in members_of(build(config)))
    return list(dict.fromkeys(model.name for model in models if isinstance(model, HumanModel)))


def people_to_ask(sweep: Sweep) -> list[str]:
    """Return the names of the people among the models of a sweep.

    Raises:
        InputError: there are none.
    """
    names = people_in(sweep)
    if not names:
        raise InputError(
            "Nobody is asked here: name a person among the models, model=human/<name> or "
            "model=mix/human/<name>@0+<model>@1-9, or leave out 'play'."
        )
    return names


def how_far(folder: SweepFolder) -> Callable[[], float]:
    """Return what says how far a sweep is, 0..1: calls that were made, or will not be, of all that it makes at most."""
    progress = SweepProgress(folder)

    def share() -> float:
        totals = progress.by_model().values()
        return sum(one.done for one in totals) / max(1, sum(one.most for one in totals))

    return share


@dataclass(frozen=True)
class Item:
    """A text that is to be labelled.

    Attributes:
        judged: the text, without its label.
        options: what it can be.
        shown: what the template of the question is filled with.
    """

    judged: Judged
    options: tuple[str, ...]
    shown: Mapping[str, str]


def _kind(options: Sequence[str]) -> str:
    return f"{KIND}: {', '.join(options)}"


def messages_of(sweep: SweepFolder) -> list[Item]:
    """Return the distinct messages of a sweep, to be told whether they warn of a fire."""
    return [
        Item(
            Judged(text=one.text, seed=seed, label="", fires=one.fires),
            YES_NO,
            {"message": one.text, "fires": ", ".join(one.fires) or "none"},
        )
        for one, seed in texts_of(sweep).items()
    ]


def replies_of(sweep: SweepFolder, most: int) -> list[Item]:
    """Return distinct replies, to be told what they decide: those that could not be read, and as many that could.

    The person cannot know which are which. Replies to questions that are not answered by one of a closed set of labels
    are left out.

    Args:
        sweep: the sweep.
        most: how many replies at most.
    """
    found: dict[tuple[str, str], Item] = {}
    for item in (item for run in sweep.runs() for item in _replies_in(run)):
        found.setdefault((item.judged.text, item.judged.kind), item)
    lost = drawn([one for one in found.values() if one.judged.recorded == NONE], most // 2)
    read = drawn([one for one in found.values() if one.judged.recorded != NONE], len(lost))
    return [*lost, *read]


def drawn(items: Sequence[Item], most: int) -> list[Item]:
    """Return so many at random, always the same: whoever asks for more later asks for these and others."""
    return sorted(items, key=lambda one: hashlib.sha256(one.judged.text.encode()).digest())[:most]


def _replies_in(run: RunFolder) -> Iterator[Item]:
    declared = {kind: one.labels for kind, one in run.declared.actions.items() if one.labels}
    if not declared:
        return
    only = next(iter(declared)) if len(declared) == 1 else ""
    lines = lines_of(run.steps_bytes(), dict[str, Any], run.stream_path("steps"))
    placed = (((line["step"], line["agent"], line.get("kind", only)), line) for line in lines)
    for line, call in with_calls(placed, (call for call in run.calls() if call.kind in declared)):
        if call is not None and call.text.strip():
            labels = declared[call.kind]
            recorded = _recorded(line, labels, run.declared.form)
            if recorded:
                yield _reply(run, call, recorded, labels)


def _recorded(line: Line, labels: Sequence[str], form: str) -> str:
    """Return what a line of `steps.jsonl` says was decided, NONE where nothing could be read; "" for all else."""
    if line.get("outcome") in UNREAD:
        return NONE
    done = [line.get(key) for key in compared_of(form).acted] if line.get("outcome") in READ else []
    return next((one for one in reversed(done) if isinstance(one, str) and one in labels), "")


def _reply(run: RunFolder, call: Call, recorded: str, labels: Sequence[str]) -> Item:
    judged = Judged(text=call.text, seed=run.run.seed, label="", kind=call.kind, recorded=recorded)
    return Item(judged, (*labels, NONE), {"reply": call.text, "options": ", ".join(labels)})


def schemas_of(sweep: SweepFolder) -> dict[str, Schema]:
    """Return what the page offers, by the kind of question of an item; the same however many items are drawn."""
    closed = {one.labels for run in sweep.runs() for one in run.declared.actions.values() if one.labels}
    choices = [YES_NO, *sorted((*labels, NONE) for labels in closed)]
    return {_kind(options): {"type": "string", "enum": list(options)} for options in choices}


async def judge(model: Model, question: str, items: Sequence[Item]) -> JudgedBy:
    """Ask a person about texts; what is not answered when the person leaves, or not by a label, is left out.

    Args:
        model: the person, with its wrappers; what was answered before comes from the cache of answers.
        question: template that the items fill.
        items: at least one, all messages or all replies.

    Raises:
        BackendError: nobody can be asked.
    """
    keys = RequestKeys(model, None)
    replies = await asyncio.gather(
        *model.begin([_request(one, question, keys) for one in items]), return_exceptions=True
    )
    labels = []
    for item, reply in zip(items, replies, strict=True):
        if isinstance(reply, BaseException) and not isinstance(reply, Interrupted):
            raise reply
        if isinstance(reply, Reply) and (said := reply.text.strip()) in item.options:
            labels.append(_labelled(item, said))
    return JudgedBy(
        labeller=model.name,
        what=REPLIES if items[0].judged.kind else WARNINGS,
        question_sha256=hashlib.sha256(question.encode()).hexdigest(),
        asked=len(items),
        labels=tuple(labels),
    )


def _labelled(item: Item, said: str) -> Judged:
    return msgspec.structs.replace(item.judged, label=said)


def _request(item: Item, question: str, keys: RequestKeys) -> Request:
    messages = (ChatMessage("user", Template(question).substitute(item.shown)),)
    key = keys.key(messages, SAMPLING_SEED)
    return Request(
        messages=messages, seed=SAMPLING_SEED, kind=_kind(item.options), observation={}, step=0, agent=0, key=key
    )
