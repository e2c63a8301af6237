"""Finds the texts of a sweep to which a label applies, each with its context."""

from collections.abc import Callable, Iterable, Iterator, Sequence
from dataclasses import dataclass
from functools import partial
from typing import Any

import msgspec

from foundry.errors import RecordError
from foundry.labels.definition import NONE, Context, Label
from foundry.records import Call, Message, Outcome
from foundry.storing.matching import with_calls
from foundry.storing.store import RunFolder, SweepFolder, lines_of
from foundry.worlds.compared import Line, compared_of

MESSAGE = "message"
"""The kind of question whose answer is a message."""
_CAMERA = "camera"
"""The form of 3D worlds."""
_PROBE = "probe"
"""The form of runs in a probe."""
_UNREAD = (Outcome.UNREADABLE, Outcome.TRUNCATED)
_READ = (Outcome.CHOSEN, Outcome.REPAIRED)
_RECORDED = "recorded"


@dataclass(frozen=True)
class Item:
    """A text to label, with its place in a sweep.

    Attributes:
        step: 1-based step.
        agent: id of the agent that wrote it.
        aware: whether the agent knew of a fire: it had perceived one by then, or it had received in an earlier step a
            message that is a warning by the rule. The correction by people's labels needs this.
        is_readable: whether the decision in the reply is readable; for a message, whether the reply with the message
            is.
    """

    run: str
    model: str
    seed: int
    step: int
    agent: int
    kind: str
    text: str
    context: Context
    aware: bool = False
    is_readable: bool = True

    @property
    def id(self) -> str:
        """The name of the text, unique in the sweep."""
        return f"{self.run}/{self.step}/{self.agent}/{self.kind}"

    @property
    def content(self) -> bytes:
        """The text and the context that a labeller sees, as bytes; texts with equal bytes get equal labels."""
        return content_of(self.text, self.context)


def content_of(text: str, context: Context) -> bytes:
    """Return a text, and the part of its context that a labeller sees, as bytes for comparisons."""
    shown = {key: value for key, value in context.items() if key != _RECORDED}
    return msgspec.json.encode((text, shown), order="sorted")


class _Fire(msgspec.Struct):
    name: str


class _LoggedText(msgspec.Struct):
    step: int
    agent: int
    outcome: Outcome
    message_outcome: Outcome | None = None
    message: str | None = None
    fires: tuple[Any, ...] = ()


class _Episode(msgspec.Struct):
    target: str = ""


def items_of(sweep: SweepFolder, label: Label) -> list[Item]:
    """Return the texts of a label in all complete runs of a sweep, in the order of the runs.

    Raises:
        RecordError: a recorded file is damaged.
    """
    return [item for run in complete_runs(sweep) for item in items_in(run, label)]


def complete_runs(sweep: SweepFolder) -> list[RunFolder]:
    """Return the complete runs of a sweep."""
    return [run for run in sweep.runs() if run.is_complete]


def items_in(run: RunFolder, label: Label) -> Iterator[Item]:
    """Yield the texts of a run to which a label applies.

    If the choices of the label are actions, replies to questions without declared actions are left out.
    """
    if label.unit == "message":
        yield from _messages_in(run, label)
        return
    form = run.declared.form
    if (label.unit == "reply") == (form == _CAMERA) and (label.unit != "moment" or form == _PROBE):
        yield from (item for item in _decisions_in(run) if label.choices or item.context["actions"])


def _messages_in(run: RunFolder, label: Label) -> Iterator[Item]:
    """Yield the messages of a run, even those that nobody heard."""
    try:
        fires = tuple(fire.name for fire in msgspec.convert(run.config()["world"].get("fires", ()), list[_Fire]))
    except msgspec.ValidationError as error:
        raise RecordError(f"The fires in the world of run '{run.id}' cannot be read: {error}") from error
    item, context = _items_of(run), {"fires": fires}
    lines = lines_of(run.steps_bytes(), _LoggedText, run.stream_path("steps"))
    sighted = ((line.step, line.agent) for line in lines if line.fires)
    aware_from = first_aware(label, context, sighted, _heard_in(run))
    for line in lines:
        if line.message is not None:
            aware = line.step >= aware_from.get(line.agent, line.step + 1)
            is_readable = (line.message_outcome or line.outcome) in _READ
            yield item(line.step, line.agent, MESSAGE, line.message, context, aware, is_readable)


def first_aware(
    label: Label, context: Context, sighted: Iterable[tuple[int, int]], heard: Iterable[tuple[int, int, str]]
) -> dict[int, int]:
    """Return the step from which each agent knows of a fire, without agents that never know of one.

    Args:
        label: the label whose rule says which texts are warnings.
        context: context of the texts.
        sighted: a step, and an agent that perceives a fire in this step.
        heard: a step, an agent that receives a text in this step, and the text; the agent knows from the next step on.
    """
    first_steps: dict[int, int] = {}
    for step, agent in sighted:
        first_steps[agent] = min(first_steps.get(agent, step), step)
    rule = label.rule_function()
    if rule is None:
        return first_steps
    warns: dict[str, bool] = {}
    for step, agent, text in heard:
        if text not in warns:
            warns[text] = rule(text, context) == label.choices[0]
        if warns[text]:
            first_steps[agent] = min(first_steps.get(agent, step + 1), step + 1)
    return first_steps


def _heard_in(run: RunFolder) -> Iterator[tuple[int, int, str]]:
    for message in lines_of(run.messages_bytes(), Message, run.stream_path("messages")):
        yield message.step, message.recipient, message.text


def _decisions_in(run: RunFolder) -> Iterator[Item]:
    """Yield the replies that are not empty to questions for which the world declares actions."""
    actions = {kind: declared_actions.labels for kind, declared_actions in run.declared.actions.items()}
    only = next(iter(actions)) if len(actions) == 1 else ""
    lines = lines_of(run.steps_bytes(), dict[str, Any], run.stream_path("steps"))
    placed = (((line["step"], line["agent"], line.get("kind", only)), line) for line in lines)
    episode = lines_of(run.episode_bytes(), _Episode, run.stream_path("episode"))
    target = {"target": episode[0].target} if episode else {}
    item = _items_of(run)
    for line, call in with_calls(placed, (call for call in run.calls() if call.kind in actions)):
        if call is not None and call.text.strip():
            recorded = _recorded(line, actions[call.kind], run.declared.form)
            context = {"told": _prompt_of(call), "actions": actions[call.kind], _RECORDED: recorded, **target}
            is_readable = line.get("outcome") in _READ
            yield item(call.step, call.agent, call.kind, call.text, context, is_readable=is_readable)


def _items_of(run: RunFolder) -> Callable[..., Item]:
    return partial(Item, run.id, str(run.recorded_config()["model"]["name"]), run.run.seed)


def _prompt_of(call: Call) -> str:
    content = call.messages[-1].get("content", "") if call.messages else ""
    return content if isinstance(content, str) else ""


def _recorded(line: Line, actions: Sequence[str], form: str) -> str:
    """Return the action in a line of `steps.jsonl`: NONE for an unreadable reply, "" if the line has no action."""
    if line.get("outcome") in _UNREAD:
        return NONE
    done = [line.get(key) for key in compared_of(form).acted] if line.get("outcome") in _READ else []
    return next((action for action in reversed(done) if isinstance(action, str) and action in actions), "")


def recorded_action(_: str, context: Context) -> str | None:
    """The rule of the label `reading`: return a reply's recorded action, or None if the reply was unreadable."""
    recorded = str(context[_RECORDED])
    return recorded if recorded not in ("", NONE) else None
