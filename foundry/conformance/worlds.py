"""What every world must hold: it asks without side effects, and equal copies play equal episodes."""

from __future__ import annotations

import pickle
from collections import Counter
from collections.abc import Callable, Mapping

import msgspec

from foundry import seeding
from foundry.conformance.finding import Broken, Skipped, require
from foundry.conformance.playing import Episode, WorldCase, play, play_ahead, seen


def plays_to_its_end(case: WorldCase) -> None:
    """An episode ends, and nothing is pending then; one that goes on asks something."""
    for episode in (case.usual, case.idle, case.silent):
        if not episode.finished:
            require(
                episode.asked > case.most,
                f"after {episode.asked} questions nothing is pending and the world is not finished, so that its run "
                "would never end: let pending() ask, or finished be true",
            )
            raise Broken(
                f"it goes on after {episode.asked} questions, and count_calls() says {case.scenario.count_calls()} at "
                "most: let finished become true"
            )
        require(not episode.left, "questions are pending after the end: return none once finished is true")


def counts_its_calls(case: WorldCase) -> str | None:
    """No episode asks more than `count_calls()` says."""
    most = case.scenario.count_calls()
    longest = max(episode.asked for episode in (case.usual, case.idle, case.silent))
    require(longest <= most, f"{longest} questions were asked where count_calls() says {most} at most: let it say more")
    return f"{longest} questions asked of {most}" if longest < most else None


def asks_what_it_says(case: WorldCase) -> str | None:
    """Questions are of the declared kinds, of the step that comes next, and each is put once."""
    kinds = case.scenario.kinds
    require(
        isinstance(kinds, tuple) and all(isinstance(kind, str) for kind in kinds),
        f"kinds is {kinds!r}: give a tuple of the kinds of question, such as ('action',)",
    )
    completed = 0
    for turn in case.usual.turns:
        for question in turn.questions:
            require(
                question.kind in kinds,
                f"it asks a '{question.kind}', which is not among its kinds {', '.join(kinds)}: name it there",
            )
            require(
                question.step == completed + 1,
                f"a question says step {question.step} when {completed} steps are completed: steps count from 1",
            )
        require(
            turn.step in (completed, completed + 1),
            f"step went from {completed} to {turn.step} at once: it is the number of completed steps",
        )
        completed = turn.step
    _each_once(case.usual)
    missing = set(kinds).difference(question.kind for question in case.usual.questions)
    return f"never asked here: {', '.join(sorted(missing))}" if missing else None


def _each_once(episode: Episode) -> None:
    put = Counter((one.step, one.agent, one.kind, one.again) for one in episode.questions)
    for (step, agent, kind, _), times in put.items():
        require(
            times == 1,
            f"agent {agent} is asked '{kind}' {times} times in step {step}, each time with the same sampling seed: "
            "give the questions of a step kinds of their own, or count in `again` how often it was asked before",
        )


def observes_plain_data(case: WorldCase) -> None:
    """Observations are dicts, lists, texts, numbers, flags and None, so that templates read all of them."""
    for question in case.usual.questions:
        check_plain(question.observation, f"the observation of a '{question.kind}'")


def check_plain(value: object, where: str) -> None:
    """Require that a value holds nothing but dicts, lists, texts, numbers, flags and None; `where` names it."""
    if isinstance(value, Mapping):
        for key, inner in value.items():
            require(isinstance(key, str), f"{where} has the key {key!r}: use texts")
            check_plain(inner, f"{where}, {key}")
    elif isinstance(value, list | tuple):
        for inner in value:
            check_plain(inner, where)
    else:
        plain = value is None or type(value) in (str, int, float, bool)
        require(plain, f"{where} holds a {type(value).__module__}.{type(value).__name__}: make it a plain value")


def asks_without_side_effects(case: WorldCase) -> None:
    """`pending()` can be asked twice: it says the same and changes nothing."""
    world = case.scenario.start(case.seed)
    world.opening()
    while not world.finished:
        first, second = ([seen(one) for one in world.pending()] for _ in range(2))
        require(first == second, f"two calls of pending() in step {world.step + 1} differ: work nothing out in it")
        if not first:
            return
        world.advance(case.answers(world.pending()))
        if world.step > 1:
            break
    often = case.played(case.answers, looks=3)
    require(
        often.content() == case.usual.content(),
        "an episode goes another way when pending() is called more often: let it change nothing",
    )


def opens_without_side_effects(case: WorldCase) -> None:
    """`opening()` and `draw()` change nothing."""
    world = case.scenario.start(case.seed)
    first = list(map(msgspec.json.encode, world.opening()))
    require(
        list(map(msgspec.json.encode, world.opening())) == first,
        "two calls of opening() give other records: work nothing out in it",
    )
    require(
        case.drawn.content() == case.usual.content(),
        "an episode goes another way when it is drawn: change nothing there",
    )


def is_equal_from_equal_settings(case: WorldCase) -> None:
    """Two worlds from the same settings play the same episode, byte for byte."""
    copy = case.played(case.answers, scenario=case.make())
    _same(copy, case.usual, "a copy of the world")


