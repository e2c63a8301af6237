"""What the measures say of agents that look at nothing: no more than the null that they state.

A measure that claims rest on must not say of a policy that is blind to something that it minds it, nor tell two such
policies apart because one of them moves or speaks more often.
"""

import math
from collections.abc import Collection, Iterable, Mapping, Sequence
from dataclasses import dataclass, replace

import msgspec
import numpy as np
import pytest

from analysis import signatures
from analysis.any.any_run import AnyRun
from analysis.arrays import STAY, IntArray
from analysis.camera.camera_run import CameraRun
from analysis.grid import moved
from analysis.grid.grid_run import HEADINGS, GridRun, GridSettings
from analysis.grid.signatures import hazard
from analysis.grid.walker import legal_moves
from analysis.measure import Measure, Null
from analysis.rounds.rounds_run import RoundsRun
from analysis.stats.family import NO_BEHAVIOUR
from analysis.stats.intervals import student_quantile
from blind_any_runs import CROWDS
from blind_runs import (
    GIVERS,
    GOERS,
    WORLD,
    Blind,
    BlindWalker,
    Talk,
    blind_answers,
    blind_camera_run,
    blind_run,
    run_of_walks,
)  # fmt: skip
from foundry import seeding
from foundry.seeding.positions import PositionLaw
from told_runs import TELLING

ANEW, BACK, ON = "anew", "back", "on"
"""What an agent does at the edge: draws a way anew, turns back, or asks for the same way on and on."""


@dataclass(frozen=True)
class Habit:
    """How an agent goes.

    Attributes:
        keep: chance to keep the way of the step before; else the way is drawn from `ways`.
        ways: chances of up, down, left and right.
        own: whether the agent has drawn one of the ways for itself, and takes it wherever `keep` fails.
        edge: what it does at the edge.
        stay: chance to stay for a step.
        cycle: choices that follow one another again and again, in place of all that; staying is 0.
    """

    keep: float = 1.0
    ways: tuple[float, float, float, float] = (0.25, 0.25, 0.25, 0.25)
    own: bool = False
    edge: str = ANEW
    stay: float = 0.0
    cycle: tuple[int, ...] = ()


@dataclass(frozen=True)
class Crowd:
    """Agents that take these habits in turn."""

    habits: tuple[Habit, ...]

    def play(self, seed: int, world: GridSettings, arm: str = "told") -> GridRun:
        """Return a run; the arm is another draw of the ways from the same world."""
        settings = placed(world, seed)
        rng = seeding.stream(seed, f"habits {self} {arm}")
        walks = [self._walk(self.habits[agent % len(self.habits)], rng, settings) for agent in range(world.agents)]
        x, y, choice = (np.stack(part, axis=1) for part in zip(*walks, strict=True))
        return run_of_walks(f"habits-{seed}", settings, (x, y, choice), Talk(speak=0.0), rng)

    def _walk(self, habit: Habit, rng: np.random.Generator, world: GridSettings) -> tuple[IntArray, IntArray, IntArray]:
        """Return columns and rows by state, (T + 1,), and choices by step, (T,)."""
        cells, choices = [_start(rng, world)], []
        own = way = int(rng.choice(4, p=habit.ways))
        for step in range(world.steps):
            if not (habit.keep == 1 or rng.random() < habit.keep):
                way = own if habit.own else int(rng.choice(4, p=habit.ways))
            legal = legal_moves(*np.array(cells[-1]), world)
            if not legal[way] and habit.edge != ON:
                way = way ^ 1 if habit.edge == BACK else int(rng.choice(np.flatnonzero(legal)))
            choice = STAY if rng.random() < habit.stay else STAY + 1 + way
            if habit.cycle:
                choice = habit.cycle[step % len(habit.cycle)]
            moves = choice != STAY and bool(legal[choice - STAY - 1])
            cells.append(cells[-1] + HEADINGS[choice] if moves else cells[-1])
            choices.append(choice)
        x, y = np.array(cells).T
        return x, y, np.array(choices, dtype=np.int64)


def _start(rng: np.random.Generator, world: GridSettings) -> IntArray:
    """Return a cell outside all places, each as likely."""
    while True:
        cell = rng.integers(-world.half_size, world.half_size, size=2, endpoint=True)
        if world.areas(cell[:1], cell[1:])[0] < 0:
            return np.asarray(cell)


