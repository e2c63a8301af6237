"""Checks of edits: each changes what an agent perceives and nothing else, the same way every time."""

from collections.abc import Mapping, Sequence
from copy import deepcopy
from dataclasses import dataclass, replace
from functools import cached_property

from foundry.conformance.playing import Skipped, WorldCase, require
from foundry.conformance.worlds import check_plain
from foundry.worlds.base import Question
from foundry.worlds.probe.editing import Edit

MOST_TRIED = 24
"""Questions of an episode that an edit is tried on."""
PNG = b"\x89PNG"
"""How such an image begins."""
MOST_BACK = 12
"""Edits of one question after which it must have come back."""


@dataclass(frozen=True)
class EditCase:
    """An edit to be checked, and the world in whose questions it is tried."""

    edit: Edit
    world: WorldCase

    @cached_property
    def questions(self) -> Sequence[Question]:
        """Questions of an episode, evenly over its length."""
        questions = list(self.world.usual.questions)
        return questions[:: max(-(-len(questions) // MOST_TRIED), 1)]

    @cached_property
    def changed(self) -> Sequence[tuple[Question, Question]]:
        """What is changed, as it was and as it is."""
        pairs = [(question, edited) for question in self.questions if (edited := self.applied(question)) is not None]
        if not pairs:
            none = f"it changes none of {len(self.questions)} questions of {self.world.scenario.name}"
            raise Skipped(f"{none}: name another world=")
        return pairs

    def applied(self, question: Question) -> Question | None:
        """Return the edited question; what it is given is a copy, which an edit may spoil."""
        copy = replace(question, observation=deepcopy(dict(question.observation)))
        return self.edit.applied(copy, [one for one in self.questions if one is not question])


def changes_something(case: EditCase) -> str:
    """It changes some question, and says None, or gives back what it was given, where there is nothing to change."""
    return f"{len(case.changed)} of {len(case.questions)} questions changed"


def asks_the_same(case: EditCase) -> None:
    """Step, agent, kind and number of the question stay, from which its sampling seed follows."""
    for before, after in case.changed:
        require(
            (after.asked, after.again) == (before.asked, before.again),
            f"a '{before.kind}' of agent {before.agent} at step {before.step} is another question afterwards: replace "
            "observation or images alone",
        )


def keeps_what_templates_name(case: EditCase) -> None:
    """The observation has the same keys, all of them plain data, and there are as many images."""
    for before, after in case.changed:
        differing = sorted(before.observation.keys() ^ after.observation.keys())
        require(not differing, f"{', '.join(differing)} is in one observation alone: change values, never keys")
        check_plain(after.observation, f"the edited '{before.kind}'")
        now, then = len(after.images), len(before.images)
        require(now == then, f"{now} images in place of {then}: change what they show alone")


def leaves_its_input_as_it_is(case: EditCase) -> None:
    """The question that it is given stays as it was: a probe asks it unedited, too."""
    for question in case.questions:
        given = deepcopy(dict(question.observation))
        case.edit.applied(replace(question, observation=given), case.questions)
        stays = given == dict(question.observation)
        require(stays, f"it changes the '{question.kind}' that it is given: make a copy, as dataclasses.replace does")


def changes_the_same_every_time(case: EditCase) -> None:
    """An edit of equal questions gives equal questions."""
    for before, after in case.changed:
        other = f"a '{before.kind}' is edited another way the second time"
        require(case.applied(before) == after, f"{other}: draw from question.sampling_seed alone")


def can_be_put(case: EditCase) -> None:
    """The world's prompt puts what was edited."""
    prompt = case.world.make_prompt()
    for _, after in case.changed:
        prompt.render(after)


def expects_one_action_for_each(case: EditCase) -> None:
    """Under an equivariance no two actions become the same, and what is edited again and again comes back with them."""
    if case.edit.leaves != "equivariance":
        raise Skipped("it moves no action")
    expected = case.edit.described(case.world.scenario)["expected"]
    made = ", ".join(map(str, expected.values()))
    each_once = set(expected.values()) == set(expected)
    require(each_once, f"expected makes {made} of {', '.join(expected)}: each action once")
    for before, after in case.changed:
        times = _times_until_back(case, before, after)
        moved = [label for label in expected if times is not None and _repeated(expected, label, times) != label]
        require(
            times is not None and not moved,
            f"a '{before.kind}' is back after {times} edits, its actions ({', '.join(moved) or 'all'}) not: edit and "
            "expected differ",
        )


def _times_until_back(case: EditCase, before: Question, after: Question) -> int | None:
    """Return how many edits give back what the agent perceives; None where so many do not."""
    if after.images != before.images and not all(image.startswith(PNG) for image in before.images):
        raise Skipped("images are no PNG, so that what is edited twice differs all the same: world.image_format=png")
    now: Question | None = after
    for times in range(1, MOST_BACK + 1):
        if now is not None and (now.observation, now.images) == (before.observation, before.images):
            return times
        now = None if now is None else case.applied(now)
    return None


def _repeated(expected: Mapping[str, str], label: str, times: int) -> str:
    for _ in range(times):
        label = expected[label]
    return label
