"""Checks how worlds read replies: bad replies choose no action; a reply that equals an option chooses this option."""

import time
from collections.abc import Iterator, Sequence
from typing import Any, NamedTuple

from foundry.conformance.playing import Answering, Skipped, WorldCase, require, seen
from foundry.conformance.prompts import fills_every_question, has_every_kind
from foundry.conformance.worlds import READABLE, declared_for, steps_of
from foundry.records import Outcome
from foundry.worlds.base import ABORTED, LENGTH, Answer, Question

_GARBAGE = "\u0000\ufffd %% ]]} <<"
_BAD = {
    "an empty reply": (Answer(""), Outcome.EMPTY),
    "a reply of blanks": (Answer(" \n\t"), Outcome.EMPTY),
    "an aborted reply": (Answer("", ABORTED), Outcome.FAILED),
    "a reply cut by the length limit": (Answer("", LENGTH), Outcome.TRUNCATED),
    "a reply cut in its first word": (Answer(_GARBAGE[:3], LENGTH), Outcome.TRUNCATED),
    "a reply that says nothing": (Answer(_GARBAGE), Outcome.UNREADABLE),
    "a reply of 100,000 characters": (Answer(_GARBAGE * 10_000), Outcome.UNREADABLE),
    "a reply of 100,000 brackets": (Answer('{"[' * 34_000), Outcome.UNREADABLE),
}
"""Replies that choose no action, and the outcome that the world must record for each."""
_SPOKEN = (Outcome.UNREADABLE, Outcome.TRUNCATED)
"""Outcomes of unreadable texts. Replies that are messages are not checked for these, as any text may be a message."""
_PATIENCE_S = 20.0
_MOST_OPTIONS = 24


class _Place(NamedTuple):
    """A question of the episode `case.usual`, with the index of its round and its index in this round."""

    turn: int
    at: int
    question: Question


def _places(case: WorldCase) -> list[_Place]:
    """Return one question of each kind: the last one in the first round that has questions of this kind."""
    places: dict[str, _Place] = {}
    for number, turn in enumerate(case.usual.turns):
        last = {question.kind: _Place(number, at, question) for at, question in enumerate(turn.questions)}
        places = last | places
    return list(places.values())


def _answered(case: WorldCase, place: _Place, answer: Answer) -> tuple[list[Any], Sequence[Question]]:
    """Give this answer to a question; return the agent's records of the step, and the next questions."""
    world, asked = case.scenario.start(case.seed), place.question
    world.opening()
    rows: list[Any] = []
    for number in range(len(case.usual.turns)):
        if world.finished or world.step >= asked.step:
            break
        answers = case.answers(world.pending())
        if number == place.turn:
            answers[place.at] = answer
        rows += steps_of(tuple(world.advance(answers)))
    own = [row for row in rows if (row.step, row.agent) == (asked.step, asked.agent)]
    return own, () if world.finished else tuple(world.pending())


def survives_bad_replies(case: WorldCase) -> None:
    """A reply that chooses no action is read quickly and without an error, and gets the right outcome."""
    for place in _places(case):
        kind = place.question.kind
        for name, (answer, expected) in _BAD.items():
            started = time.perf_counter()
            rows, _ = _answered(case, place, answer)
            took = time.perf_counter() - started
            require(took < _PATIENCE_S, f"reading {name} to a '{kind}' question took {took:.0f} s: limit texts")
            is_talk = kind not in case.scenario.actions() and expected in _SPOKEN and bool(answer.text.strip())
            if not rows or is_talk:
                continue
            outcomes = sorted({str(value) for row in rows for value in _outcomes(row)})
            require(
                expected in outcomes,
                f"{name} to a '{kind}' question has the outcome {', '.join(outcomes)} instead of {expected}: use "
                "unanswered() or undecided_outcome() of foundry.worlds.base",
            )


def _outcomes(row: Any) -> Iterator[Outcome]:
    fields = (name for name in row.__struct_fields__ if name == "outcome" or name.endswith("_outcome"))
    return (getattr(row, name) for name in fields)