def placed(world: GridSettings, seed: int) -> GridSettings:
    """Return the world of a seed, its positions drawn where that is its rule."""
    if not world.draw_positions:
        return world
    extents = np.array([place.extent for place in world.places])
    drawn = PositionLaw(world.half_size, extents, len(world.fires)).draw(seeding.stream(seed, "positions"))
    pairs = zip(world.places, drawn.places.tolist(), strict=True)
    places = tuple(msgspec.structs.replace(place, center=tuple(center)) for place, center in pairs)
    burning = zip(world.fires, drawn.fires.tolist(), strict=True)
    fires = tuple(msgspec.structs.replace(fire, position=tuple(position)) for fire, position in burning)
    return msgspec.structs.replace(world, places=places, fires=fires)


def world_of(agents: int, **changes: bool) -> GridSettings:
    return msgspec.structs.replace(WORLD, agents=agents, **changes)


_STRAIGHT, _STREAKS = Habit(), Habit(keep=0.9)
_SQUARE = tuple(way for way in (1, 4, 2, 3) for _ in range(5))
"""Up, right, down and left, five steps each."""

HABITS: Mapping[str, Crowd] = {
    "straight, turns at the edge": Crowd((_STRAIGHT,)),
    "straight, turns back": Crowd((replace(_STRAIGHT, edge=BACK),)),
    "straight, stuck at the edge": Crowd((replace(_STRAIGHT, edge=ON),)),
    "straight, all to the right": Crowd((replace(_STRAIGHT, ways=(0, 0, 0, 1), edge=ON),)),
    "a way of its own": Crowd((Habit(keep=0.0, own=True, edge=ON, stay=0.3),)),
    "mostly a way of its own": Crowd((Habit(keep=0.5, own=True),)),
    "keeps its way 9 of 10": Crowd((_STREAKS,)),
    "keeps its way 1 of 2, mostly up": Crowd((Habit(keep=0.5, ways=(0.7, 0.1, 0.1, 0.1)),)),
    "cycles in a square": Crowd((Habit(cycle=_SQUARE),)),
    "to and fro": Crowd((Habit(cycle=(4, 4, 4, 3, 3, 3)),)),
    "goes and rests": Crowd((Habit(cycle=(1, 1, 1, 1, 0, 0, 0, 0)),)),
    "half goes straight, half stays": Crowd((_STRAIGHT, Habit(stay=1.0))),
    "half goes straight, half draws": Crowd((_STRAIGHT, Habit(keep=0.0))),
    "all kinds": Crowd((_STRAIGHT, _STREAKS, Habit(cycle=_SQUARE), Habit(keep=0.0, stay=0.5))),
}

ALIKE = {f"stays {stay}": Blind(stay=stay) for stay in (0.0, 0.2, 0.5, 0.9, 1.0)}
MOVING = {name: one for name, one in ALIKE.items() if one.stay < 1}
ONE_WAY = {
    "mostly up": Blind(ways=(0.7, 0.1, 0.1, 0.1)),
    "right or up": Blind(stay=0.5, ways=(0.4, 0.1, 0.1, 0.4)),
    "right alone": Blind(stay=0.3, ways=(1e-9, 1e-9, 1e-9, 1.0)),
}
TALKING = {f"speaks {rate}": Blind(speak=rate) for rate in (0.05, 0.3, 0.9)}
IN_SIGHT = {
    f"warns {rate}": Blind(speak=rate, texts=("fire!",), in_sight=True, stay=stay)
    for rate, stay in ((0.1, 0.2), (0.5, 0.0), (1.0, 0.5))
}
WARNERS = {
    "half always warns, half never": Blind(speak=1.0, texts=("fire!",), other_texts=("hello",)),
    "half warns often, half seldom": Blind(
        speak=0.6, texts=("fire!", "hello"), other_texts=(*["hello"] * 9, "there is smoke")
    ),
}
CAMERA = {
    "all alike": BlindWalker(),
    "forward and turns": BlindWalker((0, 4, 0, 0, 0, 2, 2, 0, 0)),
    "mostly stays": BlindWalker((6, 1, 1, 1, 1, 2, 2, 1, 1)),
    "mostly forward": BlindWalker((1, 6, 1, 1, 1, 1, 1, 1, 1)),
    "mostly left turns": BlindWalker((1, 1, 0, 0, 0, 4, 1, 0, 0), claim=0.9),
}
ASKED = {f"truth {skew}": skew for skew in (0.5, 0.9)}
"""How often the first of the possible answers is the right one; what is answered is drawn from all alike."""
FRESH = {name: one for name, one in CROWDS.items() if not one.habit}
EVEN = {name: one for name, one in CAMERA.items() if name != "mostly left turns"}

