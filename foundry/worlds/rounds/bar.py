"""The El Farol bar: all agents decide at the same time whether to go, and too many guests make it crowded."""

from typing import Any, ClassVar

from foundry.declared import Actions
from foundry.errors import not_found
from foundry.records import Agent, Message, Record, RoundStep
from foundry.worlds.base import Question
from foundry.worlds.rounds.rounds_world import Play, RoundsScenario
from foundry.worlds.rounds.table import Decision, Table
from foundry.worlds.validation import check_number

GO, STAY = "go", "stay"
REPORTS = ("explicit", "implicit", "attendance")


class Evening(Record, frozen=True, kw_only=True):
    """One evening at the bar (`evenings.jsonl`).

    Attributes:
        step: 1-based evening.
        went: number of agents that went.
        places: maximum number of agents that can go without making the bar crowded.
    """

    stream: ClassVar[str] = "evenings"

    step: int
    went: int
    places: int


class Bar(RoundsScenario):
    """A bar that is fun unless too many agents go.

    Description:
        Every evening all agents decide at once whether to go to the same bar. The bar is crowded if more than the share
        `capacity` of all agents goes. An agent that goes gets the utility `crowded` if the bar is crowded, else `fun`.
        An agent that stays gets `home`.

    Observation:
        `capacity`, `places` (number of agents that can go before it is crowded), `fun`, `crowded` and `home`.
        `evenings`: for each evening so far, oldest first, `went` (number of agents), and the agent's own `action` and
        `utility`. With `reports: explicit` all agents see all of these values. With `implicit`, agents that stayed get
        null for `went`. With `attendance`, all agents see only `went`.

    Questions:
        `evening`, to all agents at once.

    Actions:
        `go` or `stay`. An unreadable reply counts as `stay`.

    Termination:
        After `steps` evenings.

    Source:
        W. B. Arthur, Inductive reasoning and bounded rationality, American Economic Review 84 (1994). Payoffs, reports
        and score come from GAMABench, Huang et al. 2024 (games/bar_game.py); the prompts are foundry's own. GAMABench's
        leaderboard gives scores of 17.0 (qwen2:72b) to 75.7 (llama3.1:8b). `scripted/inductive` has 30 predictors of
        four kinds; Arthur mentions a few dozen and names some.
    """

    kinds: ClassVar[tuple[str, ...]] = ("evening",)
    records: ClassVar[tuple[type[Record], ...]] = (RoundStep, Message, Agent, Evening)

    def __init__(
        self, *, capacity: float, fun: float, crowded: float, home: float, reports: str, **settings: Any
    ) -> None:
        super().__init__(**settings)
        check_number("world.capacity", capacity, 0, 1)
        for key, value in {"fun": fun, "crowded": crowded, "home": home}.items():
            check_number(f"world.{key}", value)
        if reports not in REPORTS:
            raise not_found("Report of a bar", str(reports), REPORTS, "Choose with world.reports.")
        self.capacity, self.reports = capacity, reports
        self.fun, self.crowded, self.home = fun, crowded, home
        self.places = max(number for number in range(self.agents + 1) if number / self.agents <= capacity)

    def actions(self) -> dict[str, Actions]:
        """Return the possible decisions."""
        return {"evening": Actions(labels=(GO, STAY), idle=STAY)}

    def payoffs(self, question: Question) -> list[float]:
        """Return the agent's utilities of earlier evenings, as its prompt shows them."""
        return [evening["utility"] for evening in question.observation["evenings"] if evening["utility"] is not None]

    def play(self, table: Table) -> Play:
        """Play the evenings."""
        bar = {key: getattr(self, key) for key in ("capacity", "places", "fun", "crowded", "home")}
        known: list[list[dict[str, Any]]] = [[] for _ in table.agents]
        for evening in table.rounds(self.steps):
            decisions = yield [
                table.ask(agent, "evening", **bar, evenings=list(known[agent])) for agent in table.agents
            ]
            went = sum(decision.taken == GO for decision in decisions)
            for decision in decisions:
                utility = self._utility(decision, went)
                table.record(decision, utility=utility)
                known[decision.agent].append(self._told(decision, went, utility))
            table.write(Evening(step=evening, went=went, places=self.places))

    def _utility(self, decision: Decision, went: int) -> float:
        if decision.taken == STAY:
            return self.home
        return self.fun if went <= self.places else self.crowded

    def _told(self, decision: Decision, went: int, utility: float) -> dict[str, Any]:
        if self.reports == "attendance":
            return {"went": went, "action": None, "utility": None}
        is_told = self.reports == "explicit" or decision.taken == GO
        return {"went": went if is_told else None, "action": decision.taken, "utility": utility}
