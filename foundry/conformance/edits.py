"""Checks of edits: an edit changes only what the agent perceives, and always in the same way."""

from collections.abc import Mapping, Sequence
from copy import deepcopy
from dataclasses import dataclass, replace
from functools import cached_property

from foundry.conformance.playing import Broken, Skipped, WorldCase, require
from foundry.conformance.worlds import check_plain
from foundry.worlds.base import Question
from foundry.worlds.probe.editing import Edit

MOST_TRIED = 24
"""Maximum number of questions with which an edit is checked."""
PNG = b"\x89PNG"
"""First bytes of a PNG image."""
MOST_BACK = 12
"""Maximum number of repetitions, such as quarter turns, after which an edit must restore the question."""


@dataclass(frozen=True)
class EditCase:
    """An edit to check, and the world whose questions it changes."""

    edit: Edit
    world: WorldCase

    @cached_property
    def questions(self) -> Sequence[Question]:
        """Questions for the checks: every k-th question of an episode, at most `MOST_TRIED` in all."""
        questions = list(self.world.usual.questions)
        return questions[:: max(-(-len(questions) // MOST_TRIED), 1)]

    @cached_property
    def changed(self) -> Sequence[tuple[Question, Question]]:
        """Pairs of a question and its edited version, for all questions that the edit changes."""
        pairs = [(question, edited) for question in self.questions if (edited := self.applied(question)) is not None]
        if not pairs:
            raise Skipped(
                f"the edit changes none of {len(self.questions)} questions of world '{self.world.scenario.name}': "
                "choose another world with world=NAME"
            )
        return pairs

    def applied(self, question: Question) -> Question | None:
        """Return the edited question; the edit gets a copy, which it may change."""
        copy = replace(question, observation=deepcopy(dict(question.observation)))
        return self.edit.applied(copy, [asked for asked in self.questions if asked is not question])


def changes_something(case: EditCase) -> str:
    """The edit changes some questions; for others, it may return None or an equal question."""
    return f"the edit changes {len(case.changed)} of {len(case.questions)} questions"


def asks_the_same(case: EditCase) -> None:
    """The edit keeps the step, agent, kind and `again` of a question, which determine the sampling seed."""
    for before, after in case.changed:
        require(
            (after.asked, after.again) == (before.asked, before.again),
            f"the edit changes step, agent, kind or `again` of a '{before.kind}' question (agent {before.agent}, step "
            f"{before.step}): replace only its observation or images",
        )


def keeps_what_templates_name(case: EditCase) -> None:
    """The observation keeps its keys, contains only plain data, and has the same number of images."""
    for before, after in case.changed:
        differing = sorted(before.observation.keys() ^ after.observation.keys())
        require(
            not differing,
            f"the key {', '.join(differing)} is only in the original or only in the edited observation: keep all keys",
        )
        check_plain(after.observation, f"the edited '{before.kind}'")
        now, then = len(after.images), len(before.images)
        require(now == then, f"the edited question has {now} images instead of {then}: change only their content")


def leaves_its_input_as_it_is(case: EditCase) -> None:
    """The edit does not change its input, since a probe also asks the unedited question."""
    for question in case.questions:
        given = deepcopy(dict(question.observation))
        case.edit.applied(replace(question, observation=given), case.questions)
        stays = given == dict(question.observation)
        require(stays, f"the edit changes its input, a '{question.kind}' question: return a changed copy of it")


def changes_the_same_every_time(case: EditCase) -> None:
    """The edit changes equal questions in the same way."""
    for before, after in case.changed:
        require(
            case.applied(before) == after,
            f"the edit changes the same '{before.kind}' question differently the second time: draw random numbers only "
            "from question.sampling_seed",
        )


def can_be_put(case: EditCase) -> None:
    """The world's prompt accepts the edited question."""
    prompt = case.world.make_prompt()
    for _, after in case.changed:
        prompt.render(after)


def expects_one_action_for_each(case: EditCase) -> None:
    """Different actions have different expected actions; repeated edits restore the question and its action."""
    if case.edit.leaves != "equivariance":
        raise Skipped("it is not an equivariance, so it expects no other action")
    expected = case.edit.described(case.world.scenario)["expected"]
    made = ", ".join(map(str, expected.values()))
    each_once = set(expected.values()) == set(expected)
    require(each_once, f"expected() maps {', '.join(expected)} to {made}: return each action exactly once")
    for before, after in case.changed:
        times = _times_until_back(case, before, after)
        if times is None:
            raise Broken(f"{MOST_BACK} edits in a row never restore a '{before.kind}' question: correct edit()")
        moved = ", ".join(label for label in expected if _repeated(expected, label, times) != label)
        require(
            not moved,
            f"{times} edits in a row restore a '{before.kind}' question, but {times} calls of expected() do not "
            f"restore the actions {moved}: correct edit() or expected()",
        )


def _times_until_back(case: EditCase, before: Question, after: Question) -> int | None:
    if after.images != before.images and not all(image.startswith(PNG) for image in before.images):
        raise Skipped("images are not PNG, so repeated edits always differ: use world.image_format=png")
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