WHOSE: Mapping[str, Iterable[str]] = {
    "draws each step independently, without regard to fires": ALIKE | ONE_WAY,
    "draws each step independently, without regard to places": ALIKE | ONE_WAY,
    "draws each step independently, without regard to others": ALIKE | ONE_WAY,
    "draws each step independently, with equal directions, and stays with any probability": ALIKE,
    "draws each step independently, all directions alike, away from edges and walls": MOVING,
    "goes and stays without regard to fires, whatever its habits": HABITS,
    "goes and stays without regard to places, whatever its habits": HABITS,
    "moves in all directions alike, never stays": ["stays 0.0"],
    "is in any cell with equal chance, without regard to others": ALIKE,
    "warns only of fires in its own sight": IN_SIGHT,
    "warns at any rate, without regard to messages it hears": ALIKE | ONE_WAY | TALKING | WARNERS | IN_SIGHT,
    "draws its actions independently": MOVING | CAMERA | FRESH,
    "claims to see it without regard to the image": CAMERA,
    "draws its decisions independently, without regard to the image": CAMERA,
    "turns to either side alike": EVEN,
    "looks up and down alike": EVEN,
    "decides like all other agents, with any habits shorter than a third of the run": CROWDS,
    "acts independently of its persona, whatever its habits": CROWDS,
    "goes or stays by a coin flip": ["goes or stays by a coin flip"],
    "goes as often as it likes without regard to others": GOERS,
    "goes without regard to earlier evenings": ["goes or stays by a coin flip", "goes by its own odds"],
    "gives without regard to the round and the others": GIVERS,
    "draws its answers at random from the possible ones": ASKED,
    "draws each decision by its expected shares": TELLING,
    "is right as often as it is sure": TELLING,
}
"""The policies that are played, by whose null a measure states."""

ALIKE_IN: Mapping[str, Iterable[str]] = {
    "clustering.largest_group": ALIKE,
    "clustering.isolated": ALIKE,
    "communication.conditional_rate": ALIKE,
    "communication.delivered": ALIKE,
    "communication.rate": ALIKE,
    "communication.length": TALKING,
    "communication.variety": TALKING,
    "hazard.exposure": ALIKE,
    "place_choice.share_cafe": ALIKE,
    "place_choice.share_library": ALIKE,
    "place_choice.overcrowding": ALIKE,
    "place_choice.utilisation": ALIKE,
    "recognition.recall": EVEN,
    "recognition.false_claim_rate": EVEN,
}
"""Headline measures without a null of their own, and policies that are alike in what they are about."""

SLIGHT = 0.005
"""Biases that are left: of the order of one over the moves or decisions of a run."""

TALK = {"communication", "warning"}
"""What only those can show that differ in what they say."""

WAYS = {"hazard", "movement"}
"""What those are played for that keep to ways of their own."""

CROWD_SIZES = (1, 2, 5, 20, 100)

UNLIKE = ("straight, all to the right", "mostly a way of its own", "cycles in a square", "goes and rests", "all kinds")
"""Few of the habits that are as unlike one another as can be; all are played before a release."""

DECISIONS = 150
"""Of a run of a 3D world: the fewer, the further are the measures of `viewpoint` from their nulls, by about 1/n."""

AMOUNTS = {
    "action": {"share_*", "variety", "variety_*", "mean", "mean_*", "sd", "sd_*"},
    "bar": {"score", "share", "constant"},
    "certainty": {"probability", "entropy", "expected_*"},
    "collision": {"rate", "rate_moving"},
    "communication": {"reply_rate"},
    "evacuation": {"out", "time_50", "over_bound", "nearest", "path_efficiency"},
    "exploration": {"coverage", "group_coverage", "gyration", "path_length"},
    "fishery": {"months", "efficiency", "equality", "over_use"},
    "follow": {"sdtw", "legs"},
    "gaze": {"rate", "share"},
    "idle_rate": {"chosen", "blocked", "invalid"},
    "map_probe": {"distance_relative"},
    "naming": {"success", "converged", "rounds", "names"},
    "outcome": {"readable", "message_readable", "repaired"},
    "path_efficiency": {
        "trip_efficiency", "trip_efficiency_moving", "arrived", "success", "spl", "soft_spl", "distance_to_goal",
    },
    "public_goods": {"score", "conditional", "free_riders", "efficiency", "punishing", "antisocial"},
    "recognition": {"false_stop", "chair_i", "object_recall"},
    "recovery": {"wrong_rate", "recovered", "rmst", "max_excess", "detour_cost"},
    "returns": {"mean", "first"},
    "stability": {"persistence", "reversal_rate"},
    "survival": {"lifespan", "sharing_rate", "attack_rate", "inequality", "births"},
    "turning": {"rate", "share"},
    "utility": {"mean", "gini"},
    "warning": {"social_reach"},
}  # fmt: skip
"""Headline measures of how much was done or achieved, which nobody is blind to; compare them with the baselines."""

