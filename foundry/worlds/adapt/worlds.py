"""Worlds that play environments of Gymnasium and PettingZoo; each kind of environment has a class."""

import importlib
import io
import os
from abc import abstractmethod
from collections import Counter
from collections.abc import Generator, Mapping, Sequence
from importlib.metadata import packages_distributions
from typing import Any, ClassVar

import msgspec
import numpy as np
from numpy.typing import NDArray

from foundry.declared import Actions
from foundry.errors import InputError, NotInstalledError, not_found
from foundry.records import Agent, Message, Record, RoundStep
from foundry.texts import one_line
from foundry.worlds.adapt.planning import plan_of
from foundry.worlds.adapt.playing import Choices, InTurn, OfAll, OfOne, Playing, choices_of, plain
from foundry.worlds.base import Question, Recorded, Redrawing
from foundry.worlds.rounds.rounds_world import Play, RoundsScenario, RoundsWorld
from foundry.worlds.rounds.table import Decision, Table
from foundry.worlds.validation import check_number

TURN = "turn"
"""The only kind of question in worlds of other libraries."""
PIXELS = "rgb_array"
"""Render mode that returns an array."""
_INSTALL = "The shipped worlds need the extra `gym`. From a clone: pip install -e '.[gym]'"


class Turn(RoundStep, frozen=True, kw_only=True):
    """A decision in an environment of another library.

    Attributes:
        played: the action that the environment got: the decision; after an unreadable reply the idle action, or a
            random legal action if there is no idle one.
    """

    played: str | float


class Return(Record, frozen=True, kw_only=True):
    """The sum of an agent's rewards in an episode (`returns.jsonl`), one line per agent.

    Attributes:
        step: the last round.
        agent: agent id.
        total: sum of the agent's rewards, including the rewards after its last decision.
        turns: number of the agent's decisions.
    """

    stream: ClassVar[str] = "returns"

    step: int
    agent: int
    total: float
    turns: int


