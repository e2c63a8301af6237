"""Checks of worlds: equal worlds play equal episodes, and write only the records that they declare."""

import math
import pickle
import re
from collections import Counter
from collections.abc import Callable, Iterator, Mapping, Sequence
from typing import Any

import msgspec

from foundry import seeding
from foundry.conformance.playing import Broken, Episode, Skipped, WorldCase, play, play_ahead, require, seen
from foundry.declared import Actions
from foundry.records import Agent, Outcome, Record
from foundry.worlds.base import Recorded

_STEPS = "steps"
_COMMON = ("step", "agent", "outcome")
"""Keys that every record of a step has, in worlds of all forms."""
READABLE = (Outcome.CHOSEN, Outcome.REPAIRED)
_FORM = re.compile(r"[a-z][a-z0-9_]{0,39}")


def plays_to_its_end(case: WorldCase) -> None:
    """An episode ends; until then questions are pending, and afterwards none."""
    for episode in (case.usual, case.idle, case.silent):
        if not episode.finished and episode.asked <= case.most:
            raise Broken(
                f"after {episode.asked} questions pending() is empty, but `finished` is false: return questions, or "
                "let `finished` be true"
            )
        most = case.scenario.count_calls()
        require(
            episode.finished,
            f"the episode goes on after {episode.asked} questions, but count_calls() is {most}: let `finished` be true",
        )
        require(not episode.left, "questions are pending after the end: return none once finished is true")


def asks_what_it_says(case: WorldCase) -> str | None:
    """Each question has a declared kind and the number of the next step, and is asked once."""
    kinds = case.scenario.kinds
    are_texts = isinstance(kinds, tuple) and all(isinstance(kind, str) for kind in kinds)
    require(are_texts, f"kinds is {kinds!r}: use a tuple of the kinds of question, such as ('action',)")
    completed = 0
    for turn in case.usual.turns:
        for question in turn.questions:
            is_named = question.kind in kinds
            require(is_named, f"the world asks '{question.kind}', but its kinds are {', '.join(kinds)}: add this kind")
            is_next = question.step == completed + 1
            require(
                is_next, f"a question has step {question.step} after {completed} completed steps: use {completed + 1}"
            )
        is_next = turn.step in (completed, completed + 1)
        require(is_next, f"`step` went from {completed} to {turn.step}: count the completed steps one by one")
        completed = turn.step
    questions = list(case.usual.questions)
    put = Counter((*question.asked, question.again) for question in questions)
    for (step, agent, kind, _), times in put.items():
        require(
            times == 1,
            f"agent {agent} is asked '{kind}' {times} times in step {step} with the same sampling seed: use different "
            "kinds, or count repetitions in Question.again",
        )
    missing = set(kinds).difference(question.kind for question in questions)
    return f"the played episode asks no question of the kind {', '.join(sorted(missing))}" if missing else None


def counts_its_calls(case: WorldCase) -> str | None:
    """No episode asks more questions than `count_calls()` says."""
    most = case.scenario.count_calls()
    longest = max(episode.asked for episode in (case.usual, case.idle, case.silent))
    require(longest <= most, f"an episode asks {longest} questions, but count_calls() is {most}: raise it")
    return f"count_calls() is {most}, but no episode asked more than {longest} questions" if longest < most else None


def observes_plain_data(case: WorldCase) -> None:
    """Observations consist of dicts, lists, texts, numbers, flags and None, so that templates can read them."""
    for question in case.usual.questions:
        check_plain(question.observation, f"the observation of a '{question.kind}' question")


def check_plain(value: object, where: str) -> None:
    """Require that a value consists of dicts, lists, texts, numbers, flags and None; `where` names the value."""
    if isinstance(value, Mapping):
        for key, inner in value.items():
            require(isinstance(key, str), f"{where} has the key {key!r}: use texts as keys")
            check_plain(inner, f"{where}, {key}")
    elif isinstance(value, list | tuple):
        for inner in value:
            check_plain(inner, where)
    else:
        plain = value is None or type(value) in (str, int, float, bool)
        name = f"{type(value).__module__}.{type(value).__name__}"
        require(plain, f"{where} contains a {name}: use dicts, lists, texts, numbers, flags and None")