Values = Mapping[str, Mapping[str, np.ndarray]]


def measured(
    runs: Iterable[GridRun | CameraRun | RoundsRun | AnyRun], about: Collection[str] = ()
) -> dict[str, np.ndarray]:
    """Return the defined values of each measure over runs, (n,) at most; of these signatures alone where named."""
    found: dict[str, list[float]] = {}
    about = about or {name.partition(".")[0] for name in (*stated_nulls(), *ALIKE_IN)}
    asked = [signature for signature in signatures.discover() if signature.name in about]
    for run in runs:
        for signature in [
            signature
            for signature in asked
            if any(part.run is type(run) and part.applies(run) for part in signature.parts)
        ]:
            for name, value in signature.measure(run).items():
                found.setdefault(f"{signature.name}.{name}", []).append(value)
    return {name: np.array(values)[~np.isnan(values)] for name, values in found.items()}


def stated_nulls() -> dict[str, Null]:
    every = (
        (f"{signature.name}.{name}", measure.null)
        for signature in signatures.discover()
        for name, measure in signature.measures.items()
    )
    return {name.replace("persona_effect.*", "persona_effect.role"): null for name, null in every if null is not None}


def of_habits(whether: bool) -> dict[str, Null]:
    """Return the nulls that hold for agents with habits, or those that are not said to."""
    return {name: null for name, null in stated_nulls().items() if (WHOSE[null.policy] is HABITS) == whether}


def played(grid_seeds: int, camera_seeds: int) -> Values:
    grid = {
        name: measured((blind_run(one, seed) for seed in range(grid_seeds)), () if name in ALIKE | ONE_WAY else TALK)
        for name, one in (ALIKE | ONE_WAY | TALKING | IN_SIGHT | WARNERS).items()
    }
    camera = {
        name: measured(blind_camera_run(one, seed, DECISIONS) for seed in range(camera_seeds))
        for name, one in CAMERA.items()
    }
    camera |= {
        name: measured(blind_answers(skew, seed) for seed in range(camera_seeds)) for name, skew in ASKED.items()
    }
    others = CROWDS | GOERS | GIVERS | TELLING
    return grid | camera | {name: measured(map(one.play, range(2 * grid_seeds))) for name, one in others.items()}


def habits(crowds: Iterable[str], seeds: int, crowd_sizes: Sequence[int]) -> Values:
    """Return the values of who keeps to ways of its own, where positions are drawn and beside an untold twin."""
    runs = [(seed, crowd_sizes[seed % len(crowd_sizes)]) for seed in range(seeds)]
    drawn = {agents: world_of(agents, draw_positions=True) for agents in crowd_sizes}
    return {
        name: measured((HABITS[name].play(seed, drawn[agents]) for seed, agents in runs), WAYS)
        | beyond_untold(HABITS[name], runs)
        for name in crowds
    }


def beyond_untold(crowd: Crowd, runs: Iterable[tuple[int, int]]) -> dict[str, np.ndarray]:
    """Return what a crowd does beyond its untold twins, which draw ways of their own; runs are seeds and sizes."""
    arms = [
        [hazard.measure(crowd.play(seed, world_of(agents, tell_fires=told), f"told {told}")) for told in (True, False)]
        for seed, agents in runs
    ]
    found = {
        f"hazard.{name}_beyond_untold": np.array(
            [told[f"{name}_beyond_blind"] - untold[f"{name}_beyond_blind"] for told, untold in arms]
        )
        for name in ("away", "distance")
    }
    return {name: values[~np.isnan(values)] for name, values in found.items()}


def columns(values: Values) -> list[str]:
    return sorted({name for value in values.values() for name in value})


def headline(values: Values) -> list[str]:
    shown = [
        signature.headline_columns(columns(values))
        for signature in signatures.discover()
        if signature.name not in NO_BEHAVIOUR
    ]
    return [name for own in shown for name in own]


def unit(measure: Measure) -> float:
    """Return what a bias is held against: half the range, where there is one."""
    return (measure.high - measure.low) / 2 if math.isfinite(measure.high - measure.low) else 1.0


