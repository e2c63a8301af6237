"""A population: several models, each of which answers for some of the agents."""

import re
from collections.abc import Callable, Mapping, Sequence
from dataclasses import dataclass, replace
from typing import Any

import msgspec

from foundry import seeding
from foundry.canary import Canary
from foundry.errors import FoundryError, InputError, not_found
from foundry.models.base import Model, ModelInfo, Reply, Request, RequestKeys, RunContext, Source, seen_through
from foundry.records import Member

Personas = Sequence[Mapping[str, str]]
STREAM = "members"
"""Name of the random stream that deals the agents to the members of a population."""
RULES = ("agents", "share", "persona")
_RANGE = re.compile(r"(\d+)(?:-(\d+))?")
_TOLERANCE = 1e-6


@dataclass(frozen=True)
class Rule:
    """Selects the agents that one model of a population answers for: by id, by a share of the agents, or by persona.

    Attributes:
        agents: ids of the agents.
        share: share of the agents that no other rule names, 0..1.
        persona: attributes that the persona of an agent must have.
    """

    agents: frozenset[int] | None = None
    share: float | None = None
    persona: Mapping[str, str] | None = None

    def names(self, agent: int, persona: Mapping[str, str]) -> bool:
        """Return whether this rule selects an agent by id or persona; a share selects agents only later."""
        if self.agents is not None:
            return agent in self.agents
        return self.persona is not None and all(persona.get(key) == value for key, value in self.persona.items())


class MixedModel(Model):
    """Passes each agent's questions on to one model (member) of a population; members have own caches and limits."""

    def __init__(self, name: str, members: Mapping[str, Mapping[str, Any]]) -> None:
        """Read which member answers for which agents.

        Args:
            name: name of the population in tables.
            members: each member's `model`, and one of `agents`, `share` and `persona`, by label. `agents` is an id, a
                range such as `0-9`, or a list. `share` is 0..1, or `50%`. `persona` is a mapping, or `attribute:value`.
        """
        self.name = name
        self._rules = {label: _rule(label, member) for label, member in members.items()}
        self._models: dict[str, Model] = {label: member["model"] for label, member in members.items()}
        self.costs = any(model.costs for model in self._models.values())
        _check_shares(self._rules)

    @property
    def kinds(self) -> tuple[str, ...] | None:
        """The kinds of question that all members can answer; None if they can answer any."""
        limited = [set(model.kinds) for model in self._models.values() if model.kinds is not None]
        return tuple(sorted(set.intersection(*limited))) if limited else None

    def parameters(self) -> dict[str, Any]:
        """Return the parameters of every member."""
        return {label: {"model": model.name, **model.parameters()} for label, model in self._models.items()}

    def wrapped(self, wrap: Callable[[Model], Model]) -> Model:
        """Return the population with a wrapper around each member."""
        copy = MixedModel.__new__(MixedModel)
        copy.name, copy.costs, copy._rules = self.name, self.costs, self._rules
        copy._models = {label: model.wrapped(wrap) for label, model in self._models.items()}
        return copy

    def in_run(self, context: RunContext) -> Model:
        """Return the population for one run: its rules decide which member answers for each agent of the run."""
        labels = assign(self.name, self._rules, context.personas, context.seed)
        infos = dict(zip(self._models, context.info.members, strict=True)) if context.info.members else {}
        placed = {
            label: model.in_run(replace(context, info=infos.get(label, ModelInfo(model.name))))
            for label, model in self._models.items()
        }
        digests = {label: info.digest for label, info in infos.items()}
        return Population(self.name, labels, placed, digests)

    async def ask(self, request: Request) -> Reply:
        """Raise an error: outside of a run, it is open which member answers."""
        raise FoundryError(f"Population '{self.name}' was asked outside of a run.")

    async def inspect(self) -> ModelInfo:
        """Return the facts that hold for the whole population, and the facts about each member.

        A capability is listed if all members have it; members whose calls cost nothing do not count.
        """
        infos = [await model.inspect() for model in self._models.values()]
        able = [set(info.capabilities) for info, model in zip(infos, self._models.values(), strict=True) if model.costs]
        common = tuple(sorted(set.intersection(*able))) if able else ()
        undeclared = tuple(sorted({name for info in infos for name in info.undeclared}))
        return ModelInfo(name=self.name, capabilities=common, undeclared=undeclared, members=tuple(infos))

    def canaries(self) -> tuple[Canary, ...]:
        """Return the results of the canary calls for each member."""
        return tuple(canary for model in self._models.values() for canary in model.canaries())

    async def confirm(self) -> None:
        """Check that the servers of all members still have the models with which the sweep started."""
        for model in self._models.values():
            await model.confirm()

    async def warm_up(self) -> None:
        """Load every member."""
        for model in self._models.values():
            await model.warm_up()

    async def unload(self) -> None:
        """Let the members' servers free their memory."""
        for model in self._models.values():
            await model.unload()

    async def close(self) -> None:
        """Free the members' connections."""
        for model in self._models.values():
            await model.close()