def asks_without_side_effects(case: WorldCase) -> None:
    """`pending()` changes nothing, and returns equal questions if it is called again."""
    world = case.scenario.start(case.seed)
    world.opening()
    while not world.finished and world.step <= 1:
        first, second = ([seen(question) for question in world.pending()] for _ in range(2))
        require(
            first == second,
            f"two calls of pending() in step {world.step + 1} return different questions: draw no random numbers and "
            "change no state in pending()",
        )
        if not first:
            return
        world.advance(case.answers(world.pending()))
    is_same = case.played(case.answers, looks=3).content() == case.usual.content()
    require(is_same, "further calls of pending() change the episode: change no state in it")


def opens_without_side_effects(case: WorldCase) -> None:
    """Calls of `opening()` and `draw()` change no state, so an episode is the same without these calls."""
    world = case.scenario.start(case.seed)
    first, second = (list(map(msgspec.json.encode, world.opening())) for _ in range(2))
    require(first == second, "two calls of opening() return different records: draw nothing and change no state")
    is_same = case.drawn.content() == case.usual.content()
    require(is_same, "draw() changes the episode: change no state in it")


def is_equal_from_equal_settings(case: WorldCase) -> None:
    """Two worlds with the same settings play the same episode, byte for byte."""
    _check_same(case, case.played(case.answers, scenario=case.make()), "a copy of the world")


def is_equal_from_a_pickle(case: WorldCase) -> None:
    """A copy of the world, made with pickle, plays the same episode."""
    try:
        copy = pickle.loads(pickle.dumps(case.scenario))
    except (pickle.PicklingError, TypeError, AttributeError) as error:
        raise Skipped(
            f"pickle cannot copy this world ({error}), so copies were not compared; runs work without copies"
        ) from error
    _check_same(case, case.played(case.answers, scenario=copy), "a pickled copy")


def starts_afresh(case: WorldCase) -> None:
    """An episode does not depend on other episodes of the same world."""
    beside, world = case.scenario.start(case.seed + 1), case.scenario.start(case.seed)
    if not beside.finished and (questions := beside.pending()):
        beside.advance(case.answers(questions))
    _check_same(case, play(world, case.answers, most=case.most), "an episode beside another one")


_AGAIN = (
    "draw only from foundry.seeding.stream(seed, ...), keep no state in the scenario, and do not use the order of a set"
)


def _check_same(case: WorldCase, other: Episode, which: str, hint: str = _AGAIN) -> None:
    usual, content = case.usual.content(), other.content()
    pairs = zip(usual, content, strict=False)
    differing = next((f"{left!r} and {right!r}" for left, right in pairs if left != right), "one is longer")
    require(content == usual, f"{which} differs: {hint}; first: {differing[:300]}")


def asks_ahead_what_it_asks_later(case: WorldCase) -> None:
    """A question that is asked early equals the question asked in order, and early answers change no record."""
    rng = seeding.stream(case.seed, "check:order")
    orders: tuple[Callable[[int], int], ...] = (lambda n: 0, lambda n: n - 1, lambda n: int(rng.integers(n)))
    for pick in orders:
        episode = play_ahead(case.scenario.start(case.seed), case.answers, most=case.most, pick=pick)
        if episode is None:
            raise Skipped("the world asks nothing early: all agents wait for each other")
        hint = (
            "ready() may only return questions that no open decision can change, and next_round() must keep the "
            "order of pending()"
        )
        _check_same(case, episode, "an episode with early questions", hint)


def follows_its_seed(case: WorldCase) -> str | None:
    """Different seeds give different episodes, if the world draws random numbers."""
    other = play(case.scenario.start(case.seed + 1), case.answers, most=case.most)
    is_same = other.content() == case.usual.content()
    return "every seed gives the same episode, so seeds only change the models' sampling" if is_same else None


def has_a_persona_for_every_agent(case: WorldCase) -> None:
    """`personas(seed)` returns one persona per agent, and the same personas in every call."""
    first, second = (case.scenario.personas(case.seed) for _ in range(2))
    agents = {question.agent for question in case.usual.questions}
    require(
        agents <= set(range(len(first))),
        (
            f"personas({case.seed}) has {len(first)}, but agents {sorted(agents)} are asked: return a persona, "
            "or {}, for every agent, with ids from 0"
        ),
    )
    for persona in first:
        plain = all(isinstance(key, str) and isinstance(value, str) for key, value in persona.items())
        require(plain, f"a persona is {dict(persona)!r}: attributes and values must be texts")
    require(
        list(map(dict, first)) == list(map(dict, second)),
        "two calls of personas(seed) differ: draw only from foundry.seeding.stream(seed, ...)",
    )