def half_width(values: np.ndarray, rows: int) -> float:
    """Return half of the interval of the mean, such that all of as many rows cover theirs in 95 % of such studies."""
    return student_quantile(len(values) - 1, 1 - 0.05 / rows) * float(values.std(ddof=1)) / math.sqrt(len(values))


def by_policy(values: Values, column: str, policies: Iterable[str]) -> dict[str, np.ndarray]:
    """Return the values of the policies for which the measure is defined in some runs, and of all of them together."""
    found = {name: values[name][column] for name in policies if column in values.get(name, {})}
    return {name: own for name, own in found.items() if len(own) > 7} | {"all": np.concatenate(list(found.values()))}


def check_nulls(values: Values, stated: Mapping[str, Null], sees: float) -> None:
    parts = {name: by_policy(values, name, WHOSE[null.policy]) for name, null in stated.items()}
    rows = sum(map(len, parts.values()))
    wrong = [
        f"{name} of '{policy}': {own.mean():.4f} -+ {half_width(own, rows):.4f}, not {stated[name].value:g}"
        for name, found in parts.items()
        for policy, own in found.items()
        if abs(own.mean() - stated[name].value) > half_width(own, rows) + SLIGHT
    ]
    assert not wrong
    widths = {name: half_width(parts[name]["all"], rows) for name in headline(values) if name in stated}
    allowed = {name: (sees - SLIGHT) * unit(signatures.describe(name)) for name in widths}
    assert {name: width for name, width in widths.items() if width > allowed[name]} == {}


def check_alike(values: Values) -> None:
    parts = {name: by_policy(values, name, policies) for name, policies in ALIKE_IN.items()}
    rows = sum(map(len, parts.values()))
    wrong = [
        f"{name} of '{policy}': {own.mean():.4f} -+ {half_width(own, rows):.4f}, of all {found['all'].mean():.4f}"
        for name, found in parts.items()
        for policy, own in found.items()
        if abs(own.mean() - found["all"].mean()) > half_width(own, rows) + half_width(found["all"], rows)
    ]
    assert not wrong


@pytest.mark.slow
def test_who_looks_at_nothing_comes_to_the_nulls_and_is_told_apart_by_nothing():
    values = played(10, 40)
    check_nulls(values, of_habits(False), sees=0.09)
    check_alike(values)


@pytest.mark.exhaustive
@pytest.mark.timeout(900)
def test_who_looks_at_nothing_comes_to_the_nulls_in_many_runs():
    values = played(200, 560)
    check_nulls(values, of_habits(False), sees=0.02)
    check_nulls(habits(HABITS, 60, CROWD_SIZES), of_habits(True), sees=0.05)
    check_alike(values)


@pytest.mark.slow
def test_who_keeps_to_a_way_but_ignores_fires_and_places_comes_to_their_nulls(monkeypatch):
    monkeypatch.setattr(moved, "DRAWS", 10)  # the null is exact for any number, and the test takes seconds
    assert set(of_habits(True)) == {
        *(f"hazard.{name}_beyond_{null}" for name in ("away", "distance") for null in ("moved", "untold")),
        "movement.drift_place_beyond_moved",
    }
    check_nulls(habits(UNLIKE, 9, (1, 2, 5)), of_habits(True), sees=0.3)


@pytest.mark.slow
def test_where_agents_warn_at_rates_of_their_own_passing_on_comes_to_its_null():
    values = [measured((blind_run(one, seed) for seed in range(20)), {"warning"}) for one in WARNERS.values()]
    assert [len(own["warning.relay_above_chance"]) for own in values] == [20, 20]
    assert max(abs(own["warning.relay_above_chance"].mean()) for own in values) < 0.05


def test_of_every_headline_measure_it_is_known_what_chance_gives_or_that_it_is_an_amount():
    named = [*stated_nulls(), *ALIKE_IN]
    known = {name.replace("_cafe", "_*").replace("_library", "_*").replace(".role", ".*") for name in named}
    amounts = {f"{signature}.{name}" for signature, names in AMOUNTS.items() for name in names}
    shown = {
        f"{signature.name}.{name}" for signature in signatures.discover() for name in signature.headline
        if signature.name not in NO_BEHAVIOUR and not signature.is_label
    }  # fmt: skip
    assert shown - known - amounts == set()
    assert amounts & known == set() and amounts <= shown


def test_every_null_has_policies_that_are_played():
    assert {null.policy for null in stated_nulls().values()} == set(WHOSE)