def takes_bad_replies_for_no_decision(case: WorldCase) -> None:
    """All replies that choose no action have the same effect in the world; only their recorded outcomes differ."""
    for place in _places(case):
        kind, agent = place.question.kind, place.question.agent
        declared = kind in case.scenario.actions()
        first: tuple[str, list[tuple[Any, ...]], list[Any]] | None = None
        for name, (answer, expected) in _BAD.items():
            if expected in _SPOKEN and not declared:
                continue
            rows, after = _answered(case, place, answer)
            state = [(row.decision, getattr(row, "utility", None), getattr(row, "message", None)) for row in rows]
            others = [seen(question) for question in after if question.agent != agent]
            first = first or (name, state, others)
            is_same = state == first[1]
            require(
                is_same,
                f"{name} to a '{kind}' question gives the record {state}, but {first[0]} gives {first[1]}: write equal "
                "records",
            )
            is_same = others == first[2]
            require(
                is_same,
                f"other agents observe whether a '{kind}' question got {name} or {first[0]}: let their observations "
                "be the same in both cases",
            )


def gives_the_same_when_played_again(case: WorldCase) -> None:
    """An episode with unreadable replies is the same if it is played again with the same seed and replies."""
    first, second = (case.played(_spoiled(case)).content() for _ in range(2))
    require(
        first == second,
        "two episodes with the same unreadable replies differ: draw only from foundry.seeding.stream(seed, ...)",
    )


def _spoiled(case: WorldCase) -> Answering:
    bad = [answer for answer, _ in _BAD.values()]

    def answers(questions: Sequence[Question]) -> list[Answer]:
        pairs = zip(questions, case.answers(questions), strict=True)
        return [
            bad[(question.step + question.agent) % len(bad)] if question.agent % 2 else usual
            for question, usual in pairs
        ]

    return answers


def reads_the_options_it_offers(case: WorldCase) -> None:
    """The world reads the replies that it suggests (`Question.options`) as declared actions, each as another one."""
    places = [place for place in _places(case) if place.question.options]
    if not places:
        raise Skipped("its questions have no options, which scripted/random needs: give each Question its `options`")
    for place in places:
        options, kind = place.question.options, place.question.kind
        decisions = {text: _decision(case, place, text) for text in options[:: -(-len(options) // _MOST_OPTIONS)]}
        is_apart = kind not in case.scenario.actions() or len(decisions) == len(set(decisions.values()))
        require(
            is_apart, f"options of a '{kind}' question lead to the same decision: {decisions}; keep one per decision"
        )


def reads_its_idle_reply(case: WorldCase) -> None:
    """The world reads the idle reply of a question as the action that it declares as idle."""
    places = [place for place in _places(case) if place.question.idle is not None]
    if not places:
        raise Skipped(
            "its questions have no idle reply, which scripted/stay needs: set `idle` if an action does nothing"
        )
    for place in places:
        decision = _decision(case, place, str(place.question.idle))
        kind = place.question.kind
        if (declared := case.scenario.actions().get(kind)) is not None:
            is_idle = decision == declared.idle
            require(
                is_idle,
                f"the world reads the idle reply to a '{kind}' question as {decision!r}, but the idle action in "
                f"actions() is {declared.idle!r}: make them equal",
            )


def _decision(case: WorldCase, place: _Place, text: str) -> Any:
    rows, kind = _answered(case, place, Answer(text))[0], place.question.kind
    for row in (row for row in rows if getattr(row, "kind", kind) == kind):
        bad = ", ".join(outcome for outcome in _outcomes(row) if outcome not in READABLE)
        require(
            not bad,
            f"the world offers the reply {text[:80]!r} to a '{kind}' question, but gives it the outcome {bad}: read it "
            "as a decision",
        )
        if declared_for(row, case.scenario.actions()) is not None:
            return row.decision
    return None


def has_a_template_for_every_question(case: WorldCase) -> None:
    """The chosen prompt has a template for every kind of question, and can fill each template."""
    has_every_kind(case)
    fills_every_question(case)


def has_a_schema_for_every_question(case: WorldCase) -> None:
    """If replies must follow a schema, there is one for every kind of question."""
    if case.schemas is None:
        raise Skipped("the chosen model uses no schema: model.format is not 'schema'")
    for kind in case.scenario.kinds:
        schema = case.schemas.get(kind)
        require(schema is not None, f"there is no schema for '{kind}': add it to the file of the chosen schema group")
        is_schema = isinstance(schema, dict) and isinstance(schema.get("type"), str)
        require(is_schema, f"the schema for '{kind}' has no `type`: use a JSON Schema, such as type: object")