class Adapted(RoundsScenario):
    """An environment of another library; subclasses define how to make it.

    Description:
        The rules are those that the environment has. The environment is reset with the run's seed, on which all its
        random numbers depend.

    Observation:
        `state`, the environment's own observation as plain values; `choices`, the names of the legal actions;
        `setting`, the environment's settings; `total`, the sum of rewards so far; `turns`, the last `history` turns
        with `state`, `action` and `reward`. With `image` also the environment's own picture.

    Questions:
        `turn`, to all agents that act at the same time. If agents act in turn, each agent gets this question once per
        round, one after another.

    Actions:
        The environment's actions, by the names in the setting `actions`. An unreadable reply plays the idle action, or
        a random legal action if there is no idle one.

    Termination:
        When the environment ends or truncates the episode, or after `steps` rounds.

    Source:
        Gymnasium (Towers et al., arXiv 2407.17032) and PettingZoo (Terry et al., NeurIPS 2021).
    """

    kinds: ClassVar[tuple[str, ...]] = (TURN,)
    records: ClassVar[tuple[type[Record], ...]] = (Turn, Message, Agent, Return)
    playing: ClassVar[type[OfOne | OfAll | InTurn]]
    choices: Choices
    plan: NDArray[np.int64] | None = None

    def __init__(
        self,
        *,
        name: str,
        env: str,
        steps: int,
        package: str | None = None,
        settings: Mapping[str, Any] | None = None,
        actions: Sequence[str] | None = None,
        idle: str | None = None,
        image: bool = False,
        history: int = 0,
        personas: Any = None,
    ) -> None:
        """Make the environment once to read its actions and its number of agents.

        Args:
            name: name of the world.
            env: the environment's name in its library.
            steps: maximum number of rounds.
            package: an installed package that registers the environment when it is imported.
            settings: arguments of the environment.
            actions: names of the actions, in the order of the action space; None numbers them.
            idle: name of the action that does nothing, or None.
            image: whether agents see the environment's picture.
            history: number of earlier turns in an agent's observation.
            personas: attribute -> value -> weight, drawn independently for each agent.
        """
        check_number("world.history", history, 0, whole=True)
        self.env, self.image, self.history = env, image, history
        self._settings = dict(settings or {})
        if package is not None:
            _import_installed(package)
        made = self._made()
        try:
            self.draws = PIXELS in made.metadata.get("render_modes", made.metadata.get("render.modes", ()))
            agents, space = self.look(made)
            self.choices = choices_of(space, actions, idle, f"Environment '{env}'")
            self.plan = plan_of(made, steps)
        finally:
            made.close()
        if image and not self.draws:
            raise InputError(f"world.image=true: environment '{env}' draws no picture. Leave this setting out.")
        super().__init__(name=name, agents=agents, steps=steps, personas=personas)

    @property
    def shows_images(self) -> bool:  # type: ignore[override]
        """True if agents see the environment's picture."""
        return self.image

    @abstractmethod
    def make(self, **settings: Any) -> Any:
        """Return the library's environment with these settings."""

    @abstractmethod
    def look(self, made: Any) -> tuple[int, Any]:
        """Return the number of agents of an environment, and their action space."""

    def actions(self) -> dict[str, Actions]:
        """Return the possible decisions."""
        return {TURN: self.choices.actions}

    def payoffs(self, question: Question) -> list[float]:
        """Return the agent's rewards of earlier turns, as its prompt shows them."""
        return [turn["reward"] for turn in question.observation["turns"]]

    def play(self, table: Table) -> Play:
        """Play one episode."""
        episode = self.episode(table.seed)
        try:
            yield from self._played(episode, table)
        finally:
            episode.close()

    def episode(self, seed: int) -> Playing:
        """Return a fresh episode of the environment."""
        return self.playing(self._made(render_mode=PIXELS if self.draws else None), seed)

    def _played(self, episode: Playing, table: Table) -> Play:
        turns: list[list[dict[str, Any]]] = [[] for _ in table.agents]
        totals: Counter[int] = Counter()
        for _ in table.rounds(self.steps):
            decided, earned = yield from self._round(episode, table, turns, totals)
            for decision, played in decided.values():
                table.record(decision, utility=float(earned[decision.agent]), played=played)
            if not episode.asked():
                break
        for agent in table.agents:
            table.write(Return(step=table.step, agent=agent, total=float(totals[agent]), turns=len(turns[agent])))

    def _round(
        self, episode: Playing, table: Table, infos: list[list[dict[str, Any]]], totals: Counter[int]
    ) -> Generator[Sequence[Question], list[Decision], tuple[dict[int, tuple[Decision, Any]], Counter[int]]]:
        """Ask each agent at most once; return each agent's decision and played action, and the rewards of the round."""
        decided: dict[int, tuple[Decision, Any]] = {}
        earned: Counter[int] = Counter()
        while (agents := episode.asked()) and not decided.keys() & agents.keys():
            legal = {agent: self.choices.legal(seen.mask) for agent, seen in agents.items()}
            images = (as_png(episode.picture()),) if self.image else ()
            decisions = yield [
                table.ask(
                    agent,
                    TURN,
                    images=images,
                    legal=legal[agent],
                    secret=self._secret(seen.state, table.step),
                    state=plain(seen.state),
                    choices=list(legal[agent].labels),
                    setting=self._settings,
                    total=float(totals[agent]),
                    turns=infos[agent][max(len(infos[agent]) - self.history, 0) :],
                )
                for agent, seen in agents.items()
            ]
            drawn = table.stream(f"unread {table.step} {min(agents)}")
            decided |= {
                decision.agent: (decision, _played_for(decision, legal[decision.agent], drawn))
                for decision in decisions
            }
            rewards = episode.take({agent: self.choices.taken(decided[agent][1]) for agent in agents})
            earned.update(rewards)
            totals.update(rewards)
            for agent, seen in agents.items():
                turn = {"state": plain(seen.state), "action": decided[agent][1], "reward": rewards.get(agent, 0.0)}
                infos[agent].append(turn)
        return decided, earned

    def _secret(self, state: Any, step: int) -> dict[str, Any] | None:
        if self.plan is None:
            return None
        return {"best": self.choices.labels[int(self.plan[step - 1, int(state)])]}

    def start(self, seed: int) -> RoundsWorld:
        """Return a fresh episode for this seed."""
        return AdaptedWorld(self, seed) if self.draws else super().start(seed)

    def redraw(self, recorded: Recorded) -> Redrawing:
        """Return an object that replays the played actions and lets the environment draw its states."""
        if not self.draws:
            return super().redraw(recorded)
        return AdaptedRedrawing(self, recorded.seed, msgspec.json.Decoder(Turn).decode_lines(recorded.steps))

    def drawn(self, seed: int, lines: Sequence[Turn]) -> bytes:
        """Replay the given turns, and return the state after them as a PNG."""
        played = {(line.step, line.agent): self.choices.taken(line.played) for line in lines}
        episode = self.episode(seed)
        try:
            for step in sorted({line.step for line in lines}):
                left = {agent: action for (when, agent), action in played.items() if when == step}
                while left:
                    episode.take({agent: left.pop(agent) for agent in episode.asked()})
            return as_png(episode.picture())
        finally:
            episode.close()

    def _made(self, **further: Any) -> Any:
        settings = {key: value for key, value in further.items() if value is not None}
        try:
            with np.errstate(invalid="ignore"):  # for a map without a start, which is rejected below
                return self.make(**self._settings, **settings)
        except (TypeError, ValueError) as error:
            cause = one_line(error)
            raise InputError(f"Environment '{self.env}' cannot be made with world.settings: {cause}") from error