def starts_afresh(case: WorldCase) -> None:
    """An episode is the same whatever was played before it or beside it."""
    beside = case.scenario.start(case.seed + 1)
    world = case.scenario.start(case.seed)
    if not beside.finished and (questions := beside.pending()):
        beside.advance(case.answers(questions))
    again = play(world, case.answers, most=case.most)
    _same(again, case.usual, "an episode beside another one")


def is_equal_from_a_pickle(case: WorldCase) -> None:
    """A copy by way of pickle plays the same episode."""
    try:
        copy = pickle.loads(pickle.dumps(case.scenario))
    except (pickle.PicklingError, TypeError, AttributeError) as error:
        raise Skipped(f"cannot be pickled, which no run needs: {error}") from error
    _same(case.played(case.answers, scenario=copy), case.usual, "a copy by way of pickle")


_AGAIN = "draw from foundry.seeding.stream(seed, ...) alone, keep no state in the scenario and no order of a set"


def _same(other: Episode, one: Episode, which: str, hint: str = _AGAIN) -> None:
    pairs = zip(one.content(), other.content(), strict=False)
    differing = next((f"{left!r} and {right!r}" for left, right in pairs if left != right), "one is longer")
    require(other.content() == one.content(), f"{which} went another way: {hint}; first: {differing[:300]}")


def asks_ahead_what_it_asks_later(case: WorldCase) -> None:
    """What can be asked ahead is what will be pending, and the records are the same in any order of the answers."""
    rng = seeding.stream(case.seed, "check:order")
    orders: tuple[Callable[[int], int], ...] = (lambda n: 0, lambda n: n - 1, lambda n: int(rng.integers(n)))
    for pick in orders:
        found = play_ahead(case.scenario.start(case.seed), case.answers, most=case.most, pick=pick)
        if found is None:
            raise Skipped("asks nothing ahead: all wait for all")
        hint = "let ready() give what nothing undecided can change, and next_round() the order of pending()"
        _same(found, case.usual, "an episode that was asked ahead", hint)


def follows_its_seed(case: WorldCase) -> str | None:
    """Another seed gives another episode, where the world draws anything."""
    world = case.scenario.start(case.seed + 1)
    other = play(world, case.answers, most=case.most)
    same_answers = other.content() == case.usual.content()
    return "every seed gives the same episode: seeds vary the models' sampling alone" if same_answers else None


def has_a_persona_for_every_agent(case: WorldCase) -> None:
    """`personas(seed)` has one persona an agent that there may ever be, by its id; the same every time."""
    personas = case.scenario.personas(case.seed)
    asked = {question.agent for question in case.usual.questions}
    require(
        asked <= set(range(len(personas))),
        f"personas({case.seed}) has {len(personas)}, and asked were the agents {sorted(asked)}: return one persona, or "
        "{}, for every agent, whose ids count from 0",
    )
    for persona in personas:
        plain = all(isinstance(key, str) and isinstance(value, str) for key, value in persona.items())
        require(plain, f"a persona is {dict(persona)!r}: use texts for attributes and values")
    again = case.scenario.personas(case.seed)
    require(list(map(dict, again)) == list(map(dict, personas)), "personas(seed) differs from call to call")


def tells_moments_apart_by_texts_and_flags(case: WorldCase) -> None:
    """`strata(question)` gives texts and flags, under the same names for every question of a kind."""
    names: dict[str, set[str]] = {}
    for question in case.usual.questions:
        found = case.scenario.strata(question)
        require(
            all(isinstance(value, str | bool) for value in found.values()),
            f"strata of a '{question.kind}' are {dict(found)!r}: use texts or flags, of which there are few",
        )
        known = names.setdefault(question.kind, set(found))
        differing = sorted(known ^ set(found))
        require(not differing, f"{', '.join(differing)} is in the strata of one '{question.kind}' and not of another")


def keeps_its_secrets(case: WorldCase) -> None:
    """What only scripted policies are told is not in the observation, where templates would see it."""
    asked = [question for question in case.usual.questions if question.secret is not None]
    if not asked:
        raise Skipped("has no secret")
    for question in asked:
        shared = sorted(set(question.secret or ()) & set(question.observation))
        require(not shared, f"a template sees {', '.join(shared)}, which is in secret: take it out of the observation")


def shows_images_where_it_says(case: WorldCase) -> None:
    """Questions carry PNG or JPEG images if `shows_images` says so, and none otherwise."""
    for question in case.usual.questions:
        says = "shows_images is True" if case.scenario.shows_images else "shows_images is False"
        require(
            bool(question.images) == case.scenario.shows_images,
            f"{says}, and a '{question.kind}' has {len(question.images)} images: let the class say what holds",
        )
        known = all(image.startswith((b"\x89PNG", b"\xff\xd8\xff")) for image in question.images)
        require(known, f"an image of a '{question.kind}' is neither PNG nor JPEG")


CHECKS = (
    plays_to_its_end,
    asks_what_it_says,
    counts_its_calls,
    observes_plain_data,
    asks_without_side_effects,
    opens_without_side_effects,
    is_equal_from_equal_settings,
    is_equal_from_a_pickle,
    starts_afresh,
    asks_ahead_what_it_asks_later,
    follows_its_seed,
    has_a_persona_for_every_agent,
    tells_moments_apart_by_texts_and_flags,
    keeps_its_secrets,
    shows_images_where_it_says,
)
