"""The loop asks ahead of the rounds where replies take time and the world can tell; records stay the same."""

import asyncio
from collections import Counter
from collections.abc import Callable, Sequence
from typing import Any

import msgspec
import pytest

from episodes import PlayedEpisode, composed
from foundry import seeding
from foundry.composing.preflight import prompt_of, scenario_of
from foundry.episode import Asker, play
from foundry.errors import Interrupted, RequestError
from foundry.models.base import Model, Reply, Request
from foundry.running.build import build
from foundry.worlds.base import QuestionKey

WORLD = composed("cafe_library", "seek", "world.agents=8", "world.steps=6", "world.half_size=30")
CALLS = 2 * 8 * 6


class Slow(Model):
    """Answers as a policy does, some turns of the event loop later; fails at some questions.

    Attributes:
        begun: what it was asked, in order.
        ended: how many of these it has seen through.
        most_apart: steps between two questions that it had to answer at once, at most.
    """

    def __init__(
        self, seed: int = 0, fails_at: Sequence[QuestionKey] = (), latency_s: float = 1.0, cached: bool = False
    ) -> None:
        self.name, self._policy = "slow", build(WORLD.conditions[0].config["model"])
        self._seed, self._fails_at, self._took = seed, fails_at, {"timings": {"latency": latency_s}, "cached": cached}
        self.begun: list[QuestionKey] = []
        self.ended, self.most_apart = 0, 0
        self._open: Counter[int] = Counter()

    async def ask(self, request: Request) -> Reply:
        asked = request.step, request.agent, request.kind
        self.begun.append(asked)
        self._open[request.step] += 1
        self.most_apart = max(self.most_apart, max(+self._open) - min(+self._open))
        for _ in range(int(seeding.stream(self._seed, f"turns {asked}").geometric(0.1))):
            await asyncio.sleep(0)
        self._open[request.step] -= 1
        self.ended += 1
        if asked in self._fails_at:
            raise RequestError(f"no answer to {asked}")
        return msgspec.structs.replace(self._policy.reply(request), **self._took)

    def parameters(self) -> dict[str, Any]:
        return {}


async def played(
    model: Slow, episode: PlayedEpisode, *, ahead: bool = True, stopping: Callable[[], bool] = lambda: False
) -> None:
    config = WORLD.conditions[0].config
    asker = Asker.create(model, prompt_of(config), digest=None, seed=3)
    await play(scenario_of(config).start(3), asker, episode, frame_every=6, ahead=ahead, stopping=stopping)


def content(episode: PlayedEpisode) -> tuple[list[bytes], list[bytes], dict[int, bytes]]:
    return episode.lines(), list(map(msgspec.json.encode, episode.calls)), episode.frames


@pytest.fixture(scope="module")
def in_lock_step() -> PlayedEpisode:
    model, kept = Slow(), PlayedEpisode()
    asyncio.run(played(model, kept, ahead=False))
    assert model.most_apart == 0 and len(kept.calls) == CALLS and list(kept.frames) == [0, 6]
    return kept


@pytest.mark.parametrize("seed", [1, 2, 3])
def test_records_calls_and_frames_are_those_of_lock_step(seed: int, in_lock_step: PlayedEpisode):
    model, kept = Slow(seed), PlayedEpisode()
    asyncio.run(played(model, kept))
    assert content(kept) == content(in_lock_step)
    assert model.most_apart >= 2, "somebody was asked steps ahead of another"
    assert Counter(model.begun) == Counter((call.step, call.agent, call.kind) for call in in_lock_step.calls)


@pytest.mark.parametrize("quick", [{"latency_s": 0.0}, {"cached": True}])
def test_where_no_reply_takes_time_the_rounds_are_asked_whole(quick: dict[str, Any], in_lock_step: PlayedEpisode):
    model, kept = Slow(1, **quick), PlayedEpisode()
    asyncio.run(played(model, kept))
    assert model.most_apart == 0
    assert kept.lines() == in_lock_step.lines()


@pytest.mark.parametrize(
    "fails_at", [[(1, 2, "action")], [(4, 5, "message")], [(6, 0, "action"), (3, 7, "action"), (3, 1, "action")]]
)
def test_a_call_that_fails_ends_the_run_at_the_round_and_with_the_error_of_lock_step(fails_at: list[QuestionKey]):
    found = []
    for ahead in (False, True):
        model, kept = Slow(1, fails_at), PlayedEpisode()
        with pytest.raises(RequestError) as raised:
            asyncio.run(played(model, kept, ahead=ahead))
        assert model.ended == len(model.begun), "no answer is thrown away"
        found.append((content(kept), str(raised.value)))
    assert found[0] == found[1]


@pytest.mark.parametrize("begun", [10, 50, 80])
def test_stopping_sees_through_what_was_asked_and_leaves_whole_rounds(begun: int, in_lock_step: PlayedEpisode):
    model, kept = Slow(2), PlayedEpisode()
    with pytest.raises(Interrupted):
        asyncio.run(played(model, kept, stopping=lambda: len(model.begun) >= begun))
    assert model.ended == len(model.begun) < CALLS
    whole = content(in_lock_step)
    assert all(then[: len(now)] == now for then, now in zip(whole[:2], content(kept)[:2], strict=True))
    assert len(kept.calls) % 8 == 0


def test_a_run_that_is_cancelled_leaves_no_call_behind():
    async def cancelled() -> None:
        model = Slow(1)
        run = asyncio.create_task(played(model, PlayedEpisode()))
        while len(model.begun) < 40:
            await asyncio.sleep(0)
        run.cancel()
        with pytest.raises(asyncio.CancelledError):
            await run
        assert asyncio.all_tasks() == {asyncio.current_task()}

    asyncio.run(cancelled())
