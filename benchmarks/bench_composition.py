"""CPU of composing further seeds and commands, beside composing each by Hydra; CPU of `foundry --help`."""

from __future__ import annotations

from functools import partial

import hydra
from measuring import at_most, cost_of, cost_of_command, print_table, print_title

from foundry import paths
from foundry.composing.compose import compose
from foundry.expansion import expand

FEW, MANY = 10, 1010
HYDRA_SEEDS = 10
REPEATS = 5
STARTS = 10


def compose_and_expand(seeds: int) -> None:
    """Compose a sweep of one condition and list its runs."""
    composed = compose(["-m", "model=scripted/random", f"seed=0-{seeds - 1}"])
    assert composed is not None
    assert len(expand(composed.asked, composed.conditions).runs) == seeds


def compose_each(seeds: int) -> None:
    """Compose the same, once a seed."""
    with hydra.initialize_config_dir(str(paths.conf_dir()), version_base="1.3"):
        for seed in range(seeds):
            hydra.compose("config", overrides=["model=scripted/random", f"seed={seed}"])


def compose_again(point: int) -> None:
    """Compose other settings of the same choices."""
    assert compose(["model=scripted/random", f"world.steps={point + 1}"]) is not None


def cpu_s(seeds: int) -> float:
    """Return the least CPU seconds that a sweep of so many seeds takes to compose and expand."""
    return min(cost_of(lambda: compose_and_expand(seeds)).cpu_s for _ in range(REPEATS))


def main() -> None:
    print_title(
        "Composition",
        f"Inside the process, the least CPU of {REPEATS}. The ratio is to one `hydra.compose` per seed.",
        f"`foundry --help`: mean of {STARTS} starts.",
    )
    compose_and_expand(1)  # what is imported on first use is start-up
    few, many = cpu_s(FEW), cpu_s(MANY)
    further_ms = 1000 * (many - few) / (MANY - FEW)
    compose_each(1)
    hydra_ms = 1000 * min(cost_of(lambda: compose_each(HYDRA_SEEDS)).cpu_s for _ in range(REPEATS)) / HYDRA_SEEDS
    again_ms = 1000 * min(cost_of(partial(compose_again, point)).cpu_s for point in range(REPEATS))
    rows = [
        [f"one hydra.compose per seed ({HYDRA_SEEDS} seeds)", "", f"{hydra_ms:.3f}", "1.0000"],
        [f"foundry, {FEW} seeds", f"{1000 * few:.0f}", f"{1000 * few / FEW:.3f}", f"{1000 * few / FEW / hydra_ms:.4f}"],
        [
            f"foundry, {MANY:,} seeds",
            f"{1000 * many:.0f}",
            f"{1000 * many / MANY:.3f}",
            f"{1000 * many / MANY / hydra_ms:.4f}",
        ],
        ["foundry, each further seed", "", f"{further_ms:.3f}", f"{further_ms / hydra_ms:.4f}"],
        ["foundry, each further command or point", "", f"{again_ms:.3f}", f"{again_ms / hydra_ms:.4f}"],
    ]
    print_table(["what", "CPU ms", "CPU ms per seed", "ratio"], rows)
    starts = [cost_of_command("--help") for _ in range(STARTS)]
    help_s = sum(start.cpu_s for start in starts) / STARTS
    targets = [
        [
            "CPU of a further command, in those of Hydra",
            f"{again_ms / hydra_ms:.2f}",
            *at_most(again_ms / hydra_ms, 0.4, ""),
        ],
        ["CPU of each further seed", f"{further_ms:.3f} ms", *at_most(further_ms, 1, "ms")],
        ["CPU of `foundry --help`", f"{help_s:.3f} s", *at_most(help_s, 0.3, "s")],
    ]
    print_table(["foundry", "measured", "target", ""], targets)


if __name__ == "__main__":
    main()