class Population(Model):
    """A population in one run: its members (models), and the agents that each member answers for."""

    def __init__(
        self, name: str, labels: Sequence[str], models: Mapping[str, Model], digests: Mapping[str, str | None]
    ) -> None:
        self.name = name
        self.costs = any(model.costs for model in models.values())
        self._labels = labels
        self._models = models
        self._digests = digests
        self._keys = {label: RequestKeys(model, digests.get(label)) for label, model in models.items()}
        self._parameters = {label: model.parameters() for label, model in models.items()}

    def parameters(self) -> dict[str, Any]:
        """Return the parameters of every member."""
        return {label: {"model": model.name, **self._parameters[label]} for label, model in self._models.items()}

    def costs_for(self, agent: int) -> bool:
        """Return whether the calls of the member that answers for this agent cost something."""
        return self._models[self._labels[agent]].costs

    def roster(self) -> tuple[Member, ...]:
        """Return which member answers for which agents."""
        return tuple(
            Member(
                model=model.name,
                digest=self._digests.get(label),
                agents=tuple(agent for agent, chosen in enumerate(self._labels) if chosen == label),
            )
            for label, model in self._models.items()
        )

    async def ask(self, request: Request) -> Reply:
        """Pass one request on to the member that answers for its agent."""
        return (await self.ask_all([request]))[0]

    async def ask_all(self, requests: Sequence[Request]) -> list[Reply]:
        """Ask the members of all agents at the same time; an error is raised only after all calls have ended."""
        places: dict[str, list[int]] = {}
        for place, request in enumerate(requests):
            places.setdefault(self._labels[request.agent], []).append(place)
        groups = [self._ask_member(label, [requests[place] for place in mine]) for label, mine in places.items()]
        replies: dict[int, Reply] = {}
        for mine, result in zip(places.values(), await seen_through(groups), strict=True):
            replies.update(zip(mine, result, strict=True))
        return [replies[place] for place in range(len(requests))]

    async def _ask_member(self, label: str, requests: Sequence[Request]) -> list[Reply]:
        keys, model = self._keys[label], self._models[label]
        rekeyed = [
            msgspec.structs.replace(request, key=keys.key(request.messages, request.seed)) for request in requests
        ]
        replies = await model.ask_all(rekeyed)
        return [self._signed(label, *pair) for pair in zip(rekeyed, replies, strict=True)]

    def _signed(self, label: str, request: Request, reply: Reply) -> Reply:
        if reply.source is not None:
            return reply
        name, digest, parameters = self._models[label].name, self._digests.get(label), self._parameters[label]
        source = Source(model=name, digest=digest, parameters=parameters, key=request.key)
        return msgspec.structs.replace(reply, source=source)