def _played_for(decision: Decision, legal: Actions, rng: np.random.Generator) -> str | float:
    """Return the action to play for a decision, or a random legal action after an unreadable reply."""
    if decision.taken is not None:
        return decision.taken  # type: ignore[no-any-return]
    if legal.labels:
        return str(legal.labels[int(rng.integers(len(legal.labels)))])
    return float(rng.uniform(legal.low or 0.0, legal.high or 0.0))


class AdaptedWorld(RoundsWorld):
    """One episode, drawn by its environment."""

    def __init__(self, scenario: Adapted, seed: int) -> None:
        super().__init__(scenario, seed)
        self._adapted, self._seed = scenario, seed

    def draw(self) -> bytes:
        """Return the present state as a PNG."""
        return self._adapted.drawn(self._seed, [line for line in self._lines if isinstance(line, Turn)])


class AdaptedRedrawing(Redrawing):
    """The pictures of a run, drawn by replaying it."""

    def __init__(self, scenario: Adapted, seed: int, lines: Sequence[Turn]) -> None:
        self._scenario, self._seed, self._lines = scenario, seed, lines

    def draw(self, step: int) -> bytes:
        """Return the state after a step as a PNG."""
        return self._scenario.drawn(self._seed, [line for line in self._lines if line.step <= step])


class GymnasiumWorld(Adapted):
    """An environment of Gymnasium, by its registered name."""

    playing = OfOne

    def make(self, **settings: Any) -> Any:
        """Return the environment."""
        gymnasium = _library("gymnasium")
        if ":" in self.env:
            raise InputError(
                f"world.env={self.env} names a module. Give only the name of the environment, and as world.package "
                "the installed package that registers it."
            )
        try:
            made = gymnasium.make(self.env, **settings)
        except gymnasium.error.Error as error:
            raise InputError(f"Environment '{self.env}' cannot be made: {' '.join(str(error).split())}") from error
        if made.spec is not None and made.spec.nondeterministic:
            raise InputError(
                f"Environment '{self.env}' is not deterministic, so no run could be repeated. Choose another."
            )
        return made

    def look(self, made: Any) -> tuple[int, Any]:
        """Return the number of agents, which is 1, and the environment's action space."""
        return 1, made.action_space


class PettingZooWorld(Adapted):
    """An environment of PettingZoo, by its registered name, such as `classic/tictactoe-v3`."""

    registry: ClassVar[str]

    def make(self, **settings: Any) -> Any:
        """Return the environment."""
        library = _library("pettingzoo")
        known = getattr(library, f"{self.registry}_registry")
        if self.env not in known:
            raise not_found(f"Environment of PettingZoo ({self.registry})", self.env, known)
        try:
            return library.make(self.registry, self.env, **settings)
        except ImportError as error:
            raise NotInstalledError(f"Environment '{self.env}' cannot be imported: {error}.", _INSTALL) from error

    def look(self, made: Any) -> tuple[int, Any]:
        """Return the number of agents, and the action space that they share."""
        spaces = [made.action_space(name) for name in made.possible_agents]
        if any(space != spaces[0] for space in spaces):
            raise InputError(
                f"The agents of environment '{self.env}' have different actions. Choose another environment."
            )
        return len(spaces), spaces[0]


class TurnsWorld(PettingZooWorld):
    """An environment of PettingZoo in which agents act in turn (AEC)."""

    registry: ClassVar[str] = "aec"
    playing = InTurn


class ParallelWorld(PettingZooWorld):
    """An environment of PettingZoo in which all agents act at once."""

    registry: ClassVar[str] = "parallel"
    playing = OfAll


def _import_installed(package: str) -> None:
    """Import an installed package; nothing else, since a stranger's record may name a harmful module."""
    if package not in packages_distributions():
        message = f"world.package={package} is not installed. Install the package that contains it."
        raise NotInstalledError(message, _INSTALL)
    try:
        importlib.import_module(package)
    except ImportError as error:
        raise NotInstalledError(f"world.package={package} cannot be imported: {error}.", _INSTALL) from error


def _library(name: str) -> Any:
    os.environ.setdefault("SDL_VIDEODRIVER", "dummy")  # environments draw to arrays and need no screen
    try:
        return importlib.import_module(name)
    except ImportError as error:
        raise NotInstalledError(f"{name} is not installed.", _INSTALL) from error


def as_png(pixels: Any) -> bytes:
    """Encode pixels, (height, width, 3), as a PNG; equal pixels give equal bytes."""
    from PIL import Image

    content = io.BytesIO()
    Image.fromarray(np.asarray(pixels, dtype=np.uint8)).save(content, format="PNG")
    return content.getvalue()