def tells_moments_apart_by_texts_and_flags(case: WorldCase) -> None:
    """`strata(question)` returns values that are texts or flags, under the same names for all questions of a kind."""
    names: dict[str, set[str]] = {}
    for question in case.usual.questions:
        strata = case.scenario.strata(question)
        plain = all(isinstance(value, str | bool) for value in strata.values())
        require(plain, f"strata() of a '{question.kind}' question is {dict(strata)!r}: use texts or flags as values")
        differing = sorted(names.setdefault(question.kind, set(strata)) ^ set(strata))
        require(
            not differing,
            f"strata() lacks {', '.join(differing)} for some '{question.kind}' questions: always return the same names",
        )


def keeps_its_secrets(case: WorldCase) -> None:
    """The observation has no key of the question's secret data, which only scripted policies may read."""
    questions = [question for question in case.usual.questions if question.secret is not None]
    if not questions:
        raise Skipped("its questions have no secret")
    for question in questions:
        shared = sorted(set(question.secret or ()) & set(question.observation))
        require(not shared, f"the observation contains the secret {', '.join(shared)}: remove it from the observation")


def shows_images_where_it_says(case: WorldCase) -> None:
    """Questions contain PNG or JPEG images if `shows_images` is true; otherwise they contain no images."""
    shows = case.scenario.shows_images
    for question in case.usual.questions:
        images, kind = question.images, question.kind
        is_said = bool(images) == shows
        require(
            is_said, f"shows_images is {shows}, but a '{kind}' question has {len(images)} images: correct shows_images"
        )
        known = all(image.startswith((b"\x89PNG", b"\xff\xd8\xff")) for image in images)
        require(known, f"an image of a '{kind}' question is neither PNG nor JPEG: encode it as one of these")


def declares_its_records(case: WorldCase) -> None:
    """The world declares its form, its records with all common keys, and the possible decisions."""
    scenario = case.scenario
    form = getattr(scenario, "form", None)
    is_name = isinstance(form, str) and _FORM.fullmatch(form) is not None
    require(is_name, f"form is {form!r}: use lower case letters, digits and _, such as form = 'rounds'")
    for record in scenario.records:
        is_record = isinstance(record, type) and issubclass(record, Record) and bool(record.stream)
        require(is_record, f"records contains {record!r}: use subclasses of foundry.records.Record with a `stream`")
    steps = [record for record in scenario.records if record.stream == _STEPS]
    require(len(steps) == 1, f"{len(steps)} classes of records have the stream 'steps': exactly one must have it")
    missing = [key for key in _COMMON if key not in steps[0].__struct_fields__]
    require(
        not missing,
        f"{steps[0].__name__} lacks {', '.join(missing)}: add these fields, which every record of a step needs",
    )
    for kind, actions in scenario.actions().items():
        _check_actions(kind, actions, scenario.kinds)
    scenario.declared()


def _check_actions(kind: str, actions: Actions, kinds: tuple[str, ...]) -> None:
    require(kind in kinds, f"actions() has the key '{kind}', which this world never asks: use {', '.join(kinds)}")
    low, high = _ends(actions)
    is_one = low <= high and not (actions.labels and math.isfinite(low - high))
    require(is_one, f"actions()['{kind}'] is {actions}: give either labels, or low and high with low <= high")
    is_action = actions.idle is None or _is_among(actions, actions.idle)
    require(is_action, f"actions()['{kind}'] has the idle action {actions.idle!r}, which is not one of its actions")


def writes_what_it_declares(case: WorldCase) -> None:
    """Every record has a declared class; records of steps have the step of their question, and a known agent."""
    agents = range(len(case.scenario.personas(case.seed)))
    for record in case.usual.records:
        name, is_declared = type(record).__name__, type(record) in case.scenario.records
        require(
            is_declared,
            f"the world writes a {name} (stream '{record.stream}'), but `records` lacks this class: add it",
        )
    for turn in case.usual.turns:
        step = turn.questions[0].step
        for row in steps_of(turn.records):
            require(
                row.step == step,
                f"a record of step {step} has the number {row.step}: write the number of its step, counted from 1",
            )
            require(row.agent in agents, f"a record has agent {row.agent!r}, but the agents are 0 to {len(agents) - 1}")


