"""What a world must make of replies: those that are of no use change nothing, those it offers decide what they say."""

from __future__ import annotations

import time
from collections.abc import Iterator, Sequence
from dataclasses import dataclass
from typing import Any

from foundry.conformance.finding import Broken, Skipped, require
from foundry.conformance.playing import Episode, WorldCase, play, seen
from foundry.conformance.records import READABLE, STEPS, declared_for
from foundry.records import Outcome, Record
from foundry.worlds.base import ABORTED, LENGTH, Answer, Question

_GARBAGE = "\u0000\ufffd %% ]]} <<"
BAD = {
    "an empty reply": (Answer(""), Outcome.EMPTY),
    "a reply of blanks": (Answer(" \n\t"), Outcome.EMPTY),
    "an aborted reply": (Answer("", ABORTED), Outcome.FAILED),
    "a reply cut by the length limit": (Answer("", LENGTH), Outcome.TRUNCATED),
    "a reply cut in its first word": (Answer(_GARBAGE[:3], LENGTH), Outcome.TRUNCATED),
    "a reply that says nothing": (Answer(_GARBAGE), Outcome.UNREADABLE),
    "a reply of 100,000 characters": (Answer(_GARBAGE * 10_000), Outcome.UNREADABLE),
    "a reply of 100,000 brackets": (Answer('{"[' * 34_000), Outcome.UNREADABLE),
}
"""Replies that decide nothing, and the outcome of a decision that gets one."""
_SPOKEN = (Outcome.UNREADABLE, Outcome.TRUNCATED)
"""Outcomes of a text that decides nothing; where any text is an answer, as in talk, there are none such."""
_PATIENCE_S = 20.0
_MOST_OPTIONS = 24


@dataclass(frozen=True)
class _Place:
    """A question in the usual episode: its round and its place among the questions of that round."""

    turn: int
    index: int
    question: Question


def _places(episode: Episode) -> Iterator[_Place]:
    """Yield the last agent's first question of every kind."""
    found: dict[str, _Place] = {}
    for number, turn in enumerate(episode.turns):
        last = {question.kind: _Place(number, index, question) for index, question in enumerate(turn.questions)}
        found = last | found
    yield from found.values()


def _answered(case: WorldCase, place: _Place, answer: Answer) -> tuple[list[Record], Sequence[Question]]:
    """Return the records of the agent in the step of a question that gets this answer, and what is asked after it."""
    turns = iter(range(place.turn + 1))

    def answers(questions: Sequence[Question]) -> list[Answer]:
        usual = case.answers(questions)
        if next(turns, None) == place.turn:
            usual[place.index] = answer
        return usual

    world = case.scenario.start(case.seed)
    world.opening()
    records: list[Record] = []
    for _ in case.usual.turns:
        if world.finished or world.step >= place.question.step:
            break
        records += world.advance(answers(world.pending()))
    mine = [one for one in records if one.stream == STEPS and _is_of(one, place.question)]
    return mine, () if world.finished else tuple(world.pending())


def _is_of(record: Any, question: Question) -> bool:
    return bool(record.step == question.step and record.agent == question.agent)


def survives_bad_replies(case: WorldCase) -> None:
    """A reply that decides nothing raises nothing, costs no time, and has the outcome that it should."""
    for place in _places(case.usual):
        declared = place.question.kind in case.scenario.actions()
        for what, (answer, expected) in BAD.items():
            started = time.perf_counter()
            records, _ = _answered(case, place, answer)
            took = time.perf_counter() - started
            require(
                took < _PATIENCE_S, f"{what} to a '{place.question.kind}' took {took:.0f} s to read: bound its length"
            )
            if records and (declared or expected not in _SPOKEN or not answer.text.strip()):
                outcomes = sorted({str(value) for one in records for value in _outcomes(one)})
                require(
                    expected in outcomes,
                    f"{what} to a '{place.question.kind}' has the outcome {', '.join(outcomes)} instead of {expected}: "
                    "see unanswered() and undecided_outcome() of foundry.worlds.base",
                )


def takes_bad_replies_for_no_decision(case: WorldCase) -> None:
    """Whatever is wrong with a reply, nothing but the outcome of its decision depends on it."""
    for place in _places(case.usual):
        declared = place.question.kind in case.scenario.actions()
        first: tuple[str, list[tuple[Any, ...]], list[Any]] | None = None
        for what, (answer, expected) in BAD.items():
            if expected in _SPOKEN and not declared:
                continue
            records, after = _answered(case, place, answer)
            state = [(one.decision, getattr(one, "utility", None), getattr(one, "message", None)) for one in records]
            others = [seen(one) for one in after if one.agent != place.question.agent]
            first = first or (what, state, others)
            kind = place.question.kind
            require(
                state == first[1],
                f"{what} to a '{kind}' gives {state}, {first[0]} gives {first[1]}: let both decide nothing",
            )
            require(
                others == first[2], f"others are told other things after {what} to a '{kind}' than after {first[0]}"
            )


