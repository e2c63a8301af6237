"""Measures what a probe costs beside free runs, for intervals of the same width: `python benchmarks/bench_probe.py`.

Two scripted policies are compared in the share of each action: in free runs, and in moments of these runs. The interval
of a paired difference over seeds is as wide as sd / sqrt(seeds), so that for one width the calls are as sd^2 times the
calls of a seed.
"""

import itertools
import subprocess
import sys
import tempfile
from collections import Counter
from collections.abc import Iterable, Mapping, Sequence
from pathlib import Path

import msgspec
import numpy as np
from measuring import Stopwatch, print_table, print_title

from foundry.storing.store import RunFolder, SweepFolder

SEEDS = 10
WORLDS: Mapping[str, tuple[Sequence[str], Sequence[str]]] = {
    "cafe_library": (("random", "herd", "avoid"), ("world=cafe_library", "world.steps=50")),
    "survival": (("random", "forager", "sharer"), ("world=survival", "world.steps=40")),
}
"""The policies that are compared in each world, and what it is set to."""
MOMENTS, REPEATS = 12, (1, 10)
"""Moments of each seed, and how often each is asked."""
QUIET = ("analyze=false", "determinism=0")


def foundry(*arguments: str, cwd: Path) -> None:
    """Run a command that succeeds."""
    subprocess.run([sys.executable, "-m", "foundry", *arguments], cwd=cwd, check=True, stdout=subprocess.DEVNULL)


def shares(path: Path) -> dict[str, dict[int, dict[str, float]]]:
    """Return the share of each action among those that were read, by model and seed."""
    counts: dict[str, dict[int, Counter[str]]] = {}
    for run in SweepFolder.open(path).runs():
        mine = counts.setdefault(run.config()["model"]["name"], {}).setdefault(run.run.seed, Counter())
        mine.update(actions(run))
    return {
        model: {seed: {one: found[one] / found.total() for one in found} for seed, found in by_seed.items()}
        for model, by_seed in counts.items()
    }


def actions(run: RunFolder) -> Iterable[str]:
    """Return what was done in each answer to a question of an action; of a move, where to."""
    for line in msgspec.json.Decoder().decode_lines(run.steps_bytes()):
        if line.get("kind", "action") == "action" and isinstance(line["action"], str):
            yield line.get("direction") or line["action"]


def spread(found: Mapping[str, Mapping[int, Mapping[str, float]]], pair: Sequence[str], action: str) -> float:
    """Return the standard deviation over seeds of the paired difference of two models."""
    first, second = (found[model] for model in pair)
    return float(np.std([first[seed].get(action, 0) - second[seed].get(action, 0) for seed in first], ddof=1))


def calls_of_seed(path: Path) -> float:
    """Return how many questions a model is asked a seed."""
    runs = SweepFolder.open(path).runs()
    asked = sum(sum(1 for _ in run.calls()) for run in runs)
    return asked / len({(run.config()["model"]["name"], run.run.seed) for run in runs})


def compare(name: str, policies: Sequence[str], overrides: Sequence[str], folder: Path) -> list[list[str]]:
    """Return a row for each number of repeats: how many times fewer calls a probe needs."""
    named = [f"scripted/{policy}" for policy in policies]
    models = f"model={','.join(named)}"
    foundry("-m", models, f"seed=0-{SEEDS - 1}", *overrides, *QUIET, "output.dir=free", cwd=folder)
    free, rows = shares(folder / "free"), []
    for repeats in REPEATS:
        asked = (f"moments={MOMENTS * SEEDS}", f"repeats={repeats}", f"output.dir=probe{repeats}")
        foundry("probe", "free", "-m", models, *asked, *QUIET, cwd=folder)
        probe = shares(folder / f"probe{repeats}")
        calls = [calls_of_seed(folder / one) for one in ("free", f"probe{repeats}")]
        ratios = []
        for pair in itertools.combinations(named, 2):
            for action in sorted({one for model in pair for found in free[model].values() for one in found}):
                sds = [spread(found, pair, action) for found in (free, probe)]
                if min(sds) > 0:
                    ratios.append((sds[0] ** 2 * calls[0]) / (sds[1] ** 2 * calls[1]))
        low, middle, high = np.quantile(ratios, (0, 0.5, 1))
        rows.append([name, str(repeats), f"{calls[0]:,.0f}", f"{calls[1]:,.0f}", str(len(ratios)),
                     f"{low:.1f}", f"{middle:.1f}", f"{high:.1f}"])  # fmt: skip
    return rows


def main() -> None:
    print_title(
        "Calls for an interval of the same width: free runs beside a probe",
        f"Scripted policies in pairs, {SEEDS} seeds, {MOMENTS} moments a seed; shares of each action.",
    )
    rows = []
    for name, (policies, overrides) in WORLDS.items():
        with tempfile.TemporaryDirectory() as folder:
            rows += compare(name, policies, overrides, Path(folder))
    heads = ["world", "repeats", "calls a seed, free", "probe", "differences", "fewer by: least", "median", "most"]
    print_table(heads, rows)


if __name__ == "__main__":
    watch = Stopwatch()
    main()
    print(f"{watch.cost().wall_s:.0f} s in all", file=sys.stderr)