def assign(name: str, rules: Mapping[str, Rule], personas: Personas, seed: int) -> list[str]:
    """Return the label of the member that answers for each agent, (N,)."""
    _check_ids(name, rules, len(personas))
    labels: list[str | None] = []
    for agent, persona in enumerate(personas):
        naming = [label for label, rule in rules.items() if rule.names(agent, persona)]
        if len(naming) > 1:
            both = " and ".join(naming)
            raise InputError(
                f"Population '{name}': agent {agent} (seed {seed}) belongs to members {both}. Let one member name it."
            )
        labels.append(naming[0] if naming else None)
    left = [agent for agent, label in enumerate(labels) if label is None]
    shares = {label: rule.share for label, rule in rules.items() if rule.share is not None}
    if left and not shares:
        raise InputError(
            f"Population '{name}': no member answers for agent{'s' if len(left) > 1 else ''} "
            f"{', '.join(map(str, left[:5]))}{' ...' if len(left) > 5 else ''} (seed {seed}). Give one member a share."
        )
    drawn = iter(_drawn(shares, len(left), seed))
    return [next(drawn) if label is None else label for label in labels]


def _drawn(shares: Mapping[str, float], agents: int, seed: int) -> list[str]:
    """Draw a label for each agent; the method of largest remainders converts shares to counts."""
    exact = {label: share * agents for label, share in shares.items()}
    counts = {label: int(number + _TOLERANCE) for label, number in exact.items()}
    for label in sorted(exact, key=lambda label: counts[label] - exact[label])[: agents - sum(counts.values())]:
        counts[label] += 1
    pool = [label for label, count in counts.items() for _ in range(count)]
    return [pool[place] for place in seeding.stream(seed, STREAM).permutation(len(pool)).tolist()]


def _check_ids(name: str, rules: Mapping[str, Rule], agents: int) -> None:
    for label, rule in rules.items():
        beyond = [agent for agent in sorted(rule.agents or ()) if agent >= agents]
        if beyond:
            raise InputError(
                f"Population '{name}', member '{label}': there is no agent {beyond[0]}. The world has agents 0 to "
                f"{agents - 1}."
            )


def _check_shares(rules: Mapping[str, Rule]) -> None:
    shares = [rule.share for rule in rules.values() if rule.share is not None]
    if shares and abs(sum(shares) - 1) > _TOLERANCE:
        raise InputError(
            f"model.members: the shares add up to {sum(shares):.3g}, but must add up to 1. Shares apply to the "
            "agents that no member lists by agents or persona."
        )


def _rule(label: str, member: Mapping[str, Any]) -> Rule:
    where = f"model.members.{label}"
    unknown = set(member) - {"model", *RULES}
    if unknown:
        raise not_found("Setting", f"{where}.{sorted(unknown)[0]}", [f"{where}.{key}" for key in ("model", *RULES)])
    if not isinstance(member.get("model"), Model):
        raise InputError(f"{where} has no model: name one in the defaults list, as in docs/models.md.")
    given = [key for key in RULES if member.get(key) is not None]
    if len(given) != 1:
        raise InputError(f"{where} must have exactly one of {', '.join(RULES)}.")
    value = member[given[0]]
    read: Mapping[str, Callable[[str, Any], Rule]] = {"agents": _agents, "share": _share, "persona": _persona}
    return read[given[0]](where, value)


def _agents(where: str, value: Any) -> Rule:
    agents: set[int] = set()
    for item in value if isinstance(value, list) else [value]:
        match = _RANGE.fullmatch(str(item).strip())
        first, last = (int(match[1]), int(match[2] or match[1])) if match else (1, 0)
        if last < first or last - first > 1_000_000:
            raise InputError(f"{where}.agents: '{item}' is neither an agent's id nor a range such as 0-9.")
        agents |= set(range(first, last + 1))
    return Rule(agents=frozenset(agents))


def _share(where: str, value: Any) -> Rule:
    text = str(value).strip()
    try:
        share = float(text.removesuffix("%")) / (100 if text.endswith("%") else 1)
    except ValueError:
        share = -1.0
    if not 0 < share <= 1:
        raise InputError(
            f"{where}.share: '{value}' is not a share. Use a number above 0 and up to 1, or a percentage such as 50%."
        )
    return Rule(share=share)


def _persona(where: str, value: Any) -> Rule:
    if isinstance(value, str) and value.count(":") == 1:
        value = dict([value.split(":")])
    if not isinstance(value, Mapping) or not value:
        raise InputError(f"{where}.persona: '{value}' is neither a mapping nor a text such as mood:calm.")
    return Rule(persona={str(key).strip(): str(text).strip() for key, text in value.items()})