def records_every_step(case: WorldCase) -> None:
    """Each agent that is asked in a step gets at least one record of this step, and at most one per question."""
    put = Counter(question.asked for question in case.usual.questions)
    rows = Counter((row.step, row.agent, getattr(row, "kind", None)) for row in steps_of(case.usual.records))
    for (step, agent, kind), times in rows.items():
        most = max(put[step, agent, str(kind)], 1)
        require(times <= most, f"agent {agent} has {times} records of kind {kind} in step {step}: write at most {most}")
    recorded = {(step, agent) for step, agent, _ in rows}
    for step, agent, _ in put:
        require(
            (step, agent) in recorded,
            f"agent {agent} was asked in step {step}, but has no record of this step: write a record",
        )


def decides_as_declared(case: WorldCase) -> None:
    """Each recorded action is one of the declared actions, or null after an unreadable reply.

    Each recorded outcome is a value of `Outcome`.
    """
    actions = case.scenario.actions()
    for row in steps_of((*case.usual.records, *case.silent.records)):
        is_outcome = isinstance(row.outcome, Outcome)
        require(is_outcome, f"a record has the outcome {row.outcome!r}: use foundry.records.Outcome")
        declared = declared_for(row, actions)
        if declared is None:
            continue
        if row.outcome in READABLE:
            require(
                row.decision is not None and _is_among(declared, row.decision),
                f"agent {row.agent} decided {row.decision!r} in step {row.step}, but actions() has only {declared}",
            )
        else:
            require(
                row.decision is None,
                f"agent {row.agent} has the action {row.decision!r} in step {row.step}, but its reply chose nothing "
                f"({row.outcome}): record null as the action",
            )


def declared_for(row: Any, actions: Mapping[str, Actions]) -> Actions | None:
    """Return the declared actions for the question that a record answers; None if the world declares none for it."""
    kind = getattr(row, "kind", None)
    if kind is None and len(actions) == 1:
        return next(iter(actions.values()))
    return actions.get(str(kind))


def _is_among(actions: Actions, decision: object) -> bool:
    if actions.labels:
        return decision in actions.labels
    if not isinstance(decision, int | float) or isinstance(decision, bool):
        return False
    low, high = _ends(actions)
    return (not actions.whole or float(decision).is_integer()) and low <= decision <= high


def _ends(actions: Actions) -> tuple[float, float]:
    return (-math.inf if actions.low is None else actions.low, math.inf if actions.high is None else actions.high)


def loads_its_records_back(case: WorldCase) -> None:
    """A written record can be read back unchanged, with the declared types."""
    for record in case.usual.records:
        name, content = type(record).__name__, msgspec.json.encode(record)
        try:
            back = msgspec.json.decode(content, type=type(record))
        except msgspec.DecodeError as error:
            raise Broken(f"a record {name} cannot be read back: {error}; its line is {content[:200]!r}") from error
        require(
            back == record,
            f"a record {name} changes when it is read back: correct its types; its line is {content[:200]!r}",
        )


def opens_with_its_personas(case: WorldCase) -> None:
    """If agents have personas, the opening records contain the persona of each agent.

    The persona of an agent that is born later is recorded at its birth.
    """
    personas = [dict(persona) for persona in case.scenario.personas(case.seed)]
    recorded = {record.agent: record.persona for record in case.usual.opening if isinstance(record, Agent)}
    if not any(personas) and not recorded:
        raise Skipped("its agents have no personas")
    if case.scenario.grows:
        personas = personas[: len(case.usual.turns[0].questions)]
    expected = {agent: persona for agent, persona in enumerate(personas) if persona}
    require(
        recorded == expected,
        f"opening() records the personas {recorded}, but personas({case.seed}) returns {expected}: make them equal",
    )


def redraws_what_it_drew(case: WorldCase) -> None:
    """Pictures that are drawn again from the records alone equal the original pictures, byte for byte."""
    episode = case.drawn
    images = {
        record.path: record.content
        for record in episode.records
        if hasattr(record, "path") and hasattr(record, "content")
    }
    again = case.make().redraw(Recorded(case.seed, episode.lines(_STEPS), episode.lines("episode"), images.get))
    for step, picture in episode.pictures.items():
        require(picture.startswith(b"\x89PNG"), f"draw() returns no PNG after step {step}: encode the picture as PNG")
        is_same = again.draw(step) == picture
        require(
            is_same, f"redraw() and draw() give different pictures in step {step}: draw only what the records contain"
        )


def steps_of(records: Sequence[Record]) -> Iterator[Any]:
    """Yield the records of steps; leave out other records, such as messages."""
    return (record for record in records if record.stream == _STEPS)