def _outcomes(record: Record) -> Iterator[Outcome]:
    fields = (name for name in record.__struct_fields__ if name == "outcome" or name.endswith("_outcome"))
    return (getattr(record, name) for name in fields)


def reads_the_options_it_offers(case: WorldCase) -> None:
    """Each reply in `Question.options` is read as a decision of its own, among those that are declared."""
    offering = [place for place in _places(case.usual) if place.question.options]
    if not offering:
        raise Skipped("offers no options: scripted/random needs them, so give each Question its `options`")
    for place in offering:
        options = place.question.options
        stride = -(-len(options) // _MOST_OPTIONS)
        decided = {option: _decision(case, place, option) for option in options[::stride]}
        if place.question.kind in case.scenario.actions():
            doubled = len(decided) - len(set(decided.values()))
            require(
                not doubled, f"options of a '{place.question.kind}' decide the same: {decided}; give one a decision"
            )


def reads_its_idle_reply(case: WorldCase) -> None:
    """The reply in `Question.idle` is read as the action that is declared as doing nothing."""
    places = [place for place in _places(case.usual) if place.question.idle is not None]
    if not places:
        raise Skipped("offers no idle reply: scripted/stay needs one, where there is an action that does nothing")
    for place in places:
        decision = _decision(case, place, str(place.question.idle))
        declared = case.scenario.actions().get(place.question.kind)
        if declared is not None:
            require(
                decision == declared.idle,
                f"the idle reply to a '{place.question.kind}' decides {decision!r}, not the declared {declared.idle!r}",
            )


def _decision(case: WorldCase, place: _Place, text: str) -> Any:
    """Return what a reply that the world offers decides."""
    records, _ = _answered(case, place, Answer(text))
    actions = case.scenario.actions()
    for record in records:
        if getattr(record, "kind", place.question.kind) != place.question.kind:
            continue
        bad = [one for one in _outcomes(record) if one not in READABLE]
        require(not bad, f"the reply {text[:80]!r} that it offers itself to a '{place.question.kind}' is read as {bad}")
        if declared_for(record, actions) is not None:
            return record.decision
    return None


def has_a_template_for_every_question(case: WorldCase) -> None:
    """The chosen prompt has a template for every kind of question, and each can be filled."""
    if case.prompt is None:
        raise Skipped("no prompt is chosen")
    missing = [kind for kind in case.scenario.kinds if kind not in case.prompt.kinds]
    require(
        not missing, f"prompt '{case.prompt.name}' has no template for {', '.join(missing)}: add one, or choose another"
    )
    for question in (*case.usual.questions, *case.silent.questions):
        case.prompt.render(question)


def has_a_schema_for_every_question(case: WorldCase) -> None:
    """Where replies are held to a schema, there is one for every kind of question."""
    if case.schemas is None:
        raise Skipped("the chosen model holds replies to no schema: model.format is not 'schema'")
    for kind in case.scenario.kinds:
        schema = case.schemas.get(kind)
        require(
            schema is not None,
            f"there is no schema for '{kind}': add it to the file of the schema group that is chosen",
        )
        if not isinstance(schema, dict) or not isinstance(schema.get("type"), str):
            raise Broken(f"the schema for '{kind}' says no `type`: give a JSON Schema, such as type: object")


def gives_the_same_when_played_again(case: WorldCase) -> None:
    """An episode can be played while another goes on, each with bad replies in it."""
    one, other = (play(case.scenario.start(case.seed), _spoiled(case), most=case.most) for _ in range(2))
    require(one.content() == other.content(), "two episodes with the same bad replies differ")


def _spoiled(case: WorldCase) -> Any:
    bad = [answer for answer, _ in BAD.values()]

    def answers(questions: Sequence[Question]) -> list[Answer]:
        usual = case.answers(questions)
        return [
            bad[(one.step + one.agent) % len(bad)] if one.agent % 2 else usual[place]
            for place, one in enumerate(questions)
        ]

    return answers


CHECKS = (
    survives_bad_replies,
    takes_bad_replies_for_no_decision,
    gives_the_same_when_played_again,
    reads_the_options_it_offers,
    reads_its_idle_reply,
    has_a_template_for_every_question,
    has_a_schema_for_every_question,
)
