"""Measures a scripted run of twenty agents and fifty steps; the baseline is its world and model alone."""

from pathlib import Path

from measuring import Cost, at_most, cost_of, cost_of_command, fastest, print_table, print_title, run_sweep, scratch

from foundry.composing.compose import compose
from foundry.composing.preflight import scenario_of
from foundry.models.base import Request, ScriptedModel
from foundry.running.build import build
from foundry.worlds.base import Answer, Question, Scenario

AGENTS, STEPS, SEED = 20, 50, 0
OVERRIDES = ("model=scripted/random", f"world.agents={AGENTS}", f"world.steps={STEPS}", "runner.workers=1")
REPEATS = 5


def bare_loop(scenario: Scenario, model: ScriptedModel) -> int:
    """Play an episode without prompts, keys, log and records; returns the number of calls."""
    world = scenario.start(SEED)
    calls = 0
    while not world.finished:
        replies = [model.reply(request(question)) for question in world.pending()]
        world.advance([Answer(reply.text, reply.ending) for reply in replies])
        calls += len(replies)
    return calls


def request(question: Question) -> Request:
    seed = question.sampling_seed(SEED)
    return Request((), seed, question.kind, question.observation, question.step, question.agent)


def bare() -> tuple[int, Cost]:
    """Return the number of calls of the bare loop, and their cost."""
    composed = compose(OVERRIDES)
    assert composed is not None
    config = composed.conditions[0].config
    scenario, model = scenario_of(config), build(config["model"])
    return bare_loop(scenario, model), fastest([cost_of(lambda: bare_loop(scenario, model)) for _ in range(REPEATS)])


def whole_command(folder: Path) -> Cost:
    """Return the cost of the command from start-up to exit."""
    numbers = range(REPEATS)
    return fastest([cost_of_command(*OVERRIDES, "analyze=false", f"output.dir={folder / str(n)}") for n in numbers])


def row(name: str, calls: int, cost: Cost, baseline: Cost) -> list[str]:
    per_call = f"{1e6 * cost.wall_s / calls:,.0f}"
    return [name, f"{cost.wall_s:.3f}", f"{cost.cpu_s:.3f}", per_call, f"{cost.wall_s / baseline.wall_s:.2f}"]


def main() -> None:
    calls, alone = bare()
    print_title(
        "A scripted run",
        f"{AGENTS} agents, {STEPS} steps, {calls:,} calls, one worker, no analysis. Best of {REPEATS}.",
        "Ratios are to the world and the model alone.",
    )
    with scratch() as folder:
        swept = [run_sweep(folder / f"in-{number}", *OVERRIDES) for number in range(REPEATS)]
        inside = fastest([timing.running for timing in swept])
        composing = fastest([timing.whole for timing in swept])
        command = whole_command(folder)
    rows = [
        row("world and model alone", calls, alone, alone),
        row("the run, inside the process", calls, inside, alone),
        row("composing, checking and the run, inside the process", calls, composing, alone),
        row("the whole command, with its start", calls, command, alone),
    ]
    print_table(["what", "wall s", "CPU s", "wall µs/call", "ratio"], rows)
    names = ("the run, inside the process", "the whole command, with its start")
    targets = [
        [name, f"{cost.wall_s:.2f} s", *at_most(cost.wall_s, 1, "s")]
        for name, cost in zip(names, (inside, command), strict=True)
    ]
    print_table(["foundry", "measured", "target", ""], targets)


if __name__ == "__main__":
    main()
